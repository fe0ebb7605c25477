// The elastic energy of volumes: the specification against finite elements in double, the levels against the
// products that define them, and backends against scalar, step by step.

#include "backends/registry.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/check/cases.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "reference/finite_elements.hpp"
#include "test/random_level.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace hdmbench {
namespace {

using test::elastic_level;
using test::Held;
using test::Tissue;

std::string name_of(Extent extent) {
  return std::to_string(extent.width) + " x " + std::to_string(extent.height) + " x " +
         std::to_string(extent.depth);
}

std::unique_ptr<ElasticSession> open_session(const char* backend, int threads) {
  SessionOptions options;
  options.threads = threads;
  return find_backend(make_backends(), backend).open_elastic(options);
}

/// Root mean square of the distance over sites, voxels.
double distance(const VectorField& field, const ReferenceField& truth) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < field.extent.sites(); ++i) {
      const double difference = static_cast<double>(field[axis][i]) - truth[axis][i];
      sum += difference * difference;
    }
  }
  return std::sqrt(sum / static_cast<double>(field.extent.sites()));
}

double product(const VectorField& a, const VectorField& b) {
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < a.extent.sites(); ++i) {
      sum += static_cast<double>(a[axis][i]) * static_cast<double>(b[axis][i]);
    }
  }
  return sum;
}

/// The field of a level that moves only where it may: 0 where nothing responds.
VectorField free_field(const ElasticLevel& level, std::uint64_t seed) {
  VectorField field = test::random_field(level.grid.sites, seed);
  const Extent sites = field.extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int row = 0; row < sites.height * sites.depth; ++row) {
      for (int x = 0; x < sites.width; ++x) {
        const std::size_t at = level.grid.index(x, row % sites.height, row / sites.height);
        if (!(level.response[symmetric_entry(3, axis, axis)][at] > 0.0F)) {
          field[axis][sites.index(x, row)] = 0.0F;
        }
      }
    }
  }
  return field;
}

TEST(ElasticVolume, EnergyOfTheImageIsThatOfFiniteElements) {
  for (const Extent extent : odd_volumes()) {
    const Level level = elastic_level(extent, Tissue::noise, Held::scattered, 100.0, 3);
    const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, 0.3, Springs::none);
    const auto session = open_session("scalar", 1);
    session->load(hierarchy);
    const VectorField field = free_field(hierarchy.levels.front(), 5);
    session->write(0, ElasticField::displacement, field);
    session->forces(ElasticField::displacement, ElasticField::image);
    VectorField forces;
    session->read(0, ElasticField::image, forces);
    const double energy =
        elastic_energy(elastic_problem(level), ElementRule::of(extent, 0.3), ReferenceField(field));
    EXPECT_NEAR(-product(field, forces) / force_unit(3, 0.3), energy, 1e-5 * energy) << name_of(extent);
  }
}

/// What a level's forces do to a field is what the finer level's do to its interpolation.
TEST(ElasticVolume, CoarseLevelsAreGalerkinProducts) {
  for (const Held held : test::all_held) {
    for (const Extent extent : {Extent{9, 7, 12}, {16, 18, 17}}) {
      const Level level = elastic_level(extent, Tissue::noise, held, 100.0, 4);
      const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, 0.3);
      const auto session = open_session("scalar", 1);
      session->load(hierarchy);
      const int levels = static_cast<int>(hierarchy.levels.size());
      const auto energy = [&](int at, const VectorField& field) {
        // A sweep moves by the response times the residual: with no load it tells the forces' sign only, so
        // they are read where the next level has them.
        session->write(at, ElasticField::correction, field);
        session->write(at, ElasticField::load, VectorField(field.extent));
        session->restrict_residual(at, ElasticField::correction);
        VectorField restricted;
        session->read(at + 1, ElasticField::load, restricted);
        return restricted;
      };
      for (int at = 1; at + 1 < levels; ++at) {
        const VectorField coarse = free_field(hierarchy.levels[static_cast<std::size_t>(at)], 7);
        session->write(at, ElasticField::correction, coarse);
        session->interpolate(at - 1);
        VectorField fine;
        session->read(at - 1, ElasticField::correction, fine);
        // P' K P u from the finer level, restricted once more; and from the level itself.
        const VectorField restricted = energy(at - 1, fine);
        session->write(at, ElasticField::load, restricted);
        session->restrict_load(at);
        VectorField expected;
        session->read(at + 1, ElasticField::load, expected);
        const VectorField found = energy(at, coarse);
        double largest = 0.0;
        double worst = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (std::size_t i = 0; i < found.extent.sites(); ++i) {
            largest = std::max(largest, std::abs(static_cast<double>(expected[axis][i])));
            worst = std::max(worst, std::abs(static_cast<double>(expected[axis][i]) - found[axis][i]));
          }
        }
        EXPECT_LT(worst, 1e-5 * largest)
            << name_of(extent) << ", level " << at << ", held " << static_cast<int>(held);
      }
    }
  }
}

struct Way {
  const char* backend;
  int threads;
};

class VolumeBits : public testing::TestWithParam<Way> {};
INSTANTIATE_TEST_SUITE_P(Backends, VolumeBits,
                         testing::Values(Way{"openmp", 1}, Way{"openmp", 3}, Way{"opencl", 1},
                                         Way{"gl-compute", 1}, Way{"vulkan-compute", 1},
                                         Way{"gl-fragment", 1}, Way{"gl-fragment-osmesa", 1}),
                         [](const auto& way) {
                           std::string name = way.param.backend + std::to_string(way.param.threads);
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(VolumeBits, AreThoseOfScalar) {
  std::unique_ptr<ElasticSession> found_by;
  try {
    found_by = open_session(GetParam().backend, GetParam().threads);
  } catch (const std::runtime_error& error) {
    GTEST_SKIP() << GetParam().backend << " is not there: " << error.what();
  }
  const auto scalar = open_session("scalar", 1);
  for (const Extent extent : odd_volumes()) {
    for (const Held held : {Held::border, Held::regions, Held::springs}) {
      const Level level = elastic_level(extent, Tissue::inclusion, held, 100.0, 6);
      const ElasticHierarchy hierarchy = make_elastic_hierarchy(level, 0.3);
      const int levels = static_cast<int>(hierarchy.levels.size());
      scalar->load(hierarchy);
      found_by->load(hierarchy);
      const auto agrees = [&](int at, ElasticField field, const char* step) {
        VectorField expected;
        VectorField found;
        scalar->read(at, field, expected);
        found_by->read(at, field, found);
        EXPECT_TRUE(expected.planes == found.planes)
            << step << " on level " << at << " of " << name_of(extent) << ", held " << static_cast<int>(held);
      };
      const auto each = [&](const auto& call) {
        call(*scalar);
        call(*found_by);
      };
      for (int at = 0; at < levels; ++at) {
        const Extent sites = hierarchy.levels[static_cast<std::size_t>(at)].grid.sites;
        const auto seed = static_cast<std::uint64_t>(at);
        each([&](ElasticSession& session) {
          session.write(at, ElasticField::correction, test::random_field(sites, 10 + seed));
          session.write(at, ElasticField::load, test::random_field(sites, 20 + seed));
          session.relax(at, ElasticField::correction);
        });
        agrees(at, ElasticField::correction, "relax");
        if (at + 1 < levels) {
          each([&](ElasticSession& session) { session.restrict_residual(at, ElasticField::correction); });
          agrees(at + 1, ElasticField::load, "restrict_residual");
          each([&](ElasticSession& session) { session.restrict_load(at); });
          agrees(at + 1, ElasticField::load, "restrict_load");
        }
        if (at > 0) {
          each([&](ElasticSession& session) { session.correct(at - 1, ElasticField::correction); });
          agrees(at - 1, ElasticField::correction, "correct");
          each([&](ElasticSession& session) { session.interpolate(at - 1); });
          agrees(at - 1, ElasticField::correction, "interpolate");
        }
        each([&](ElasticSession& session) { session.relax_from_zero(at); });
        agrees(at, ElasticField::correction, "relax_from_zero");
      }
      each([](ElasticSession& session) { session.solve_coarsest(); });
      agrees(levels - 1, ElasticField::correction, "solve_coarsest");
      each([](ElasticSession& session) {
        session.forces(ElasticField::correction, ElasticField::image);
        session.advance(ElasticField::direction, ElasticField::image, 0.7F, ElasticField::load);
      });
      agrees(0, ElasticField::image, "forces");
      agrees(0, ElasticField::direction, "advance");
      EXPECT_EQ(scalar->dot(ElasticField::direction, ElasticField::load),
                found_by->dot(ElasticField::direction, ElasticField::load));
    }
  }
}

/// To 1e-4 voxels at targets of 5, whatever the tissue and the conditions.
TEST(ElasticVolume, SolutionIsThatOfFiniteElements) {
  for (const Tissue tissue : test::all_tissues) {
    for (const Held held : test::all_held) {
      for (const double contrast : {1.0, 1000.0}) {
        for (const double poisson : {0.0, 0.45}) {
          const Extent extent{9, 8, 11};
          const Level level = elastic_level(extent, tissue, held, contrast, 8);
          const auto session = open_session("openmp", 2);
          ElasticSolver solver(level, poisson, *session);
          solver.full_multigrid();
          int steps = 0;
          while (steps < 200 && !solver.conjugate_gradients().ended) {
            ++steps;
          }
          const ReferenceField truth =
              solve_finite_elements(elastic_problem(level), ElementRule::of(extent, poisson));
          // A force in the stiffest tissue is rounded by this, and a spring in the softest one carries it.
          const double rounding = held == Held::springs ? 5.0 * 0x1p-23 * contrast : 0.0;
          EXPECT_LT(distance(solver.displacement(), truth), 1e-4 + rounding)
              << "tissue " << static_cast<int>(tissue) << ", held " << static_cast<int>(held) << ", contrast "
              << contrast << ", Poisson's ratio " << poisson << ", " << steps << " steps";
        }
      }
    }
  }
}

} // namespace
} // namespace hdmbench
