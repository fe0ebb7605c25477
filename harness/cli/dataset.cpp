// Deformations with a known truth, to learn from or to compare with: hdmbench dataset.

#include "harness/applications/spread.hpp"
#include "harness/check/compare.hpp"
#include "harness/check/golden.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/cli/run_spread.hpp"
#include "harness/cli/warp.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/given_scene.hpp"
#include "harness/scene/images/npz.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/solve/unloading.hpp"

#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <span>
#include <utility>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

const Option<std::string> label_image("scene", "An image of labels", Content::labels);
const Option<fs::path>
    recipe_file("--recipe", "What is drawn from which ranges, [recipe], and a [[tissue]] for each label",
                Content::toml);
const Option<int> how_many("--count", "How many", 10, CLI::Range(1, 9999));
const Option<int> seed_of_set("--seed", "Of what is drawn; the same seed is the same set", 0,
                              CLI::Range(0, 1'000'000'000));
const Option<std::string> set_format(
    "--format",
    "nrrd, mha or nii.gz (NIfTI); h5: fields as ITK's transforms and images as nrrd; npz: all of a "
    "deformation in one file of NumPy's",
    "nrrd", CLI::IsMember({"nrrd", "mha", "nii.gz", "h5", "npz"}));
const Option<std::vector<fs::path>> moved_too("--warp", "Also these pictures, moved", Content::image);

/// What is drawn, and from which ranges.
struct Recipe {
  std::array<double, 2> points{3.0, 8.0};       ///< how many points are moved
  std::array<double, 2> displacement{1.0, 8.0}; ///< how far, mm, in any direction
  double deviation = 1.0;                       ///< of a point, mm
  double moduli = 0.0;                          ///< deviation of the logarithm of each label's modulus
  std::vector<float> labels{};                  ///< of the points; empty: all but 0
  std::optional<std::array<double, 2>> loads{}; ///< how many times the scene's loads; none: once
  double neo_hookean = 0.0; ///< share of the deformations whose tissues without a law have that one
};

Recipe read_recipe(const fs::path& file) {
  const toml::table root = parse_toml(read_file(file), file.string());
  if (!root["recipe"].is_table()) {
    throw InputError(fmt::format("{}: has no [recipe], which says what is drawn", file.string()));
  }
  TomlReader table(*root["recipe"].as_table(), file.string(), "[recipe]");
  Recipe recipe;
  const auto read_range = [&](const char* key, std::array<double, 2>& range) {
    range = table.get<std::array<double, 2>>(key);
    if (range[1] < range[0]) {
      table.fail(key, "must be [low, high] with low <= high");
    }
  };
  if (table.has("points")) {
    read_range("points", recipe.points);
  }
  if (table.has("displacement")) {
    read_range("displacement", recipe.displacement);
  }
  if (table.has("loads")) {
    read_range("loads", recipe.loads.emplace());
  }
  table.read("neo_hookean", recipe.neo_hookean);
  table.read("deviation", recipe.deviation);
  table.read("moduli", recipe.moduli);
  table.read("labels", recipe.labels);
  table.finish();
  return recipe;
}

/// Returns the sites that a point may be drawn at: of tissue, and no condition holds them.
std::vector<std::size_t> sites_for_points(const Scene& scene, const Recipe& recipe) {
  const std::vector<float> tissue = tissue_of(scene).values;
  const std::span held = std::span(scene.full.confidence.planes).first(scene.extent().axes());
  std::vector<std::size_t> sites;
  for (std::size_t site = 0; site < scene.labels.values.size(); ++site) {
    const auto label = static_cast<float>(scene.labels.values[site]);
    const bool is_meant = recipe.labels.empty() ? label != 0.0F : contains(recipe.labels, label);
    const bool is_tissue = tissue.empty() || tissue[site] > 0.0F;
    if (is_meant && is_tissue && std::ranges::all_of(held, [&](const std::vector<float>& component) {
          return component[site] < 1.0F;
        })) {
      sites.push_back(site);
    }
  }
  if (sites.empty()) {
    throw InputError("--recipe: no free site of tissue has one of the labels that points are drawn from");
  }
  return sites;
}

/// A point as `run` --points reads it: x, y, z, dx, dy, dz, deviation, mm (LPS).
using PointNumbers = std::array<double, 7>;

double between(const std::array<double, 2>& range, NormalDraws& random) {
  return range[0] + (range[1] - range[0]) * random.uniform();
}

std::vector<PointNumbers> drawn_points(const Scene& scene, const Recipe& recipe,
                                       const std::vector<std::size_t>& sites, NormalDraws& random) {
  const Extent extent = scene.extent();
  const auto width = static_cast<std::size_t>(extent.width);
  const auto height = static_cast<std::size_t>(extent.height);
  std::vector<PointNumbers> points(
      static_cast<std::size_t>(between({recipe.points[0], recipe.points[1] + 1.0}, random)));
  for (PointNumbers& point : points) {
    const std::size_t site =
        sites[static_cast<std::size_t>(random.uniform() * static_cast<double>(sites.size()))];
    const Placement::Vector at =
        place_of(scene, {static_cast<double>(site % width), static_cast<double>(site / width % height),
                         static_cast<double>(site / (width * height))});
    std::array<double, 3> way{random(), random(), extent.axes() == 3 ? random() : 0.0};
    const double length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    const double factor = between(recipe.displacement, random) / std::max(length, 1e-6);
    const Placement::Vector moved = scene.placement.vector(factor * way[0], factor * way[1], factor * way[2]);
    point = {at[0], at[1], at[2], moved[0], moved[1], moved[2], recipe.deviation};
  }
  return points;
}

/// All that the deformations of a set have in common.
struct DataSet {
  const Call& call;
  Recipe recipe;
  Scene plain;                              ///< without points
  GivenScene given{};                       ///< what it is made of
  std::vector<std::size_t> sites{};         ///< for points
  images::Pixels labels{};                  ///< that are moved
  std::vector<images::Pixels> pictures{};   ///< that are moved, too
  std::vector<std::string> picture_names{}; ///< without an ending
};

/// One deformation.
struct Deformation {
  int number = 0;
  std::vector<PointNumbers> points;
  std::string law{};  ///< of tissues that state none; empty: the scene's
  double loads = 1.0; ///< times the scene's
  Scene scene{};
  VectorField displacement{};
};

/// The names of the files of a deformation: of npz one; else points, field, the way back, labels, then
/// pictures.
std::vector<std::string> names_of(const DataSet& set, int number) {
  const std::string& format = set.call[set_format];
  if (format == "npz") {
    return {fmt::format("{:04}.npz", number)};
  }
  const std::string images = format == "h5" ? "nrrd" : format;
  std::vector<std::string> names{
      fmt::format("{:04}-points.csv", number), fmt::format("{:04}-field.{}", number, format),
      fmt::format("{:04}-back.{}", number, format), fmt::format("{:04}-labels.{}", number, images)};
  for (const std::string& name : set.picture_names) {
    names.push_back(fmt::format("{:04}-moved-{}.{}", number, name, images));
  }
  return names;
}

void multiply_forces(double factor, Level& level) {
  for (std::vector<float>& component : level.force.planes) {
    std::ranges::transform(component, component.begin(),
                           [&](float force) { return static_cast<float>(force * factor); });
  }
}

/// Draws and solves one deformation. The draws of older keys come first: a recipe without newer ones stays
/// the set that it was.
Deformation drawn(const DataSet& set, int number, Solver& solver, Progress& progress) {
  NormalDraws random(static_cast<std::uint32_t>(set.call[seed_of_set]), static_cast<std::uint32_t>(number));
  Deformation one{.number = number, .points = drawn_points(set.plain, set.recipe, set.sites, random)};
  if (set.recipe.neo_hookean > 0.0) {
    one.law = random.uniform() < set.recipe.neo_hookean ? "neo-hookean" : "linear";
  }
  SceneOptions options{.law = one.law};
  for (const PointNumbers& point : one.points) {
    options.pairs.push_back(point_pair(point, std::to_string(options.pairs.size() + 1)));
  }
  one.scene = make_scene(set.given, options);
  if (set.recipe.moduli > 0.0) {
    one.scene = with_drawn_moduli(one.scene, set.recipe.moduli, random);
  }
  if (set.recipe.loads) {
    one.loads = between(*set.recipe.loads, random);
    multiply_forces(one.loads, one.scene.full);
    if (one.scene.before) {
      multiply_forces(one.loads, *one.scene.before);
    }
  }
  unload(one.scene, progress);
  progress.describe(fmt::format("dataset: {} of {}", number, set.call[how_many]));
  Solution solution = solver.solve(one.scene, progress);
  if (const std::string why = why_absurd(one.scene, solution) + doubt_about(solution); !why.empty()) {
    throw InputError(fmt::format("deformation {} has no displacement that tissue would have: {}; give the "
                                 "recipe smaller ranges, or another --seed",
                                 number, why));
  }
  one.displacement = std::move(solution.displacement);
  return one;
}

std::string lines_of(const std::vector<PointNumbers>& points) {
  std::string lines = "x,y,z,dx,dy,dz,deviation\n";
  for (const PointNumbers& point : points) {
    lines += fmt::format("{}\n", fmt::join(point, ","));
  }
  return lines;
}

/// Returns the array of pixels, as NumPy has volumes: z, y, x, then the components.
NamedArray array_of(std::string name, images::Pixels pixels, bool of_labels) {
  const images::Geometry& geometry = pixels.geometry;
  NamedArray array{std::move(name), {}, {}};
  for (const std::size_t axis : {2, 1, 0}) {
    array.shape.push_back(static_cast<std::size_t>(geometry.size[axis]));
  }
  if (geometry.components > 1) {
    array.shape.push_back(geometry.components);
  }
  constexpr float largest = std::numeric_limits<std::int16_t>::max();
  if (of_labels && std::ranges::all_of(pixels.values, [](float label) { return label <= largest; })) {
    array.values = std::vector<std::int16_t>(pixels.values.begin(), pixels.values.end());
  } else {
    array.values = std::move(pixels.values);
  }
  return array;
}

/// Returns the matrix from (x, y, z, 1), the indices of a voxel, to its place, mm (LPS).
NamedArray matrix_of(const images::Geometry& geometry) {
  std::vector<double> matrix;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      matrix.push_back(geometry.axes[axis][row] * geometry.spacing[axis] + 0.0); // no -0
    }
    matrix.push_back(geometry.origin[row]);
  }
  matrix.insert(matrix.end(), {0.0, 0.0, 0.0, 1.0});
  return {"affine", {4, 4}, std::move(matrix)};
}

/// Writes all of a deformation into one file.
void write_arrays(const fs::path& file, const DataSet& set, const Deformation& one, images::Pixels back) {
  std::vector<double> points;
  for (const PointNumbers& point : one.points) {
    points.insert(points.end(), point.begin(), point.end());
  }
  std::vector<NamedArray> arrays{{"points", {one.points.size(), PointNumbers{}.size()}, std::move(points)},
                                 matrix_of(back.geometry)};
  arrays.push_back(array_of(
      "field",
      physical_displacement(file, one.displacement, one.scene.spacing, one.scene.placement, one.scene.oblong),
      false));
  images::Pixels labels = set.labels;
  move_pixels(set.call[label_image], back, true, labels);
  arrays.push_back(array_of("labels", std::move(labels), true));
  for (std::size_t i = 0; i < set.pictures.size(); ++i) {
    images::Pixels picture = set.pictures[i];
    move_pixels(set.call[moved_too][i], back, false, picture);
    arrays.push_back(array_of("moved-" + set.picture_names[i], std::move(picture), false));
  }
  arrays.push_back(array_of("back", std::move(back), false));
  write_npz(file, arrays);
}

/// Writes the files of a deformation; returns its row.
json write_deformation(const DataSet& set, const Deformation& one) {
  const fs::path& folder = set.call[option::output];
  const std::vector<std::string> names = names_of(set, one.number);
  const Scene& scene = one.scene;
  const Inverse inverse = inverse_of(scene, one.displacement);
  images::Pixels back = physical_displacement(folder / names.back(), inverse.displacement, scene.spacing,
                                              scene.placement, scene.oblong);
  if (names.size() == 1) {
    write_arrays(folder / names[0], set, one, std::move(back));
  } else {
    write_text(folder / names[0], lines_of(one.points));
    write_displacement(folder / names[1], one.displacement, scene.spacing, scene.placement, scene.oblong);
    write_displacement(folder / names[2], inverse.displacement, scene.spacing, scene.placement, scene.oblong,
                       Mapping::backward);
    const auto write = [&](std::size_t name, const fs::path& file, images::Pixels image, bool of_labels) {
      move_pixels(file, back, of_labels, image);
      write_moved(folder / names[name], std::move(image), of_labels);
    };
    write(3, set.call[label_image], set.labels, true);
    for (std::size_t i = 0; i < set.pictures.size(); ++i) {
      write(4 + i, set.call[moved_too][i], set.pictures[i], false);
    }
  }
  const std::uint64_t hash = state_hash(one.displacement) * 31 + state_hash(inverse.displacement);
  return {{"number", one.number},
          {"points", scene.points.size()},
          {"law", one.law.empty() ? "as stated" : one.law},
          {"loads", one.loads},
          {"largest_mm", largest_magnitude(one.displacement, tissue_of(scene)) * scene.spacing},
          {"folds", inverse.unmet},
          {"hash", fmt::format("{:016x}", hash)}};
}

/// Reads what all deformations begin with. Throws InputError where they could not be written.
DataSet prepared(const Call& call) {
  DataSet set{.call = call,
              .recipe = read_recipe(call[recipe_file]),
              .plain = load_scene(call[label_image], {.tissues = call[recipe_file]})};
  set.given = {.name = call[label_image],
               .file = call[recipe_file].string(),
               .folder = call[recipe_file].parent_path(),
               .keys = read_keys(call[recipe_file])};
  set.given.keys.erase("recipe");
  set.labels = images::read_pixels(call[label_image]);
  set.given.images.emplace("labels", set.labels);
  set.sites = sites_for_points(set.plain, set.recipe);
  if (set.recipe.loads && !has_forces(set.plain.full) && !set.plain.before) {
    throw InputError("--recipe: loads says how many times the [[load]]s act, and there are none");
  }
  for (const fs::path& picture : call[moved_too]) {
    set.pictures.push_back(images::read_pixels(picture));
  }
  for (const std::string& name : moved_names(call[moved_too], "")) {
    set.picture_names.push_back(name.substr(0, name.size() - 1));
  }
  std::vector<std::string> names{"index.csv"};
  for (int number = 1; number <= call[how_many]; ++number) {
    std::ranges::move(names_of(set, number), std::back_inserter(names));
  }
  if (call[set_format] != "npz") {
    require_displacement_name(names[2], set.plain.extent());
  }
  std::vector<fs::path> read{call[label_image], call[recipe_file]};
  std::ranges::copy(call[moved_too], std::back_inserter(read));
  require_folder(call[option::output], names, read);
  return set;
}

/// The rows as lines, for who has the set without what the program printed.
std::string index_of(const json& rows) {
  std::string lines = "number,points,law,loads,largest_mm,folds,hash\n";
  for (const json& row : rows) {
    lines += fmt::format("{},{},{},{},{},{},{}\n", row["number"].get<int>(), row["points"].get<int>(),
                         row["law"].get<std::string>(), row["loads"].get<double>(),
                         row["largest_mm"].get<double>(), row["folds"].get<std::size_t>(),
                         row["hash"].get<std::string>());
  }
  return lines;
}

int make_dataset(Call& call) {
  const DataSet set = prepared(call);
  const auto registry = make_backends();
  Solver solver(choose_backend(call, registry, set.plain), call.session());
  Progress progress(call.speaks());
  json rows = json::array();
  std::future<json> written; // the deformation before, while the next one is solved
  for (int number = 1; number <= call[how_many]; ++number) {
    Deformation one = drawn(set, number, solver, progress);
    if (written.valid()) {
      rows.push_back(written.get());
    }
    written =
        std::async(std::launch::async, [&set, one = std::move(one)] { return write_deformation(set, one); });
  }
  rows.push_back(written.get());
  std::uint64_t hash = 0;
  std::size_t folded = 0;
  for (const json& row : rows) {
    hash = hash * 31 + std::stoull(row["hash"].get<std::string>(), nullptr, 16);
    folded += row["folds"].get<std::size_t>() > 0 ? 1 : 0;
  }
  write_text(call[option::output] / "index.csv", index_of(rows));
  progress.clear();
  fmt::print("{}\n  {} deformations of {} in {}, {} of them fold\n  hash of the set {:016x}\n",
             table_text(rows, "number|points|law|loads|largest_mm:moves by mm at most|folds:sites where it "
                              "folds|hash"),
             call[how_many], call[label_image], call[option::output].string(), folded, hash);
  call.write(rows);
  return success;
}

} // namespace

void add_dataset(CLI::App& program, Call& call) {
  add_command(
      program, call, "dataset", make_dataset,
      "Make deformations with a known truth.\n"
      "Make deformations of a segmentation whose truth is known, each from points and moduli that are\n"
      "drawn from the ranges of a recipe: the points, the displacement, the one that leads back, and\n"
      "labels and pictures moved by it. A recipe, a seed and a hash are a data set, on every machine.",
      {label_image, recipe_file, how_many, seed_of_set, moved_too, set_format, backend_options(),
       Options(option::output, nullptr, "hdmbench-dataset"), option::json},
      {"scene is required", "--recipe is required"});
}

} // namespace hdmbench::commands
