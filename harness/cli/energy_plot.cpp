#include "harness/tools/energy_plot.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace hdmbench::commands {

namespace {

struct Arguments {
  SceneArguments scene;
  std::vector<std::string> sites;
  std::string component = "x";
  std::vector<double> range;
  int points = 81;
  bool at_start = false;
  std::filesystem::path output;
};

SiteIndex parse_site(const std::string& text) {
  SiteIndex site;
  const char* const end = text.data() + text.size();
  const auto x = std::from_chars(text.data(), end, site.x);
  if (x.ec == std::errc{} && x.ptr != end && *x.ptr == ',') {
    const auto y = std::from_chars(x.ptr + 1, end, site.y);
    if (y.ec == std::errc{} && y.ptr == end) {
      return site;
    }
  }
  throw InputError(fmt::format("the site \"{}\" is not understood; give column,row such as 10,20", text));
}

/// The displacements of the two sites now and where they are drawn to, with some space around.
std::array<double, 2> range_around(const Level& level, const std::array<std::size_t, 2>& indices,
                                   std::array<float, 2> here, Component component) {
  double low = std::min(here[0], here[1]);
  double high = std::max(here[0], here[1]);
  const auto& target = component == Component::x ? level.target.x : level.target.y;
  const auto& confidence = component == Component::x ? level.confidence.x : level.confidence.y;
  for (const std::size_t site : indices) {
    if (confidence[site] > 0.0F) {
      low = std::min(low, double{target[site]});
      high = std::max(high, double{target[site]});
    }
  }
  const double margin = std::max(5.0, 0.5 * (high - low));
  return {low - margin, high + margin};
}

VectorField displacement_of(const Scene& scene, const Arguments& arguments) {
  if (arguments.at_start) {
    return scene.start_field();
  }
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  Progress progress;
  progress.set_total(site_updates(scene), WorkUnit::site_updates);
  progress.describe(fmt::format("solving {} on {}", scene.name, backend.name()));
  return solve(scene, *backend.open(arguments.scene.session), progress).displacement;
}

void plot(const Arguments& arguments, const Command& command) {
  refuse_idle(command,
              {{.here = arguments.at_start,
                .options = options_of_group(command, schedule_group, {"--penalty", "--prior-weight"}),
                .why = "with --start nothing is solved"},
               {.here = arguments.at_start,
                .options = {"--backend", "--device", "--threads"},
                .why = "with --start nothing is solved"}});
  const Scene scene = arguments.scene.load();
  const Extent extent = scene.extent();
  EnergyPlaneOptions options{.sites = {parse_site(arguments.sites[0]), parse_site(arguments.sites[1])},
                             .component = arguments.component == "x" ? Component::x : Component::y,
                             .points = arguments.points};
  const auto output =
      arguments.output.empty() ? std::filesystem::path(scene.name + "-energy.svg") : arguments.output;
  require_writable(output);
  require_sites(options.sites, extent);
  const VectorField displacement = displacement_of(scene, arguments);
  const std::array<std::size_t, 2> indices{extent.index(options.sites[0].x, options.sites[0].y),
                                           extent.index(options.sites[1].x, options.sites[1].y)};
  const auto& component = options.component == Component::x ? displacement.x : displacement.y;
  const std::array<float, 2> here{component[indices[0]], component[indices[1]]};
  const auto range = arguments.range.empty() ? range_around(scene.full, indices, here, options.component)
                                             : std::array<double, 2>{arguments.range[0], arguments.range[1]};
  options.low = range[0];
  options.high = range[1];
  const EnergyPlane plane = energy_plane(scene.full, displacement, options);
  const std::string title = fmt::format("{}, {} x {} pixels{}", scene.name, extent.width, extent.height,
                                        arguments.at_start ? ", as it starts" : "");
  write_text(output, energy_plot_svg(plane, options, here, title));
  fmt::print("{}\n  {} displacement of the sites {},{} and {},{}, {} x {} values in {:.6g} ... {:.6g} px\n"
             "  lowest on the grid: U = {:.6g} at {:.6g} and {:.6g} px\n"
             "  {}: U = {:.6g} at {:.6g} and {:.6g} px\n  {}: the plot\n",
             scene.title, arguments.component, options.sites[0].x, options.sites[0].y, options.sites[1].x,
             options.sites[1].y, options.points, options.points, options.low, options.high,
             plane.energy[plane.lowest], plane.lowest_first(), plane.lowest_second(),
             arguments.at_start ? "as the scene starts" : "as solved", total_energy(scene.full, displacement),
             here[0], here[1], output.string());
}

} // namespace

void add_energy_plot(const Command& program) {
  const Command command = program.add_subcommand(
      "energy-plot", "Plot the total energy U over the displacements of two sites, all others as the scene's "
                     "schedule leaves them\n(thesis A.5). The sum of all U_t, in double.");
  const auto own = std::make_shared<Arguments>();
  own->scene.add_scene_to(command);
  own->scene.add_backend_to(command);
  command.add_option("--sites", own->sites, "Two sites as column,row: --sites 10,20 11,20")
      .required()
      .expected(2);
  command.add_option("--component", own->component, "Displacement along x or y")
      .one_of({"x", "y"})
      .capture_default_str();
  command
      .add_option("--range", own->range,
                  "Displacements low,high in pixels (default: around the sites' own "
                  "and their targets)")
      .delimiter(',')
      .expected(2);
  command.add_option("--points", own->points, "Values tried per site").range(2, 500).capture_default_str();
  command.add_flag("--start", own->at_start, "All other sites as the scene starts, not solved");
  command.add_option("--output", own->output, "SVG file (default: SCENE-energy.svg)");
  command.callback([own, command] { plot(*own, command); });
}

} // namespace hdmbench::commands
