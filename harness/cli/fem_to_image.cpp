#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/tools/mesh_image.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path nodes;
  fs::path elements;
  std::string size;
  std::vector<double> origin;
  std::optional<double> pixel;
  std::string interpolation;
  double reach = 1.0;
  fs::path output;
  fs::path mask;
};

PixelGrid grid_of(const Arguments& arguments, const Mesh& mesh) {
  const Extent extent = parse_size(arguments.size);
  require_memory(extent);
  if (arguments.origin.empty() != !arguments.pixel) {
    throw InputError("--origin and --pixel belong together: give both, or none for a grid over all nodes");
  }
  if (!arguments.pixel) {
    return grid_over(mesh, extent);
  }
  return {.extent = extent,
          .origin_x = arguments.origin[0],
          .origin_y = arguments.origin[1],
          .pixel = *arguments.pixel};
}

void convert(const Arguments& arguments, const Command& command) {
  const bool by_element =
      arguments.interpolation.empty() ? !arguments.elements.empty() : arguments.interpolation == "element";
  refuse_idle(command,
              {{.here = by_element,
                .options = {"--reach"},
                .why = "shape functions do not look for the nearest node; --interpolation nearest does"}});
  if (by_element && arguments.elements.empty()) {
    throw InputError("--interpolation element needs the element list: --elements FILE");
  }
  require_writable(arguments.output);
  if (!arguments.mask.empty()) {
    require_writable(arguments.mask);
  }
  const Mesh mesh = read_mesh(arguments.nodes,
                              arguments.elements.empty() ? std::nullopt : std::optional(arguments.elements));
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
  fmt::print("{} nodes, {} elements; {} x {} pixels of {:.6g} from ({:.6g}, {:.6g}) on, by {}\n"
             "  {} of {} pixels are defined, {} undefined ones are 0\n  {}: the displacement\n",
             mesh.nodes.size(), mesh.elements.size(), grid.extent.width, grid.extent.height, grid.pixel,
             grid.origin_x, grid.origin_y, way, grid.extent.sites() - image.undefined, grid.extent.sites(),
             image.undefined, arguments.output.string());
  if (!arguments.mask.empty()) {
    fmt::print("  {}: white where it is defined\n", arguments.mask.string());
  }
}

} // namespace

void add_fem_to_image(const Command& program) {
  const Command command = program.add_subcommand(
      "fem-to-image",
      "Turn a finite element result into a displacement image (thesis A.1). Lists are text: a "
      "line id,x,y,u,v per node,\nid,n1,n2,n3[,n4] per element; commas, semicolons or white "
      "space between, # begins a comment. y points down,\nas in images. Lengths of the "
      "result count as millimetres.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("nodes", own->nodes, "Node list").required();
  command.add_option("--elements", own->elements, "Element list");
  command.add_option("--size", own->size, "Image size: 300 (square) or 257x130").required();
  command
      .add_option("--origin", own->origin,
                  "Position x,y of the first pixel's centre (with --pixel; default: "
                  "the image covers all nodes)")
      .delimiter(',')
      .expected(2);
  command.add_option("--pixel", own->pixel, "Side of a pixel in the result's unit");
  command
      .add_option("--interpolation", own->interpolation,
                  "nearest (node; default without elements) or element (shape functions; default with)")
      .one_of({"nearest", "element"});
  command.add_option("--reach", own->reach, "With nearest: pixels beyond which a node is too far away")
      .capture_default_str();
  command.add_option("--output", own->output, "Displacement image, .nrrd or .mha").required();
  command.add_option("--mask", own->mask, "Also a PNG of where the displacement is defined");
  command.callback([own, command] { convert(*own, command); });
}

} // namespace hdmbench::commands
