// A.1: finite element results to images.

#include "harness/scene/sites.hpp"
#include "harness/tools/thesis_tools.hpp"
#include "test/files.hpp"
#include "test/random_level.hpp"

namespace hdmbench {
namespace {

/// A displacement as a function of the position.
using Function = std::function<double(double x, double y)>;

/// columns x rows quadrilaterals over a rectangle, the inner nodes moved by up to `distortion` of a cell;
/// every third one is cut into two triangles, every fifth one is listed the other way round.
Mesh distorted_mesh(int columns, int rows, double width, double height, double distortion, const Function& u,
                    const Function& v) {
  test::Uniform uniform(5);
  Mesh mesh;
  const auto node = [columns](int i, int j) { return static_cast<std::size_t>(j * (columns + 1) + i); };
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double dx = i > 0 && i < columns ? distortion * (2.0 * uniform() - 1.0) : 0.0;
      const double dy = j > 0 && j < rows ? distortion * (2.0 * uniform() - 1.0) : 0.0;
      const double x = (i + dx) * width / columns;
      const double y = (j + dy) * height / rows;
      mesh.nodes.push_back({x, y, u(x, y), v(x, y)});
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const std::size_t a = node(i, j);
      const std::size_t b = node(i + 1, j);
      const std::size_t c = node(i + 1, j + 1);
      const std::size_t d = node(i, j + 1);
      const int number = j * columns + i;
      if (number % 3 == 0) {
        mesh.elements.push_back({{a, b, c, 0}, 3});
        mesh.elements.push_back({{a, c, d, 0}, 3});
      } else if (number % 5 == 0) {
        mesh.elements.push_back({{a, d, c, b}, 4});
      } else {
        mesh.elements.push_back({{a, b, c, d}, 4});
      }
    }
  }
  return mesh;
}

/// Weights that are not those of a pixel's own r and s give it another place. Undistorted cells, and those at
/// the rim, have parallel sides.
TEST(MeshImage, AnAffineFieldIsMetInADistortedMesh) {
  const auto u = [](double x, double y) { return 3.0 - 0.5 * x + 0.25 * y; };
  const auto v = [](double x, double y) { return -1.0 + 0.125 * x - 0.75 * y; };
  for (const double distortion : {0.0, 0.1, 0.24}) {
    for (const auto& [columns, rows] : {std::pair{11, 8}, {3, 2}, {40, 31}}) {
      const Mesh mesh = distorted_mesh(columns, rows, 59.0, 39.0, distortion, u, v);
      const MeshImage image = element_image(mesh, {.extent = {60, 40}});
      EXPECT_EQ(image.undefined, 0U);
      for_each_site({60, 40}, [&](int x, int y) {
        const auto site = image.displacement.extent.index(x, y);
        ASSERT_NEAR(image.displacement[0][site], u(x, y), 1e-5) << x << "," << y;
        ASSERT_NEAR(image.displacement[1][site], v(x, y), 1e-5) << x << "," << y;
        ASSERT_EQ(image.mask.values[site], 255.0F);
      });
    }
  }
}

TEST(MeshImage, NearestNodeIsThatOfAskingEveryNode) {
  test::Uniform uniform(9);
  Mesh mesh;
  for (int i = 0; i < 300; ++i) { // a cluster, a line and an outlier
    const double x = i < 200 ? 8.0 * uniform() : 30.0 * uniform();
    const double y = i < 200 ? 8.0 * uniform() : 12.0;
    mesh.nodes.push_back({x, y, double(i), 0.0});
  }
  mesh.nodes.push_back({500.0, 300.0, 300.0, 0.0});
  for (const double reach : {0.0, 0.7, 3.0, 1e9}) {
    const MeshImage image = nearest_node_image(mesh, {.extent = {40, 30}}, reach);
    for_each_site({40, 30}, [&](int x, int y) {
      const auto distance = [&](const MeshNode& node) { return std::hypot(node.x - x, node.y - y); };
      const auto nearest = std::ranges::min_element(mesh.nodes, {}, distance);
      const bool reached = distance(*nearest) <= reach;
      const auto site = image.displacement.extent.index(x, y);
      ASSERT_EQ(image.mask.values[site] != 0.0F, reached) << x << "," << y << " reach " << reach;
      ASSERT_EQ(double{image.displacement[0][site]}, reached ? nearest->u : 0.0);
    });
  }
}

TEST(MeshFile, ListsMayBeWrittenInManyWays) {
  const test::TemporaryFolder folder;
  const auto elements =
      folder.write("e.csv", "# quads and triangles\nid;n1;n2;n3;n4\n7;30;10;20;40\n8;10;30;40\n");
  for (const std::string_view text :
       {"id,x,y,u,v\n10,1,0,1.5,-2\n20, 1, 1, 0, 0\n30,0,0,0,0\n40,0,1,0,0\n",
        "\xef\xbb\xbf# mesh\r\n10;1;0;+1.5;-2.0e0\r\n\r\n20;1;1;0;0 # corner\r\n30;0;0;0;0\r\n40;0;1;0;0",
        "  node x y u v\n  10 1 0\t1.5 -2\n20 1 1 0 0\n30 0 0 0 0\n40 0 1 0 0\n"}) {
    const Mesh mesh = read_mesh(folder.write("n.csv", text), elements);
    ASSERT_EQ(mesh.nodes.size(), 4U) << text;
    EXPECT_EQ(mesh.nodes[0].u, 1.5);
    EXPECT_EQ(mesh.nodes[0].v, -2.0);
    ASSERT_EQ(mesh.elements.size(), 2U);
    EXPECT_EQ(mesh.elements[0].nodes, (std::array<std::size_t, 4>{2, 0, 1, 3}));
    EXPECT_EQ(mesh.elements[1].corners, 3U);
  }
}

} // namespace
} // namespace hdmbench
