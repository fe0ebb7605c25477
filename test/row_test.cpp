// Every instruction set of the openmp backend, not only the one this processor would choose; and that the
// comparison sees what the compiler must not do, but on scenes that are exact, where it can do no harm.

#include "backends/cpu/cpu.hpp"
#include "backends/shared/energy_programs.hpp"
#include "kernels/data/gather.hpp"
#include "test/random_level.hpp"
#include "test/scene_sweeps.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hdmbench::energies::Hdm {
/// row.cpp built with fused multiply-adds: a planted fault.
namespace contracted {
std::int64_t sweep_row(const openmp::RowPart& part);
}
/// row.cpp built with -ffast-math: sums in any order, another planted fault.
namespace reordered {
std::int64_t sweep_row(const openmp::RowPart& part);
}
} // namespace hdmbench::energies::Hdm

namespace hdmbench {
namespace {

/// Whose turn it is all along a row.
struct Turn {
  bool x = true;
  bool y = true;
};

/// Which way through the kernel a part takes.
struct Path {
  bool inside = false;
  bool uniform = false;
  bool observed = true;
  bool uniform_confidence = false;
  int longest = 1 << 20; ///< sites of a part
};

/// One sweep over the interior by a row kernel and by update.inc as the scalar backend calls it: the number
/// of sites that differ. The problem goes on from scalar's field.
int sweep_and_compare(openmp::SweepRow kernel, test::Problem& problem, int number = 0, Turn turn = {},
                      Path path = {}) {
  const Level& level = problem.level;
  const VectorField& from = problem.start;
  const Extent extent = level.extent;
  const SweepState state = sweep_state(level, number);
  const HdmInFloat::Sweep sweep{state.colour, state.strength, state.number, state.seed};
  VectorField next = from;
  VectorField expected = from;
  int differing = 0;
  for (int y = 1; y + 1 < extent.height; ++y) {
    int changed = 0;
    const auto row = extent.index(0, y);
    openmp::RowPart part{.neighbours = openmp::inside_offsets(extent.width),
                         .dx = from.x.data() + row,
                         .dy = from.y.data() + row,
                         .inverse_modulus = level.inverse_modulus.values.data() + row,
                         .modulus = level.modulus.values.data() + row,
                         .target_x = level.target.x.data() + row,
                         .target_y = level.target.y.data() + row,
                         .confidence_x = level.confidence.x.data() + row,
                         .confidence_y = level.confidence.y.data() + row,
                         .inverse_curvature_x = level.inverse_curvature.x.data() + row,
                         .inverse_curvature_y = level.inverse_curvature.y.data() + row,
                         .penalty = level.penalty,
                         .steps = level.steps.padded().data(),
                         .step_count = level.steps.count(),
                         .strength = state.strength,
                         .number = state.number,
                         .seed = state.seed,
                         .row = y,
                         .column = 0,
                         .stride = 1,
                         .next_x = next.x.data() + row,
                         .next_y = next.y.data() + row,
                         .first = 0,
                         .last = 0,
                         .pitch = extent.width,
                         .rule = static_cast<int>(level.rule),
                         .moves_x = turn.x,
                         .moves_y = turn.y,
                         .observed = path.observed,
                         .inside = path.inside,
                         .uniform = path.uniform,
                         .uniform_modulus = level.modulus.values.front(),
                         .uniform_inverse_modulus = level.inverse_modulus.values.front(),
                         .uniform_confidence = path.uniform_confidence,
                         .uniform_confidence_x = level.confidence.x.front(),
                         .uniform_confidence_y = level.confidence.y.front()};
    std::int64_t counted = 0;
    for (part.first = 1; part.first + 1 < extent.width; part.first = part.last) {
      part.last = std::min(part.first + path.longest, extent.width - 1);
      counted += kernel(part);
    }
    for (int x = 1; x + 1 < extent.width; ++x) {
      const auto i = extent.index(x, y);
      const HdmInFloat::Displacement moved = HdmInFloat::moved_displacement(
          static_cast<int>(level.rule), true, gather<HdmInFloat>(level, from, x, y),
          {static_cast<float>(x), static_cast<float>(y)}, sweep, level.steps.padded().data(),
          level.steps.count());
      expected.x[i] = turn.x ? moved.x : from.x[i];
      expected.y[i] = turn.y ? moved.y : from.y[i];
      differing += (next.x[i] != expected.x[i] || next.y[i] != expected.y[i]) ? 1 : 0;
      changed += (next.x[i] != from.x[i] || next.y[i] != from.y[i]) ? 1 : 0;
    }
    differing += counted == changed ? 0 : 1;
  }
  problem.start = expected;
  return differing;
}

/// Rows of every length up to some vectors, so that there is every remainder, and parts that end inside a
/// row.
int differing_on_short_path(openmp::SweepRow kernel, Path path) {
  int differing = 0;
  for (int width = 3; width < 80; ++width) {
    auto problem = test::random_problem({width, 6}, test::Texture::smooth, static_cast<std::uint64_t>(width));
    if (path.uniform) {
      const float modulus = problem.level.modulus.values.front(); // m * (1 / m) is not always 1
      std::ranges::fill(problem.level.modulus.values, modulus);
      set_inverse_modulus(problem.level);
    }
    if (!path.observed) {
      std::ranges::fill(problem.level.confidence.x, 0.0F);
      std::ranges::fill(problem.level.confidence.y, 0.0F);
    }
    if (path.uniform_confidence) {
      std::ranges::fill(problem.level.confidence.x, 0.625F);
      std::ranges::fill(problem.level.confidence.y, 1.0F);
    }
    for (int sweep = 0; sweep < 5; ++sweep) {
      differing += sweep_and_compare(kernel, problem, sweep, {}, path);
    }
  }
  return differing;
}

int differing_sites(openmp::SweepRow kernel) {
  int differing = 0;
  for (const test::Texture texture :
       {test::Texture::smooth, test::Texture::tie_rich, test::Texture::dyadic}) {
    for (const char* steps : {"default", "fine", "0,-1,-0.25,1,0.25"}) {
      auto problem = test::random_problem({301, 101}, texture, 31, StepSet::parse(steps));
      for (int sweep = 0; sweep < 20; ++sweep) {
        differing += sweep_and_compare(kernel, problem);
      }
    }
  }
  for (const Rule rule : test::all_rules) {
    for (const Turn turn : {Turn{true, true}, Turn{true, false}, Turn{false, true}}) {
      auto problem = test::random_problem({101, 41}, test::Texture::smooth, 32, {}, rule);
      for (int sweep = 0; sweep < 6; ++sweep) {
        differing += sweep_and_compare(kernel, problem, sweep, turn);
      }
    }
  }
  for (const bool uniform : {false, true}) {
    for (const bool observed : {false, true}) {
      for (const int longest : {1 << 20, 15, 7, 1}) {
        differing += differing_on_short_path(
            kernel, {.inside = true, .uniform = uniform, .observed = observed, .longest = longest});
      }
    }
  }
  for (const bool uniform : {false, true}) {
    differing +=
        differing_on_short_path(kernel, {.inside = true, .uniform = uniform, .uniform_confidence = true});
  }
  for (const int longest : {1 << 20, 15, 7, 1}) {
    differing += differing_on_short_path(kernel, {.longest = longest});
  }
  return differing;
}

TEST(OpenMpRow, EveryInstructionSetHasTheBitsOfScalar) {
  for (const openmp::InstructionSet& set : openmp::instruction_sets()) {
    EXPECT_EQ(differing_sites(programs_of(thesis_energy).rows.at(set.row)), 0) << set.name;
  }
}

#if defined(__x86_64__)
TEST(OpenMpRow, ContractionIsSeen) {
  if (__builtin_cpu_supports("fma") == 0 || __builtin_cpu_supports("avx2") == 0) {
    GTEST_SKIP() << "this processor has no fused multiply-add";
  }
  EXPECT_GT(differing_sites(energies::Hdm::contracted::sweep_row), 100);
}

TEST(OpenMpRow, AnotherOrderIsSeen) {
  if (__builtin_cpu_supports("avx2") == 0) {
    GTEST_SKIP() << "this processor has no AVX2";
  }
  EXPECT_GT(differing_sites(energies::Hdm::reordered::sweep_row), 100);
}

TEST(OpenMpRow, OnExactScenesNeitherChangesABit) {
  if (__builtin_cpu_supports("fma") == 0 || __builtin_cpu_supports("avx2") == 0) {
    GTEST_SKIP() << "this processor has no fused multiply-add";
  }
  for (const Scene& scene : test::exact_scenes()) {
    int differing = 0;
    test::for_each_sweep(scene, [&](const Level& level, const VectorField& before, int number) {
      for (const auto kernel : {energies::Hdm::contracted::sweep_row, energies::Hdm::reordered::sweep_row}) {
        test::Problem problem{level, before};
        differing += sweep_and_compare(kernel, problem, number);
      }
    });
    EXPECT_EQ(differing, 0) << scene.name;
  }
}

TEST(OpenMpRow, ContractionLeavesTheRandomNumbersAlone) {
  if (__builtin_cpu_supports("fma") == 0 || __builtin_cpu_supports("avx2") == 0) {
    GTEST_SKIP() << "this processor has no fused multiply-add";
  }
  // At an endless temperature every candidate is taken: what is compared is which one was drawn.
  auto problem =
      test::random_problem({301, 101}, test::Texture::dyadic, 33,
                           StepSet::parse("0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15"), Rule::annealing);
  problem.level.strengths = {0.0F};
  EXPECT_EQ(sweep_and_compare(energies::Hdm::contracted::sweep_row, problem, 123456), 0);
}
#endif

} // namespace
} // namespace hdmbench
