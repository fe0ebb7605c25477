#include "harness/tools/positions.hpp"
#include "harness/check/compare.hpp"
#include "harness/cli/commands.hpp"
#include "harness/scene/file_output.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::filesystem::path input;
  std::filesystem::path output;
  std::optional<double> spacing;
};

void convert(const Arguments& arguments) {
  require_writable(arguments.output);
  const Image<VectorField> positions = read_positions(arguments.input);
  const VectorField displacement = displacements_from_positions(positions.pixels);
  const double spacing = arguments.spacing.value_or(positions.spacing);
  write_displacement(arguments.output, displacement, spacing, positions.placement);
  fmt::print("{}: {} x {} pixels of {:.4g} mm, largest displacement {:.4g} px\n", arguments.output.string(),
             displacement.extent.width, displacement.extent.height, spacing, largest_magnitude(displacement));
}

} // namespace

void add_positions_to_displacements(const Command& program) {
  const Command command = program.add_subcommand(
      "positions-to-displacements",
      "Turn an image of where every pixel goes (positions in pixels) into a displacement image (thesis "
      "A.2).\nThe input is a vector image, or the raw transformation that bUnwarpJ saves as text.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("input", own->input, "Positions: a vector image or bUnwarpJ's text").required();
  command.add_option("output", own->output, "Displacement image, .nrrd or .mha").required();
  command.add_option("--spacing", own->spacing,
                     "Millimetres per pixel (default: the image's own; 1 for a text)");
  command.callback([own] { convert(*own); });
}

} // namespace hdmbench::commands
