// Normals of walls: those of the labels' pixels, how much they err, and those that an image gives.

#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/solver.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/elastic/wall_hold.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

namespace hdmbench {
namespace {

using test::body_in_a_wall;
using testing::HasSubstr;

TEST(WallNormals, OfPixelsAreThoseOfTheOutline) {
  for (const auto& [extent, step] : {std::pair{Extent{121, 121}, std::array{1.0, 1.0, 1.0}},
                                     {Extent{121, 61}, {1.0, 2.0, 1.0}},
                                     {Extent{61, 61, 15}, {1.0, 1.0, 1.0}},
                                     {Extent{61, 61, 7}, {1.0, 1.0, 2.5}}}) {
    for (const double radius : {12.0, 18.0, 26.0, 38.0, 52.0}) {
      if (radius > 0.45 * step[0] * extent.width) {
        continue;
      }
      const Level level = body_in_a_wall(
          extent, [&](const auto& at) { return std::hypot(at[0], at[1]) <= radius; }, step);
      double squares = 0.0;
      double sites = 0.0;
      for_each_site(extent, [&](int x, int y, int z) {
        const std::size_t at = extent.index(x, y, z);
        const double along_x = step[0] * (x - 0.5 * (extent.width - 1));
        const double along_y = step[1] * (y - 0.5 * (extent.height - 1));
        const auto spring = [&](std::size_t a, std::size_t b) {
          return double{level.walls[symmetric_entry(extent.axes(), a, b)][at]} / double{stiffness_of_walls};
        };
        if (spring(0, 0) + spring(1, 1) > 0.0) { // (n . tangent)^2 is the square of the angle
          const double square = along_x * along_x + along_y * along_y;
          squares += (spring(0, 0) * along_y * along_y - 2.0 * spring(0, 1) * along_x * along_y +
                      spring(1, 1) * along_x * along_x) /
                     square;
          sites += 1.0;
        }
      });
      const double angle = std::sqrt(std::max(0.0, squares) / sites);
      fmt::print("{}, radius {}: {:.2f} degrees\n", extent.text(), radius, 180.0 / std::numbers::pi * angle);
      EXPECT_LT(180.0 / std::numbers::pi * angle, error_of_normals) << "they would be refused nowhere";
    }
  }
}

/// Normals of pixels err: they alone kept a disc with a heavy side from turning in a round hole, and
/// what lies between two slanting planes from sliding, by .003 and .01 px under its own weight.
TEST(WallNormals, WhatTheyAloneHoldIsRefused) {
  const auto expect = [](const std::string& name, const Level& level, bool is_held) {
    const double angle = least_angle_to_walls(level);
    fmt::print("{} of {}: {:.1f} degrees\n", name, level.extent.text(), angle);
    const std::string refusal = test::refusal([&] { require_held(level); });
    if (is_held) {
      EXPECT_EQ(refusal, "accepted") << name;
      EXPECT_GT(angle, 1.5 * error_of_normals) << name;
    } else {
      EXPECT_THAT(refusal, HasSubstr("can slide along its walls or turn in them")) << name;
      EXPECT_LT(angle, 0.9 * error_of_normals) << name;
    }
  };
  const auto ellipse = [](double a, double b) {
    return [a, b](const std::array<double, 3>& at) { return std::hypot(at[0] / a, at[1] / b) < 1.0; };
  };
  for (const double radius : {12.0, 26.0, 52.0}) {
    const int side = 2 * static_cast<int>(radius) + 15;
    expect("disc", body_in_a_wall({side, side}, ellipse(radius, radius)), false);
    expect("ellipse", body_in_a_wall({side, side}, ellipse(radius, radius / 1.2)), true);
    Level known = body_in_a_wall({side, side}, ellipse(radius, radius));
    for (const int shift : {0, 3}) {
      known.confidence[1][known.extent.index(side / 2 + shift, side / 2)] = 1.0F;
    }
    EXPECT_EQ(test::refusal([&] { require_held(known); }), "accepted") << "two points hold what would turn";
  }
  for (const double degrees : {0.0, 5.0, 17.0, 26.565, 45.0}) {
    const double slope = degrees * std::numbers::pi / 180.0;
    const auto is_between = [&](const std::array<double, 3>& at) {
      return std::abs(std::sin(slope) * at[0] - std::cos(slope) * at[1]) < 15.3;
    };
    expect(fmt::format("channel at {} degrees", degrees), body_in_a_wall({97, 97}, is_between), false);
  }
  for (const std::array<double, 3> way : {std::array{1.0, 0.0, 0.0}, {0.96, 0.28, 0.0}, {0.6, 0.48, 0.64}}) {
    const auto along = [way](const std::array<double, 3>& at) {
      return std::inner_product(at.begin(), at.end(), way.begin(), 0.0);
    };
    const auto around = [along](const std::array<double, 3>& at) {
      return std::sqrt(std::inner_product(at.begin(), at.end(), at.begin(), 0.0) - along(at) * along(at));
    };
    const Extent extent{33, 35, 31};
    const std::string name = fmt::format("along {}", way);
    expect("slab " + name, body_in_a_wall(extent, [&](const auto& at) { return std::abs(along(at)) < 8.2; }),
           false);
    expect("tube " + name, body_in_a_wall(extent, [&](const auto& at) { return around(at) < 9.3; }), false);
    expect("ovoid " + name,
           body_in_a_wall(
               extent, [&](const auto& at) { return std::hypot(along(at) / 14.2, around(at) / 10.4) < 1.0; }),
           false);
  }
  expect("ellipsoid",
         body_in_a_wall(
             {33, 35, 31},
             [](const auto& at) { return std::hypot(at[0] / 14.2, at[1] / 11.4, at[2] / 9.2) < 1.0; }),
         true);
}

/// The level with the normals that its outline, an ellipse with these half axes in the middle, has.
Level with_normals_of_ellipse(Level level, double a, double b) {
  const Extent extent = level.extent;
  for_each_site(extent, [&](int x, int y, int /*z*/) {
    const std::size_t at = extent.index(x, y);
    const std::array<double, 2> way{(x - 0.5 * (extent.width - 1)) / (a * a),
                                    (y - 0.5 * (extent.height - 1)) / (b * b)};
    for (std::size_t row = 0; row < 2 && level.walls[0][at] + level.walls[2][at] > 0.0F; ++row) {
      for (std::size_t column = row; column < 2; ++column) {
        level.walls[symmetric_entry(2, row, column)][at] =
            stiffness_of_walls *
            static_cast<float>(way[row] * way[column] / (way[0] * way[0] + way[1] * way[1]));
      }
    }
  });
  return level;
}

/// A heavy spot turns an ellipse in its wall by as much as its form lets it: how far that is off by errors of
/// normals is what `run` warns of.
TEST(WallNormals, OfNearlyRoundWallsMatterAsMuchAsIsSaid) {
  for (const int side : {80, 129}) {
    for (const double ratio : {1.08, 1.1, 1.15, 1.2}) {
      const double a = 0.42 * side;
      const double b = a / ratio;
      Level level = body_in_a_wall({side, side},
                                   [&](const auto& at) { return std::hypot(at[0] / a, at[1] / b) < 1.0; });
      level.force = VectorField(level.extent);
      for_each_site(level.extent, [&](int x, int y, int /*z*/) {
        if (std::hypot(x - 0.5 * side + 0.2 * a, y - 0.5 * side - 0.3 * b) < 0.2 * b) {
          level.force[1][level.extent.index(x, y)] = 0.4F / static_cast<float>(side);
        }
      });
      set_inverse_modulus(level);
      const std::vector<std::uint8_t> tissue = test::sites_of_tissue(level);
      const ReferenceField exact(test::converged(with_normals_of_ellipse(level, a, b), 0.3));
      const ReferenceField rest(VectorField(level.extent));
      const double off =
          rmsd(ReferenceField(test::converged(level, 0.3)), exact, tissue) / rmsd(exact, rest, tissue);
      const double angle = least_angle_to_walls(level);
      fmt::print("{} x {}, {} : 1, {:.1f} degrees: {:.2f} of the way off\n", side, side, ratio, angle, off);
      EXPECT_LT(off, largest_share_of_normals(angle));
      EXPECT_GT(off, 0.05 * largest_share_of_normals(angle)) << "nobody would have to be warned";
    }
  }
}

using Direction = std::array<double, 3>;

/// A disc or a ball of tissue in the middle of label 2, which it slides in.
class RoundHole {
public:
  RoundHole(Extent extent, const Placement& placement, double radius)
      : extent_(extent), placement_(placement), radius_(radius) {
    LabelField labels{extent, std::vector<int>(extent.sites())};
    for_each_site(extent, [&](int x, int y, int z) {
      labels.values[extent.index(x, y, z)] = length(from_middle(x, y, z)) > radius ? 2 : 1;
    });
    write_labels(folder_.path() / "labels.nrrd", labels, 1.0, placement);
  }

  /// Returns the way from the middle to a site along the image's axes, shortest sides of a pixel.
  [[nodiscard]] Direction from_middle(int x, int y, int z) const {
    const std::array<int, 3> place{x, y, z};
    Direction way{};
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      way[axis] = placement_.aspect[axis] * (place[axis] - 0.5 * (extent_.sides()[axis] - 1));
    }
    return way;
  }
  [[nodiscard]] static double length(const Direction& way) { return std::hypot(way[0], way[1], way[2]); }

  /// Writes an image of the directions from the middle, along the axes of the space and of any length; 0
  /// where `is_unknown(x)`.
  template <typename IsUnknown>
  void write_directions(const IsUnknown& is_unknown) const {
    VectorField directions(extent_);
    for_each_site(extent_, [&](int x, int y, int z) {
      const Direction way = from_middle(x, y, z);
      const Placement::Vector in_space = placement_.vector(way[0], way[1], way[2]);
      for (std::size_t axis = 0; axis < extent_.axes() && !is_unknown(x); ++axis) {
        directions[axis][extent_.index(x, y, z)] = static_cast<float>(-3.0 * in_space[axis]);
      }
    });
    write_vector(folder_.path() / "normals.nrrd", directions, 1.0, placement_);
  }
  /// Writes an image of the distance to the wall, in another unit.
  void write_distance() const {
    ScalarField distance(extent_);
    for_each_site(extent_, [&](int x, int y, int z) {
      distance.values[extent_.index(x, y, z)] =
          static_cast<float>(25.4 * (radius_ - length(from_middle(x, y, z))));
    });
    write_scalar(folder_.path() / "normals.nrrd", distance, 1.0, placement_);
  }

  /// `of_image`: more lines of [image].
  [[nodiscard]] Scene scene(const std::string& of_image, const SceneOptions& options = {},
                            const std::string& conditions = slides,
                            const std::string& energy = "elastic") const {
    return load_scene(folder_
                          .write("scene.toml", "energy = \"" + energy +
                                                   "\"\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n"
                                                   "[[tissue]]\nlabel = 2\nmodulus = 300.0\n" +
                                                   conditions + "[image]\nlabels = \"labels.nrrd\"\n" +
                                                   of_image)
                          .string(),
                      options);
  }

  static constexpr const char* slides = "[[condition]]\nwhere = \"labels\"\nlabels = [2]\nslide = true\n";

private:
  test::TemporaryFolder folder_;
  Extent extent_;
  Placement placement_;
  double radius_;
};

constexpr const char* normals = "normals = \"normals.nrrd\"\n";

/// The axes of a turned image of long pixels.
Placement oblique(const Direction& aspect) {
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  return {
      .origin = {3.0, -4.0, 5.0}, .axes = {{{c, s, 0.0}, {-s, c, 0.0}, {0.0, 0.0, 1.0}}}, .aspect = aspect};
}

/// How far the normals of walls are from those of the round hole at most, as the sine of the angle.
double most_off(const RoundHole& hole, const Level& level) {
  double most = 0.0;
  for_each_site(level.extent, [&](int x, int y, int z) {
    const std::size_t site = level.extent.index(x, y, z);
    if (!is_on_wall(level, site)) {
      return;
    }
    const Direction way = hole.from_middle(x, y, z);
    double along = 0.0; // the square of the cosine, times the length of the way
    for (std::size_t a = 0; a < level.extent.axes(); ++a) {
      for (std::size_t b = 0; b < level.extent.axes(); ++b) {
        along +=
            way[a] * way[b] *
            double{level.walls[symmetric_entry(level.extent.axes(), std::min(a, b), std::max(a, b))][site]} /
            double{stiffness_of_walls};
      }
    }
    const double length = RoundHole::length(way);
    most = std::max(most, std::sqrt(std::max(0.0, 1.0 - along / (length * length))));
  });
  return most;
}

TEST(WallNormals, AreThoseOfAnImageThatHasThem) {
  for (const auto& [extent, placement] : {std::pair{Extent{61, 57}, Placement{}},
                                          {Extent{61, 41}, Placement{.aspect = {1.0, 1.5, 1.0}}},
                                          {Extent{31, 33, 29}, oblique({1.0, 1.0, 1.0})},
                                          {Extent{31, 33, 19}, oblique({1.0, 1.0, 1.6})}}) {
    const RoundHole hole(extent, placement, extent.axes() == 3 ? 12.3 : 24.3);
    const Level of_labels = hole.scene("").full;
    EXPECT_GT(most_off(hole, of_labels), 2.5e-3) << "those of pixels would do";
    hole.write_directions([](int) { return false; });
    EXPECT_LT(most_off(hole, hole.scene(normals).full), 1e-3) << extent.text(); // roots of roundings
    hole.write_distance();
    EXPECT_LT(most_off(hole, hole.scene(normals).full), 3e-3)
        << extent.text(); // of differences, second order
    hole.write_directions([&](int x) { return 2 * x < extent.width; });
    const Level half = hole.scene(normals).full;
    for_each_site(extent, [&](int x, int y, int z) {
      const std::size_t site = extent.index(x, y, z);
      for (std::size_t entry = 0; 2 * x < extent.width && entry < half.walls.size(); ++entry) {
        ASSERT_EQ(half.walls[entry][site], of_labels.walls[entry][site]) << extent.place(site);
      }
    });
    EXPECT_LT(most_off(hole, half), most_off(hole, of_labels) + 1e-9);
  }
}

class WallNormalsOfADisc : public testing::TestWithParam<double> {};

/// A disc that its hub turns in a round hole comes short by what normals of pixels err, and by what springs
/// of walls give way.
TEST_P(WallNormalsOfADisc, ThatAreExactLetItTurn) {
  const Extent extent{65, 65};
  const double radius = GetParam();
  const RoundHole hole(extent, {}, radius);
  hole.write_directions([](int) { return false; });
  std::array<double, 2> off{};
  for (const bool is_exact : {false, true}) {
    Scene scene = hole.scene(is_exact ? normals : "");
    for_each_site(extent, [&](int x, int y) {
      const Direction way = hole.from_middle(x, y, 0);
      if (RoundHole::length(way) < 8.0) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
          scene.full.target[axis][extent.index(x, y)] =
              static_cast<float>(axis == 0 ? -0.02 * way[1] : 0.02 * way[0]);
          scene.full.confidence[axis][extent.index(x, y)] = 1.0F;
        }
      }
    });
    scene.schedule.method = "conjugate-gradients";
    scene.schedule.iterations = 60;
    const VectorField field =
        Solver(test::find("openmp"), {.device = {}, .threads = 2}).solve(scene, test::silent()).displacement;
    double& most = off[is_exact ? 1 : 0];
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      const Direction way = hole.from_middle(x, y, 0);
      if (scene.full.modulus.values[site] >= void_modulus(scene.full)) {
        most = std::max(
            most, std::hypot(double{field[0][site]} + 0.02 * way[1], double{field[1][site]} - 0.02 * way[0]));
      }
    });
  }
  fmt::print("radius {}: {:.2g} px off by normals of pixels, {:.2g} by exact ones\n", radius, off[0], off[1]);
  EXPECT_GT(off[0], 0.004);
  EXPECT_LT(off[1], 0.0002);
}

INSTANTIATE_TEST_SUITE_P(Radius, WallNormalsOfADisc, testing::Values(25.7, 26.0, 26.3));

/// Tissue in a hole with waves on its outline, of 60 mm at any number of pixels.
class WavyHole {
public:
  WavyHole(int sides, double waves) : extent_{sides, sides}, spacing_(60.0 / sides) {
    LabelField labels{extent_, std::vector<int>(extent_.sites())};
    for_each_site(extent_, [&](int x, int y) {
      const double along = spacing_ * (x - 0.5 * (sides - 1));
      const double across = spacing_ * (y - 0.5 * (sides - 1));
      const double outline = 22.0 + waves * std::cos(14.0 * std::atan2(across, along));
      labels.values[extent_.index(x, y)] = std::hypot(along, 1.3 * across) < outline ? 1 : 2;
    });
    write_labels(folder_.path() / "labels.nrrd", labels, spacing_);
  }

  /// `more`: lines of the condition that slides, and further ones.
  [[nodiscard]] Scene scene(const std::string& more) const {
    return load_scene(folder_
                          .write("scene.toml", "energy = \"elastic\"\n[[tissue]]\nlabel = 1\nmodulus = 3.0\n"
                                               "[[tissue]]\nlabel = 2\nmodulus = 300.0\n[image]\nlabels = "
                                               "\"labels.nrrd\"\n[[condition]]\nwhere = \"labels\"\nlabels = "
                                               "[2]\n" +
                                                   more)
                          .string());
  }

  /// Returns how far the tissue moves where its middle is pulled one way, its sides the other: mean, mm.
  [[nodiscard]] double moved(const std::string& more) const {
    Scene of = scene(more);
    Level& level = of.full;
    level.force = VectorField(extent_);
    for_each_site(extent_, [&](int x, int y) {
      const bool is_inner = std::abs(2 * x - extent_.width) < extent_.width / 3;
      level.force[1][extent_.index(x, y)] = static_cast<float>(is_inner ? 0.01 * spacing_ : -0.01 * spacing_);
    });
    const VectorField field = test::converged(level, 0.3);
    const ScalarField tissue = tissue_of(of);
    double sum = 0.0;
    for (std::size_t site = 0; site < extent_.sites(); ++site) {
      sum += tissue.values[site] * std::hypot(field[0][site], field[1][site]);
    }
    return spacing_ * sum / static_cast<double>(std::ranges::count(tissue.values, 1.0F));
  }

private:
  test::TemporaryFolder folder_;
  Extent extent_;
  double spacing_;
};

/// Nine pixels are less of an outline the finer it is: tissue slid half as far in a fine image of the same
/// hole.
TEST(WallNormals, OfARadiusAreTheSameAtEveryResolution) {
  const WavyHole coarse(100, 1.5);
  const WavyHole fine(300, 1.5);
  const std::string usual = "slide = true\n";
  const std::string within = usual + "normal_radius = 9.0\n";
  fmt::print("mean displacement of 100 and 300 pixels: {:.4f} and {:.4f} mm by 9 pixels, {:.4f} and {:.4f} "
             "by 9 mm\n",
             coarse.moved(usual), fine.moved(usual), coarse.moved(within), fine.moved(within));
  EXPECT_GT(coarse.moved(usual), 1.6 * fine.moved(usual));
  EXPECT_LT(coarse.moved(within), 1.25 * fine.moved(within));
}

TEST(WallNormals, OfRoughOutlinesAreWarnedOf) {
  const auto is_warned = [](const Scene& scene) {
    return std::ranges::count(diagnose(scene), "rough-walls", &Warning::kind) > 0;
  };
  const std::string slides = "slide = true\n";
  for (const int sides : {50, 100, 200, 400}) {
    for (const double waves : {0.0, 1.5}) {
      const Scene scene = WavyHole(sides, waves).scene(slides);
      fmt::print("{} pixels, waves of {} mm: normals turn by {:.1f} degrees\n", scene.extent().text(), waves,
                 scene.turn_of_normals.value().degrees);
      EXPECT_EQ(is_warned(scene), waves > 0.0 && sides > 50) << "9 pixels of 50 are more than a wave";
    }
  }
  const std::string opening = "[[condition]]\nwhere = \"labels\"\nlabels = [2]\ncentre = [0.5, 0.2]\n"
                              "size = [0.3, 0.2]\ndx = 0.0\ndy = -2.0\n";
  EXPECT_FALSE(is_warned(WavyHole(200, 0.0).scene(slides + opening))) << "a wall keeps its normals at rims";
  const WavyHole rough(200, 1.5);
  EXPECT_FALSE(is_warned(rough.scene(slides + "normal_radius = 8.0\n"))) << "somebody has said so";
  expect_refusal([&] { (void)rough.scene(slides + "normal_radius = 50.0\n"); },
                 "see the other side of what slides");
  expect_refusal([&] { (void)rough.scene("dx = 1.0\nnormal_radius = 5.0\n"); }, "belongs to slide = true");
  expect_refusal(
      [&] {
        (void)rough.scene(slides + "normal_radius = 5.0\n[[condition]]\nwhere = \"labels\"\nlabels = [2]\n" +
                          slides + "normal_radius = 6.0\n");
      },
      "the walls of a scene have one");
}

TEST(WallNormals, AreRefusedWhereTheyCannotBe) {
  const RoundHole hole({31, 33}, {}, 12.3);
  hole.write_distance();
  expect_refusal(
      [&] { (void)hole.scene(normals, {}, "[[condition]]\nwhere = \"border\"\ndx = 0\ndy = 0\n"); },
      "has normals, and no [[condition]] slides");
  expect_refusal([&] { (void)hole.scene(normals, {}, RoundHole::slides, "hdm"); },
                 "it belongs to energy = \"elastic\"");
  expect_refusal(
      [&] {
        (void)hole.scene(normals, {.size = Extent{62, 66}});
      },
      "normals takes the file's own pixels");
  const RoundHole of_bad_numbers({31, 33}, {}, std::numeric_limits<double>::quiet_NaN());
  of_bad_numbers.write_distance();
  expect_refusal([&] { (void)of_bad_numbers.scene(normals, {}, RoundHole::slides); },
                 "normals must be finite");
}

} // namespace
} // namespace hdmbench
