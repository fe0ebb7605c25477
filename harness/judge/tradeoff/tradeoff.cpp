#include "harness/judge/tradeoff/tradeoff.hpp"

#include "harness/judge/tradeoff/comparison.hpp"
#include "harness/scene/joined.hpp"
#include "harness/solve/methods/sampled_image.hpp"
#include "harness/solve/planner.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/elastic_krylov.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

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

/// Coarser ones show too little to be a choice.
bool is_shown(Extent image, int stride) {
  constexpr int fewest_sites = 16;
  const Extent sampled = sampled_extent(image, stride);
  return std::min(sampled.width, sampled.height) > fewest_sites;
}

class Measurement {
public:
  Measurement(const Scene& scene, std::span<const Backend* const> backends, const TradeoffOptions& options,
              Progress& progress)
      : scene_(scene), options_(options), progress_(progress),
        judge_(scene, backends, {.session = options.session, .repeats = options.quick ? 1 : options.repeats},
               progress) {}

  std::vector<Judged> run() {
    for (const Method& method : methods()) {
      if (is_wanted(method.name)) {
        measure_method(method, std::nullopt);
      }
    }
    for (const Method& method : elastic_methods()) {
      for (const double poisson : is_wanted(method.name) ? poisson_ratios() : std::vector<double>{}) {
        measure_method(method, poisson);
      }
    }
    for (const double poisson : is_wanted(requested_name) ? poisson_ratios() : std::vector<double>{}) {
      measure_requests(poisson);
    }
    for (const Rival& rival : rivals(scene_, judge_.truths(), options_.quick)) {
      if (is_wanted(rival.name)) {
        Judged& row = judge_.add_rival(rival);
        row.command = options_.command ? options_.command(rival.name, std::nullopt, "") : "";
      }
    }
    mark_front(judge_.rows());
    return std::move(judge_.rows());
  }

private:
  [[nodiscard]] bool is_wanted(std::string_view name) const {
    return options_.methods.empty() || std::ranges::find(options_.methods, name) != options_.methods.end();
  }

  /// Of the elastic energy: as finite elements, against which it stands.
  [[nodiscard]] std::vector<double> poisson_ratios() const {
    return scene_.poisson == 0.0 ? std::vector{0.0} : std::vector{0.0, scene_.poisson};
  }

  /// `poisson`: of the elastic energy, in place of the scene's.
  void measure_method(const Method& method, std::optional<double> poisson) {
    const int usual = usual_effort(method, scene_.schedule.iterations);
    for (const Effort& effort :
         efforts(method, scene_.schedule.iterations, scene_.extent(), options_.quick)) {
      const bool is_usual = effort.iterations == usual && effort.stride == 1;
      Scene scene = scene_;
      use_method(scene, method, effort.iterations);
      scene.schedule.stride = effort.stride;
      scene.poisson = poisson.value_or(scene.poisson);
      const Judge::Place& main = judge_.main_place(scene.full.update);
      const std::size_t first = judge_.rows().size();
      judge_.add_solutions(
          {.method = std::string(method.name),
           .effort = effort_text(method, effort),
           .poisson_used = poisson},
          scene, [&](const Judge::Place& place) { return &place == &main || (is_usual && !options_.quick); });
      for (Judged& row : std::span(judge_.rows()).subspan(first)) {
        row.command = options_.command ? options_.command(method.name, effort, row.backend) : "";
      }
    }
  }

  /// What `run --accuracy` gives. Without a limit of time a plan depends on the scene alone, so the reference
  /// must come to the same field.
  void measure_requests(double poisson) {
    Scene scene = scene_;
    use_method(scene, usual_method(EnergyModel::elastic));
    scene.poisson = poisson;
    const Judge::Place& place = judge_.main_place(Update::coloured);
    for (const double asked : options_.quick ? std::vector{1.0, 0.1}
                                             : std::vector{5.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02}) {
      Judged& row = judge_.rows().emplace_back(Judged{.method = std::string(requested_name),
                                                      .effort = fmt::format("{:.3g} px asked", asked),
                                                      .energy = EnergyModel::elastic,
                                                      .poisson_used = poisson,
                                                      .backend = std::string(place.backend->name()),
                                                      .device = place.device,
                                                      .asked = asked});
      row.command = options_.request_command ? options_.request_command(asked, row.backend) : "";
      progress_.describe(fmt::format("{}: {}", scene.name, row.effort));
      const auto plan_on = [&](const Judge::Place& where) {
        Progress silent(false);
        return solve_as_needed(scene, {.accuracy = asked}, *where.backend, options_.session, silent);
      };
      Plan plan;
      const auto solve = [&] { plan = plan_on(place); };
      if (!judge_.sample(row, solve, solve)) {
        continue;
      }
      row.fine_sweep_equivalents = fine_sweep_equivalents(plan);
      row.estimated = plan.solution.estimated_error;
      if (!judge_.judge(row, ReferenceField(plan.solution.displacement))) {
        continue;
      }
      if (!plan.met) {
        row.fail(JudgedStatus::failed, plan.outcome);
        continue;
      }
      judge_.expect([&] { return plan_on(judge_.reference()).solution.displacement; });
      judge_.check_bits(row, plan.solution.displacement);
    }
  }

  const Scene& scene_;
  const TradeoffOptions& options_;
  Progress& progress_;
  Judge judge_;
};

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

} // namespace

int usual_effort(const Method& method, int own_iterations) {
  constexpr int most_annealing = 40; // 200 take scalar half a minute, and every point is checked against it
  if (method.name == "annealing") {
    return most_annealing;
  }
  return method.usual_effort > 0 ? method.usual_effort : own_iterations;
}

std::string effort_text(const Method& method, Effort effort) {
  if (effort.stride > 1) {
    return fmt::format("{} cycles on every {} pixel", effort.iterations, ordinal(effort.stride));
  }
  std::string text = fmt::format("{} {}", effort.iterations, method.effort);
  if (effort.iterations == 1) {
    for (const std::string_view plural : {"iterations", "cycles", "steps"}) {
      const std::size_t at = text.find(plural);
      if (at != std::string::npos) {
        text.erase(at + plural.size() - 1, 1);
      }
    }
  }
  return text;
}

std::vector<Effort> efforts(const Method& method, int own_iterations, Extent image, bool quick) {
  const int usual = usual_effort(method, own_iterations);
  const auto found = std::ranges::find(known, method.name, &Efforts::method);
  std::vector<int> counts;
  if (found != known.end()) {
    counts.assign(found->counts.begin(), found->counts.end());
  }
  if (quick && !counts.empty()) {
    counts.resize(2);
  } else {
    counts.push_back(usual);
  }
  std::ranges::sort(counts);
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  std::vector<Effort> result;
  if (method.name == elastic_full_multigrid && !quick) {
    for (int stride = 4; is_shown(image, stride); stride *= 2) {
      result.insert(result.begin(), {.iterations = usual, .stride = stride});
    }
  }
  std::ranges::transform(counts, std::back_inserter(result),
                         [](int iterations) { return Effort{.iterations = iterations}; });
  return result;
}

std::vector<Judged> measure_tradeoff(const Scene& scene, std::span<const Backend* const> backends,
                                     const TradeoffOptions& options, Progress& progress) {
  require_known(options.methods);
  return Measurement(scene, backends, options, progress).run();
}

} // namespace hdmbench
