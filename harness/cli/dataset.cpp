// Deformations with a known truth, to learn from or to compare with: hdmbench dataset.

#include "harness/applications/spread.hpp"
#include "harness/check/compare.hpp"
#include "harness/check/golden.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/run_files.hpp"
#include "harness/cli/run_spread.hpp"
#include "harness/cli/warp.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/scene_content.hpp"

#include <array>
#include <cmath>

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
const Option<std::vector<fs::path>> moved_too("--warp", "Also these pictures, moved", Content::image);

/// What is drawn, and from which ranges.
struct Recipe {
  std::array<double, 2> points{3.0, 8.0};       ///< how many points are moved
  std::array<double, 2> displacement{1.0, 8.0}; ///< how far, mm, in any direction
  double deviation = 1.0;                       ///< of a point, mm
  double moduli = 0.0;                          ///< deviation of the logarithm of each label's modulus
  std::vector<float> labels{};                  ///< of the points; empty: all but 0
};

Recipe read_recipe(const fs::path& file) {
  const toml::table root = parse_toml(read_file(file), file.string());
  if (!root["recipe"].is_table()) {
    throw InputError(fmt::format("{}: has no [recipe], which says what is drawn", file.string()));
  }
  TomlReader table(*root["recipe"].as_table(), file.string(), "[recipe]");
  Recipe recipe;
  const auto read_range = [&](const char* key, std::array<double, 2>& range) {
    table.read(key, range);
    if (range[1] < range[0]) {
      table.fail(key, "must be [low, high] with low <= high");
    }
  };
  read_range("points", recipe.points);
  read_range("displacement", recipe.displacement);
  table.read("deviation", recipe.deviation);
  table.read("moduli", recipe.moduli);
  table.read("labels", recipe.labels);
  table.finish();
  return recipe;
}

/// Returns the sites that a point may be drawn at.
std::vector<std::size_t> sites_for_points(const Scene& scene, const Recipe& recipe) {
  std::vector<std::size_t> sites;
  for (std::size_t site = 0; site < scene.labels.values.size(); ++site) {
    const auto label = static_cast<float>(scene.labels.values[site]);
    const bool is_meant = recipe.labels.empty() ? label != 0.0F : contains(recipe.labels, label);
    if (is_meant && scene.full.confidence[0][site] < 1.0F) {
      sites.push_back(site);
    }
  }
  if (sites.empty()) {
    throw InputError("--recipe: no free site has one of the labels that points are drawn from");
  }
  return sites;
}

/// Lines of points, as `run` --points reads them.
std::string drawn_points(const Scene& scene, const Recipe& recipe, const std::vector<std::size_t>& sites,
                         NormalDraws& random) {
  const Extent extent = scene.extent();
  const auto width = static_cast<std::size_t>(extent.width);
  const auto height = static_cast<std::size_t>(extent.height);
  const auto between = [&](const std::array<double, 2>& range) {
    return range[0] + (range[1] - range[0]) * random.uniform();
  };
  const auto points = static_cast<int>(std::floor(between({recipe.points[0], recipe.points[1] + 1.0})));
  std::string lines = "x,y,z,dx,dy,dz,deviation\n";
  for (int number = 0; number < points; ++number) {
    const std::size_t site =
        sites[static_cast<std::size_t>(random.uniform() * static_cast<double>(sites.size()))];
    const Placement::Vector at =
        place_of(scene, {static_cast<double>(site % width), static_cast<double>(site / width % height),
                         static_cast<double>(site / (width * height))});
    std::array<double, 3> way{random(), random(), extent.axes() == 3 ? random() : 0.0};
    const double length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    const double factor = between(recipe.displacement) / std::max(length, 1e-6);
    const Placement::Vector moved = scene.placement.vector(factor * way[0], factor * way[1], factor * way[2]);
    lines += fmt::format("{},{},{},{},{},{},{}\n", at[0], at[1], at[2], moved[0], moved[1], moved[2],
                         recipe.deviation);
  }
  return lines;
}

/// The names of the files of a deformation: points, field, transform, labels, then pictures.
std::vector<std::string> names_of(const Call& call, int number) {
  std::vector<std::string> names;
  for (const char* const what : {"points.csv", "field.nrrd", "back.nrrd", "labels.nrrd"}) {
    names.push_back(fmt::format("{:04}-{}", number, what));
  }
  for (const std::string& name : moved_names(call[moved_too], "nrrd")) {
    names.push_back(fmt::format("{:04}-moved-{}", number, name));
  }
  return names;
}

/// Draws, solves and writes one deformation; returns its row.
json deformation(Call& call, const Scene& plain, const Recipe& recipe, const std::vector<std::size_t>& sites,
                 int number, Solver& solver, Progress& progress) {
  const fs::path& folder = call[option::output];
  const std::vector<std::string> names = names_of(call, number);
  NormalDraws random(static_cast<std::uint32_t>(call[seed_of_set]), static_cast<std::uint32_t>(number));
  write_text(folder / names[0], drawn_points(plain, recipe, sites, random));
  Scene scene = load_scene(call[label_image], {.tissues = call[recipe_file], .points = {folder / names[0]}});
  if (recipe.moduli > 0.0) {
    scene = with_drawn_moduli(scene, recipe.moduli, random);
  }
  progress.describe(fmt::format("dataset: {} of {}", number, call[how_many]));
  const Solution solution = solver.solve(scene, progress);
  if (const std::string absurd = why_absurd(scene, solution); !absurd.empty()) {
    throw InputError(fmt::format("deformation {} has no displacement: {}; give the recipe smaller ranges, or "
                                 "another --seed",
                                 number, absurd));
  }
  const VectorField& field = solution.displacement;
  write_displacement(folder / names[1], field, scene.spacing, scene.placement, scene.oblong);
  const Inverse inverse = write_inverse(folder / names[2], scene, field);
  write_moved(folder / names[3], call[label_image], folder / names[2], true);
  for (std::size_t i = 0; i < call[moved_too].size(); ++i) {
    write_moved(folder / names[4 + i], call[moved_too][i], folder / names[2], false);
  }
  const std::uint64_t hash = state_hash(field) * 31 + state_hash(inverse.displacement);
  return {{"number", number},
          {"points", scene.points.size()},
          {"largest_mm", largest_magnitude(field) * scene.spacing},
          {"folds", inverse.unmet},
          {"hash", fmt::format("{:016x}", hash)}};
}

int make_dataset(Call& call) {
  const Recipe recipe = read_recipe(call[recipe_file]);
  const Scene plain = load_scene(call[label_image], {.tissues = call[recipe_file]});
  const std::vector<std::size_t> sites = sites_for_points(plain, recipe);
  std::vector<std::string> names;
  for (int number = 1; number <= call[how_many]; ++number) {
    std::ranges::move(names_of(call, number), std::back_inserter(names));
  }
  std::vector<fs::path> read{call[label_image], call[recipe_file]};
  std::ranges::copy(call[moved_too], std::back_inserter(read));
  require_folder(call[option::output], names, read);
  const auto registry = make_backends();
  Solver solver(choose_backend(call, registry, plain), call.session());
  Progress progress(call.speaks());
  json rows = json::array();
  std::uint64_t hash = 0;
  std::size_t folded = 0;
  for (int number = 1; number <= call[how_many]; ++number) {
    rows.push_back(deformation(call, plain, recipe, sites, number, solver, progress));
    hash = hash * 31 + std::stoull(rows.back()["hash"].get<std::string>(), nullptr, 16);
    folded += rows.back()["folds"].get<std::size_t>() > 0 ? 1 : 0;
  }
  progress.clear();
  fmt::print("{}\n  {} deformations of {} in {}, {} of them fold\n  hash of the set {:016x}\n",
             table_text(rows, "number|points|largest_mm:moves by mm at most|folds:sites where it folds|hash"),
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
      {label_image, recipe_file, how_many, seed_of_set, moved_too, backend_options(),
       Options(option::output, nullptr, "hdmbench-dataset"), option::json},
      {"scene is required", "--recipe is required"});
}

} // namespace hdmbench::commands
