#include "harness/judge/tradeoff.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace hdmbench {

namespace {

struct Efforts {
  std::string_view method;
  std::array<int, 4> counts; ///< rising
};

/// A factor of about 4 each; the same number again is nothing new.
constexpr std::array known{Efforts{"icm", {5, 20, 20, 200}},
                           Efforts{"icm-6", {5, 20, 20, 200}},
                           Efforts{"icm-thesis-steps", {5, 20, 20, 20}},
                           Efforts{"sequential", {5, 20, 20, 20}},
                           Efforts{"coloured", {5, 20, 20, 20}},
                           Efforts{"four-coloured", {5, 20, 20, 20}},
                           Efforts{"closed-form", {5, 20, 20, 200}},
                           Efforts{"cascade", {1, 2, 4, 8}},
                           Efforts{"annealing", {5, 10, 20, 20}},
                           Efforts{elastic_full_multigrid, {0, 1, 2, 3}},
                           Efforts{elastic_conjugate_gradients, {1, 2, 4, 8}},
                           Efforts{elastic_sweeps, {10, 50, 50, 200}}};

/// The effort on every backend: the method's usual one or the scene's, less for annealing.
int usual_effort(const Method& method, int own_iterations) {
  constexpr int most_annealing = 40; // 200 take scalar half a minute, and every point is checked against it
  if (method.name == "annealing") {
    return most_annealing;
  }
  return method.usual_effort > 0 ? method.usual_effort : own_iterations;
}

/// "4 cycles", "1 iteration on the full resolution".
std::string effort_text(const Method& method, int effort) {
  std::string what(method.effort); // its first word is a plural
  if (effort == 1) {
    what.erase(std::min(what.find(' '), what.size()) - 1, 1);
  }
  return fmt::format("{} {}", effort, what);
}

/// The --iterations that a method is measured at, rising, its usual effort among them unless quick: then the
/// two smallest. `own_iterations` are the scene's, the usual effort of the methods that have none.
std::set<int> efforts(const Method& method, int own_iterations, bool quick) {
  const auto found = std::ranges::find(known, method.name, &Efforts::method);
  std::set<int> counts;
  if (found != known.end()) {
    counts.insert(found->counts.begin(), found->counts.begin() + (quick ? 2 : 4));
  }
  if (!quick || counts.empty()) {
    counts.insert(usual_effort(method, own_iterations));
  }
  return counts;
}

/// Throws InputError where there is no such method or rival, or this build has it not.
void require_known(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name == "fem-amg" && !has_algebraic_multigrid()) {
      throw InputError("this build has no fem-amg; configure with -DHDMBENCH_PETSC=ON (Debian: petsc-dev)");
    }
    if (name != requested_name && std::ranges::find(rival_names, name) == rival_names.end()) {
      (void)find_method(name); // throws
    }
  }
}

/// The accuracies that are asked for, pixels.
std::vector<double> requests(bool quick) {
  return quick ? std::vector{1.0, 0.1} : std::vector{5.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01};
}

Setting requested(const Scene& scene, double asked, double poisson) {
  Setting setting{{.method = std::string(requested_name),
                   .effort = fmt::format("{:.3g} px asked", asked),
                   .poisson_used = poisson,
                   .asked = asked},
                  scene,
                  Where::main_place};
  use_energy(setting.scene, energy_near(ReferenceSolution::finite_elements));
  setting.scene.elastic.poisson = poisson;
  return setting;
}

bool is_result(const Judged& row) {
  return row.status == JudgedStatus::ok && !row.seconds.empty();
}

nlohmann::json setting(const Judged* row) {
  return row == nullptr ? nlohmann::json()
                        : nlohmann::json{{"method", row->method},
                                         {"effort", row->effort},
                                         {"backend", row->backend},
                                         {"seconds_median", median(row->seconds)},
                                         {"rmsd_to_fem", row->deviations.to_fem},
                                         {"rmsd_to_fem_nu0", row->deviations.to_fem_no_poisson}};
}

/// Adds the settings of a scene that is_of_tissue(): the methods of the elastic energy with the scene's
/// Poisson's ratio; of laws what an accuracy takes, and the linear answer beside it.
template <typename IsWanted, typename AddEfforts>
void add_settings_of_tissue(const Scene& scene, bool quick, const IsWanted& is_wanted,
                            const AddEfforts& add_efforts, Judge& judge) {
  const RegisteredEnergy& elastic = energy_near(ReferenceSolution::finite_elements);
  if (!has_laws(scene.full)) {
    for (const Method& method : elastic.methods) {
      if (is_wanted(method.name)) {
        add_efforts(method, scene.elastic.poisson);
      }
    }
  }
  for (const double asked : is_wanted(requested_name) ? requests(quick) : std::vector<double>{}) {
    judge.add(requested(scene, asked, scene.elastic.poisson));
  }
  if (!has_laws(scene.full) || !is_wanted(elastic_conjugate_gradients)) {
    return;
  }
  constexpr int steps = 8;
  Setting linear{{.method = std::string(elastic_conjugate_gradients),
                  .variant = linear_law,
                  .note = "how far the linear law is from the scene's",
                  .effort = fmt::format("{} steps", steps),
                  .told = steps,
                  .poisson_used = scene.elastic.poisson},
                 scene,
                 Where::main_place};
  linear.scene.full.law_parameter = {};
  linear.scene.full.fibre = {};
  linear.scene.full.fibre_compression = {};
  use_method(linear.scene, find_method(elastic_conjugate_gradients), steps);
  judge.add(linear);
}

} // namespace

std::vector<Judged> measure_tradeoff(const Scene& scene, std::span<const Backend* const> backends,
                                     const JudgeOptions& options, Progress& progress) {
  require_known(options.methods);
  Judge judge(scene, backends, options, progress);
  const auto is_wanted = [&](std::string_view name) {
    return options.methods.empty() || std::ranges::find(options.methods, name) != options.methods.end();
  };
  /// `poisson`: of the elastic energy, in place of the scene's.
  const auto add_efforts = [&](const Method& method, std::optional<double> poisson) {
    const int own = scene.schedule.iterations;
    for (const int effort : efforts(method, own, options.quick)) {
      const bool is_usual = effort == usual_effort(method, own) && !options.quick;
      Setting setting{{.method = std::string(method.name),
                       .effort = effort_text(method, effort),
                       .told = effort,
                       .poisson_used = poisson},
                      scene,
                      is_usual ? Where::everywhere : Where::main_place};
      use_method(setting.scene, method, effort);
      setting.scene.elastic.poisson = poisson.value_or(scene.elastic.poisson);
      judge.add(setting);
    }
  };
  const auto add_rivals = [&](const std::vector<Rival>& all) {
    for (const Rival& rival : all) {
      if (is_wanted(rival.told.method)) {
        judge.add(rival);
      }
    }
  };
  if (is_of_tissue(scene)) {
    add_settings_of_tissue(scene, options.quick, is_wanted, add_efforts, judge);
    add_rivals(rivals_of_tissue(scene, judge.truths(), options.quick));
    mark_front(judge.rows());
    return std::move(judge.rows());
  }
  for (const Method& method : methods()) {
    if (is_wanted(method.name)) {
      add_efforts(method, std::nullopt);
    }
  }
  // The elastic energy as finite elements, against which it stands.
  const RegisteredEnergy& elastic = energy_near(ReferenceSolution::finite_elements);
  const std::set<double> poisson_ratios{0.0, scene.elastic.poisson};
  for (const Method& method : elastic.methods) {
    for (const double poisson : is_wanted(method.name) ? poisson_ratios : std::set<double>{}) {
      add_efforts(method, poisson);
    }
  }
  for (const double poisson : is_wanted(requested_name) ? poisson_ratios : std::set<double>{}) {
    for (const double asked : requests(options.quick)) {
      judge.add(requested(scene, asked, poisson));
    }
  }
  add_rivals(rivals(scene, judge.truths(), options.quick));
  mark_front(judge.rows());
  return std::move(judge.rows());
}

void mark_front(std::vector<Judged>& rows) {
  const auto error = [](const Judged* row) { return error_to_chart(*row); };
  std::vector<Judged*> order;
  for (Judged& row : rows) {
    row.is_on_front = false;
    if (is_result(row) && std::isfinite(error(&row))) {
      order.push_back(&row);
    }
  }
  std::ranges::stable_sort(order, {},
                           [&](const Judged* row) { return std::pair(median(row->seconds), error(row)); });
  double best = std::numeric_limits<double>::infinity();
  for (Judged* const row : order) {
    row->is_on_front = error(row) < best;
    best = std::min(best, error(row));
  }
}

nlohmann::json compare_at(const Scene& scene, std::span<const Judged> rows, double target) {
  const auto fastest = [&](const auto& condition) {
    const Judged* best = nullptr;
    for (const Judged& row : rows) {
      if (is_result(row) && condition(row) && error_to_chart(row) <= target &&
          (best == nullptr || median(row.seconds) < median(best->seconds))) {
        best = &row;
      }
    }
    return best;
  };
  const Judged* const ours = fastest([](const Judged& row) { return !row.is_rival; });
  nlohmann::json equal = with_size({{"kind", "equal accuracy"},
                                    {"scene", scene.name},
                                    {"title", scene.title},
                                    {"law", law_of(scene)},
                                    {"poisson", scene.elastic.poisson},
                                    {"target", target},
                                    {"against", is_of_tissue(scene) ? "FEM" : "FEM nu 0"},
                                    {"nearest", nullptr},
                                    {"ours", setting(ours)}},
                                   scene.extent());
  for (const Judged& row : rows) {
    if (is_result(row) && !row.is_rival) {
      const double error = error_to_chart(row);
      equal["nearest"] = equal["nearest"].is_null() ? error : std::min(equal["nearest"].get<double>(), error);
    }
  }
  const auto solves_the_same = [&](const Judged& row) {
    return is_of_tissue(scene) || row.poisson_used == 0.0;
  };
  for (const auto& [key, method] : {std::pair("direct", has_laws(scene.full) ? "newton" : "fem"),
                                    {"iterative", "fem-cg"},
                                    {"multigrid", "fem-amg"},
                                    {"coarse", "fem-coarse"},
                                    {"positions", "xpbd"}}) {
    const Judged* const rival =
        fastest([&](const Judged& row) { return row.method == method && solves_the_same(row); });
    equal[key] = setting(ours != nullptr ? rival : nullptr);
    if (!equal[key].is_null()) {
      equal[key]["ratio"] = median(rival->seconds) / median(ours->seconds);
    }
  }
  return equal;
}

} // namespace hdmbench
