#include "harness/scene/scene.hpp"

#include "harness/scene/images/images.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/toml_reader.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <scene_texts.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

int coarsest_level(const Scene& scene) {
  return static_cast<int>(pyramid_extents(scene.extent()).size()) - 1;
}

/// The method with its options, of which it refuses those it does not take.
void read_method(TomlReader& table, std::optional<StepSet> steps, Scene& scene) {
  MethodOptions options{.steps = std::move(steps)};
  if (table.has("iterations")) {
    options.iterations = table.integer("iterations");
  }
  if (table.has("update")) {
    options.update = static_cast<Update>(table.choice("update", update_names, 0));
  }
  options.relaxation = table.optional_number("relaxation");
  if (table.has("temperatures")) {
    const auto [highest, lowest] = table.pair("temperatures");
    options.cooling = Cooling{.highest = highest, .lowest = lowest};
  }
  if (table.has("seed")) {
    options.seed = table.integer("seed");
  }
  const std::string name = table.text("method", usual_method(scene.energy).name);
  try {
    use_method(scene, find_method(name, scene.energy));
    set_options(scene, options);
  } catch (const InputError& error) {
    table.fail(table.has("method") ? "method" : "iterations", fmt::format("is wrong: {}", error.what()));
  }
}

/// At another size than the file's own there may be fewer levels: then the coarsest one stands for a start
/// level beyond it. `steps`: of the file, none where it has none.
void read_schedule(TomlReader& table, std::optional<StepSet> steps, bool at_own_size, Scene& scene) {
  Schedule& schedule = scene.schedule;
  read_method(table, std::move(steps), scene);
  if (scene.energy == EnergyModel::elastic) { // has no other keys
    table.finish();
    return;
  }
  schedule.stop = static_cast<Stop>(table.choice("stop", stop_names, 0));
  table.refuse_unless(schedule.stop == Stop::energy, "epsilon");
  schedule.epsilon = table.number("epsilon", schedule.epsilon);
  if (table.has("start_level")) {
    const int level = table.integer("start_level");
    try {
      set_start_level(scene, at_own_size ? level : std::min(level, coarsest_level(scene)));
    } catch (const InputError& error) {
      table.fail("start_level", error.what());
    }
  }
  schedule.alignment = static_cast<Alignment>(table.choice("alignment", alignment_names, 0));
  table.finish();
}

std::optional<StepSet> read_steps(TomlReader& scene) {
  if (!scene.has("steps")) {
    return std::nullopt;
  }
  try {
    return scene.is_text("steps") ? StepSet::parse(scene.text("steps")) : StepSet(scene.numbers("steps"));
  } catch (const InputError& error) {
    scene.fail("steps", error.what());
  }
}

void read_weight(TomlReader& reader, Scene& scene) {
  ObservationWeight weight;
  weight.penalty = reader.number("penalty", weight.penalty);
  weight.prior_weight = reader.number("prior_weight", weight.prior_weight);
  try {
    set_weight(scene, weight);
  } catch (const InputError& error) {
    reader.fail(reader.has("prior_weight") ? "prior_weight" : "penalty", error.what());
  }
}

std::optional<Extent> read_size(TomlReader& scene, const SceneOptions& options) {
  std::optional<Extent> size = options.size;
  if (scene.has("size")) {
    const auto pair = scene.pair("size");
    const bool valid = std::ranges::all_of(pair, [](double side) {
      return side >= 1.0 && side <= 1e6 && side == static_cast<double>(static_cast<int>(side));
    });
    if (!valid) {
      scene.fail("size", "must be two whole numbers >= 1, [width, height]");
    }
    if (!size) {
      size = Extent{static_cast<int>(pair[0]), static_cast<int>(pair[1])};
    }
  }
  return size;
}

/// Optional images of target displacement (pixels) and confidence, before the built-in conditions, and of the
/// displacement to begin with.
void read_vector_images(TomlReader& image, const Files& file, std::optional<Extent> size, Scene& scene) {
  Level& full = scene.full;
  const bool is_elastic = scene.energy == EnergyModel::elastic;
  const auto read = [&](std::string_view key, VectorField& into) {
    if (image.has(key)) {
      Image<VectorField> found = read_vector(file(image.text(key)), {.size = size});
      require_filled(image, key, found.padded && key == "deviation",
                     found.pixels.extent); // 0 would be certain
      into = std::move(found.pixels);
      require_extent(image, key, into.extent, full.extent);
    }
  };
  image.refuse_unless(is_elastic, "deviation");
  image.refuse_unless(!is_elastic, "start");
  const auto require_possible = [&](std::string_view key, const VectorField& displacement) {
    for (const std::vector<float>* const values : {&displacement.x, &displacement.y}) {
      for (const float value : *values) {
        require_possible_displacement(image, key, static_cast<double>(value));
      }
    }
  };
  if (image.has("target") != (image.has("confidence") || image.has("deviation"))) {
    image.fail("target", "and confidence (or deviation): give both images or none");
  }
  if (image.has("confidence") && image.has("deviation")) {
    image.fail("deviation", "cannot stand beside confidence");
  }
  read("target", full.target);
  require_possible("target", full.target);
  read("confidence", full.confidence);
  if (image.has("deviation")) {
    read("deviation", full.confidence);
    for (std::vector<float>* const values : {&full.confidence.x, &full.confidence.y}) {
      std::ranges::transform(*values, values->begin(), [&](float deviation) {
        if (deviation < 0.0F || std::isnan(deviation)) {
          image.fail("deviation", "has a value below 0 (pixels)");
        }
        return confidence_of_deviation(static_cast<double>(deviation)); // 0 of an infinite one
      });
    }
  }
  if (image.has("start")) {
    read("start", scene.start.emplace());
    require_possible("start", *scene.start);
  }
}

/// Whether interpolation between the levels keeps displacements on dyadic grids: all weights are quarters.
bool interpolates_dyadically(const Scene& scene) {
  const LevelSequence levels(scene);
  const auto is_dyadic = [&](int coarse, int fine) {
    const auto weights = interpolations(coarse, fine, scene.schedule.alignment);
    return std::ranges::all_of(
        weights, [](float weight) { return 4.0F * weight == std::round(4.0F * weight); },
        &Interpolation::weight);
  };
  const std::vector<int>& order = levels.order();
  return std::adjacent_find(order.begin(), order.end(), [&](int above, int level) {
           const Extent coarse = levels.extent(above);
           const Extent fine = levels.extent(level);
           return !is_dyadic(coarse.width, fine.width) || !is_dyadic(coarse.height, fine.height);
         }) == order.end();
}

/// scene.schedule is there already. At a size that is not the file's own the pyramid may not be exact: then
/// nothing is declared.
void read_exact(TomlReader& reader, const SceneOptions& options, Scene& scene) {
  if (!reader.boolean("exact", false)) {
    return;
  }
  if (scene.schedule.rule != Rule::steps || scene.full.update == Update::sequential ||
      scene.energy != EnergyModel::hdm) {
    reader.fail("exact", "cannot be true: only icm and its variants in any number of colours can be proven");
  }
  scene.exact = interpolates_dyadically(scene);
  if (!scene.exact && !options.size) {
    reader.fail(
        "exact",
        "cannot be true: interpolation between the levels rounds; give start_level = 0, or alignment = "
        "\"center\" and sides that are powers of two");
  }
}

Scene build(const toml::table& root, const std::string& name, const std::string& file_name, const Files& file,
            const SceneOptions& options) {
  TomlReader reader(root, file_name, "");
  Scene scene;
  scene.name = name;
  scene.title = reader.text("title", name);
  if (reader.has("energy")) {
    scene.energy = static_cast<EnergyModel>(reader.choice("energy", energy_names, 0));
    scene.stated_energy = scene.energy;
  }
  reader.refuse_unless(scene.energy == EnergyModel::elastic, "robust");
  for (const std::string_view key : {"penalty", "prior_weight", "steps"}) {
    reader.refuse_unless(scene.energy == EnergyModel::hdm, key);
  }
  const std::optional<Extent> size = read_size(reader, options);
  if (size) {
    require_memory(*size);
  }

  constexpr std::array<std::string_view, 4> sources{"shape", "image", "brain", "random"};
  if (std::ranges::count_if(sources, [&](std::string_view source) { return reader.has(source); }) != 1) {
    reader.fail("shape", "tables, [image], [brain] or [random]: a scene needs exactly one of these");
  }
  if (!options.orientation.empty() && !reader.has("brain")) {
    throw InputError(fmt::format("the scene {} is no [brain]: it has no other orientation", name));
  }
  TomlReader image = reader.table("image");
  TomlReader brain = reader.table("brain");
  Content content;
  if (reader.has("image")) {
    content = read_image_content(image, reader, file, size);
  } else {
    if (!size) {
      reader.fail("size", "is missing: [width, height]");
    }
    if (reader.has("brain")) {
      content = read_brain_content(brain, reader, file, *size, options);
      if (!options.orientation.empty()) {
        scene.name += fmt::format(", {}", options.orientation);
      }
    } else if (reader.has("random")) {
      content.labels = {*size, std::vector<int>(size->sites(), 1)};
      content.modulus = ScalarField(*size);
    } else {
      content = read_shapes_content(reader, *size);
    }
  }

  const Extent extent = content.modulus.extent;
  Level& full = scene.full;
  full.extent = extent;
  full.target = VectorField(extent);
  full.confidence = VectorField(extent);
  full.modulus = std::move(content.modulus);
  if (reader.has("random")) {
    TomlReader random = reader.table("random");
    fill_randomly(random, full, scene.start.emplace(extent));
    if (is_inspected(extent)) {
      content.picture = full.modulus;
      stretch(content.picture);
    }
  }
  read_vector_images(image, file, size, scene);
  image.finish();
  apply_conditions(reader, content.labels, scene.energy, full);
  if (content.segmented && is_inspected(extent)) {
    scene.labels = std::move(content.labels);
  }
  content.labels = {}; // before there is more
  read_weight(reader, scene);
  const std::optional<double> spacing = read_spacing(reader);
  scene.spacing = spacing && !reader.has("image") ? *spacing : content.spacing; // an image has seen it
  scene.placement = content.placement;
  scene.poisson = reader.number("poisson", scene.poisson);
  if (!(scene.poisson > -1.0 && scene.poisson <= 0.5)) {
    reader.fail("poisson", "must lie in (-1, 0.5]");
  }
  scene.robust = reader.optional_number("robust");
  if (scene.robust && !(*scene.robust > 0.0)) {
    reader.fail("robust", "must be above 0 (pixels)");
  }
  TomlReader schedule = reader.table("schedule");
  read_schedule(schedule, read_steps(reader), !options.size, scene);
  read_exact(reader, options, scene);
  reader.finish();
  set_inverse_modulus(full);
  scene.picture = std::move(content.picture);
  validate(full);
  return scene;
}

} // namespace

float ObservationWeight::product() const {
  if (!(penalty > 0.0) || !std::isfinite(penalty)) {
    throw InputError(fmt::format("the penalty K is {}, it must be positive and finite", penalty));
  }
  if (!(prior_weight > 0.0 && prior_weight < 1.0)) {
    throw InputError(
        fmt::format("the prior weight alpha is {}, it must be above 0 and below 1", prior_weight));
  }
  const auto result = static_cast<float>((1.0 - prior_weight) / prior_weight * penalty);
  if (!(result > 0.0F) || !std::isfinite(result)) {
    throw InputError(
        fmt::format("the penalty K = {} weighted with alpha = {} is {} as a 32-bit float, it must be "
                    "positive and finite",
                    penalty, prior_weight, result));
  }
  return result;
}

void set_weight(Scene& scene, const ObservationWeight& weight) {
  scene.full.penalty = weight.product();
  scene.weight = weight;
}

void set_start_level(Scene& scene, int level) {
  const int coarsest = coarsest_level(scene);
  if (level < 0 || level > coarsest) {
    throw InputError(
        fmt::format("the start level {} is none of the pyramid's: {} x {} pixels have the levels "
                    "0 (full resolution) ... {}",
                    level, scene.extent().width, scene.extent().height, coarsest));
  }
  scene.schedule.start_level = level;
}

bool is_inspected(Extent extent) {
  return extent.sites() <= std::size_t{4096} * 4096;
}

void require_memory(Extent extent) {
  const double needed = static_cast<double>(largest_bytes_per_site) * static_cast<double>(extent.sites());
  const double present =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (needed > present) {
    throw InputError(
        fmt::format("an image of {} x {} pixels needs about {:.0f} GiB of memory, this machine has {:.0f}",
                    extent.width, extent.height, needed / 0x1p30, present / 0x1p30));
  }
}

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  std::ranges::transform(scene_texts::all, std::back_inserter(names),
                         [](const scene_texts::Text& scene) { return std::string(scene.name); });
  return names;
}

Scene load_scene(const std::string& scene, const SceneOptions& options) {
  if (options.size && (options.size->width < 1 || options.size->height < 1)) {
    throw InputError(fmt::format("the size {} x {} is not possible, each side must be at least 1",
                                 options.size->width, options.size->height));
  }
  const SceneText file = text_of(scene);
  try {
    const toml::table root = toml::parse(file.text, file.file_name);
    Scene result = build(root, file.name, file.file_name, Files(file.folder), options);
    result.source = scene;
    return result;
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: {}", file.file_name, error.source().begin.line,
                                 std::string(error.description())));
  }
}

} // namespace hdmbench
