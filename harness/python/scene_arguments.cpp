#include "harness/python/scene_arguments.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/laws.hpp"
#include "harness/scene/method.hpp"
#include "harness/solve/unloading.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hdmbench::python {

namespace {

/// Throws InputError for one of these that is given all the same.
void refuse(std::initializer_list<std::pair<const char*, const py::object*>> arguments,
            std::string_view why) {
  for (const auto& [name, value] : arguments) {
    if (!value->is_none()) {
      throw InputError(fmt::format("{} has no effect here: {}", name, why));
    }
  }
}

std::optional<Extent> size_of(const py::object& size) {
  if (size.is_none()) {
    return std::nullopt;
  }
  auto sides =
      py::isinstance<py::int_>(size) ? std::vector<int>(2, size.cast<int>()) : size.cast<std::vector<int>>();
  if (sides.size() < 2 || sides.size() > 3 || std::ranges::min(sides) < 1) {
    throw InputError("size: is one number, (width, height) or (width, height, depth), each at least 1");
  }
  sides.resize(3, 1);
  return Extent{sides[0], sides[1], sides[2]};
}

/// The [[tissue]] tables of {label: modulus or a dictionary of what else a tissue has}.
toml::array tissues_of(const py::dict& tissues) {
  toml::array tables;
  for (const auto& [label, value] : tissues) {
    const bool is_table = py::isinstance<py::dict>(value);
    py::dict table;
    if (is_table) {
      table.attr("update")(value);
    } else {
      table["modulus"] = value;
    }
    table["label"] = label;
    tables.push_back(table_of(table));
  }
  return tables;
}

/// The [[resect]] tables of a label, or of several.
toml::array resected_of(const py::object& labels) {
  const bool is_one = !py::isinstance<py::iterable>(labels);
  toml::array tables;
  for (const py::handle label : is_one ? py::object(py::make_tuple(labels)) : labels) {
    py::dict table;
    table["label"] = label;
    tables.push_back(table_of(table));
  }
  return tables;
}

/// The law of all tissues that state none; empty: that of the scene.
std::string law_of(const py::object& law) {
  if (law.is_none()) {
    return {};
  }
  const auto name = py::str(law).cast<std::string>();
  const std::span<const RegisteredLaw* const> laws = registered_laws();
  if (std::ranges::none_of(laws,
                           [&](const RegisteredLaw* one) { return one->key.empty() && one->name == name; })) {
    throw InputError(
        fmt::format("law: is \"linear\" or \"neo-hookean\", not \"{}\"; one with a parameter is for the "
                    "dictionaries of tissues",
                    name));
  }
  return name;
}

/// What the scene has beside its images: of a file, or of arguments.
toml::table keys_of(const SceneArguments& given, GivenScene& scene) {
  toml::table keys;
  if (is_path(given.tissues)) {
    scene.file = path_of(given.tissues);
    scene.folder = std::filesystem::path(scene.file).parent_path();
    keys = read_keys(scene.file);
  } else if (py::isinstance<py::dict>(given.tissues)) {
    keys.insert("tissue", tissues_of(given.tissues.cast<py::dict>()));
  } else if (!given.tissues.is_none()) {
    throw InputError("tissues: is a dictionary {label: modulus in MPa}, or the path of a file of [[tissue]] "
                     "tables");
  }
  if (!given.conditions.is_none()) {
    keys.insert_or_assign("condition", tables_of("conditions", given.conditions.cast<py::iterable>()));
  }
  if (!given.loads.is_none()) {
    keys.insert_or_assign("load", tables_of("loads", given.loads.cast<py::iterable>()));
  }
  if (!given.resect.is_none()) {
    keys.insert_or_assign("resect", resected_of(given.resect));
  }
  return keys;
}

/// Adds the points to the options: paths as the command line takes them, or arrays.
void add_points(const SceneArguments& given, bool with_targets, Space space, SceneOptions& options) {
  const py::object& points = given.points;
  if (points.is_none()) {
    return;
  }
  const bool is_pair = py::isinstance<py::tuple>(points) && py::len(points) == 2;
  if (with_targets) {
    options.pairs = points_of(points, given.targets, space);
  } else if (is_path(points)) {
    options.points = {path_of(points)};
  } else if (is_pair) {
    const auto pair = points.cast<py::tuple>();
    const py::object before = pair[0];
    const py::object after = pair[1];
    if (is_path(before)) {
      options.points = {path_of(before), path_of(after)};
    } else {
      options.pairs = points_of(before, after, space);
    }
  } else {
    options.pairs = points_of(points, space);
  }
}

/// Whether the targets are where the points go, and not vectors of pixels.
bool are_of_points(const SceneArguments& given) {
  return !given.points.is_none() && !given.targets.is_none() && py::array::ensure(given.targets).ndim() == 2;
}

/// A scene by its name or file, or a label image by its file.
SceneToLoad load_of_file(const SceneArguments& given, SceneOptions options) {
  const bool has_scene = !given.scene.is_none();
  refuse({{"modulus", &given.modulus},
          {"spacing", &given.spacing},
          {"affine", &given.affine},
          {"conditions", &given.conditions},
          {"loads", &given.loads},
          {"resect", &given.resect}},
         "the scene's files say it");
  if (has_scene) {
    refuse({{"labels", &given.labels}, {"tissues", &given.tissues}}, "the scene has its own");
  } else if (!is_path(given.tissues)) {
    throw InputError("tissues: labels that are a file have them in a file, too");
  } else {
    options.tissues = path_of(given.tissues);
  }
  const bool with_targets = are_of_points(given);
  if (!with_targets) {
    refuse({{"targets", &given.targets}}, "the scene's files say it");
  }
  refuse({{"confidence", &given.confidence},
          {"precision", &given.precision},
          {"force", &given.force},
          {"fibre", &given.fibre},
          {"normals", &given.normals}},
         "the scene's files say it");
  add_points(given, with_targets, Space::lps, options);
  const std::string name = path_of(has_scene ? given.scene : given.labels);
  return {[name, options](ScheduleOverrides& schedule) {
    SceneOptions own = options;
    own.energy = schedule.energy_to_be();
    own.law = own.law.empty() ? schedule.law : own.law;
    Scene scene = load_scene(name, own);
    schedule.apply(scene);
    Progress silent(false);
    unload(scene, silent);
    return scene;
  }};
}

/// A scene of arrays.
SceneToLoad load_of_arrays(const SceneArguments& given, SceneOptions options) {
  const bool has_labels = !given.labels.is_none();
  if (has_labels == !given.modulus.is_none()) {
    throw InputError("labels, modulus, or scene: give exactly one of them");
  }
  const std::string key = has_labels ? "labels" : "modulus";
  const GivenImage image =
      given_image(key, has_labels ? given.labels : given.modulus, given.spacing, given.affine);
  auto in_memory = std::make_shared<GivenScene>();
  in_memory->name = key;
  in_memory->file = "scene";
  in_memory->keys = keys_of(given, *in_memory);
  in_memory->images.emplace(key, pixels_of(image));
  const bool with_targets = are_of_points(given);
  if (!with_targets && !given.targets.is_none()) {
    in_memory->images.emplace("target", vectors_of(image, "targets", given.targets, true));
  }
  if (!given.confidence.is_none()) {
    in_memory->images.emplace("confidence", confidence_of(image, given.confidence));
  }
  if (!given.precision.is_none()) {
    in_memory->images.emplace("precision", matrices_of(image, "precision", given.precision));
  }
  for (const auto& [name, vectors] :
       {std::pair{"force", &given.force}, {"fibre", &given.fibre}, {"normals", &given.normals}}) {
    if (!vectors->is_none()) {
      in_memory->images.emplace(name, vectors_of(image, name, *vectors, true));
    }
  }
  add_points(given, with_targets, image.space, options);
  return {.load =
              [in_memory, options](ScheduleOverrides& schedule) {
                SceneOptions own = options;
                own.energy = schedule.energy_to_be();
                own.law = own.law.empty() ? schedule.law : own.law;
                Scene scene = make_scene(std::move(*in_memory), own);
                schedule.apply(scene);
                Progress silent(false);
                unload(scene, silent);
                return scene;
              },
          .space = image.space,
          .axes = static_cast<std::size_t>(image.array.ndim())};
}

} // namespace

SceneToLoad scene_to_load(const SceneArguments& given) {
  const SceneOptions options{.size = size_of(given.size), .law = law_of(given.law)};
  const bool is_file = !given.scene.is_none() || is_path(given.labels);
  return is_file ? load_of_file(given, options) : load_of_arrays(given, options);
}

ScheduleOverrides schedule_of(const py::object& energy, const py::object& method,
                              const py::object& iterations, const py::object& poisson) {
  ScheduleOverrides schedule{.takes_boxes = true};
  if (!energy.is_none()) {
    schedule.choose_energy(energy.cast<std::string>());
  }
  for (const auto& [key, value] :
       {std::pair("method", method), {"iterations", iterations}, {"poisson", poisson}}) {
    if (!value.is_none()) {
      schedule.given[key] = py::str(value).cast<std::string>();
    }
  }
  return schedule;
}

} // namespace hdmbench::python
