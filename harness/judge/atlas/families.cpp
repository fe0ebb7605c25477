#include "harness/judge/atlas/atlas.hpp"
#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/joined.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"

#include <families_text.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <random>

/// The scenes of families.json along their knobs, and what is measured of their fields.
namespace hdmbench::atlas {

namespace {

constexpr int two_material_side = 96; // pixels
constexpr int condition_side = 100;   // targets of 16.67 px, which are no sum of candidates

template <typename Field, typename Change>
void for_each_value(Field& field, const Change& change) {
  std::ranges::for_each(field.x, change);
  std::ranges::for_each(field.y, change);
}

/// A shipped scene of `size` x `size` pixels with its displacements multiplied by `size` / 300, so that
/// strains are those of the thesis at every size.
Scene shipped(const char* name, int size) {
  Scene scene = load_scene(name, {.size = Extent{size, size}});
  for_each_value(scene.full.target, [&](float& value) { value *= static_cast<float>(size) / 300.0F; });
  return scene;
}

/// Whether a site of an image is stiff.
using Where = std::function<bool(Extent extent, int x, int y)>;

/// The square scene (left border dx < 0, bottom border dy > 0, the other two 0), 10 MPa and `ratio` times
/// that where `is_stiff`.
Scene of_two_materials(const Where& is_stiff, double ratio, int size = two_material_side) {
  Scene scene = shipped("square", size);
  for_each_site(scene.extent(), [&](int x, int y) {
    scene.full.modulus.values[scene.extent().index(x, y)] =
        is_stiff(scene.extent(), x, y) ? 10.0F * static_cast<float>(ratio) : 10.0F;
  });
  set_inverse_modulus(scene.full);
  return scene;
}

Scene of_one_material(int size) {
  return of_two_materials([](Extent, int, int) { return false; }, 1.0, size);
}

/// Inside the square in the middle, a third of the image wide, of the square scene.
bool in_inclusion(Extent extent, int x, int y) {
  return std::abs(x - extent.width / 2) <= extent.width / 6 &&
         std::abs(y - extent.height / 2) <= extent.height / 6;
}

/// Prescribes both components of a site, confidence 1.
void hold(Scene& scene, int x, int y, float dx, float dy) {
  const std::size_t site = scene.extent().index(x, y);
  scene.full.target.x[site] = dx;
  scene.full.target.y[site] = dy;
  scene.full.confidence.x[site] = 1.0F;
  scene.full.confidence.y[site] = 1.0F;
}

Problem against_fixed_point(Scene scene) {
  ReferenceField truth = solve_fixed_point(scene.full).displacement;
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

/// A scene that no unique answer belongs to has an empty truth: every method has to refuse it.
Problem against_finite_elements(Scene scene) {
  ReferenceField truth;
  try {
    truth = find_finite_elements(scene.full, scene.poisson);
  } catch (const InputError&) {
    truth = {};
  }
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

using MakeProblem = std::function<Problem(double knob)>;

MakeProblem stiff_where(const Where& is_stiff) {
  return [is_stiff](double ratio) { return against_fixed_point(of_two_materials(is_stiff, ratio)); };
}
MakeProblem elastic_where(const Where& is_stiff) {
  return [is_stiff](double ratio) { return against_finite_elements(of_two_materials(is_stiff, ratio)); };
}

Problem of_a_rim(double wide) {
  constexpr int size = 128;
  const int width = static_cast<int>(wide);
  Scene scene = of_one_material(size);
  for_each_site(scene.extent(), [&](int x, int y) {
    if (x < width || y < width || x >= size - width || y >= size - width) {
      // The values of a field that is its own fixed point, bent so that no level is right by chance.
      const float u = static_cast<float>(x) / (size - 1);
      const float v = static_cast<float>(y) / (size - 1);
      hold(scene, x, y, 20.0F * (u - 1.0F) * (1.0F - 0.5F * v), 20.0F * v * u);
    }
  });
  return against_fixed_point(std::move(scene));
}

/// The square scene, to begin on the full image with the answer plus independent noise of `amplitude` px: a
/// rough field from elsewhere (thesis 9.5).
Problem rough(double amplitude) {
  Problem problem = against_fixed_point(shipped("square", 64));
  problem.scene.schedule.start_level = 0;
  std::minstd_rand random(1);
  for_each_value(problem.scene.start.emplace(problem.truth.to_float()), [&](float& value) {
    const auto uniform = static_cast<float>(random()) / static_cast<float>(std::minstd_rand::max());
    value += static_cast<float>(amplitude) * (2.0F * uniform - 1.0F);
  });
  return problem;
}

Problem hard_conditions_with(double penalty) {
  Problem problem = against_fixed_point(shipped("square", condition_side));
  set_weight(problem.scene, {.penalty = penalty});
  return problem;
}

Problem shifted(double offset) {
  Problem problem = against_fixed_point(shipped("square", condition_side));
  Scene& scene = problem.scene;
  const auto shift = [&](float& value) { value += static_cast<float>(offset); };
  for_each_value(scene.start.emplace(scene.start_field()), shift);
  for_each_value(scene.full.target, shift);
  for_each_value(problem.truth, [&](double& value) { value += offset; });
  return problem;
}

Problem of_confidence(double confidence) {
  Scene scene = shipped("square", condition_side);
  for (int y = 0; y < condition_side; ++y) {
    scene.full.confidence.x[scene.extent().index(0, y)] = static_cast<float>(confidence);
  }
  return against_fixed_point(std::move(scene));
}

/// The square scene with dy given only by `count` sites in the middle of the top border, as 0; the start is
/// 10 px everywhere.
Problem few_conditions(double count) {
  Scene scene = shipped("square", 64);
  std::ranges::fill(scene.full.confidence.y, 0.0F);
  std::ranges::fill(scene.full.target.y, 0.0F);
  std::ranges::fill(scene.start.emplace(scene.extent()).y, 10.0F);
  for (int i = 0; i < static_cast<int>(count); ++i) {
    scene.full.confidence.y[scene.extent().index(32 + (i % 2 == 0 ? i / 2 : -1 - i / 2), 0)] = 1.0F;
  }
  return {.scene = std::move(scene)};
}

Problem in_conflict(double difference) {
  Scene scene = of_one_material(two_material_side);
  for_each_value(scene.full.target, [](float& value) { value = 0.0F; });
  const auto half = static_cast<float>(difference / 2.0);
  hold(scene, two_material_side / 2 - 1, two_material_side / 2, half, 0.0F);
  hold(scene, two_material_side / 2, two_material_side / 2, -half, 0.0F);
  return {.scene = std::move(scene)};
}

Problem pressed(double percent) {
  Scene scene = shipped("circular-radial", two_material_side);
  const auto factor = static_cast<float>(percent / (100.0 * 20.0 / 300.0));
  for_each_value(scene.full.target, [&](float& value) { value *= factor; });
  return {.scene = std::move(scene)};
}

Problem that_bulges(double poisson) {
  Scene scene = shipped("circular", two_material_side);
  ReferenceField truth = find_finite_elements(scene.full, poisson);
  return {.scene = std::move(scene), .truth = std::move(truth)};
}

Problem elastic_that_bulges(double poisson) {
  Scene scene = shipped("circular", two_material_side);
  scene.poisson = poisson;
  return against_finite_elements(std::move(scene));
}

Problem held_at(double sites) {
  Scene scene = of_two_materials(in_inclusion, 10.0);
  for_each_value(scene.full.confidence, [](float& value) { value = 0.0F; });
  std::mt19937_64 engine(5);
  for (int i = 0; i < static_cast<int>(sites); ++i) {
    const int x = static_cast<int>(engine() % two_material_side);
    const int y = static_cast<int>(engine() % two_material_side);
    hold(scene, x, y, static_cast<float>(0.05 * x + 0.03 * y), static_cast<float>(0.02 * x - 0.04 * y));
  }
  return against_finite_elements(std::move(scene));
}

const std::map<std::string_view, MakeProblem> problems{
    {"start-level-late", [](double) { return against_fixed_point(shipped("square", 128)); }},
    {"alignment", of_a_rim},
    {"step-quantum", [](double) { return against_fixed_point(shipped("square", 96)); }},
    {"oscillation", [](double) { return rough(2.0); }},
    {"two-cycles", rough},
    {"cooling", [](double) { return against_fixed_point(shipped("square", 64)); }},
    {"penalty-small", hard_conditions_with},
    {"offset", shifted},
    {"confidence", of_confidence},
    {"undetermined", few_conditions},
    {"stiff-inclusion", stiff_where(in_inclusion)},
    {"soft-inclusion", stiff_where([](Extent extent, int x, int y) { return !in_inclusion(extent, x, y); })},
    {"checkerboard", stiff_where([](Extent, int x, int y) { return (x + y) % 2 != 0; })},
    {"layers", stiff_where([](Extent extent, int x, int) { return x % 2 == 1 && x < extent.width / 2; })},
    {"conflict", in_conflict},
    {"fold-over", pressed},
    {"poisson", that_bulges},
    {"elastic-contrast", elastic_where(in_inclusion)},
    {"elastic-poisson", elastic_that_bulges},
    {"elastic-layers",
     elastic_where([](Extent extent, int x, int y) { return x < extent.width / 2 && y % 4 < 1; })},
    {"elastic-supports", held_at},
    {"elastic-free-body", elastic_where([](Extent extent, int x, int y) {
       return !in_inclusion(extent, x, y) &&
              std::min({x, y, extent.width - 1 - x, extent.height - 1 - y}) >= 3;
     })}};

double rmsd_to_truth(const Problem& problem, const Outcome& outcome) {
  return rmsd(ReferenceField(outcome.displacement), problem.truth);
}

double moving_percent(const Problem&, const Outcome& outcome) {
  return 100.0 * outcome.share_moving;
}

double mean_dy(const Problem&, const Outcome& outcome) {
  double sum = 0.0;
  for (const float value : outcome.displacement.y) {
    sum += static_cast<double>(value);
  }
  return std::abs(sum) / static_cast<double>(outcome.displacement.y.size());
}

double folded_percent(const Problem&, const Outcome& outcome) {
  const std::vector<float> ratios = least_area_ratios(outcome.displacement).values;
  const auto folded = std::ranges::count_if(ratios, [](float ratio) { return !(ratio > 0.0F); });
  return 100.0 * static_cast<double>(folded) / static_cast<double>(ratios.size());
}

using Error = double (*)(const Problem& problem, const Outcome& outcome);
const std::map<std::string_view, Error> errors{{"two-cycles", moving_percent},
                                               {"undetermined", mean_dy},
                                               {"conflict", folded_percent},
                                               {"fold-over", folded_percent}};

/// Candidates 0 and +-1, +-0.3, +-0.1, ... down to the knob.
void step_down_to(Scene& scene, double knob) {
  std::vector<float> steps{0.0F};
  for (const double step : {1.0, 0.3, 0.1, 0.03, 0.01, 0.003}) {
    if (step >= knob) {
      steps.push_back(static_cast<float>(-step));
      steps.push_back(static_cast<float>(step));
    }
  }
  scene.full.steps = StepSet(steps);
}

using Adjust = void (*)(Scene& scene, double knob);
const std::map<std::string_view, Adjust> adjustments{
    {"", [](Scene&, double) {}},
    {"start level", [](Scene& scene, double knob) { scene.schedule.start_level = static_cast<int>(knob); }},
    {"center", [](Scene& scene, double) { scene.schedule.alignment = Alignment::center; }},
    {"smallest step", step_down_to},
    {"relaxation", [](Scene& scene, double knob) { scene.schedule.relaxation = {.factor = knob}; }},
    {"relaxation in two colours",
     [](Scene& scene, double knob) {
       scene.schedule.relaxation = {.factor = knob};
       scene.full.update = Update::coloured;
     }},
    {"iterations", [](Scene& scene, double knob) { scene.schedule.iterations = static_cast<int>(knob); }},
    {"30 iterations", [](Scene& scene, double) { scene.schedule.iterations = 30; }},
    {"300 iterations", [](Scene& scene, double) { scene.schedule.iterations = 300; }}};

} // namespace

void adjust(Scene& scene, const Series& series, double knob) {
  adjustments.at(series.adjust)(scene, knob);
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = [] {
    auto read = nlohmann::json::parse(sources::families_text).get<std::vector<Entry>>();
    for (Entry& entry : read) {
      entry.problem = problems.at(entry.name);
      entry.error = errors.contains(entry.name) ? errors.at(entry.name) : rmsd_to_truth;
    }
    return read;
  }();
  return all;
}

const Entry& find_entry(std::string_view name) {
  const auto found = std::ranges::find(entries(), name, &Entry::name);
  if (found == entries().end()) {
    std::vector<std::string> names;
    std::ranges::transform(entries(), std::back_inserter(names), &Entry::name);
    throw InputError(
        fmt::format("the atlas has no entry \"{}\"; its entries are {}", name, joined(names, ", ")));
  }
  return *found;
}

} // namespace hdmbench::atlas
