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

bool is_result(const Judged& row) {
  return row.status == JudgedStatus::ok && !row.seconds.empty();
}

nlohmann::json setting(const Judged* row) {
  return row == nullptr ? nlohmann::json()
                        : nlohmann::json{{"method", row->method},
                                         {"effort", row->effort},
                                         {"backend", row->backend},
                                         {"seconds_median", median(row->seconds)},
                                         {"rmsd_to_fem_nu0", row->deviations.to_fem_no_poisson}};
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
  const std::vector<double> requests = options.quick
                                           ? std::vector{1.0, 0.1}
                                           : std::vector{5.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01};
  for (const double poisson : is_wanted(requested_name) ? poisson_ratios : std::set<double>{}) {
    for (const double asked : requests) {
      Setting setting{{.method = std::string(requested_name),
                       .effort = fmt::format("{:.3g} px asked", asked),
                       .poisson_used = poisson,
                       .asked = asked},
                      scene,
                      Where::main_place};
      use_energy(setting.scene, elastic);
      setting.scene.elastic.poisson = poisson;
      judge.add(setting);
    }
  }
  for (const Rival& rival : rivals(scene, judge.truths(), options.quick)) {
    if (is_wanted(rival.told.method)) {
      judge.add(rival);
    }
  }
  mark_front(judge.rows());
  return std::move(judge.rows());
}

void mark_front(std::vector<Judged>& rows) {
  const auto error = [](const Judged* row) { return row->deviations.to_fem_no_poisson; };
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
      if (is_result(row) && condition(row) && row.deviations.to_fem_no_poisson <= target &&
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
                                    {"poisson", scene.elastic.poisson},
                                    {"target", target},
                                    {"nearest", nullptr},
                                    {"ours", setting(ours)}},
                                   scene.extent());
  for (const Judged& row : rows) {
    if (is_result(row) && !row.is_rival) {
      const double error = row.deviations.to_fem_no_poisson;
      equal["nearest"] = equal["nearest"].is_null() ? error : std::min(equal["nearest"].get<double>(), error);
    }
  }
  for (const auto& [key, method] : {std::pair("direct", "fem"),
                                    {"iterative", "fem-cg"},
                                    {"multigrid", "fem-amg"},
                                    {"coarse", "fem-coarse"}}) {
    const Judged* const rival =
        fastest([&](const Judged& row) { return row.method == method && row.poisson_used == 0.0; });
    equal[key] = setting(ours != nullptr ? rival : nullptr);
    if (!equal[key].is_null()) {
      equal[key]["ratio"] = median(rival->seconds) / median(ours->seconds);
    }
  }
  return equal;
}

} // namespace hdmbench
