// The scalar backend in the browser: backends/cpu/scalar_sweep.cpp and these few functions, compiled to
// WebAssembly, which never contracts a * b + c. follow.js calls them; pointers are into the module's memory.

#include "kernels/data/energy.hpp"
#include "kernels/data/level.hpp"
#include "kernels/specification/projection.hpp"

#include <cstdint>
#include <span>
#include <utility>

#define EXPORTED(name) extern "C" __attribute__((export_name(name)))

namespace hdmbench {

// Nothing here asks the host's side of it.
const Energy thesis_energy{.name = "hdm", .coloured_sets = 2};

namespace energies::Hdm {
std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to);
}

namespace {

Level level;
VectorField field;      ///< the newest
VectorField next_field; ///< the one before, which the next sweep overwrites
VectorField coarse;     ///< of the level before, for project()
SweepState state;

} // namespace

/// Room for a level and its field; all pointers are new.
EXPORTED("load") void load(int width, int height, int rule, int update, float penalty, int seed) {
  const Extent extent{width, height};
  coarse = std::move(field);
  level = Level{};
  level.extent = extent;
  level.target = level.confidence = level.inverse_curvature = VectorField(extent);
  level.modulus = level.inverse_modulus = ScalarField(extent);
  level.rule = static_cast<Rule>(rule);
  level.update = static_cast<Update>(update);
  level.penalty = penalty;
  level.seed = seed;
  field = next_field = VectorField(extent);
}

/// Of the level, in the order of the page's data, then the displacement.
EXPORTED("array") float* array(int index) {
  std::vector<float>* const all[] = {&level.modulus.values,
                                     &level.inverse_modulus.values,
                                     &level.target[0],
                                     &level.target[1],
                                     &level.confidence[0],
                                     &level.confidence[1],
                                     &level.inverse_curvature[0],
                                     &level.inverse_curvature[1],
                                     &field[0],
                                     &field[1]};
  return all[index]->data();
}

/// Room for so many floats, which the calls below take as arguments; good until the next call of this.
EXPORTED("scratch") float* scratch(int count) {
  static std::vector<float> values;
  values.resize(static_cast<std::size_t>(count));
  return values.data();
}

EXPORTED("set_strengths") void set_strengths(const float* strengths, int count) {
  level.strengths.assign(strengths, strengths + count);
}

/// The candidates.
EXPORTED("set_steps") void set_steps(const float* steps, int count) {
  level.steps = StepSet(std::span(steps, static_cast<std::size_t>(count)));
}

/// The displacement from the level before. Four floats for each column, then each row: the two coarse indices
/// and the weight of the second, and one unused.
EXPORTED("project") void project(const float* columns) {
  const float* const rows = columns + 4 * level.extent.width;
  for (int y = 0; y < level.extent.height; ++y) {
    const int north = static_cast<int>(rows[4 * y]);
    const int south = static_cast<int>(rows[4 * y + 1]);
    for (int x = 0; x < level.extent.width; ++x) {
      const int west = static_cast<int>(columns[4 * x]);
      const int east = static_cast<int>(columns[4 * x + 1]);
      const auto component = [&](const std::vector<float>& from) {
        return projection::projected(
            from[coarse.extent.index(west, north)], from[coarse.extent.index(east, north)],
            from[coarse.extent.index(west, south)], from[coarse.extent.index(east, south)],
            columns[4 * x + 2], rows[4 * y + 2]);
      };
      field[0][level.extent.index(x, y)] = component(coarse[0]);
      field[1][level.extent.index(x, y)] = component(coarse[1]);
    }
  }
}

/// colour, strength, number and seed of update.inc's Sweep.
EXPORTED("turn") const float* turn(int number) {
  state = sweep_state(level, number);
  return &state.colour;
}

/// Returns how many sites changed.
EXPORTED("sweep") int sweep(int number) {
  const auto changed = energies::Hdm::scalar_sweep(level, number, field, next_field);
  std::swap(field, next_field);
  return static_cast<int>(changed);
}

} // namespace hdmbench

// The page's data were validated when it was written: what would be thrown is a trap.
extern "C" [[noreturn]] void* __cxa_allocate_exception(std::size_t /*size*/) {
  __builtin_trap();
}
extern "C" [[noreturn]] void __cxa_throw(void* /*exception*/, void* /*type*/, void (* /*destroy*/)(void*)) {
  __builtin_trap();
}
