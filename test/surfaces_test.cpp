// Surfaces that have moved: what their files say, and what they do in a scene.

#include "harness/scene/surfaces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "test/files.hpp"
#include "test/sessions.hpp"

#include <bit>
#include <numbers>

namespace hdmbench {
namespace {

using testing::HasSubstr;
using Vector = Placement::Vector;

struct Mesh {
  std::vector<Vector> vertices;
  std::vector<std::array<int, 3>> triangles;
};

constexpr Vector middle{17.25, 17.25, 17.25};
constexpr double radius = 11.0;

/// A sphere of so many rings of triangles; those at the poles have an edge of no length or none of their own.
Mesh sphere(int rings) {
  Mesh mesh;
  const int sectors = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    const double polar = std::numbers::pi * ring / rings;
    const double wide = ring % rings == 0 ? 0.0 : radius * std::sin(polar);
    for (int sector = 0; sector < sectors; ++sector) {
      const double around = std::numbers::pi * sector / rings;
      mesh.vertices.push_back({middle[0] + wide * std::cos(around), middle[1] + wide * std::sin(around),
                               middle[2] + radius * std::cos(polar)});
      if (ring < rings) {
        const int here = ring * sectors + sector;
        const int next = ring * sectors + (sector + 1) % sectors;
        mesh.triangles.push_back({here, here + sectors, next});
        mesh.triangles.push_back({next, here + sectors, next + sectors});
      }
    }
  }
  return mesh;
}

std::string as_text(const Mesh& mesh, std::string_view space = "SPACE=LPS") {
  std::string text =
      fmt::format("# vtk DataFile Version 4.2\n{}\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", space,
                  mesh.vertices.size());
  for (const Vector& at : mesh.vertices) {
    text += fmt::format("{} {} {}\n", at[0], at[1], at[2]);
  }
  text += fmt::format("METADATA\nINFORMATION 0\n\nLINES 1 5\n4 0 1 2 3\nPOLYGONS {} {}\n",
                      mesh.triangles.size(), 4 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    text += fmt::format("3 {} {} {}\n", a, b, c);
  }
  return text + "POINT_DATA 1\n";
}

template <typename Number>
std::string bytes_of(Number number, std::endian order) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  if (order != std::endian::native) {
    std::ranges::reverse(bytes);
  }
  return bytes;
}

/// VTK's binary format since version 5.
std::string as_binary_vtk(const Mesh& mesh) {
  std::string text =
      fmt::format("# vtk DataFile Version 5.1\nSPACE=LPS\nBINARY\nDATASET POLYDATA\nPOINTS {} double\n",
                  mesh.vertices.size());
  for (const Vector& at : mesh.vertices) {
    for (const double component : at) {
      text += bytes_of(component, std::endian::big);
    }
  }
  text += fmt::format("\nPOLYGONS {} {}\nOFFSETS vtktypeint64\n", mesh.triangles.size() + 1,
                      3 * mesh.triangles.size());
  for (std::size_t i = 0; i <= mesh.triangles.size(); ++i) {
    text += bytes_of(static_cast<std::int64_t>(3 * i), std::endian::big);
  }
  text += "\nCONNECTIVITY vtktypeint64\n";
  for (const auto& corners : mesh.triangles) {
    for (const int corner : corners) {
      text += bytes_of(std::int64_t{corner}, std::endian::big);
    }
  }
  return text + "\n";
}

/// PLY with what other programs write beside vertices and faces.
std::string as_ply(const Mesh& mesh, std::string_view format) {
  std::string text = fmt::format("ply\nformat {} 1.0\ncomment SPACE=LPS\nelement vertex {}\n"
                                 "property double x\nproperty float quality\nproperty double y\n"
                                 "property double z\nelement face {}\nproperty uchar red\n"
                                 "property list uchar int vertex_indices\nend_header\n",
                                 format, mesh.vertices.size(), mesh.triangles.size());
  const auto put = [&](auto number) {
    if (format == "ascii") {
      text += fmt::format("{} ", number);
    } else {
      text += bytes_of(number, format == "binary_big_endian" ? std::endian::big : std::endian::little);
    }
  };
  for (const Vector& at : mesh.vertices) {
    put(at[0]);
    put(0.5F);
    put(at[1]);
    put(at[2]);
  }
  for (const auto& corners : mesh.triangles) {
    put(std::uint8_t{255});
    put(std::uint8_t{3});
    for (const int corner : corners) {
      put(corner);
    }
  }
  return text;
}

std::string as_obj(const Mesh& mesh) {
  std::string text = "# SPACE=LPS\n";
  for (const Vector& at : mesh.vertices) {
    text += fmt::format("v {} {} {}\n", at[0], at[1], at[2]);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    text += fmt::format("f {}/1/1 {} {}\n", a + 1, b + 1, c - static_cast<int>(mesh.vertices.size()));
  }
  return text;
}

std::string as_stl(const Mesh& mesh) {
  std::string text = "3D Slicer output. SPACE=LPS";
  text.resize(80, ' ');
  text += bytes_of(static_cast<std::int32_t>(mesh.triangles.size()), std::endian::little);
  for (const auto& corners : mesh.triangles) {
    text.append(12, '\0');
    for (const int corner : corners) {
      for (const double component : mesh.vertices[static_cast<std::size_t>(corner)]) {
        text += bytes_of(static_cast<float>(component), std::endian::little);
      }
    }
    text.append(2, '\0');
  }
  return text;
}

class Surfaces : public ImageFiles {
protected:
  /// A cube of side^3 voxels, 34.5 mm from the first to the last, held on its border.
  [[nodiscard]] Scene load(std::string_view more, int side) const {
    const Extent extent{side, side, side};
    write_labels(path("labels.nrrd"), {extent, std::vector<int>(extent.sites(), 1)}, 34.5 / (side - 1));
    return load_scene(
        write("scene.toml", fmt::format("energy = \"elastic\"\n[image]\nlabels = \"labels.nrrd\"\n"
                                        "[[tissue]]\nlabel = 1\nmodulus = 3.0\n[[condition]]\n"
                                        "where = \"border\"\ndx = 0\ndy = 0\ndz = 0\n[[points]]\n"
                                        "before = \"before.vtk\"\nafter = \"after.vtk\"\n{}",
                                        more))
            .string());
  }
};

/// Millimetres by which a uniform strain moves a point.
Vector strained(const Vector& at) {
  const Vector from{at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]};
  return {0.04 * from[0] + 0.02 * from[1], -0.03 * from[1], 0.01 * from[0] - 0.02 * from[2]};
}

Mesh moved(Mesh mesh) {
  for (Vector& vertex : mesh.vertices) {
    const Vector way = strained(vertex);
    for (std::size_t i = 0; i < 3; ++i) {
      vertex[i] += way[i];
    }
  }
  return mesh;
}

/// What is inside of a surface that a uniform strain moves is strained as it is. Certain pieces prescribe the
/// sites of their cells, less than a voxel away along each axis, with means of what they know: they are off
/// by at most the strain times that, 0.06 (the largest sum of a row) times the side. To meet the pieces,
/// whose gaps are no larger, the first pass moves a site by a mean of gaps, at most as much again, and later
/// ones by less. What moves is up to 0.66 mm.
TEST_F(Surfaces, StrainWhatIsInside) {
  for (const auto& [side, rings] : {std::pair{24, 4}, {24, 16}, {46, 8}}) {
    const Mesh mesh = sphere(rings);
    (void)write("before.vtk", as_text(mesh));
    (void)write("after.vtk", as_text(moved(mesh)));
    const Scene scene = load("", side);
    const VectorField field = test::converged(scene.full, scene.elastic);
    double worst = 0.0;
    for_each_site(scene.extent(), [&](int x, int y, int z) {
      const Vector at{scene.spacing * x, scene.spacing * y, scene.spacing * z};
      if (std::hypot(at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]) < 0.9 * radius) {
        for (std::size_t i = 0; i < 3; ++i) {
          const double found = scene.spacing * double{field[i][scene.extent().index(x, y, z)]};
          worst = std::max(worst, std::abs(found - strained(at)[i]));
        }
      }
    });
    double missed = 0.0;
    for (const KnownPoint& piece : scene.points) {
      missed = std::max(missed, residual_at(piece, field) * scene.spacing);
    }
    fmt::print("{} pieces, voxels of {:.3g} mm: {:.2g} mm, missed by {:.2g} mm\n", scene.points.size(),
               scene.spacing, worst, missed);
    EXPECT_LE(worst, 2.0 * 0.06 * scene.spacing);
    EXPECT_LE(missed, 2.0 * 0.06 * scene.spacing);
  }
}

/// A piece with a deviation weighs as its area, so that it does not matter how fine the triangles are: the
/// springs of a face of a box that is two triangles, or 1152, weigh the same, whatever each site's share is.
TEST_F(Surfaces, WeighAsTheirArea) {
  const auto weight_of = [&](int cells) {
    Mesh plane;
    for (int y = 0; y <= cells; ++y) {
      for (int x = 0; x <= cells; ++x) {
        plane.vertices.push_back({6.0 + 24.0 * x / cells, 6.0 + 24.0 * y / cells, 17.0});
        if (x < cells && y < cells) {
          const int corner = y * (cells + 1) + x;
          plane.triangles.push_back({corner, corner + 1, corner + cells + 1});
          plane.triangles.push_back({corner + 1, corner + cells + 2, corner + cells + 1});
        }
      }
    }
    (void)write("before.vtk", as_text(plane));
    (void)write("after.vtk", as_text(moved(plane)));
    const Scene scene = load("deviation = 0.5\n", 24);
    double weight = 0.0;
    for (const float confidence : scene.full.confidence[0]) {
      weight += is_spring(confidence) ? weight_of_confidence(confidence) : 0.0;
    }
    return weight;
  };
  // point_springs(): 24^2 mm^2 are 92.16 points of (2.5 mm / 1.5 mm)^3 voxels each, at (1.5 mm / 0.5 mm)^2
  const double expected = 92.16 * std::pow(2.5 / 1.5, 3) * 9.0;
  for (const int cells : {1, 24}) {
    EXPECT_NEAR(weight_of(cells), expected, 1e-4 * expected) << "floats of confidence";
  }
}

/// What pieces are made of, whatever the file: as many, and each within a float's rounding of STL's.
TEST_F(Surfaces, OfAllFormatsAreTheSame) {
  const Mesh mesh = sphere(4);
  (void)write("before.vtk", as_text(mesh));
  (void)write("after.vtk", as_text(moved(mesh)));
  const auto expected = read_surface_pairs(path("before.vtk"), path("after.vtk"), "");
  for (const PointPair& pair : expected) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(pair.after[i] - pair.before[i], strained(pair.before)[i], 1e-12);
    }
  }
  const auto expect_same = [&](const char* name, const std::string& before, const std::string& after) {
    const auto pairs = read_surface_pairs(write(fmt::format("a{}", name), before),
                                          write(fmt::format("b{}", name), after), "LPS");
    ASSERT_EQ(pairs.size(), expected.size()) << name;
    for (std::size_t piece = 0; piece < pairs.size(); ++piece) {
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(pairs[piece].before[i], expected[piece].before[i], 2e-6) << name;
        EXPECT_NEAR(pairs[piece].after[i], expected[piece].after[i], 2e-6) << name;
      }
    }
  };
  expect_same(".vtk", as_binary_vtk(mesh), as_binary_vtk(moved(mesh)));
  for (const char* const format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    expect_same(".ply", as_ply(mesh, format), as_ply(moved(mesh), format));
  }
  expect_same(".obj", as_obj(mesh), as_obj(moved(mesh)));
  expect_same(".stl", as_stl(mesh), as_stl(moved(mesh)));
  const auto turned = read_surface_pairs(write("r.vtk", as_text(mesh, "")), path("r.vtk"), "RAS");
  EXPECT_EQ(turned[0].before, Placement::turned(expected[0].before));
}

TEST_F(Surfaces, ThatCannotBeMeantAreRefused) {
  const Mesh mesh = sphere(2);
  const fs::path good = write("good.vtk", as_text(mesh));
  const auto refuse = [&](const char* name, const std::string& text, const char* why,
                          const char* space = "") {
    const fs::path file = write(name, text);
    expect_refusal([&] { (void)read_surface_pairs(file, good, space); }, why);
  };
  Mesh other = sphere(3);
  refuse("a.vtk", as_text(other), "a.vtk has 24 vertices, ");
  other = mesh;
  other.triangles.pop_back();
  refuse("a.vtk", as_text(other), "a.vtk has 15 triangles, ");
  other = mesh;
  std::swap(other.triangles[2][0], other.triangles[2][1]);
  refuse("a.vtk", as_text(other), "triangle 3 has other corners");
  other.triangles[0][0] = 12;
  refuse("a.vtk", as_text(other), "has the vertex 12, and there are 12");
  other.triangles[0][0] = -1;
  refuse("a.vtk", as_text(other), "has the vertex -1");
  refuse("a.vtk", as_text(mesh, ""), "does not say where it lies");
  refuse("a.vtk", as_text(mesh), "says that it is in LPS, and not in RAS", "RAS");
  refuse("a.vtk", "solid SPACE=LPS\n", "is no PolyData");
  refuse("a.ply", "plx SPACE=LPS\n", "is no PLY file");
  refuse("a.ply", "ply\ncomment SPACE=LPS\nelement vertex 3\n", "a header that does not end");
  refuse("a.ply", "ply\ncomment SPACE=LPS\nelement vertex 3\nproperty\n", "a header that does not end");
  refuse("a.ply", "ply\nformat xml 1.0\ncomment SPACE=LPS\n", "\"xml\" is no format");
  refuse("a.ply", "ply\ncomment SPACE=LPS\nelement vertex 1e18\nend_header\n", "vertex has no property");
  std::string ply = as_ply(mesh, "ascii");
  refuse("a.ply", ply.substr(0, ply.size() - 20), "is no number");
  ply = as_ply(mesh, "binary_little_endian");
  refuse("a.ply", ply.substr(0, ply.size() - 20), "ends before its numbers do");
  ply.replace(ply.find("list uchar int"), 14, "list uchar big");
  refuse("a.ply", ply, "\"big\" is no type");
  refuse("a.obj", "# SPACE=LPS\nv 1 2 x\n", "\"x\" is no number");
  refuse("a.stl", "solid SPACE=LPS\n", "has no vertices");
  const std::string binary = as_binary_vtk(mesh);
  refuse("a.vtk", binary.substr(0, binary.size() / 2), "ends before its numbers do");
  other = mesh;
  other.vertices[0][0] = 1e9;
  (void)write("far.vtk", as_text(other));
  expect_refusal([&] { (void)read_surface_pairs(path("far.vtk"), path("far.vtk"), ""); }, "in millimetres?");
  (void)write("before.vtk", as_text(mesh, ""));
  (void)write("after.vtk", as_text(mesh, ""));
  expect_refusal([&] { (void)load("", 8); }, "does not say where it lies");
  expect_refusal([&] { (void)load("space = \"lps\"\n", 8); }, "lps");
  EXPECT_EQ(load("space = \"LPS\"\n", 8).points.size(), 8U * 7U * 7U) << "edges of 15.6 mm, in pieces";
}

} // namespace
} // namespace hdmbench
