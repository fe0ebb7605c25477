#include "harness/judge/atlas/atlas.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/names.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/fixed_point.hpp"
#include "reference/large_strains.hpp"

#include <families_text.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <random>

/// The scenes of families.json along their knobs, and what is measured of their fields.
namespace hdmbench::atlas {

namespace {

template <typename Field, typename Change>
void for_each_value(Field& field, const Change& change) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    std::ranges::for_each(field[axis], change);
  }
}

using Step = std::function<void(Problem& problem, double knob)>;

/// Tissue of 10 MPa, and of the knob times that where `is_stiff`.
Step stiff_where(bool (*is_stiff)(Extent extent, int x, int y, int z)) {
  return [is_stiff](Problem& problem, double ratio) {
    Level& level = problem.scene.full;
    for_each_site(level.extent, [&](int x, int y, int z) {
      level.modulus.values[level.extent.index(x, y, z)] =
          is_stiff(level.extent, x, y, z) ? 10.0F * static_cast<float>(ratio) : 10.0F;
    });
    set_inverse_modulus(level);
  };
}

/// Inside the square or cube in the middle, a third of the image wide.
bool in_inclusion(Extent extent, int x, int y, int z) {
  return std::abs(x - extent.width / 2) <= extent.width / 6 &&
         std::abs(y - extent.height / 2) <= extent.height / 6 &&
         std::abs(z - extent.depth / 2) <= extent.depth / 6;
}

/// Between that and the outermost 3 pixels.
bool in_moat(Extent extent, int x, int y, int z) {
  return !in_inclusion(extent, x, y, z) && std::min({x, y, extent.width - 1 - x, extent.height - 1 - y}) >= 3;
}

/// Prescribes all components of a site, confidence 1; dz is 0.
void hold(Scene& scene, std::size_t site, float dx, float dy) {
  for (std::size_t axis = 0; axis < scene.extent().axes(); ++axis) {
    scene.full.target[axis][site] = axis == 0 ? dx : axis == 1 ? dy : 0.0F;
    scene.full.confidence[axis][site] = 1.0F;
  }
}

/// A scene that no unique answer belongs to has an empty truth: every method has to refuse it.
void add_finite_elements(Problem& problem, double /*knob*/) {
  try {
    problem.truth = find_finite_elements(problem.scene.full, problem.scene.elastic);
  } catch (const InputError&) {
    problem.truth = {};
  }
}

/// The same of neo-Hookean tissue; empty where Newton's method finds none.
void find_large_strains(Problem& problem, const ReferenceFibres* fibres) {
  const Scene& scene = problem.scene;
  problem.truth = {};
  for (const int parts : {4, 16}) { // of the load: few where they are enough
    try {
      problem.truth =
          solve_large_strains(elastic_problem(scene.full), std::vector<double>(scene.extent().sites()),
                              scene.elastic.poisson, parts, fibres);
      return;
    } catch (const InputError&) {
      continue;
    }
  }
}

void add_neo_hookean_elements(Problem& problem, double /*knob*/) {
  find_large_strains(problem, nullptr);
}

void be_neo_hookean(Problem& problem, double /*knob*/) {
  problem.scene.full.law_parameter = ScalarField(problem.scene.extent());
}

constexpr std::array<double, 3> along_fibres{0.8, 0.6, 0.0}; ///< a unit vector

/// Fibres in all tissues, so many times as stiff as each.
void add_fibre_elements(Problem& problem, double ratio) {
  const Level& level = problem.scene.full;
  ReferenceFibres fibres{.direction = {},
                         .modulus = {level.modulus.values.begin(), level.modulus.values.end()},
                         .tension_only = std::vector<bool>(level.extent.sites())};
  std::ranges::for_each(fibres.modulus, [&](double& modulus) { modulus *= ratio; });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fibres.direction[axis].assign(level.extent.sites(), along_fibres[axis]);
  }
  find_large_strains(problem, &fibres);
}

void have_fibres(Problem& problem, double ratio) {
  Level& level = problem.scene.full;
  level.fibre = VectorField(level.extent);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    const double component = along_fibres[axis] * std::sqrt(std::sqrt(ratio));
    std::ranges::fill(level.fibre[axis], static_cast<float>(component));
  }
  level.fibre_compression = ScalarField(level.extent, 1.0F);
}

/// Of a volume whose elements have a third of the side and the same moduli at the same places.
void add_finer_elements(Problem& problem, double /*knob*/) {
  const Level& coarse = problem.scene.full;
  const auto finer = [](int sites) { return 3 * (sites - 1) + 1; };
  const Extent extent{finer(coarse.extent.width), finer(coarse.extent.height), finer(coarse.extent.depth)};
  Level fine{.extent = extent,
             .target = VectorField(extent),
             .confidence = VectorField(extent),
             .modulus = ScalarField(extent)};
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t at = extent.index(x, y, z);
    fine.modulus.values[at] =
        coarse.modulus.values[coarse.extent.index((x + 1) / 3, (y + 1) / 3, (z + 1) / 3)];
    for (std::size_t axis = 0; axis < 3; ++axis) { // prescribed where all corners that count are
      float target = 0.0F;
      float confidence = 1.0F;
      for (int corner = 0; corner < 8; ++corner) {
        const auto weight = [&](int place, int bit) {
          return static_cast<float>((corner >> bit & 1) == 0 ? 3 - place % 3 : place % 3) / 3.0F;
        };
        const float share = weight(x, 0) * weight(y, 1) * weight(z, 2);
        if (share > 0.0F) {
          const std::size_t from =
              coarse.extent.index(x / 3 + (corner & 1), y / 3 + (corner >> 1 & 1), z / 3 + (corner >> 2));
          target += share * coarse.target[axis][from];
          confidence = std::min(confidence, coarse.confidence[axis][from]);
        }
      }
      fine.target[axis][at] = target;
      fine.confidence[axis][at] = confidence;
    }
  });
  set_inverse_modulus(fine);
  const ReferenceField found =
      find_finite_elements(fine, {problem.scene.elastic.poisson, Integration::selective_reduced});
  problem.truth = ReferenceField(coarse.extent);
  for_each_site(coarse.extent, [&](int x, int y, int z) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      problem.truth[axis][coarse.extent.index(x, y, z)] = found[axis][extent.index(3 * x, 3 * y, 3 * z)];
    }
  });
}

/// Sites at most `wide` from the border are known: the values of a field that is its own fixed point, bent so
/// that no level is right by chance.
void hold_rim(Problem& problem, double wide) {
  const Extent extent = problem.scene.extent();
  const int width = static_cast<int>(wide);
  for_each_site(extent, [&](int x, int y) {
    if (x < width || y < width || x >= extent.width - width || y >= extent.height - width) {
      const float u = static_cast<float>(x) / static_cast<float>(extent.width - 1);
      const float v = static_cast<float>(y) / static_cast<float>(extent.height - 1);
      hold(problem.scene, extent.index(x, y), 20.0F * (u - 1.0F) * (1.0F - 0.5F * v), 20.0F * v * u);
    }
  });
}

/// Begins on the full image with the answer plus independent noise of `amplitude` px: a rough field from
/// elsewhere (thesis 9.5).
void start_roughly(Problem& problem, double amplitude) {
  problem.scene.schedule.start_level = 0;
  std::minstd_rand random(1);
  for_each_value(problem.scene.start.emplace(problem.truth.to_float()), [&](float& value) {
    const auto uniform = static_cast<float>(random()) / static_cast<float>(std::minstd_rand::max());
    value += static_cast<float>(amplitude) * (2.0F * uniform - 1.0F);
  });
}

void add_offset(Problem& problem, double offset) {
  Scene& scene = problem.scene;
  const auto shift = [&](float& value) { value += static_cast<float>(offset); };
  for_each_value(scene.start.emplace(scene.start_field()), shift);
  for_each_value(scene.full.target, shift);
  for_each_value(problem.truth, [&](double& value) { value += offset; });
}

void trust_left_border(Problem& problem, double confidence) {
  Level& level = problem.scene.full;
  for (int y = 0; y < level.extent.height; ++y) {
    level.confidence[0][level.extent.index(0, y)] = static_cast<float>(confidence);
  }
}

/// dy is given only by `count` sites in the middle of the top border, as 0; the start is 10 px everywhere.
void know_few(Problem& problem, double count) {
  Scene& scene = problem.scene;
  const int middle = scene.extent().width / 2;
  std::ranges::fill(scene.full.confidence[1], 0.0F);
  std::ranges::fill(scene.full.target[1], 0.0F);
  std::ranges::fill(scene.start.emplace(scene.extent())[1], 10.0F);
  for (int i = 0; i < static_cast<int>(count); ++i) {
    scene.full.confidence[1][scene.extent().index(middle + (i % 2 == 0 ? i / 2 : -1 - i / 2), 0)] = 1.0F;
  }
}

/// Two neighbours in the middle go into each other by `difference` px; the border stays.
void let_two_differ(Problem& problem, double difference) {
  Scene& scene = problem.scene;
  const int middle = scene.extent().width / 2;
  const std::size_t site = scene.extent().index(middle, middle, scene.extent().depth / 2);
  for_each_value(scene.full.target, [](float& value) { value = 0.0F; });
  const auto half = static_cast<float>(difference / 2.0);
  hold(scene, site - 1, half, 0.0F);
  hold(scene, site, -half, 0.0F);
}

/// By this share of the image; the thesis presses by 20 of 300 pixels.
void press(Problem& problem, double percent) {
  const auto factor = static_cast<float>(percent / (100.0 * 20.0 / 300.0));
  for_each_value(problem.scene.full.target, [&](float& value) { value *= factor; });
}

/// The middle third moves by so many percent of the side, the border stays.
void move_middle(Problem& problem, double percent) {
  Scene& scene = problem.scene;
  const Extent extent = scene.extent();
  for_each_value(scene.full.target, [](float& value) { value = 0.0F; });
  for_each_site(extent, [&](int x, int y, int z) {
    if (in_inclusion(extent, x, y, z)) {
      hold(scene, extent.index(x, y, z), static_cast<float>(percent / 100.0 * extent.width), 0.0F);
    }
  });
}

/// The middle third turns by so many degrees about z, the border stays.
void turn_middle(Problem& problem, double degrees) {
  Scene& scene = problem.scene;
  const Extent extent = scene.extent();
  const double angle = degrees * std::numbers::pi / 180.0;
  for_each_value(scene.full.target, [](float& value) { value = 0.0F; });
  for_each_site(extent, [&](int x, int y, int z) {
    if (in_inclusion(extent, x, y, z)) {
      const double right = x - extent.width / 2;
      const double down = y - extent.height / 2;
      hold(scene, extent.index(x, y, z),
           static_cast<float>((std::cos(angle) - 1.0) * right - std::sin(angle) * down),
           static_cast<float>(std::sin(angle) * right + (std::cos(angle) - 1.0) * down));
    }
  });
}

/// Only the first and the last column are held, and pressed together by so many percent of the side.
void press_ends(Problem& problem, double percent) {
  Scene& scene = problem.scene;
  const Extent extent = scene.extent();
  for_each_value(scene.full.target, [](float& value) { value = 0.0F; });
  for_each_value(scene.full.confidence, [](float& value) { value = 0.0F; });
  for_each_site(extent, [&](int x, int y, int z) {
    if (x == 0 || x + 1 == extent.width) {
      const double way = 0.5 * percent / 100.0 * (extent.width - 1);
      hold(scene, extent.index(x, y, z), static_cast<float>(x == 0 ? way : -way), 0.0F);
    }
  });
}

/// Conditions move so many percent of what they do in the scene.
void move_by(Problem& problem, double percent) {
  for_each_value(problem.scene.full.target,
                 [&](float& value) { value *= static_cast<float>(percent / 100.0); });
}

/// Nothing but some sites is known.
void support(Problem& problem, double sites) {
  Scene& scene = problem.scene;
  for_each_value(scene.full.confidence, [](float& value) { value = 0.0F; });
  std::mt19937_64 engine(5);
  const auto any = [&](int below) { return static_cast<int>(engine() % static_cast<unsigned>(below)); };
  for (int i = 0; i < static_cast<int>(sites); ++i) {
    const int x = any(scene.extent().width);
    const int y = any(scene.extent().height);
    hold(scene, scene.extent().index(x, y), static_cast<float>(0.05 * x + 0.03 * y),
         static_cast<float>(0.02 * x - 0.04 * y));
  }
}

/// Candidates 0 and +-1, +-0.3, +-0.1, ... down to the knob.
void step_down_to(Problem& problem, double knob) {
  std::vector<float> steps{0.0F};
  for (const double step : {1.0, 0.3, 0.1, 0.03, 0.01, 0.003}) {
    if (step >= knob) {
      steps.push_back(static_cast<float>(-step));
      steps.push_back(static_cast<float>(step));
    }
  }
  problem.scene.full.steps = StepSet(steps);
}

/// What can be done to a problem, in the words of families.json.
const std::map<std::string_view, Step> steps{
    {"one material", stiff_where([](Extent, int, int, int) { return false; })},
    {"stiff inclusion", stiff_where(in_inclusion)},
    {"inclusion ten times as stiff",
     [](Problem& problem, double) { stiff_where(in_inclusion)(problem, 10.0); }},
    {"stiff surroundings",
     stiff_where([](Extent extent, int x, int y, int z) { return !in_inclusion(extent, x, y, z); })},
    {"stiff checkerboard", stiff_where([](Extent, int x, int y, int z) { return (x + y + z) % 2 != 0; })},
    {"stiff columns",
     stiff_where([](Extent extent, int x, int, int) { return x % 2 == 1 && x < extent.width / 2; })},
    {"stiff rows",
     stiff_where([](Extent extent, int x, int y, int) { return x < extent.width / 2 && y % 4 < 1; })},
    {"moat", stiff_where(in_moat)},
    {"rim", hold_rim},
    {"rough start", start_roughly},
    {"rough start of 2 px", [](Problem& problem, double) { start_roughly(problem, 2.0); }},
    {"penalty", [](Problem& problem, double knob) { set_weight(problem.scene, {.penalty = knob}); }},
    {"offset", add_offset},
    {"confidence of the left border", trust_left_border},
    {"few conditions in y", know_few},
    {"two that differ", let_two_differ},
    {"pressed", press},
    {"Poisson's ratio", [](Problem& problem, double knob) { problem.scene.elastic.poisson = knob; }},
    {"voxels so long", [](Problem& problem, double knob) { problem.scene.full.sides[2] = knob; }},
    {"supports", support},
    {"fixed point",
     [](Problem& problem, double) { problem.truth = solve_fixed_point(problem.scene.full).displacement; }},
    {"finite elements", add_finite_elements},
    {"finer elements", add_finer_elements},
    {"moved so far", move_by},
    {"middle moved", move_middle},
    {"middle turned", turn_middle},
    {"ends pressed", press_ends},
    {"neo-Hookean", be_neo_hookean},
    {"neo-Hookean elements", add_neo_hookean_elements},
    {"moved by a tenth of the scene's way", [](Problem& problem, double) { move_by(problem, 10.0); }},
    {"fibres", have_fibres},
    {"elements with fibres", add_fibre_elements},
    {"selective integration",
     [](Problem& problem, double) { problem.scene.elastic.integration = Integration::selective_reduced; }},
    {"finite elements that bulge",
     [](Problem& problem, double knob) { problem.truth = find_finite_elements(problem.scene.full, knob); }},
    {"start level",
     [](Problem& problem, double knob) { problem.scene.schedule.start_level = static_cast<int>(knob); }},
    {"center", [](Problem& problem, double) { problem.scene.schedule.alignment = Alignment::center; }},
    {"smallest step", step_down_to},
    {"relaxation",
     [](Problem& problem, double knob) { problem.scene.schedule.relaxation = {.factor = knob}; }},
    {"two colours", [](Problem& problem, double) { problem.scene.full.update = Update::coloured; }},
    {"iterations",
     [](Problem& problem, double knob) { problem.scene.schedule.iterations = static_cast<int>(knob); }},
    {"30 iterations", [](Problem& problem, double) { problem.scene.schedule.iterations = 30; }},
    {"300 iterations", [](Problem& problem, double) { problem.scene.schedule.iterations = 300; }}};

double rmsd_to_truth(const Problem& problem, const Outcome& outcome) {
  return rmsd(ReferenceField(outcome.displacement), problem.truth);
}

double moving_percent(const Problem&, const Outcome& outcome) {
  return 100.0 * outcome.share_moving;
}

double mean_dy(const Problem&, const Outcome& outcome) {
  double sum = 0.0;
  for (const float value : outcome.displacement[1]) {
    sum += static_cast<double>(value);
  }
  return std::abs(sum) / static_cast<double>(outcome.displacement[1].size());
}

double folded_percent(const Problem&, const Outcome& outcome) {
  const std::vector<float> ratios = least_area_ratios(outcome.displacement).values;
  const auto folded = std::ranges::count_if(ratios, [](float ratio) { return !(ratio > 0.0F); });
  return 100.0 * static_cast<double>(folded) / static_cast<double>(ratios.size());
}

using Error = double (*)(const Problem& problem, const Outcome& outcome);
const std::map<std::string_view, Error> errors{
    {"", rmsd_to_truth}, {"moving", moving_percent}, {"mean dy", mean_dy}, {"folded", folded_percent}};

} // namespace

void change(Problem& problem, const std::vector<std::string>& by, double knob) {
  for (const std::string& step : by) {
    steps.at(step)(problem, knob);
  }
}

Extent extent_of(const Entry& entry) {
  const bool is_volume = std::ranges::find(shipped_volumes, entry.scene) != shipped_volumes.end();
  return {entry.size, entry.size, is_volume ? entry.size : 1};
}

Problem problem_of(const Entry& entry, double knob) {
  Problem problem{.scene = load_scene(entry.scene, {.size = extent_of(entry)})};
  const float usual_side = problem.scene.extent().depth > 1 ? 64.0F : 300.0F;
  for_each_value(problem.scene.full.target,
                 [&](float& value) { value *= static_cast<float>(entry.size) / usual_side; });
  change(problem, entry.problem, knob);
  return problem;
}

double error_of(const Entry& entry, const Problem& problem, const Outcome& outcome) {
  return errors.at(entry.error)(problem, outcome);
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = [] {
    nlohmann::json rows = nlohmann::json::parse(sources::families_text);
    for (nlohmann::json& row : rows) {
      if (row.contains("as")) { // another family's, but for what it says itself
        nlohmann::json whole = *std::ranges::find(rows, row["as"], [](const auto& of) { return of["name"]; });
        whole.update(row);
        row = std::move(whole);
      }
    }
    return rows.get<std::vector<Entry>>();
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
