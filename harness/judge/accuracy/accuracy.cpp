#include "harness/judge/accuracy/accuracy.hpp"

#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/judge/registration/elastic_registration.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/mean_energy.hpp"
#include "reference/interpolation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace hdmbench {

namespace {

/// The thesis's GPU design: simultaneous, a fixed number of iterations.
Scene gpu_design(Scene scene) {
  scene.full.update = Update::simultaneous;
  scene.schedule.stop = Stop::fixed;
  return scene;
}

/// The thesis's CPU design: in place, until nothing moves. Two neighbours can pass a step to and fro for
/// ever, because no site's energy is part of a common one; so there is a limit.
Scene cpu_design(Scene scene) {
  scene.full.update = Update::sequential;
  scene.schedule.stop = Stop::still;
  scene.schedule.iterations = std::max(scene.schedule.iterations, 1000);
  return scene;
}

class Measurement {
public:
  Measurement(const Scene& scene, std::span<const Backend* const> backends, const AccuracyOptions& options,
              Progress& progress)
      : scene_(scene), backends_(backends), options_(options), progress_(progress),
        registry_(make_backends()), fast_(find_backend(registry_, "openmp")) {
    result_.truths = find_truths(scene, progress);
  }

  SceneAccuracy run() {
    add_truths();
    if (scene_.energy == EnergyModel::elastic) {
      add_elastic_methods();
      return std::move(result_);
    }
    const std::size_t first = result_.rows.size();
    const Scene icm = gpu_design(scene_);
    for (const Backend* backend : backends_) {
      add_solution(icm, *backend, options_.repeats);
    }
    JudgedField& reference = result_.rows[first];
    describe_reference(icm, reference);
    if (!options_.quick) {
      add_arithmetic(icm, first);
      reference.convergence = converge(icm);
    }
    const Scene cpu = cpu_design(scene_);
    JudgedField& in_place = add_solution(cpu, *backends_.front(), options_.repeats);
    add_profiles(in_place);
    note_limit(cpu, in_place);
    if (!options_.quick) {
      add_variants(icm);
    }
    if (options_.registration) {
      add_registration();
    }
    return std::move(result_);
  }

private:
  static void add_profiles(JudgedField& row) { row.profiles = figures::profiles(row.field); }

  /// Says so where a level of "until nothing moves" ended at its limit.
  static void note_limit(const Scene& scene, JudgedField& row) {
    for (const LevelResult& level : row.levels) {
      if (level.changed > 0) {
        row.note = fmt::format("ended by its limit of {} iterations on level {}, {} still moving",
                               scene.schedule.iterations, level.level,
                               level.changed == 1 ? "1 site" : fmt::format("{} sites", level.changed));
      }
    }
  }

  [[nodiscard]] GridFigure grid(const ReferenceField& field) const {
    const int spacing = grid_spacing(field.extent);
    return {spacing, figures::deformed_grid(field, spacing), figures::deformed_interfaces(scene_, field)};
  }

  /// Judges a field that stands by itself.
  JudgedField& add_field(std::string method, ReferenceField field, double seconds) {
    JudgedField& row = result_.rows.emplace_back();
    row.method = std::move(method);
    row.field = std::move(field);
    row.seconds = {seconds};
    judge(row);
    return row;
  }

  void judge(JudgedField& row) const {
    row.mean_energy = mean_energy(scene_.full, row.field.to_float());
    row.deviations = measure(row.field, result_.truths);
    if (!std::isfinite(row.mean_energy) || !std::isfinite(row.deviations.to_fem)) {
      row.valid = false;
      row.status = "the field has values that are not finite";
    }
  }

  void add_truths() {
    const Truths& truths = result_.truths;
    JudgedField& elastic = add_field("fem", truths.elastic.displacement, truths.elastic.seconds);
    elastic.poisson_used = truths.elastic.poisson;
    elastic.energy = EnergyModel::elastic;
    add_profiles(elastic);
    elastic.grid = grid(elastic.field);
    JudgedField& no_poisson =
        add_field("fem", truths.elastic_no_poisson.displacement, truths.elastic_no_poisson.seconds);
    no_poisson.poisson_used = 0.0;
    no_poisson.energy = EnergyModel::elastic;
    add_profiles(no_poisson);
    constexpr int thesis_elements = 60;
    FiniteElements coarse = coarse_finite_elements(scene_, thesis_elements, scene_.poisson);
    JudgedField& few = add_field("fem-coarse", std::move(coarse.displacement), coarse.seconds);
    few.poisson_used = coarse.poisson;
    few.energy = EnergyModel::elastic;
    JudgedField& rest = add_field("fixed-point", truths.fixed_point.displacement, truths.fixed_point_seconds);
    rest.energy = EnergyModel::hdm;
    add_profiles(rest);
    const auto start = std::chrono::steady_clock::now();
    ReferenceField interpolated = interpolate_conditions(scene_.full);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    add_profiles(add_field("interpolation", std::move(interpolated), seconds));
  }

  JudgedField& add_solution(const Scene& scene, const Backend& backend, int repeats) {
    JudgedField& row = result_.rows.emplace_back();
    row.method = method_name(scene);
    row.backend = backend.name();
    progress_.describe(fmt::format("accuracy {}: {} on {}", scene_.name, row.method, row.backend));
    row.energy = scene.energy;
    if (const std::string why = why_not_solved(scene, backend); !why.empty()) {
      row.valid = false;
      row.status = fmt::format("skipped: {} {}", backend.name(), why);
      return row;
    }
    try {
      row.device = backend.device(options_.session);
      Solver solver(backend, options_.session);
      Solution solution;
      for (int i = 0; i < repeats; ++i) {
        solution = solver.solve(scene, progress_, {.last_changed = true});
        row.seconds.push_back(solution.timings.total());
      }
      check_bits(row, solution.displacement);
      row.levels = std::move(solution.levels);
      row.field = ReferenceField(solution.displacement);
    } catch (const DeviceError& error) {
      row.valid = false;
      row.status = fmt::format("skipped: {}", error.what());
      return row;
    }
    judge(row);
    if (scene.energy == EnergyModel::elastic) { // whose minimum is no fixed point of the thesis's
      return row;
    }
    for (const FiniteElements* fem : {&result_.truths.elastic_no_poisson, &result_.truths.elastic}) {
      row.decompositions.push_back(
          {fem->poisson, decompose(row.field, result_.truths.fixed_point.displacement, fem->displacement)});
    }
    return row;
  }

  void check_bits(JudgedField& row, const VectorField& found) {
    if (row.method == "sequential") {
      return;
    }
    if (expected_.extent != found.extent) {
      expected_ = found;
      return;
    }
    const FieldDifference apart = compare(expected_, found);
    if (apart.sites != 0) {
      row.valid = false;
      row.status = fmt::format("{} sites differ from {}, by up to {:.3g} px", apart.sites,
                               backends_.front()->name(), apart.largest);
    }
  }

  void add_elastic_methods() {
    for (const Method& method : elastic_methods()) {
      Scene scene = scene_;
      use_method(scene, method);
      expected_ = VectorField();
      const std::size_t first = result_.rows.size();
      for (const Backend* const backend : backends_) {
        add_solution(scene, *backend, options_.repeats);
      }
      add_profiles(result_.rows[first]);
    }
  }

  void describe_reference(const Scene& icm, JudgedField& row) {
    add_profiles(row);
    row.grid = grid(row.field);
    row.with_difference = true;
    const auto session = fast_.open(options_.session);
    (void)solve(
        icm, *session, progress_,
        {.last_changed = false, .level_done = [&](const LevelResult& level, const VectorField& field) {
           row.level_profiles.push_back(figures::level_profile(level.level, field));
         }});
  }

  void add_arithmetic(const Scene& icm, std::size_t first) {
    const std::vector<ArithmeticError> errors =
        measure_arithmetic(icm, fast_, backends_, options_.session, options_.arithmetic_stride, progress_);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (errors[i].reason.empty()) {
        result_.rows[first + i].arithmetic = errors[i];
      }
    }
    const ReferenceField in_double = solve_in_double(icm, progress_);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      JudgedField& row = result_.rows[first + i];
      if (row.arithmetic) {
        row.rmsd_to_double = rmsd(row.field, in_double);
      }
    }
  }

  Convergence converge(Scene scene) {
    constexpr std::array iterations{1,  2,   3,   5,   7,   10,  15,  20,  30,  50,
                                    70, 100, 150, 200, 250, 350, 500, 700, 1000};
    Convergence result;
    const auto session = fast_.open(options_.session);
    for (const int count : iterations) {
      progress_.describe(fmt::format("accuracy {}: {} iterations a level", scene.name, count));
      scene.schedule.iterations = count;
      const Solution solution = solve(scene, *session, progress_);
      const ReferenceField field(solution.displacement);
      result.iterations_per_level.push_back(count);
      result.rmsd_to_fem.push_back(rmsd(field, result_.truths.elastic.displacement));
      result.rmsd_to_fixed_point.push_back(rmsd(field, result_.truths.fixed_point.displacement));
      result.mean_energy.push_back(mean_energy(scene.full, solution.displacement));
    }
    return result;
  }

  void add_variant(const Scene& scene, const char* variant, const char* note) {
    const VectorField expected = std::move(expected_);
    expected_ = VectorField(); // another answer is meant to come out
    JudgedField& row = add_solution(scene, fast_, 1);
    row.variant = variant;
    row.note = note;
    expected_ = expected;
  }

  void add_variants(const Scene& icm) {
    Scene scene = icm;
    scene.full.steps = StepSet::parse("thesis");
    add_variant(
        scene, "step set without 0",
        "Every site has to move at every iteration, so the field never rests: a floor of the error of "
        "the size of the smallest step.");
    scene = icm;
    scene.full.steps = StepSet::parse("0,-1,0.1,1");
    add_variant(
        scene, "step set as printed, with 0",
        "The thesis prints {-1, 0.1, 1, 0.1}. Read without the -0.1 that it seems to mean, a component "
        "can creep up but not down.");
    scene = icm;
    scene.full.steps = StepSet::parse("fine");
    add_variant(
        scene, "step set with 0.01",
        "Steps of 0.1 px no longer pay where the field is smooth; a smaller quantum moves that floor.");
    scene = icm;
    scene.schedule.alignment = Alignment::center;
    add_variant(
        scene, "pixel-centred pyramid",
        "Coarse levels sampled at pixel centres lose conditions that are one pixel wide, such as those "
        "on the image border.");
    scene = icm;
    scene.schedule.iterations = 10 * scene.schedule.iterations;
    add_variant(scene, "ten times the iterations", "What more iterations alone would bring.");
  }

  /// The finite elements deform the picture, the registration has to find out how (thesis 5.11).
  void add_registration() {
    const VectorField truth = result_.truths.elastic.displacement.to_float();
    RegistrationResult found =
        register_elastically(scene_.picture, warp(scene_.picture, truth), {}, progress_);
    JudgedField& row =
        add_field(std::string(registration_name), ReferenceField(found.displacement), found.seconds);
    row.grid = grid(row.field);
    if (const std::string why = why_astray(row.field, result_.truths.elastic.displacement);
        row.valid && !why.empty()) {
      row.valid = false;
      row.status = why;
    }
  }

  const Scene& scene_;
  std::span<const Backend* const> backends_;
  const AccuracyOptions& options_;
  Progress& progress_;
  std::vector<std::unique_ptr<Backend>> registry_;
  const Backend& fast_;  ///< where only the field counts; all backends give the same
  VectorField expected_; ///< the reference's field
  SceneAccuracy result_;
};

} // namespace

std::string why_astray(const ReferenceField& found, const ReferenceField& truth) {
  const int longer = std::max(found.extent.width, found.extent.height);
  const double largest = largest_magnitude(found.to_float());
  if (largest > longer) {
    return fmt::format("went astray: it moves a site by {:.0f} px in an image of {} px", largest, longer);
  }
  const double distance = rmsd(found, truth);
  const double of_nothing = rmsd(ReferenceField(truth.extent), truth);
  if (distance > of_nothing) {
    return fmt::format(
        "went astray: {:.3g} px from finite elements, where no displacement at all is {:.3g} px", distance,
        of_nothing);
  }
  return {};
}

SceneAccuracy measure_accuracy(const Scene& scene, std::span<const Backend* const> backends,
                               const AccuracyOptions& options, Progress& progress) {
  return Measurement(scene, backends, options, progress).run();
}

} // namespace hdmbench
