// Text lists of the thesis's tools: nodes and elements (a line of = between the two), bUnwarpJ's raw
// transformations.

#include "harness/tools/mesh_image.hpp"
#include "harness/tools/positions.hpp"
#include "test/fuzz/input.hpp"

namespace {

using namespace hdmbench;

void read_lists(std::string_view text) {
  constexpr std::string_view border = "\n=\n";
  const auto end = text.find(border);
  const auto nodes = fuzz::file_with("nodes.csv", text.substr(0, end));
  if (end == std::string_view::npos) {
    const Mesh mesh = read_mesh(nodes, std::nullopt);
    (void)nearest_node_image(mesh, grid_over(mesh, {8, 6}), 1.0);
  } else {
    const Mesh mesh = read_mesh(nodes, fuzz::file_with("elements.csv", text.substr(end + border.size())));
    (void)element_image(mesh, grid_over(mesh, {8, 6}));
  }
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto text = fuzz::as_text(data, size);
  fuzz::expect_an_answer([&] {
    if (text.starts_with("Width=")) {
      (void)displacements_from_positions(read_positions(fuzz::file_with("raw.txt", text)).pixels);
    } else {
      read_lists(text);
    }
  });
  return 0;
}
