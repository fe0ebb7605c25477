// The elastic energy of images and volumes: the specification against finite elements in double, the levels
// against the products that define them, and how far a sweep may go.

#include "backends/session/part_rows.hpp"
#include "harness/check/cases.hpp"
#include "kernels/data/elastic/set_up.hpp"
#include "reference/finite_elements.hpp"
#include "test/sessions.hpp"

#include <Eigen/Eigenvalues>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

double product(const VectorField& a, const VectorField& b) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
    sum = std::inner_product(a[axis].begin(), a[axis].end(), b[axis].begin(), sum);
  }
  return sum;
}

/// The field of a level that moves only where it may: 0 where nothing responds.
VectorField free_field(const ElasticLevel& level, std::uint64_t seed) {
  VectorField field = test::random_field(level.grid.sites, seed);
  const std::size_t axes = field.extent.axes();
  for_each_site(field.extent, [&](int x, int y, int z) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      if (!(level.response[symmetric_entry(axes, axis, axis)][level.grid.index(x, y, z)] > 0.0F)) {
        field[axis][field.extent.index(x, y, z)] = 0.0F;
      }
    }
  });
  return field;
}

struct Body {
  Extent extent;
  std::vector<ElasticModel> models;
};
constexpr auto selective = Integration::selective_reduced;
const std::array bodies{Body{{47, 39}, {-0.5, 0.0, 0.3, 0.49, 0.5}}, Body{{16, 18, 17}, {0.0, 0.3, 0.49}}};

TEST(ElasticLevels, EnergyOfTheImageIsThatOfFiniteElements) {
  std::vector<Body> all(bodies.begin(), bodies.end());
  all.push_back({{2, 2}, {0.3}});
  for (const Extent extent : odd_volumes()) {
    all.push_back({extent, {0.3, {0.3, selective}, {0.49, selective}}});
  }
  for (const auto& [extent, models] : all) {
    for (const ElasticModel& model : models) {
      for (const std::array<double, 3>& sides : {std::array{1.0, 1.0, 1.0}, {1.5, 1.0, 4.0}}) {
        Level level = elastic_level(extent, Tissue::noise, Held::scattered, 100.0, 3);
        level.sides = {sides[0], sides[1], extent.axes() == 3 ? sides[2] : 1.0};
        const ElasticHierarchy hierarchy = make_elastic_hierarchy({level, model});
        const auto session = test::scalar().open_elastic({});
        session->load(hierarchy);
        const VectorField field = free_field(hierarchy.levels.front(), 5);
        session->write(0, ElasticField::displacement, field);
        session->forces(ElasticField::displacement, ElasticField::image);
        VectorField forces;
        session->read(0, ElasticField::image, forces);
        const double energy =
            elastic_energy(elastic_problem(level), ElementRule::of(extent, model), ReferenceField(field));
        EXPECT_NEAR(-product(field, forces) / force_unit(level, model.poisson), energy, 1e-5 * energy)
            << extent.text() << ", Poisson's ratio " << model.poisson << ", sides " << sides[0];
      }
    }
  }
}

/// What the forces of `field` on level `at` are to the next level. A sweep tells the forces' sign only, so
/// that they are read where they are restricted to.
VectorField restricted_forces(ElasticSession& session, int at, const VectorField& field) {
  session.write(at, ElasticField::correction, field);
  session.write(at, ElasticField::load, VectorField(field.extent));
  session.restrict_residual(at, ElasticField::correction);
  VectorField restricted;
  session.read(at + 1, ElasticField::load, restricted);
  return restricted;
}

/// Squares and cubes, and cells whose levels are halved along some axes only at first.
std::array<double, 3> sides_for(double poisson, std::size_t axes) {
  std::array<double, 3> sides{1.0, 1.0, 1.0};
  if (poisson == 0.3) {
    sides = {1.0, 2.5, 1.0};
  } else if (poisson == 0.49) {
    sides = {axes == 3 ? 3.0 : 6.0, 1.0, 7.0};
  } else if (poisson == 0.5) {
    sides = {1.0, 5.0, 1.0};
  }
  sides[2] = axes == 3 ? sides[2] : 1.0;
  return sides;
}

/// What a level's forces do to a field is what the finer level's do to its interpolation.
TEST(ElasticLevels, CoarseOnesAreGalerkinProducts) {
  for (const auto& [extent, models] : bodies) {
    for (const ElasticModel& model : models) {
      for (const Held held : test::all_held) {
        Level level = elastic_level(extent, Tissue::noise, held, 100.0, 4);
        level.sides = sides_for(model.poisson, extent.axes());
        const ElasticHierarchy hierarchy = make_elastic_hierarchy({level, model});
        const auto session = test::scalar().open_elastic({});
        session->load(hierarchy);
        ASSERT_GT(hierarchy.levels.size(), 3U);
        for (int at = 1; at + 1 < std::ssize(hierarchy.levels); ++at) {
          const VectorField coarse = free_field(hierarchy.levels[static_cast<std::size_t>(at)], 7);
          session->write(at, ElasticField::correction, coarse);
          session->interpolate(at - 1);
          VectorField fine;
          session->read(at - 1, ElasticField::correction, fine);
          // P' K P u from the finer level, restricted once more; and from the level itself.
          session->write(at, ElasticField::load, restricted_forces(*session, at - 1, fine));
          session->restrict_load(at);
          VectorField expected;
          session->read(at + 1, ElasticField::load, expected);
          const VectorField found = restricted_forces(*session, at, coarse);
          EXPECT_LT(compare(expected, found).largest, 1e-5 * double{largest_magnitude(expected)})
              << extent.text() << ", level " << at << ", held " << static_cast<int>(held)
              << ", Poisson's ratio " << model.poisson;
        }
      }
    }
  }
}

/// The largest eigenvalue of what a sweep takes the forces of one cell's corners times, which no other cell
/// holds: a wave grows where it is above 2, and that of a body is not larger than that of its worst cell.
double stiffest_wave(const Level& cell, const ElasticModel& model) {
  const ElasticHierarchy hierarchy = make_elastic_hierarchy({cell, model});
  const ElasticLevel& level = hierarchy.levels.front();
  const CellMatrix matrix = cell_matrix(level, level.grid.index(0, 0));
  const auto size = static_cast<Eigen::Index>(matrix.components);
  const auto axes = static_cast<Eigen::Index>(matrix.axes);
  const Eigen::MatrixXd stiffness = Eigen::MatrixXd::NullaryExpr(size, size, [&](auto row, auto column) {
    return matrix.at(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
  });
  Eigen::MatrixXd blocks = Eigen::MatrixXd::Zero(size, size); // the inverses of the responses
  for (std::size_t corner = 0; corner < cell.extent.sites(); ++corner) {
    const std::size_t at = level.grid.index(0, 0) + level.grid.to_corner(corner);
    const Eigen::MatrixXd response = Eigen::MatrixXd::NullaryExpr(axes, axes, [&](auto row, auto column) {
      const std::size_t entry =
          symmetric_entry(matrix.axes, static_cast<std::size_t>(row), static_cast<std::size_t>(column));
      return double{level.response[entry][at]};
    });
    const auto first = static_cast<Eigen::Index>(corner) * axes;
    blocks.block(first, first, axes, axes) = response.inverse();
  }
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(stiffness, blocks)
      .eigenvalues()
      .maxCoeff();
}

/// One corner that is a thousand times stiffer than the others is an image's worst.
TEST(ElasticLevels, SweepsOfTheImageLetNoWaveGrow) {
  for (const auto& [extent, sides] : {std::pair{Extent{2, 2}, std::array{1.0, 1.0, 1.0}},
                                      {{2, 2, 2}, {1.0, 1.0, 1.0}},
                                      {{2, 2}, {1.0, 2.0, 1.0}},
                                      {{2, 2}, {6.0, 1.0, 1.0}},
                                      {{2, 2, 2}, {1.0, 1.0, 6.0}},
                                      {{2, 2, 2}, {2.5, 1.0, 1.5}}}) {
    for (const ElasticModel& model :
         std::initializer_list<ElasticModel>{0.0, 0.3, 0.49, {0.3, selective}, {0.49, selective}}) {
      test::Uniform uniform(6);
      double worst = 0.0;
      for (int round = 0; round < 300; ++round) {
        Level cell = test::plain_level(extent);
        cell.sides = sides;
        std::ranges::generate(cell.modulus.values, [&] {
          return uniform() < 0.5 ? 1.0F : static_cast<float>(std::pow(1000.0, uniform()));
        });
        worst = std::max(worst, stiffest_wave(cell, model));
      }
      const std::string of =
          fmt::format("{} of {}, Poisson's ratio {}, integration {}", extent.text(), fmt::join(sides, " x "),
                      model.poisson, static_cast<int>(model.integration));
      EXPECT_LT(worst, 2.0) << of;
      EXPECT_GT(worst, 1.7) << of << ": they go less than they might";
    }
  }
}

/// Void at the rim of a coarse cell is far softer than the softest tissue: its determinant was 0.
TEST(ElasticLevels, RespondAlikeToModuliInAnyUnit) {
  constexpr int exponent = -60; // the softest that are not scaled before
  for (const auto& [extent, models] : bodies) {
    Level level = elastic_level(extent, Tissue::noise, Held::scattered, 100.0, 3);
    const ElasticHierarchy usual = make_elastic_hierarchy({level, models[1]});
    scale_moduli(level, exponent);
    const ElasticHierarchy soft = make_elastic_hierarchy({level, models[1]});
    for (std::size_t at = 0; at < usual.levels.size(); ++at) {
      for (std::size_t entry = 0; entry < usual.levels[at].response.size(); ++entry) {
        std::vector<float> expected = usual.levels[at].response[entry];
        std::ranges::for_each(expected, [](float& value) { value = std::ldexp(value, -exponent); });
        EXPECT_EQ(soft.levels[at].response[entry], expected)
            << extent.text() << ", level " << at << ", entry " << entry;
      }
    }
  }
}

/// An array larger than staging memory goes part by part: each site is in one part, at its place.
TEST(ElasticLayout, EverySiteIsInOneOfTheParts) {
  for (const Extent sites : {Extent{37, 23}, Extent{2, 2}, Extent{9, 11, 13}, Extent{40, 2, 3}}) {
    const ElasticLayout::Part part = ElasticLayout::alone(sites);
    const auto size = static_cast<std::int64_t>(ElasticLayout::padded(sites).sites());
    for (const std::int64_t together : {std::int64_t{7}, std::int64_t{100}, size, size + 1000}) {
      SCOPED_TRACE(sites.text() + " by " + std::to_string(together));
      std::vector<int> seen(sites.sites());
      for (std::int64_t from = 0; from < size; from += together) {
        for_each_row(part, from, from + together, [&](int y, int z, int first, int end, std::int64_t at) {
          ASSERT_EQ(at, part.first + z * part.layer + y * part.pitch);
          ASSERT_GE(at + first, from);
          ASSERT_LE(at + end, from + together);
          for (int x = first; x < end; ++x) {
            ++seen[sites.index(x, y, z)];
          }
        });
      }
      EXPECT_THAT(seen, testing::Each(1));
    }
  }
}

} // namespace
} // namespace hdmbench
