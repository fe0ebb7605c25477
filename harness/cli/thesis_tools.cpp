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

namespace fs = std::filesystem;

const Option<std::string> search("--search", "simplex (Nelder and Mead) or annealing (thesis Alg. 1)",
                                 "simplex", CLI::IsMember({"simplex", "annealing"}));
const Option<int> evaluations("--evaluations", "Solutions after the scan, about, at most",
                              TuneOptions{}.evaluations, CLI::Range(1, 100000));
/// Of `tune`, and of `energy-plot`.
const Option<std::vector<double>> limits("--range", "alpha is sought in low,high (default: 0.01,0.99)", {},
                                         {}, 2);
const Option<std::string> truth_name(
    "--truth",
    "fem (finite elements, plane stress, the scene's Poisson ratio), or a displacement image in millimetres",
    "fem");
const Option<fs::path> truth_mask("--mask", "Image that is 0 where the truth from a file is not defined");

/// What a solution is measured against.
struct Truth {
  ReferenceField displacement;         ///< pixels
  std::vector<std::uint8_t> counted{}; ///< not 0 where the truth is known; empty: everywhere
};

Truth read_truth(const Call& call, Extent extent) {
  Image<VectorField> read = read_displacement(call[truth_name]);
  if (read.pixels.extent != extent) {
    throw InputError(fmt::format("{}: is {} pixels, the scene is {}", call[truth_name],
                                 read.pixels.extent.text(), extent.text()));
  }
  validate(read.pixels, extent, "the truth");
  Truth truth{.displacement = ReferenceField(read.pixels)};
  if (!call[truth_mask].empty()) {
    const ScalarField mask = read_scalar(call[truth_mask]).pixels;
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

int run_tune(Call& call) {
  call.schedule.meets_truths = true;
  const bool against_elements = call[truth_name] == "fem";
  if (against_elements) {
    refuse_idle(*call.command, {"--mask"}, "it belongs to a truth from a file, --truth FILE.nrrd");
  }
  Scene scene = scene_of(call);
  TuneOptions options{.method = call[search] == "simplex" ? SearchMethod::simplex : SearchMethod::annealing,
                      .evaluations = call[evaluations]};
  if (!call[limits].empty()) {
    options.low = call[limits][0];
    options.high = call[limits][1];
  }
  const auto registry = make_backends();
  const Backend& backend = choose_backend(call, registry, scene);
  Progress progress;
  progress.describe(fmt::format("tune {}: the truth", scene.name));
  const Truth truth = against_elements ? Truth{find_finite_elements(scene.full, scene.elastic)}
                                       : read_truth(call, scene.extent());
  const auto session = backend.open(call.session());
  int evaluation = 0;
  const double penalty = scene.weight.penalty;
  const Tuning tuning = tune_prior_weight(
      [&](double alpha) {
        progress.describe(
            fmt::format("tune {}: evaluation {}, alpha = {:.4g}", scene.name, ++evaluation, alpha));
        set_weight(scene, {.penalty = penalty, .prior_weight = alpha});
        Progress silent(false);
        return rmsd(ReferenceField(solve(scene, *session, silent).displacement), truth.displacement,
                    truth.counted);
      },
      options);
  progress.clear();

  const Evaluation& best = tuning.evaluations[tuning.best];
  fmt::print("{}\n{} pixels, K = {:.6g}, {} on {}, against {}\n\n", scene.title, scene.extent().text(),
             penalty, tuning.matters() ? call[search] : "scan", backend.name(),
             against_elements ? fmt::format("finite elements (nu = {})", scene.elastic.poisson)
                              : call[truth_name]);
  print(tuning, penalty);
  if (tuning.matters()) {
    fmt::print("\n  alpha = {:.5f}: RMSD {:.5f} px (the largest seen is {:.3g} px above)\n",
               best.prior_weight, best.rmsd, tuning.spread());
  } else {
    fmt::print(
        "\n  alpha does not matter here: from {} to {} the RMSD changes by {:.2g} px, less than {:.0e}\n",
        options.low, options.high, tuning.spread(), Tuning::flat);
  }
  return success;
}

const Option<fs::path> nodes("nodes", "Node list");
const Option<fs::path> elements("--elements",
                                "Element list: by its shape functions, else by the nearest node");
const Option<std::optional<double>> pixel_side("--pixel", "Side of a pixel in the result's unit");
const Option<std::vector<double>>
    origin("--origin",
           "Position x,y of the first pixel's centre (with --pixel; default: the image covers all nodes)", {},
           {}, 2);
const Option<double> reach("--reach", "Without --elements: pixels beyond which a node is too far away", 1.0);
const Option<OutputFile> image_file("--output", "Displacement image, .nrrd or .mha");
const Option<OutputFile> mask_file("--mask", "Also a PNG of where the displacement is defined");

PixelGrid grid_of(const Call& call, const Mesh& mesh) {
  const Extent extent = parse_size(call[option::size]);
  if (!call[pixel_side]) {
    return grid_over(mesh, extent);
  }
  return {
      .extent = extent, .origin_x = call[origin][0], .origin_y = call[origin][1], .pixel = *call[pixel_side]};
}

int convert_mesh(Call& call) {
  const bool by_element = !call[elements].empty();
  if (by_element) {
    refuse_idle(*call.command, {"--reach"},
                "shape functions do not look for the nearest node; leave out --elements for that");
  }
  const Mesh mesh = read_mesh(call[nodes], by_element ? std::optional(call[elements]) : std::nullopt);
  const PixelGrid grid = grid_of(call, mesh);
  const MeshImage image =
      by_element ? element_image(mesh, grid) : nearest_node_image(mesh, grid, call[reach]);
  write_displacement(call[image_file], image.displacement, grid.pixel,
                     {.origin = {grid.origin_x, grid.origin_y, 0.0}});
  if (!call[mask_file].empty()) {
    write_png(call[mask_file], image.mask);
  }
  const std::string way =
      by_element ? "shape functions" : fmt::format("nearest node within {} px", call[reach]);
  fmt::print("{} nodes, {} elements; {} pixels of {:.6g} from ({:.6g}, {:.6g}) on, by {}\n"
             "  {} of {} pixels are defined, {} undefined ones are 0\n  {}: the displacement\n",
             mesh.nodes.size(), mesh.elements.size(), grid.extent.text(), grid.pixel, grid.origin_x,
             grid.origin_y, way, grid.extent.sites() - image.undefined, grid.extent.sites(), image.undefined,
             call[image_file].string());
  if (!call[mask_file].empty()) {
    fmt::print("  {}: white where it is defined\n", call[mask_file].string());
  }
  return success;
}

const Option<fs::path> positions_file("input", "Positions: a vector image or bUnwarpJ's text");
const Option<OutputFile> displacement_file("output", "Displacement image, .nrrd or .mha");
const Option<std::optional<double>>
    spacing_of_pixels("--spacing", "Millimetres per pixel (default: the image's own; 1 for a text)");

int convert_positions(Call& call) {
  const Image<VectorField> positions = read_positions(call[positions_file]);
  const VectorField displacement = displacements_from_positions(positions.pixels);
  const double spacing = call[spacing_of_pixels].value_or(positions.spacing);
  write_displacement(call[displacement_file], displacement, spacing, positions.placement);
  fmt::print("{}: {} pixels of {:.4g} mm, largest displacement {:.4g} px\n", call[displacement_file].string(),
             displacement.extent.text(), spacing, largest_magnitude(displacement));
  return success;
}

const Option<bool>
    with_finite_elements("--fem", "Also the displacement by finite elements (plane stress), in millimetres");

int write_scene(Call& call) {
  call.schedule.meets_truths = true; // the file has it for who reads it
  const Scene scene = scene_of(call);
  const std::vector<std::string> files{
      "scene.toml",    "picture.nrrd", "picture.png", "modulus.nrrd",    "target.nrrd",
      "target.png",    "labels.nrrd",  "start.nrrd",  "confidence.nrrd", "displacement-fem.nrrd",
      "confidence.png"};
  require_folder(call[option::output], files, files_of_scene(call[option::scene]));
  Progress progress;
  progress.describe(fmt::format("export {}", scene.name));
  std::vector<std::string> names;
  if (call[with_finite_elements]) {
    progress.describe(fmt::format("export {}: solving the finite elements", scene.name));
    names.emplace_back("displacement-fem.nrrd");
    write_displacement(call[option::output] / names.back(),
                       find_finite_elements(scene.full, scene.elastic).to_float(), scene.spacing,
                       scene.placement);
  }
  const auto images = export_scene(scene, call[option::output]);
  names.insert(names.end(), images.begin(), images.end());
  progress.clear();
  fmt::print("{}, {} pixels of {:.4g} mm: {} files in {}\n  {}\n", scene.title, scene.extent().text(),
             scene.spacing, names.size(), call[option::output].string(), fmt::join(names, "\n  "));
  fmt::print("\n  hdmbench run {} solves the same problem.\n",
             shell_word((call[option::output] / "scene.toml").string()));
  return success;
}

const Option<std::vector<int>> sites("--sites", "Two sites as column,row: --sites 10,20 11,20", {}, {}, 4);
const Option<std::string> component_name("--component", "Displacement along x or y", "x",
                                         CLI::IsMember({"x", "y"}));
const Option<int> points("--points", "Values tried per site", 81, CLI::Range(2, 500));
const Option<bool> at_start("--start", "All other sites as the scene starts, not solved");
const Option<OutputFile> plot_file("--output", "SVG file (default: SCENE-energy.svg)");

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

VectorField displacement_of(const Scene& scene, const Call& call) {
  if (call[at_start]) {
    return scene.start_field();
  }
  const auto registry = make_backends();
  const Backend& backend = choose_backend(call, registry, scene);
  Progress progress;
  progress.set_total(site_updates(scene));
  progress.describe(fmt::format("solving {} on {}", scene.name, backend.name()));
  return solve(scene, *backend.open(call.session()), progress).displacement;
}

int plot(Call& call) {
  if (call[at_start]) {
    std::vector<std::string> idle = schedule_names(*call.command, {"--penalty", "--prior-weight"});
    idle.insert(idle.end(), {"--backend", "--device", "--threads"});
    refuse_idle(*call.command, idle, "with --start nothing is solved");
  }
  const Scene scene = scene_of(call);
  const Extent extent = scene.extent();
  EnergyPlaneOptions options{
      .sites = {SiteIndex{call[sites][0], call[sites][1]}, SiteIndex{call[sites][2], call[sites][3]}},
      .axis = call[component_name] == "x" ? 0U : 1U,
      .points = call[points]};
  const auto output = call[plot_file].empty() ? fs::path(scene.name + "-energy.svg") : call[plot_file];
  require_writable(output);
  require_sites(options.sites, extent);
  const VectorField displacement = displacement_of(scene, call);
  const std::array<std::size_t, 2> indices{extent.index(options.sites[0].x, options.sites[0].y),
                                           extent.index(options.sites[1].x, options.sites[1].y)};
  const std::vector<float>& component = displacement[options.axis];
  const std::array<float, 2> here{component[indices[0]], component[indices[1]]};
  const auto range = call[limits].empty() ? range_around(scene.full, indices, here, options.axis)
                                          : std::array<double, 2>{call[limits][0], call[limits][1]};
  options.low = range[0];
  options.high = range[1];
  const EnergyPlane plane = energy_plane(scene.full, displacement, options);
  const std::string title =
      fmt::format("{}, {} pixels{}", scene.name, extent.text(), call[at_start] ? ", as it starts" : "");
  write_text(output, energy_plot_svg(plane, options, here, title));
  fmt::print("{}\n  {} displacement of the sites {},{} and {},{}, {} x {} values in {:.6g} ... {:.6g} px\n"
             "  lowest on the grid: U = {:.6g} at {:.6g} and {:.6g} px\n"
             "  {}: U = {:.6g} at {:.6g} and {:.6g} px\n  {}: the plot\n",
             scene.title, call[component_name], options.sites[0].x, options.sites[0].y, options.sites[1].x,
             options.sites[1].y, options.points, options.points, options.low, options.high,
             plane.energy[plane.lowest], plane.lowest_first(), plane.lowest_second(),
             call[at_start] ? "as the scene starts" : "as solved", total_energy(scene.full, displacement),
             here[0], here[1], output.string());
  return success;
}

} // namespace

void add_tune(CLI::App& program, Call& call) {
  add_command(program, call, "tune", run_tune,
              "Find the prior weight nearest to a truth.\n"
              "Find the prior weight alpha of (3.17) that brings the solution nearest to a truth (thesis "
              "A.7, (A.8)): a scan of\n"
              "five alphas, then the downhill simplex or simulated annealing over log(alpha / (1 - alpha)).",
              {option::scene, option::size, schedule_options(false).without({"--prior-weight"}),
               backend_options(), search, evaluations, limits, truth_name, truth_mask},
              {"scene is required"}, false);
}

void add_fem_to_image(CLI::App& program, Call& call) {
  add_command(program, call, "fem-to-image", convert_mesh,
              "Turn a finite element result into an image.\n"
              "Turn a finite element result into a displacement image (thesis A.1). Lists are text: a line "
              "id,x,y,u,v per node,\n"
              "id,n1,n2,n3[,n4] per element; commas, semicolons or white space between, # begins a comment. "
              "y points down,\n"
              "as in images. Lengths of the result count as millimetres.",
              {nodes, elements, Options(option::size, "Image size: 300 (square) or 257x130"), pixel_side,
               origin, reach, image_file, mask_file},
              {"nodes is required", "--size is required", "--output is required", "--origin needs --pixel",
               "--pixel needs --origin"});
}

void add_positions_to_displacements(CLI::App& program, Call& call) {
  add_command(program, call, "positions-to-displacements", convert_positions,
              "Turn positions of pixels into displacements.\n"
              "Turn an image of where every pixel goes (positions in pixels) into a displacement image "
              "(thesis A.2).\n"
              "The input is a vector image, or the raw transformation that bUnwarpJ saves as text.",
              {positions_file, displacement_file, spacing_of_pixels},
              {"input is required", "output is required"});
}

void add_export(CLI::App& program, Call& call) {
  add_command(program, call, "export", write_scene,
              "Write all inputs of a scene as images.\n"
              "Write all inputs of a scene as images (NRRD, with PNGs to look at) and a scene file that "
              "refers to them\n"
              "(thesis A.3, A.6, A.8). --size computes the scene, and the finite elements, at that size; the "
              "images of a scene file are\n"
              "scaled when it is read with --size.",
              {option::scene, option::size, schedule_options(false),
               Options(option::output, nullptr, "hdmbench-scene"), with_finite_elements},
              {"scene is required"}, false);
}

void add_energy_plot(CLI::App& program, Call& call) {
  add_command(
      program, call, "energy-plot", plot,
      "Plot the energy over two sites' displacements.\n"
      "Plot the total energy U over the displacements of two sites, all others as the scene's schedule "
      "leaves them\n"
      "(thesis A.5). The sum of all U_t, in double.",
      {option::scene, option::size, schedule_options(false), backend_options(), sites, component_name,
       Options(limits, "Displacements low,high in pixels (default: around the sites' own and their targets)"),
       points, at_start, plot_file},
      {"scene is required", "--sites is required"}, false);
}

} // namespace hdmbench::commands
