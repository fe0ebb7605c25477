#include "harness/scene/scene.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/precision.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/schedule_keys.hpp"
#include "harness/scene/toml_reader.hpp"
#include "harness/scene/walls.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/interruption.hpp"

#include <fmt/format.h>
#include <scene_texts.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace hdmbench {

namespace {

int coarsest_level(const Scene& scene) {
  return static_cast<int>(pyramid_extents(scene.extent()).size()) - 1;
}

/// The schedule keys that stand in this table and mean something to the scene's energy. At another size than
/// the file's own there may be fewer levels: then the coarsest one stands for a start level beyond it.
void read_keys(TomlReader& table, std::string_view name, bool at_own_size, Scene& scene) {
  for (const ScheduleKey& key : schedule_keys()) {
    const bool is_idle = (key.of != ScheduleKey::Of::all && scene.energy->is_of_cells()) ||
                         (key.name == "epsilon" && scene.schedule.stop != Stop::energy);
    if (key.table != name || is_idle || !table.has(key.name)) {
      continue;
    }
    std::string value = table.text(key.name);
    if (key.name == "start_level" && !at_own_size) {
      value = std::to_string(std::min(table.get<int>(key.name), coarsest_level(scene)));
    }
    table.blame(key.name, [&] { set_key(scene, key, value); });
  }
}

void read_schedule(TomlReader& root, bool at_own_size, Scene& scene) {
  TomlReader table = root.table("schedule");
  // A number of iterations without a method counts those of the energy's first one.
  std::string method(table.has("iterations") ? scene.energy->methods.front().name : usual_method(scene).name);
  table.read("method", method);
  table.blame("method", [&] { use_method(scene, find_method(method, scene.energy)); });
  read_keys(table, "schedule", at_own_size, scene);
  table.finish();
  set_weight(scene, {});
  read_keys(root, "", at_own_size, scene);
}

/// The file's own where `options` have none.
std::optional<Extent> read_size(TomlReader& scene, const SceneOptions& options) {
  std::optional<Extent> size = options.size;
  if (scene.has("size")) {
    std::vector<double> own = scene.numbers("size", 2, 3);
    own.resize(3, 1.0);
    const Extent stated{static_cast<int>(own[0]), static_cast<int>(own[1]), static_cast<int>(own[2])};
    if (size && size->axes() != stated.axes() && !scene.has("random")) { // numbers have no shape to lose
      scene.fail("size", fmt::format("is {}, and so it cannot be {}: one is a volume, the other is not",
                                     stated.text(), size->text()));
    }
    size = size.value_or(stated);
  }
  if (size && std::min({size->width, size->height, size->depth}) < (size->depth > 1 ? 2 : 1)) {
    throw InputError(fmt::format("the size {} is not possible, each side must be at least {}", size->text(),
                                 size->depth > 1 ? "2" : "1"));
  }
  return size;
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
           return !is_dyadic(coarse.width, fine.width) || !is_dyadic(coarse.height, fine.height) ||
                  !is_dyadic(coarse.depth, fine.depth);
         }) == order.end();
}

/// scene.schedule is there already. At a size that is not the file's own the pyramid may not be exact, and
/// the 13 lines of a volume need more bits than an image's four: then nothing is declared.
void read_exact(TomlReader& reader, const SceneOptions& options, Scene& scene) {
  bool is_exact = false;
  reader.read("exact", is_exact);
  if (!is_exact) {
    return;
  }
  if (scene.schedule.rule != Rule::steps || scene.full.update == Update::sequential ||
      scene.energy->is_of_cells()) {
    reader.fail("exact", "cannot be true: only icm and its variants in any number of colours can be proven");
  }
  scene.exact = scene.extent().axes() == 2 && interpolates_dyadically(scene);
  if (!scene.exact && !options.size) {
    reader.fail(
        "exact",
        "cannot be true: interpolation between the levels rounds; give start_level = 0, or alignment = "
        "\"center\" and sides that are powers of two");
  }
}

/// What the pixels are made of; nothing of [random]. `image`: its table.
Content read_content(TomlReader& scene, TomlReader& image, const SceneText& file, std::optional<Extent> size,
                     const SceneOptions& options, bool takes_boxes) {
  constexpr std::array<std::string_view, 4> sources{"shape", "image", "brain", "random"};
  if (std::ranges::count_if(sources, [&](std::string_view source) { return scene.has(source); }) != 1) {
    scene.fail("shape", "tables, [image], [brain] or [random]: a scene needs exactly one of these");
  }
  TomlReader brain = scene.table("brain");
  const bool is_slice = scene.has("brain") && !brain.has("head");
  if (!options.orientation.empty() && !is_slice) {
    throw InputError(
        fmt::format("the scene {} is no slice of a [brain]: it has no other orientation", file.name));
  }
  if (!size && !scene.has("image") && !brain.has("head")) {
    scene.fail("size", "is missing: [width, height]");
  }
  if (size && size->axes() == 3 && is_slice) {
    brain.fail("slice",
               fmt::format("is no volume of {}; a whole head is one, with its file as head", size->text()));
  }
  if (scene.has("image")) {
    return read_image_content(image, scene, file, size, takes_boxes);
  }
  if (scene.has("brain")) {
    return read_brain_content(brain, scene, file.folder, size, options);
  }
  return scene.has("shape") ? read_shapes_content(scene, *size) : Content{};
}

/// Reads the side of a pixel, or of a shape's pixels each of its sides. `is_for_cubes`: of a scene whose
/// energy would take boxes.
void read_spacing(TomlReader& scene, std::size_t axes, bool takes_boxes, bool is_for_cubes,
                  Content& content) {
  if (!scene.is_list("spacing")) {
    scene.read("spacing", content.spacing);
    return;
  }
  const std::vector<double> sides = scene.numbers("spacing", axes, axes);
  content.spacing = std::ranges::min(sides);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    content.placement.aspect[axis] = sides[axis] / content.spacing;
  }
  if (std::ranges::max(sides) > most_oblong * content.spacing) {
    scene.fail("spacing", fmt::format("has a side {:.4g} times as long as the shortest, {:g} are possible",
                                      std::ranges::max(sides) / content.spacing, most_oblong));
  }
  if (!takes_boxes && content.placement != Placement{}) {
    scene.fail("spacing", is_for_cubes ? "has other sides along the axes, and this command knows squares and "
                                         "cubes only; give one number"
                                       : "has other sides along the axes, which the elastic energy alone "
                                         "knows; give energy = \"elastic\", or one number");
  }
}

/// call(), where a text that is no TOML is an InputError with the line.
template <typename Call>
auto with_line(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}:{}: {}", file, error.source().begin.line, std::string(error.description())));
  }
}

/// Reads what moves the sites. `energy`: that will be minimised.
void read_conditions(TomlReader& reader, const SceneText& file, const SceneOptions& options,
                     const RegisteredEnergy& energy, Content& content, Scene& scene) {
  scene.before = take_out(reader, content, energy, options.law, scene.full);
  AppliedConditions applied = apply_conditions(reader, content, scene.energy->is_of_cells(), scene.full);
  scene.idle = std::move(applied.idle);
  scene.turn_of_normals = applied.turn_of_normals;
  std::ranges::move(content.idle, std::back_inserter(scene.idle));
  scene.has_own_normals = !content.normals[0].empty();
  apply_points(reader, file.folder, options, content, scene);
  if (content.precision) {
    scene.observed = add_precision(std::move(*content.precision), scene.full);
  } else if (scene.full.has_walls) {
    set_rest_on_walls(scene.full);
  }
  std::ranges::move(apply_loads(reader, content, energy, scene.full), std::back_inserter(scene.idle));
  apply_laws(reader, content, energy, options.law, scene.full);
  std::ranges::move(apply_fibres(reader, content, scene.full), std::back_inserter(scene.idle));
  if (content.segmented) {
    std::ranges::move(fill_void(reader, energy, scene.full), std::back_inserter(scene.idle));
  }
  if (content.segmented && is_inspected(scene.extent())) {
    scene.labels = std::move(content.labels);
  }
  content.labels = {}; // before there is more
}

/// A key of volumes alone.
void read_integration(TomlReader& reader, Scene& scene) {
  if (scene.extent().axes() != 3) {
    return;
  }
  reader.read("integration", integration_names, scene.elastic.integration);
  if ((has_laws(scene.full) || scene.before) && scene.elastic.integration != Integration::full) {
    reader.fail("integration", "must be \"full\" where a tissue has a law of large strains, or is taken out");
  }
}

Scene build(const toml::table& root, const SceneText& file, const SceneOptions& options) {
  TomlReader reader(root, file.file_name, "");
  Scene scene;
  scene.name = file.name;
  scene.title = file.name;
  reader.read("title", scene.title);
  if (reader.has("energy")) {
    scene.stated_energy = registered_energies()[reader.choice("energy", energy_names())];
    scene.energy = scene.stated_energy;
  }
  const std::optional<Extent> size = read_size(reader, options);
  if (size) {
    require_memory(*size, *scene.energy);
  }

  TomlReader image = reader.table("image");
  const RegisteredEnergy& to_be = options.energy != nullptr ? *options.energy : *scene.energy;
  const bool takes_boxes = !options.as_cubes && to_be.takes_boxes;
  Content content = read_content(reader, image, file, size, options, takes_boxes);
  scene.name += options.orientation.empty() ? "" : ", " + options.orientation;
  Level& full = scene.full;
  full.extent = content.modulus.values.empty() ? *size : content.modulus.extent;
  require_memory(full.extent, *scene.energy);
  may_end_here();
  full.target = VectorField(full.extent);
  full.confidence = VectorField(full.extent);
  full.modulus = std::move(content.modulus);
  if (reader.has("random")) {
    full.modulus = ScalarField(full.extent);
    TomlReader random = reader.table("random");
    content = read_random_content(random, full, scene.start.emplace(full.extent));
  }
  read_vector_images(image, file, size, content, scene);
  image.finish();
  content.knows_millimetres = reader.has("spacing") || reader.has("brain") ||
                              (reader.has("image") && content.grid.stated != Stated::nothing);
  if (!reader.has("image")) { // an image has seen it
    read_spacing(reader, full.extent.axes(), takes_boxes, to_be.takes_boxes && !takes_boxes, content);
  }
  scene.spacing = content.spacing;
  may_end_here();
  read_conditions(reader, file, options, to_be, content, scene);
  scene.placement = content.placement;
  full.sides = content.placement.aspect;
  scene.oblong = content.oblong;
  scene.stated = content.grid.stated;
  read_integration(reader, scene);
  may_end_here();
  read_schedule(reader, !options.size, scene);
  read_exact(reader, options, scene);
  reader.finish();
  may_end_here();
  set_inverse_modulus(full);
  may_end_here();
  set_energy_of_sites(scene);
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
    throw InputError(fmt::format("the start level {} is none of the pyramid's: {} pixels have the levels "
                                 "0 (full resolution) ... {}",
                                 level, scene.extent().text(), coarsest));
  }
  scene.schedule.start_level = level;
}

ScalarField tissue_of(const Scene& scene) {
  ScalarField tissue;
  if (scene.energy->is_of_cells() && has_void(scene.full)) {
    tissue = scene.full.modulus;
    std::ranges::transform(
        tissue.values, tissue.values.begin(),
        [least = void_modulus(scene.full)](float modulus) { return modulus < least ? 0.0F : 1.0F; });
  }
  return tissue;
}

bool is_inspected(Extent extent) {
  return extent.sites() <= std::size_t{4096} * 4096;
}

void require_memory(Extent extent, double per_site, double power, std::string_view who) {
  const bool is_volume = extent.axes() == 3;
  const double needed = per_site * std::pow(static_cast<double>(extent.sites()), power);
  const double present =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (needed > present) {
    const double side = std::pow(present / per_site, 1.0 / (power * static_cast<double>(extent.axes())));
    throw InputError(fmt::format("{}{} of {} {} needs {:.3g} bytes, {:.0f} GiB of memory, this machine has "
                                 "{:.0f}: sides of {} would fit",
                                 who, is_volume ? "a volume" : "an image", extent.text(),
                                 is_volume ? "voxels" : "pixels", needed, needed / 0x1p30, present / 0x1p30,
                                 static_cast<int>(side)));
  }
}

namespace {

double bytes_per_site(Extent extent, const RegisteredEnergy& energy) {
  return extent.axes() == 3 ? energy.bytes_per_voxel : energy.bytes_per_pixel;
}

} // namespace

void require_memory(Extent extent, const RegisteredEnergy& energy) {
  require_memory(extent, bytes_per_site(extent, energy));
}

void require_memory(const Scene& scene) {
  const Extent extent = scene.extent();
  const double of_laws =
      has_laws(scene.full) ? 90.0 : 0.0; // the peak of `run ball --size 200x200x200` was 207
  const double of_before = scene.before ? 11.0 * sizeof(float) : 0.0;
  double of_long_cells = 0.0;
  if (scene.energy->is_of_cells()) {
    // A site of a coarse level has so many, by the peaks of `run` with boxes of 1 x 1 x 5 and 1 x 5 x 5: 156
    // and 240 bytes a voxel.
    const double floats = extent.axes() == 3 ? 45.0 : 19.0;
    of_long_cells = sizeof(float) * floats *
                    (coarse_share(extent, scene.full.sides) - coarse_share(extent, {1.0, 1.0, 1.0}));
  }
  require_memory(extent, bytes_per_site(extent, *scene.energy) + of_laws + of_before + of_long_cells);
}

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const scene_texts::Text& scene : scene_texts::all) {
    if (std::ranges::find(shipped_volumes, scene.name) == shipped_volumes.end()) {
      names.emplace_back(scene.name);
    }
  }
  return names;
}

std::vector<SceneSummary> scene_summaries() {
  std::vector<std::string> names = shipped_scenes();
  names.insert(names.end(), shipped_volumes.begin(), shipped_volumes.end());
  std::vector<SceneSummary> summaries;
  for (const std::string& name : names) {
    const toml::table root = parse_toml(text_of(name).text, name);
    std::string size;
    if (const toml::array* const sides = root["size"].as_array()) {
      for (const toml::node& side : *sides) {
        size += fmt::format("{}{}", size.empty() ? "" : " x ", side.value_or(0));
      }
    }
    summaries.push_back({name, root["title"].value_or(name), size.empty() ? "its files'" : size});
  }
  return summaries;
}

namespace {

/// Returns whether the scene's file has what is asked for; false where it cannot be read.
bool says(const std::string& scene, bool (*is_there)(const toml::table&)) {
  try {
    const SceneText file = text_of(scene);
    return is_there(with_line(file.file_name, [&] { return parse_toml(file.text, file.file_name); }));
  } catch (const InputError&) {
    return false; // load_scene() says why
  }
}

} // namespace

bool states_volume(const std::string& scene) {
  return says(scene, [](const toml::table& root) {
    const toml::array* const sides = root["size"].as_array();
    return sides != nullptr && sides->size() == 3;
  });
}

bool has_pixels_of_files(const std::string& scene) {
  return says(scene,
              [](const toml::table& root) { return root["image"].is_table() || root["brain"]["head"]; });
}

Scene load_scene(const std::string& scene, const SceneOptions& options) {
  const std::filesystem::path path(scene);
  const bool is_of_labels = !options.tissues.empty();
  const SceneText file = is_of_labels ? SceneText{path.stem().stem().string(),
                                                  options.tissues.string(),
                                                  options.tissues.parent_path(),
                                                  {},
                                                  nullptr}
                                      : text_of(scene);
  return with_line(file.file_name, [&] {
    const toml::table root =
        is_of_labels ? scene_of_labels(path, options.tissues) : parse_toml(file.text, file.file_name);
    Scene result = build(root, file, options);
    if (is_of_labels && is_shipped_tissues(options.tissues)) { // no person has all of them
      std::erase_if(result.idle, [](const std::string& idle) { return idle.starts_with(idle_tissue); });
    }
    result.source = scene;
    return result;
  });
}

toml::table read_keys(const std::filesystem::path& file) {
  return with_line(file.string(), [&] { return parse_toml(read_file(file), file.string()); });
}

Scene make_scene(GivenScene given, const SceneOptions& options) {
  toml::table& root = given.keys;
  if (!given.images.empty()) {
    if (root.contains("image")) {
      throw InputError(
          fmt::format("{}: is a scene of its own, with an [image], and its images are given", given.file));
    }
    toml::table names;
    for (const auto& [key, pixels] : given.images) {
      names.insert(key, key);
    }
    if (given.images.contains("target")) {
      names.insert("target_unit", "mm");
    }
    root.insert("image", std::move(names));
  }
  add_usual_keys(root);
  return build(root, {given.name, given.file, given.folder, {}, &given}, options);
}

Scene make_scene(const std::string& text, ImagesByKey images, const SceneOptions& options) {
  GivenScene given{.name = "scene", .images = std::move(images)};
  given.keys = with_line(given.file, [&] { return parse_toml(text, given.file); });
  return make_scene(std::move(given), options);
}

} // namespace hdmbench
