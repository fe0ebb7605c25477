// The tools of the thesis's appendix A.

#include "harness/tools/thesis_tools.hpp"

#include "harness/check/compare.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/solve/solve.hpp"

#include <fmt/ranges.h>

namespace hdmbench::commands {

namespace {

struct Arguments {
  SceneArguments scene;
  TuneOptions search;
  std::string method = "simplex";
  std::vector<double> range;
  std::string truth = "fem";
  std::filesystem::path mask;
};

/// What a solution is measured against.
struct Truth {
  ReferenceField displacement;         ///< pixels
  std::vector<std::uint8_t> counted{}; ///< not 0 where the truth is known; empty: everywhere
};

Truth read_truth(const Arguments& arguments, Extent extent) {
  Image<VectorField> read = read_displacement(arguments.truth);
  if (read.pixels.extent != extent) {
    throw InputError(fmt::format("{}: is {} pixels, the scene is {}", arguments.truth,
                                 read.pixels.extent.text(), extent.text()));
  }
  validate(read.pixels, extent, "the truth");
  Truth truth{.displacement = ReferenceField(read.pixels)};
  if (!arguments.mask.empty()) {
    const ScalarField mask = read_scalar(arguments.mask).pixels;
    if (mask.extent != extent) {
      throw InputError(fmt::format("the mask of the truth is {} pixels, the scene is {}", mask.extent.text(),
                                   extent.text()));
    }
    std::ranges::transform(mask.values, std::back_inserter(truth.counted),
                           [](float defined) { return static_cast<std::uint8_t>(defined != 0.0F); });
    if (std::ranges::count(truth.counted, 1) == 0) {
      throw InputError("the truth is defined at no pixel: its mask is 0 everywhere");
    }
  }
  return truth;
}

void print(const Tuning& tuning, double penalty) {
  json rows = json::array();
  for (std::size_t i = 0; i < tuning.evaluations.size(); ++i) {
    const Evaluation& evaluation = tuning.evaluations[i];
    const ObservationWeight weight{.penalty = penalty, .prior_weight = evaluation.prior_weight};
    rows.push_back({{"alpha", fmt::format("{:.5f}", evaluation.prior_weight)},
                    {"product", weight.product()},
                    {"rmsd", fmt::format("{:.5f}", evaluation.rmsd)},
                    {"which", i == tuning.best ? "best" : (i < tuning.scanned ? "scan" : "")}});
  }
  fmt::print("{}", table_text(rows, "alpha|product:K (1 - alpha) / alpha|rmsd:RMSD [px]|which:"));
}

int run_tune(Arguments& arguments, Call& call) {
  const bool against_elements = arguments.truth == "fem";
  if (against_elements) {
    refuse_idle(*call.command, {"--mask"}, "it belongs to a truth from a file, --truth FILE.nrrd");
  }
  Scene scene = arguments.scene.load();
  TuneOptions search = arguments.search;
  search.method = arguments.method == "simplex" ? SearchMethod::simplex : SearchMethod::annealing;
  if (!arguments.range.empty()) {
    search.low = arguments.range[0];
    search.high = arguments.range[1];
  }
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  Progress progress;
  progress.describe(fmt::format("tune {}: the truth", scene.name));
  const Truth truth = against_elements ? Truth{find_finite_elements(scene.full, scene.poisson)}
                                       : read_truth(arguments, scene.extent());
  const auto session = backend.open(arguments.scene.session);
  int evaluations = 0;
  const double penalty = scene.weight.penalty;
  const Tuning tuning = tune_prior_weight(
      [&](double alpha) {
        progress.describe(
            fmt::format("tune {}: evaluation {}, alpha = {:.4g}", scene.name, ++evaluations, alpha));
        set_weight(scene, {.penalty = penalty, .prior_weight = alpha});
        Progress silent(false);
        return rmsd(ReferenceField(solve(scene, *session, silent).displacement), truth.displacement,
                    truth.counted);
      },
      search);
  progress.clear();

  const Evaluation& best = tuning.evaluations[tuning.best];
  fmt::print("{}\n{} pixels, K = {:.6g}, {} on {}, against {}\n\n", scene.title, scene.extent().text(),
             penalty, tuning.matters() ? arguments.method : "scan", backend.name(),
             against_elements ? fmt::format("finite elements (nu = {})", scene.poisson) : arguments.truth);
  print(tuning, penalty);
  if (tuning.matters()) {
    fmt::print("\n  alpha = {:.5f}: RMSD {:.5f} px (the largest seen is {:.3g} px above)\n",
               best.prior_weight, best.rmsd, tuning.spread());
  } else {
    fmt::print(
        "\n  alpha does not matter here: from {} to {} the RMSD changes by {:.2g} px, less than {:.0e}\n",
        search.low, search.high, tuning.spread(), Tuning::flat);
  }
  return success;
}

} // namespace

void add_tune(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "tune",
              "Find the prior weight alpha of (3.17) that brings the solution nearest to a truth (thesis "
              "A.7, (A.8)): a scan of\nfive alphas, then the downhill simplex or simulated annealing over "
              "log(alpha / (1 - alpha)).",
              run_tune);
  own.scene.add_scene_to(command);
  remove_options(command, {"--prior-weight"}); // it is what is looked for
  own.scene.add_backend_to(command);
  add_option(command, "--search", own.method, "simplex (Nelder and Mead) or annealing (thesis Alg. 1)")
      ->check(CLI::IsMember({"simplex", "annealing"}));
  add_option(command, "--evaluations", own.search.evaluations, "Solutions after the scan, about, at most")
      ->check(CLI::Range(1, 100000));
  add_option(command, "--range", own.range, "alpha is sought in low,high (default: 0.01,0.99)")
      ->delimiter(',')
      ->expected(2);
  add_option(command, "--truth", own.truth,
             "fem (finite elements, plane stress, the scene's Poisson ratio), or a displacement image "
             "in millimetres");
  add_option(command, "--mask", own.mask, "Image that is 0 where the truth from a file is not defined");
}

namespace {

namespace fs = std::filesystem;

struct MeshArguments {
  fs::path nodes;
  fs::path elements;
  std::string size;
  std::vector<double> origin;
  std::optional<double> pixel;
  double reach = 1.0;
  fs::path output;
  fs::path mask;
};

PixelGrid grid_of(const MeshArguments& arguments, const Mesh& mesh) {
  const Extent extent = parse_size(arguments.size);
  if (!arguments.pixel) {
    return grid_over(mesh, extent);
  }
  return {.extent = extent,
          .origin_x = arguments.origin[0],
          .origin_y = arguments.origin[1],
          .pixel = *arguments.pixel};
}

int convert_mesh(MeshArguments& arguments, Call& call) {
  const bool by_element = !arguments.elements.empty();
  if (by_element) {
    refuse_idle(*call.command, {"--reach"},
                "shape functions do not look for the nearest node; leave out --elements for that");
  }
  const Mesh mesh = read_mesh(arguments.nodes, by_element ? std::optional(arguments.elements) : std::nullopt);
  const PixelGrid grid = grid_of(arguments, mesh);
  const MeshImage image =
      by_element ? element_image(mesh, grid) : nearest_node_image(mesh, grid, arguments.reach);
  write_displacement(arguments.output, image.displacement, grid.pixel,
                     {.origin = {grid.origin_x, grid.origin_y, 0.0}});
  if (!arguments.mask.empty()) {
    write_png(arguments.mask, image.mask);
  }
  const std::string way =
      by_element ? "shape functions" : fmt::format("nearest node within {} px", arguments.reach);
  fmt::print("{} nodes, {} elements; {} pixels of {:.6g} from ({:.6g}, {:.6g}) on, by {}\n"
             "  {} of {} pixels are defined, {} undefined ones are 0\n  {}: the displacement\n",
             mesh.nodes.size(), mesh.elements.size(), grid.extent.text(), grid.pixel, grid.origin_x,
             grid.origin_y, way, grid.extent.sites() - image.undefined, grid.extent.sites(), image.undefined,
             arguments.output.string());
  if (!arguments.mask.empty()) {
    fmt::print("  {}: white where it is defined\n", arguments.mask.string());
  }
  return success;
}

struct PositionsArguments {
  fs::path input;
  fs::path output;
  std::optional<double> spacing;
};

int convert_positions(PositionsArguments& arguments, Call& /*call*/) {
  const Image<VectorField> positions = read_positions(arguments.input);
  const VectorField displacement = displacements_from_positions(positions.pixels);
  const double spacing = arguments.spacing.value_or(positions.spacing);
  write_displacement(arguments.output, displacement, spacing, positions.placement);
  fmt::print("{}: {} pixels of {:.4g} mm, largest displacement {:.4g} px\n", arguments.output.string(),
             displacement.extent.text(), spacing, largest_magnitude(displacement));
  return success;
}

struct ExportArguments {
  SceneArguments scene;
  fs::path output = "hdmbench-scene";
  bool finite_elements = false;
};

int write_scene(ExportArguments& arguments, Call& /*call*/) {
  const Scene scene = arguments.scene.load();
  const std::vector<std::string> files{
      "scene.toml",    "picture.nrrd", "picture.png", "modulus.nrrd",    "target.nrrd",
      "target.png",    "labels.nrrd",  "start.nrrd",  "confidence.nrrd", "displacement-fem.nrrd",
      "confidence.png"};
  require_folder(arguments.output, files, files_of_scene(arguments.scene.scene));
  Progress progress;
  progress.describe(fmt::format("export {}", scene.name));
  std::vector<std::string> names;
  if (arguments.finite_elements) {
    progress.describe(fmt::format("export {}: solving the finite elements", scene.name));
    names.emplace_back("displacement-fem.nrrd");
    write_displacement(arguments.output / names.back(),
                       find_finite_elements(scene.full, scene.poisson).to_float(), scene.spacing,
                       scene.placement);
  }
  const auto images = export_scene(scene, arguments.output);
  names.insert(names.end(), images.begin(), images.end());
  progress.clear();
  fmt::print("{}, {} pixels of {:.4g} mm: {} files in {}\n  {}\n", scene.title, scene.extent().text(),
             scene.spacing, names.size(), arguments.output.string(), fmt::join(names, "\n  "));
  fmt::print("\n  hdmbench run {} solves the same problem.\n",
             shell_word((arguments.output / "scene.toml").string()));
  return success;
}

struct EnergyArguments {
  SceneArguments scene;
  std::vector<int> sites; ///< column and row of two
  std::string component = "x";
  std::vector<double> range;
  int points = 81;
  bool at_start = false;
  fs::path output;
};

/// The displacements of the two sites now and where they are drawn to, with some space around.
std::array<double, 2> range_around(const Level& level, const std::array<std::size_t, 2>& indices,
                                   std::array<float, 2> here, std::size_t axis) {
  double low = std::min(here[0], here[1]);
  double high = std::max(here[0], here[1]);
  for (const std::size_t site : indices) {
    if (level.confidence[axis][site] > 0.0F) {
      low = std::min(low, double{level.target[axis][site]});
      high = std::max(high, double{level.target[axis][site]});
    }
  }
  const double margin = std::max(5.0, 0.5 * (high - low));
  return {low - margin, high + margin};
}

VectorField displacement_of(const Scene& scene, const EnergyArguments& arguments) {
  if (arguments.at_start) {
    return scene.start_field();
  }
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  Progress progress;
  progress.set_total(site_updates(scene));
  progress.describe(fmt::format("solving {} on {}", scene.name, backend.name()));
  return solve(scene, *backend.open(arguments.scene.session), progress).displacement;
}

int plot(EnergyArguments& arguments, Call& call) {
  if (arguments.at_start) {
    std::vector<std::string> idle = schedule_options(*call.command, {"--penalty", "--prior-weight"});
    idle.insert(idle.end(), {"--backend", "--device", "--threads"});
    refuse_idle(*call.command, idle, "with --start nothing is solved");
  }
  const Scene scene = arguments.scene.load();
  const Extent extent = scene.extent();
  EnergyPlaneOptions options{.sites = {SiteIndex{arguments.sites[0], arguments.sites[1]},
                                       SiteIndex{arguments.sites[2], arguments.sites[3]}},
                             .axis = arguments.component == "x" ? 0U : 1U,
                             .points = arguments.points};
  const auto output = arguments.output.empty() ? fs::path(scene.name + "-energy.svg") : arguments.output;
  require_writable(output);
  require_sites(options.sites, extent);
  const VectorField displacement = displacement_of(scene, arguments);
  const std::array<std::size_t, 2> indices{extent.index(options.sites[0].x, options.sites[0].y),
                                           extent.index(options.sites[1].x, options.sites[1].y)};
  const std::vector<float>& component = displacement[options.axis];
  const std::array<float, 2> here{component[indices[0]], component[indices[1]]};
  const auto range = arguments.range.empty() ? range_around(scene.full, indices, here, options.axis)
                                             : std::array<double, 2>{arguments.range[0], arguments.range[1]};
  options.low = range[0];
  options.high = range[1];
  const EnergyPlane plane = energy_plane(scene.full, displacement, options);
  const std::string title =
      fmt::format("{}, {} pixels{}", scene.name, extent.text(), arguments.at_start ? ", as it starts" : "");
  write_text(output, energy_plot_svg(plane, options, here, title));
  fmt::print("{}\n  {} displacement of the sites {},{} and {},{}, {} x {} values in {:.6g} ... {:.6g} px\n"
             "  lowest on the grid: U = {:.6g} at {:.6g} and {:.6g} px\n"
             "  {}: U = {:.6g} at {:.6g} and {:.6g} px\n  {}: the plot\n",
             scene.title, arguments.component, options.sites[0].x, options.sites[0].y, options.sites[1].x,
             options.sites[1].y, options.points, options.points, options.low, options.high,
             plane.energy[plane.lowest], plane.lowest_first(), plane.lowest_second(),
             arguments.at_start ? "as the scene starts" : "as solved", total_energy(scene.full, displacement),
             here[0], here[1], output.string());
  return success;
}

} // namespace

void add_fem_to_image(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "fem-to-image",
              "Turn a finite element result into a displacement image (thesis A.1). Lists are text: a "
              "line id,x,y,u,v per node,\nid,n1,n2,n3[,n4] per element; commas, semicolons or white "
              "space between, # begins a comment. y points down,\nas in images. Lengths of the "
              "result count as millimetres.",
              convert_mesh);
  add_option(command, "nodes", own.nodes, "Node list")->required();
  add_option(command, "--elements", own.elements,
             "Element list: by its shape functions, else by the nearest node");
  add_option(command, "--size", own.size, "Image size: 300 (square) or 257x130")->required();
  CLI::Option* const pixel =
      add_option(command, "--pixel", own.pixel, "Side of a pixel in the result's unit");
  CLI::Option* const origin =
      add_option(command, "--origin", own.origin,
                 "Position x,y of the first pixel's centre (with --pixel; default: the image covers all "
                 "nodes)")
          ->delimiter(',')
          ->expected(2)
          ->needs(pixel);
  pixel->needs(origin);
  add_option(command, "--reach", own.reach, "Without --elements: pixels beyond which a node is too far away");
  add_output(command, "--output", own.output, "Displacement image, .nrrd or .mha")->required();
  add_output(command, "--mask", own.mask, "Also a PNG of where the displacement is defined");
}

void add_positions_to_displacements(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "positions-to-displacements",
      "Turn an image of where every pixel goes (positions in pixels) into a displacement image (thesis "
      "A.2).\nThe input is a vector image, or the raw transformation that bUnwarpJ saves as text.",
      convert_positions);
  add_option(command, "input", own.input, "Positions: a vector image or bUnwarpJ's text")->required();
  add_output(command, "output", own.output, "Displacement image, .nrrd or .mha")->required();
  add_option(command, "--spacing", own.spacing,
             "Millimetres per pixel (default: the image's own; 1 for a text)");
}

void add_export(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "export",
      "Write all inputs of a scene as images (NRRD, with PNGs to look at) and a scene file that "
      "refers to them\n(thesis A.3, A.6, A.8). --size computes the scene, and the finite elements, at that "
      "size; the images of a scene file are\nscaled when it is read with --size.",
      write_scene);
  own.scene.add_scene_to(command);
  add_output_folder(command, own.output);
  add_flag(command, "--fem", own.finite_elements,
           "Also the displacement by finite elements (plane stress), in millimetres");
}

void add_energy_plot(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "energy-plot",
              "Plot the total energy U over the displacements of two sites, all others as the scene's "
              "schedule leaves them\n(thesis A.5). The sum of all U_t, in double.",
              plot);
  own.scene.add_scene_to(command);
  own.scene.add_backend_to(command);
  add_option(command, "--sites", own.sites, "Two sites as column,row: --sites 10,20 11,20")
      ->required()
      ->delimiter(',')
      ->expected(4);
  add_option(command, "--component", own.component, "Displacement along x or y")
      ->check(CLI::IsMember({"x", "y"}));
  add_option(command, "--range", own.range,
             "Displacements low,high in pixels (default: around the sites' own and their targets)")
      ->delimiter(',')
      ->expected(2);
  add_option(command, "--points", own.points, "Values tried per site")->check(CLI::Range(2, 500));
  add_flag(command, "--start", own.at_start, "All other sites as the scene starts, not solved");
  add_output(command, "--output", own.output, "SVG file (default: SCENE-energy.svg)");
}

} // namespace hdmbench::commands
