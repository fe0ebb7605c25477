// Laws of large strains: forces, and whole solutions against Newton's method with assembled tangents.

#include "harness/applications/detection.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/laws.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/large_strains.hpp"
#include "reference/position_based.hpp"
#include "test/files.hpp"
#include "test/scenes.hpp"
#include "test/sessions.hpp"

#include <Eigen/LU>
#include <omp.h>

#include <set>

namespace hdmbench {
namespace {

using Eigen::Matrix3d;
using test::elastic_level;
using test::Held;
using test::Tissue;
using testing::HasSubstr;

constexpr float neo_hookean = 0.0F;

void set_law(Level& level, float stiffening) {
  level.law_parameter = ScalarField(level.extent);
  std::ranges::fill(level.law_parameter.values, stiffening);
}

VectorField linear_forces(const Level& level, const ElasticModel& model, const VectorField& displacement) {
  const auto session = test::scalar().open_elastic({});
  session->load(ElasticBody{level, model, Springs::none});
  session->write(0, ElasticField::displacement, displacement);
  session->forces(ElasticField::displacement, ElasticField::load);
  VectorField force;
  session->read(0, ElasticField::load, force);
  return force;
}

/// A law of small strains has the forces of the linear energy, and the linear law has them of any.
TEST(Laws, SmallStrainsHaveTheForcesOfTheLinearEnergy) {
  for (const auto& [extent, sides] : {std::pair{Extent{33, 28}, std::array{1.0, 1.0, 1.0}},
                                      {Extent{17, 31}, {1.0, 2.5, 1.0}},
                                      {Extent{9, 8, 11}, {1.0, 1.0, 1.0}},
                                      {Extent{8, 12, 7}, {1.5, 1.0, 3.0}}}) {
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Level level = elastic_level(extent, Tissue::noise, Held::scattered, 100.0, 5);
      level.sides = sides;
      VectorField displacement = test::random_field(extent, 9);
      const VectorField expected = linear_forces(level, poisson, displacement);
      const double size = root_mean_square(expected);
      const auto error = [&](const VectorField& found, double scale) {
        double squares = 0.0;
        for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
          for (std::size_t i = 0; i < extent.sites(); ++i) {
            squares += std::pow(scale * double{found[axis][i]} - double{expected[axis][i]}, 2.0);
          }
        }
        return std::sqrt(squares / static_cast<double>(extent.sites())) / size;
      };
      VectorField found;
      set_law(level, -1.0F);
      (void)LawForces(level, poisson)(displacement, found);
      EXPECT_LT(error(found, 1.0), 1e-6) << extent.text() << ", " << poisson;
      constexpr float small = 0x1p-24F;
      for (std::vector<float>& component : displacement.planes) {
        std::ranges::for_each(component, [](float& value) { value *= small; });
      }
      for (const float stiffening : {neo_hookean, 5.0F}) {
        set_law(level, stiffening);
        (void)LawForces(level, poisson)(displacement, found);
        EXPECT_LT(error(found, 1.0 / double{small}), 2e-6) << extent.text() << ", " << poisson;
      }
    }
  }
}

/// The fibres of all sites.
struct SameFibres {
  std::array<double, 3> direction{0.6, 0.64, 0.48}; ///< a unit vector; of an image the first two are one
  double ratio = 0.0; ///< of their modulus to that of the tissue; 0: there are none
  bool tension_only = false;
};

struct Case {
  std::string name;
  std::function<void(Level&)> make;
  double poisson = 0.3;
  int parts = 2; ///< of Newton's load
  SameFibres fibres{};
};

/// Prescribes a component where `at` says so, of a site whose coordinates are 0 ... 1.
void hold(Level& level,
          const std::function<std::optional<double>(std::size_t axis, const Point& at)>& where) {
  for_each_site(level.extent, [&](int x, int y, int z) {
    const auto share = [](int i, int sides) {
      return sides > 1 ? static_cast<double>(i) / (sides - 1) : 0.0;
    };
    const Point at{share(x, level.extent.width), share(y, level.extent.height), share(z, level.extent.depth)};
    const std::size_t site = level.extent.index(x, y, z);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      if (const std::optional<double> target = where(axis, at)) {
        level.target[axis][site] = static_cast<float>(*target);
        level.confidence[axis][site] = 1.0F;
      }
    }
  });
}

bool is_border(const Level& level, const Point& at) {
  const auto is_end = [](double place) { return place == 0.0 || place == 1.0; };
  return is_end(at[0]) || is_end(at[1]) || (level.extent.axes() == 3 && is_end(at[2]));
}

/// The ends along x are held and pulled apart by a share of the length.
void stretch(Level& level, double share) {
  const double length = level.extent.width - 1;
  hold(level, [&](std::size_t axis, const Point& at) -> std::optional<double> {
    if (at[0] != 0.0 && at[0] != 1.0) {
      return std::nullopt;
    }
    return axis == 0 ? share * length * (at[0] - 0.5) : 0.0;
  });
}

void shear(Level& level, double share) {
  const double length = level.extent.height - 1;
  hold(level, [&](std::size_t axis, const Point& at) -> std::optional<double> {
    if (at[1] != 0.0 && at[1] != 1.0) {
      return std::nullopt;
    }
    return axis == 0 ? share * length * at[1] : 0.0;
  });
}

/// What is in the middle is `contrast` times as stiff, and moved by a share of the width; the border is held.
void move_middle(Level& level, double share, double contrast) {
  const double length = level.extent.width - 1;
  const auto is_inside = [&](const Point& at) {
    double square = 0.0;
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      square += (at[axis] - 0.5) * (at[axis] - 0.5);
    }
    return square < 0.2 * 0.2;
  };
  hold(level, [&](std::size_t axis, const Point& at) -> std::optional<double> {
    if (is_inside(at)) {
      return axis == 0 ? share * length : 0.0;
    }
    return is_border(level, at) ? std::optional(0.0) : std::nullopt;
  });
  for_each_site(level.extent, [&](int x, int y, int z) {
    const std::size_t site = level.extent.index(x, y, z);
    if (level.confidence[0][site] == 1.0F && level.target[0][site] != 0.0F) {
      level.modulus.values[site] = static_cast<float>(contrast);
    }
  });
}

void set_layers(Level& level, double contrast) {
  for_each_site(level.extent, [&](int x, int y, int z) {
    level.modulus.values[level.extent.index(x, y, z)] = y % 2 == 0 ? 1.0F : static_cast<float>(contrast);
  });
}

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"stretch", [](Level& level) { stretch(level, 0.3); }},
      {"stretch, ratio 0.45", [](Level& level) { stretch(level, 0.2); }, 0.45},
      {"stretch, ratio 0", [](Level& level) { stretch(level, 0.3); }, 0.0},
      {"compression", [](Level& level) { stretch(level, -0.2); }},
      {"shear", [](Level& level) { shear(level, 0.5); }},
      {"middle moved", [](Level& level) { move_middle(level, 0.12, 10.0); }},
      {"middle moved far", [](Level& level) { move_middle(level, 0.2, 1.0); }},
      {"layers", [](Level& level) { stretch(level, 0.2), set_layers(level, 100.0); }},
      {"beam that bends",
       [](Level& level) { // one end held, the other moved across by half the length
         for_each_site(level.extent, [&](int x, int y, int z) {
           const bool is_thick = y >= level.extent.height / 3 && y <= level.extent.height / 2;
           level.modulus.values[level.extent.index(x, y, z)] = is_thick ? 100.0F : 1.0F;
         });
         hold(level, [&](std::size_t axis, const Point& at) -> std::optional<double> {
           return at[0] == 0.0                ? std::optional(0.0)
                  : at[0] == 1.0 && axis == 1 ? std::optional(0.25 * (level.extent.width - 1))
                                              : std::nullopt;
         });
       },
       0.3, 6},
      {"one stiff line",
       [](Level& level) {
         stretch(level, 0.2);
         for (int x = 0; x < level.extent.width; ++x) {
           level.modulus.values[level.extent.index(x, level.extent.height / 2, level.extent.depth / 2)] =
               1000.0F;
         }
         for_each_site(level.extent, [&](int x, int y, int z) { // the line is not held at its ends
           const bool is_line = y == level.extent.height / 2 && z == level.extent.depth / 2;
           for (std::size_t axis = 0; is_line && axis < level.extent.axes(); ++axis) {
             level.confidence[axis][level.extent.index(x, y, z)] = 0.0F;
             level.target[axis][level.extent.index(x, y, z)] = 0.0F;
           }
         });
       }},
      {"stiffening", [](Level& level) { shear(level, 0.4), set_law(level, 5.0F); }},
      {"fibres", [](Level& level) { stretch(level, 0.2); }, 0.3, 2, {.ratio = 10.0}},
      {"stiff fibres", [](Level& level) { stretch(level, 0.1); }, 0.3, 4, {.ratio = 100.0}},
      {"fibres, tension only",
       [](Level& level) { // they are stretched on one side of the middle and shortened on the other
         move_middle(level, 0.1, 1.0);
         set_law(level, 2.0F);
       },
       0.3,
       2,
       {.ratio = 5.0, .tension_only = true}},
      {"two laws",
       [](Level& level) {
         stretch(level, 0.2);
         for (std::size_t i = 0; i < level.extent.sites(); ++i) {
           level.law_parameter.values[i] = i % 3 == 0 ? -1.0F : i % 3 == 1 ? 0.0F : 3.0F;
         }
       }},
      {"boxes",
       [](Level& level) {
         level.sides = level.extent.axes() == 3 ? std::array{1.0, 1.5, 2.5} : std::array{1.0, 2.0, 1.0};
         stretch(level, 0.25);
       }},
      {"loads",
       [](Level& level) {
         hold(level, [](std::size_t /*axis*/, const Point& at) {
           return at[0] == 0.0 ? std::optional(0.0) : std::nullopt;
         });
         level.force = VectorField(level.extent);
         std::ranges::fill(level.force[0], 0.02F);
         std::ranges::fill(level.force[1], 0.002F);
       }},
      {"walls",
       [](Level& level) {
         stretch(level, 0.2);
         level.springs.assign(level.extent.axes() == 3 ? 6 : 3, std::vector<float>(level.extent.sites()));
         for (std::size_t i = 0; i < level.extent.sites(); i += 9) {
           const std::array<float, 3> normal{0.6F, 0.48F, level.extent.axes() == 3 ? 0.64F : 0.0F};
           for (std::size_t entry = 0, a = 0; a < level.extent.axes(); ++a) {
             for (std::size_t b = a; b < level.extent.axes(); ++b, ++entry) {
               level.springs[entry][i] = 0.1F * normal.at(a) * normal.at(b);
             }
           }
         }
       }},
      {"springs", [](Level& level) {
         hold(level, [](std::size_t /*axis*/, const Point& at) {
           return at[0] == 0.0 ? std::optional(0.0) : std::nullopt;
         });
         for (std::size_t i = 0; i < level.extent.sites(); i += 7) {
           if (level.confidence[0][i] == 0.0F) {
             level.confidence[0][i] = 0.2F;
             level.target[0][i] = 2.0F;
             level.confidence[1][i] = 0.4F;
             level.target[1][i] = -1.0F;
           }
         }
       }}};
  return all;
}

/// Direction and modulus of the fibres as they are, for the reference.
ReferenceFibres fibres_of(const Level& level, const SameFibres& fibres) {
  ReferenceFibres result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.direction[axis].assign(level.extent.sites(), fibres.direction[axis]);
  }
  result.modulus.assign(level.modulus.values.begin(), level.modulus.values.end());
  std::ranges::for_each(result.modulus, [&](double& modulus) { modulus *= fibres.ratio; });
  result.tension_only.assign(level.extent.sites(), fibres.tension_only);
  return result;
}

void set_fibres(const SameFibres& fibres, Level& level) {
  if (fibres.ratio == 0.0) {
    return;
  }
  level.fibre = VectorField(level.extent);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    std::ranges::fill(level.fibre[axis],
                      static_cast<float>(fibres.direction.at(axis) * std::pow(fibres.ratio, 0.25)));
  }
  level.fibre_compression = ScalarField(level.extent, fibres.tension_only ? 0.0F : 1.0F);
}

Scene scene_of(Extent extent, const Case& one) {
  Scene scene;
  use_energy(scene, energy_near(ReferenceSolution::finite_elements));
  Level& level = scene.full;
  level = Level{.extent = extent,
                .target = VectorField(extent),
                .confidence = VectorField(extent),
                .modulus = ScalarField(extent)};
  std::ranges::fill(level.modulus.values, 1.0F);
  set_law(level, neo_hookean);
  one.make(level);
  set_fibres(one.fibres, level);
  set_inverse_modulus(level);
  scene.elastic.poisson = one.poisson;
  return scene;
}

/// A column that is held at one end and pressed at the other beyond what it bears bends until its end looks
/// back: on the way there it has states that it would leave by itself.
TEST(Laws, NewtonsMethodFollowsAColumnThatBends) {
  const Extent extent{12, 4};
  const std::size_t end = extent.index(extent.width - 1, 1);
  const auto pressed = [&](double force, int parts, double aside = 0.1) {
    ElasticProblem column{.extent = extent,
                          .modulus = std::vector<double>(extent.sites(), 1.0),
                          .fixed = Planes<std::uint8_t>(extent),
                          .prescribed = ReferenceField(extent),
                          .force = ReferenceField(extent)};
    for (int y = 0; y < extent.height; ++y) {
      column.fixed[0][extent.index(0, y)] = column.fixed[1][extent.index(0, y)] = 1;
      column.force[0][extent.index(extent.width - 1, y)] = -force;
      column.force[1][extent.index(extent.width - 1, y)] = aside * force;
    }
    return solve_large_strains(column, std::vector<double>(extent.sites()), 0.3, parts);
  };
  EXPECT_LT(pressed(0.005, 1)[1][end], 1.0) << "it bears that";
  const ReferenceField straight = pressed(0.005, 1, 0.0);
  EXPECT_NEAR(straight[1][end], -straight[1][extent.index(extent.width - 1, 2)], 1e-9);
  EXPECT_THROW(pressed(0.02, 2, 0.0), InputError) << "straight it is in a balance that it would leave";
  for (const double force : {0.02, 0.05, 0.2}) {
    EXPECT_THROW(pressed(force, 1), InputError) << "it strays";
    const ReferenceField bent = pressed(force, 2);
    EXPECT_LT(bent[0][end], -8.0) << force;
    EXPECT_LT(rmsd(bent, pressed(force, 8)), 1e-8) << force;
  }
  EXPECT_LT(pressed(0.2, 2, 0.02)[0][end], -8.0)
      << "it has to turn back from a state where it is nearly straight";
}

TEST(Laws, SolutionsAreThoseOfNewtonsMethod) {
  for (const Extent extent : {Extent{25, 23}, Extent{11, 9, 10}}) {
    for (const Case& one : cases()) {
      const Scene scene = scene_of(extent, one);
      const Level& level = scene.full;
      const ReferenceFibres fibres = fibres_of(level, one.fibres);
      const ReferenceField truth = solve_large_strains(
          elastic_problem(level), {level.law_parameter.values.begin(), level.law_parameter.values.end()},
          one.poisson, one.parts, one.fibres.ratio > 0.0 ? &fibres : nullptr);
      const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
      int cycles = 0;
      const Solution found = solve_by_laws(scene.full, scene.elastic, *session, 1e-4,
                                           [&](const LawStep& /*step*/) { ++cycles; });
      EXPECT_EQ(found.failure + found.buckling, "") << one.name;
      const double error = rmsd(ReferenceField(found.displacement), truth);
      Level linear = level;
      linear.law_parameter = {};
      const double law = rmsd(ReferenceField(test::converged(linear, one.poisson)), truth);
      fmt::print(
          "{:11} {:22} {:2} cycles, least volume {:.3f}, {:.1e} px off, estimated {:.1e}; linear {:.2g}\n",
          extent.text(), one.name, cycles, *found.least_volume, error, *found.estimated_error, law);
      EXPECT_LT(error, 1e-4) << one.name;
      EXPECT_GT(law, 10.0 * error) << one.name << ": the law does not matter";
      if (one.fibres.ratio > 0.0) {
        Level without = level;
        without.fibre = {};
        const Solution bare =
            solve_by_laws(without, scene.elastic, *session, 1e-4, [](const LawStep& /*step*/) {});
        EXPECT_GT(rmsd(ReferenceField(bare.displacement), truth), 100.0 * error) << one.name;
      }
    }
  }
}

/// An affine motion of the border is one of the inside: cells of any sides and moduli have its stress alike.
TEST(Laws, AUniformStrainGoesThrough) {
  for (const Extent extent : {Extent{21, 17}, Extent{9, 11, 8}}) {
    Level level{.extent = extent,
                .target = VectorField(extent),
                .confidence = VectorField(extent),
                .modulus = ScalarField(extent)};
    std::ranges::fill(level.modulus.values, 3.0F);
    level.sides = extent.axes() == 3 ? std::array{1.0, 2.0, 1.5} : std::array{1.0, 2.0, 1.0};
    set_law(level, 2.0F);
    const Matrix3d gradient{{0.3, 0.2, -0.1}, {-0.25, -0.2, 0.15}, {0.1, 0.05, 0.25}};
    VectorField affine(extent);
    for_each_site(extent, [&](int x, int y, int z) {
      const Eigen::Vector3d at(level.sides[0] * x, level.sides[1] * y,
                               extent.axes() == 3 ? level.sides[2] * z : 0.0);
      const std::size_t site = extent.index(x, y, z);
      const bool is_end = x == 0 || y == 0 || x + 1 == extent.width || y + 1 == extent.height ||
                          (extent.axes() == 3 && (z == 0 || z + 1 == extent.depth));
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        affine[axis][site] = static_cast<float>(gradient.row(static_cast<Eigen::Index>(axis)).dot(at));
        level.target[axis][site] = is_end ? affine[axis][site] : 0.0F;
        level.confidence[axis][site] = is_end ? 1.0F : 0.0F;
      }
    });
    Scene scene;
    use_energy(scene, energy_near(ReferenceSolution::finite_elements));
    scene.full = level;
    set_inverse_modulus(scene.full);
    const auto session = test::scalar().open_elastic({});
    const Solution found =
        solve_by_laws(scene.full, scene.elastic, *session, 1e-4, [](const LawStep& /*step*/) {});
    EXPECT_EQ(found.failure + found.buckling, "");
    EXPECT_LT(rmsd(ReferenceField(found.displacement), ReferenceField(affine)), 1e-4);
    const Matrix3d in_plane =
        extent.axes() == 3 ? gradient
                           : Matrix3d(gradient.cwiseProduct(Matrix3d{{1, 1, 0}, {1, 1, 0}, {0, 0, 0}}));
    EXPECT_NEAR(*found.least_volume, (Matrix3d::Identity() + in_plane).determinant(), 1e-3);
  }
}

TEST(Laws, EveryBackendAndAnyNumberOfThreadsHasTheSameBits) {
  for (const auto& [extent, name] : {std::pair{Extent{61, 50}, "middle moved"},
                                     {Extent{45, 40}, "beam that bends"}, // by so much that axes turn with it
                                     {Extent{9, 8, 10}, "middle moved"},
                                     {Extent{35, 34, 33}, "middle moved"}}) {
    const bool is_large = extent.sites() > sites_worth_threads; // for processors: shaders take long
    Case one = *std::ranges::find(cases(), name, &Case::name);
    one.fibres = {.ratio = extent.axes() == 3 ? 3.0 : 0.0, .tension_only = is_large};
    const Scene scene = scene_of(extent, one);
    std::optional<VectorField> first;
    std::vector<std::pair<const Backend*, int>> all{{&test::find("openmp"), 1}, {&test::find("openmp"), 2}};
    for (const Backend* const backend : test::present_backends()) {
      const bool compiles_for_long = extent.axes() == 3 && backend->name() == "opencl";
      if (backend->has_elastic() && !is_large && !compiles_for_long) {
        all.emplace_back(backend, 0);
      }
    }
    for (const auto& [backend, threads] : all) {
      const auto session = backend->open_elastic({.device = {}, .threads = threads});
      omp_set_num_threads(threads == 0 ? 2 : threads);
      const Solution found =
          solve_by_laws(scene.full, scene.elastic, *session, 0.01, [](const LawStep& /*step*/) {});
      EXPECT_EQ(found.failure + found.buckling, "");
      first = first ? first : found.displacement;
      EXPECT_EQ(first->planes, found.displacement.planes) << backend->name() << ", " << threads << " threads";
    }
  }
}

/// What no law, or no step, can answer is said: where, or that there is no end.
TEST(Laws, WhatCannotBeAnsweredIsSaid) {
  const auto solved = [](const Case& one, Extent extent) {
    const Scene scene = scene_of(extent, one);
    const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
    return solve_by_laws(scene.full, scene.elastic, *session, 0.01, [](const LawStep& /*step*/) {});
  };
  const Solution turned_over = solved(
      {"turned over",
       [](Level& level) {
         hold(level, [](std::size_t /*axis*/, const Point& at) { // the middle column passes its neighbour
           return at[0] == 0.5                   ? std::optional(1.5)
                  : at[0] == 0.0 || at[0] == 1.0 ? std::optional(0.0)
                                                 : std::nullopt;
         });
         hold(level, [](std::size_t axis, const Point& at) {
           return axis == 0 && at[0] > 0.5 && at[0] < 0.6 ? std::optional(0.0) : std::nullopt;
         });
       }},
      {21, 19});
  EXPECT_THAT(turned_over.beyond_law + turned_over.failure, HasSubstr("keeps"));
  const Solution pressed = solved({"pressed", [](Level& level) { stretch(level, -0.97); }}, {21, 19});
  EXPECT_NE(pressed.beyond_law + pressed.failure, "");
}

/// Returns what laws make of a scene file, whose energy and law are left out.
Solution solved_text(const std::string& text, double accuracy) {
  const test::TemporaryFolder folder;
  const Scene scene =
      load_scene(folder.write("scene.toml", "energy = \"elastic\"\nlaw = \"neo-hookean\"\n" + text).string());
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  return solve_by_laws(scene.full, scene.elastic, *session, accuracy, [](const LawStep& /*step*/) {});
}

/// What is left of a whole field does not say how a few cells end: at a coarse accuracy one is pressed
/// together to a sixtieth, and at the end none to a half.
TEST(Laws, ACellOnItsWayIsNotTakenForOneThatNoLawHolds) {
  const Solution found = solved_text(R"(size = [50, 64]
poisson = 0.45
[[tissue]]
label = 0
modulus = 7.511
[[tissue]]
label = 1
modulus = 0.0
[[tissue]]
label = 2
modulus = 1.735
[[tissue]]
label = 3
modulus = 1.867
[[shape]]
kind = "everything"
label = 0
[[shape]]
kind = "ellipse"
label = 1
centre = [0.774, 0.641]
size = [0.84, 0.694]
[[shape]]
kind = "ellipse"
label = 2
centre = [0.725, 0.213]
size = [0.83, 0.531]
[[shape]]
kind = "ellipse"
label = 3
centre = [0.42, 0.204]
size = [0.705, 0.638]
[[condition]]
where = "labels"
labels = [2, 3]
dx = 4.95
dy = 0.0
[[condition]]
where = "labels"
labels = [3]
dx = 0.0
)",
                                     0.2);
  EXPECT_EQ(found.failure + found.beyond_law + found.buckling, "");
  EXPECT_GT(*found.least_volume, 0.2);
}

/// The message says where a cell is that stays so, and not that a closer look did not end.
TEST(Laws, ACellThatNoLawHoldsIsNamed) {
  const Solution found = solved_text(R"(size = [45, 70]
poisson = 0.45
[[tissue]]
label = 0
modulus = 6.81
[[tissue]]
label = 1
modulus = 1.444
[[tissue]]
label = 2
modulus = 29.867
[[shape]]
kind = "everything"
label = 0
[[shape]]
kind = "ellipse"
label = 1
centre = [0.467, 0.574]
size = [0.439, 0.286]
[[shape]]
kind = "rectangle"
label = 2
centre = [0.526, 0.708]
size = [0.527, 0.887]
[[condition]]
where = "border"
dx = 3.0
dy = -4.73
[[condition]]
where = "outside"
dx = 0.0
[[condition]]
where = "labels"
labels = [2]
centre = [0.273, 0.498]
size = [0.335, 0.191]
dx = 0.0
deviation = 0.705
)",
                                     0.05);
  EXPECT_THAT(found.beyond_law, HasSubstr("the cell at x = "));
  EXPECT_EQ(found.failure + found.buckling, "");
}

/// An accuracy that float32 cannot have: the field is there, and the estimate says how near it is.
TEST(Laws, AnAccuracyBeyondFloatEndsWhereStepsAreNoise) {
  const Scene scene = scene_of({61, 50}, cases().front());
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  int cycles = 0;
  const Solution found =
      solve_by_laws(scene.full, scene.elastic, *session, 1e-9, [&](const LawStep& /*step*/) { ++cycles; });
  EXPECT_EQ(found.failure + found.buckling, "");
  EXPECT_LT(cycles, 80);
  EXPECT_GT(*found.estimated_error, 1e-7);
  EXPECT_LT(*found.estimated_error, 1e-4);
}

/// Where the law does not matter the linear solution stands: the first cycle finds nothing to do.
TEST(Laws, SmallStrainsTakeNoMoreThanTheLinearSolution) {
  const Scene scene = scene_of({61, 50}, {"little", [](Level& level) { stretch(level, 0.001); }});
  const auto session = test::find("openmp").open_elastic({.device = {}, .threads = 2});
  int cycles = 0;
  (void)solve_by_laws(scene.full, scene.elastic, *session, 0.01,
                      [&](const LawStep& step) { cycles += step.extent == scene.extent() ? 1 : 0; });
  EXPECT_EQ(cycles, 1);
}

/// Commands that know the linear energy alone say so.
TEST(Laws, AreRefusedByWhatIsLinear) {
  const Scene scene = scene_of({21, 19}, cases().front());
  const auto session = test::scalar().open_elastic({});
  EXPECT_THROW(ElasticSolver(scene.full, 0.3, *session), InputError);
  Scene sites = scene;
  EXPECT_THROW(use_energy(sites, usual_energy()), InputError);
  const ScalarField everywhere(scene.extent(), 1.0F);
  EXPECT_THROW(RegionSheet(everywhere, scene, *session), InputError);
  Scene loaded = scene;
  loaded.full.law_parameter = {};
  loaded.full.force = VectorField(scene.extent());
  EXPECT_THROW(RegionSheet(everywhere, loaded, *session), InputError);
}

/// A rival has the laws, the elements and the loads of the truth, or its distance says nothing.
TEST(Laws, PositionBasedDynamicsComeNearToNewtonsMethod) {
  const std::set<std::string_view> same{"stretch", "compression", "stiffening", "two laws", "boxes", "loads"};
  std::size_t seen = 0;
  for (const Extent extent : {Extent{15, 13}, Extent{7, 8, 7}}) {
    for (const Case& one : cases()) {
      if (!same.contains(one.name)) {
        continue; // moduli that differ a hundredfold are not its strength
      }
      ++seen;
      const Scene scene = scene_of(extent, one);
      const ElasticProblem problem = elastic_problem(scene.full);
      const std::vector<float>& stiffening = scene.full.law_parameter.values;
      const std::vector<double> tissues(stiffening.begin(), stiffening.end());
      const ReferenceField truth = solve_large_strains(problem, tissues, one.poisson, one.parts);
      const double size = rmsd(truth, ReferenceField(extent));
      const double error = rmsd(relax_positions(problem, tissues, one.poisson, 500), truth) / size;
      const double early = rmsd(relax_positions(problem, tissues, one.poisson, 10), truth) / size;
      fmt::print("{:9} {:22} off by {:.2g} of the field after 500 sweeps, {:.2g} after 10\n", extent.text(),
                 one.name, error, early);
      EXPECT_LT(error, 0.1) << one.name;
      EXPECT_GT(early, 0.15) << one.name << ": it takes sweeps";
    }
  }
  EXPECT_EQ(seen, 2 * same.size());
}

} // namespace
} // namespace hdmbench
