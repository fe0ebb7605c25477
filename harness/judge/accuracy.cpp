#include "harness/judge/accuracy.hpp"

#include "harness/applications/conventional_registration.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hdmbench {

namespace {

/// What differs from the thesis's GPU design, and what that shows.
struct Variant {
  const char* name;
  const char* note;
  void (*change)(Scene& scene);
};

constexpr std::array variants{
    Variant{"step set without 0", "Every site has to move at every iteration, so the field never rests.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("thesis"); }},
    Variant{"step set as printed, with 0",
            "The thesis prints {-1, 0.1, 1, 0.1}: without -0.1 a component can creep up but not down.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("0,-1,0.1,1"); }},
    Variant{"step set with 0.01", "Steps of 0.1 px no longer pay where the field is smooth.",
            [](Scene& scene) { scene.full.steps = StepSet::parse("fine"); }},
    Variant{"pixel-centred pyramid",
            "Coarse levels sampled at pixel centres lose conditions that are one pixel wide.",
            [](Scene& scene) { scene.schedule.alignment = Alignment::center; }},
    Variant{"ten times the iterations", "What more iterations alone would bring.",
            [](Scene& scene) { scene.schedule.iterations *= 10; }}};

class Measurement {
public:
  Measurement(const Scene& scene, std::span<const Backend* const> backends, const AccuracyOptions& options,
              Progress& progress)
      : scene_(scene), backends_(backends), options_(options), progress_(progress),
        judge_(scene, backends,
               {.session = options.session, .repeats = options.repeats, .keeps_fields = true}, progress) {}

  SceneAccuracy run() {
    for (const Rival& rival : rivals(scene_, judge_.truths(), true)) {
      if (rival.name != "fem-cg" && rival.name != "fem-amg") { // the same field as fem
        judge_.add_rival(rival);
      }
    }
    if (!scene_.energy->is_of_cells()) {
      add_thesis_methods();
    } else {
      for (const Method& method : scene_.energy->methods) {
        Scene scene = scene_;
        use_method(scene, method);
        add(scene, everywhere);
      }
    }
    return {.truths = judge_.truths(), .rows = std::move(judge_.rows())};
  }

private:
  using Place = Judge::Place;

  static bool everywhere(const Place& /*place*/) { return true; }

  /// Returns the first of the new rows.
  std::size_t add(const Scene& scene, const std::function<bool(const Place&)>& wanted,
                  const Variant& variant = {"", "", nullptr}) {
    return judge_.add_solutions({.method = method_name(scene), .variant = variant.name, .note = variant.note},
                                scene, wanted);
  }

  void add_thesis_methods() {
    // The thesis's GPU design: simultaneous, a fixed number of iterations.
    Scene icm = scene_;
    icm.full.update = Update::simultaneous;
    icm.schedule.stop = Stop::fixed;
    const std::size_t first = add(icm, everywhere);
    if (!options_.quick) {
      add_arithmetic(icm, first);
      judge_.rows()[first].convergence = converge(icm);
    }
    // Its CPU design: in place, until nothing moves. Two neighbours can pass a step to and fro for ever,
    // because no site's energy is part of a common one; so there is a limit.
    Scene in_place = scene_;
    in_place.full.update = Update::sequential;
    in_place.schedule.stop = Stop::still;
    in_place.schedule.iterations = std::max(in_place.schedule.iterations, 1000);
    const Place& reference = judge_.reference();
    note_limit(in_place,
               judge_.rows()[add(in_place, [&](const Place& place) { return &place == &reference; })]);
    const Place& main = judge_.main_place(Update::simultaneous);
    for (const Variant& variant : options_.quick ? std::span<const Variant>() : std::span(variants)) {
      Scene scene = icm;
      variant.change(scene);
      add(
          scene, [&](const Place& place) { return &place == &main; }, variant);
    }
    if (options_.registration) {
      add_registration();
    }
  }

  /// Says so where a level of "until nothing moves" ended at its limit.
  static void note_limit(const Scene& scene, Judged& row) {
    for (const LevelResult& level : row.levels) {
      if (level.changed > 0) {
        row.note = fmt::format("ended by its limit of {} iterations on level {}, sites still moving: {}",
                               scene.schedule.iterations, level.level, level.changed);
      }
    }
  }

  /// Of the reference, whose bits those have that agree with it, and of those that do not.
  void add_arithmetic(const Scene& icm, std::size_t first) {
    for (std::size_t i = 0; i < backends_.size(); ++i) {
      Judged& row = judge_.rows()[first + i];
      if (!row.field.x.empty() && (i == 0 || row.status == JudgedStatus::unverified)) {
        row.arithmetic =
            measure_arithmetic(icm, *backends_[i], options_.session, options_.arithmetic_stride, progress_);
      }
    }
  }

  Convergence converge(Scene scene) {
    constexpr std::array iterations{1,  2,   3,   5,   7,   10,  15,  20,  30,  50,
                                    70, 100, 150, 200, 250, 350, 500, 700, 1000};
    Convergence result;
    for (const int count : iterations) {
      progress_.describe(fmt::format("{}: {} iterations a level", scene.name, count));
      scene.schedule.iterations = count;
      const ReferenceField field(
          judge_.main_place(Update::simultaneous).solver.solve(scene, progress_).displacement);
      result.iterations_per_level.push_back(count);
      result.rmsd_to_fem.push_back(rmsd(field, judge_.truths().elastic.displacement));
      result.rmsd_to_fixed_point.push_back(rmsd(field, judge_.truths().fixed_point.displacement));
    }
    return result;
  }

  /// The finite elements deform the picture, the registration has to find out how (thesis 5.11).
  void add_registration() {
    const ReferenceField& truth = judge_.truths().elastic.displacement;
    const ScalarField target = warp(scene_.picture, truth.to_float());
    Judged& row = judge_.add_rival(
        {.name = registration_name, .solve = [&] {
           return ReferenceField(
               register_conventionally(scene_.picture, target, {}, {}, progress_).displacement);
         }});
    if (const std::string why = row.field.x.empty() ? "" : why_astray(row.field, truth); !why.empty()) {
      row.fail(JudgedStatus::failed, why);
    }
  }

  const Scene& scene_;
  std::span<const Backend* const> backends_;
  const AccuracyOptions& options_;
  Progress& progress_;
  Judge judge_;
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

nlohmann::json write_difference(const Scene& scene, const Truths& truths, const Judged& row,
                                const std::filesystem::path& json_folder) {
  const VectorField error = difference(row.field, truths.elastic_no_poisson.displacement).to_float();
  const double largest = std::max(largest_magnitude(error), 1e-6);
  const std::string file = fmt::format("{}-{}-difference-magnitude.png", scene.name, scene.extent().width);
  write_magnitude_png(json_folder / file, error, largest);
  return {{"pictures", {{"magnitude", file}}}, {"limit", largest}, {"against", "fem nu 0"}};
}

} // namespace hdmbench
