// The scalar backend in the browser: backends/cpu/scalar_sweep.cpp and these few functions, compiled to
// WebAssembly, which never contracts a * b + c. follow.js calls them; pointers are into the module's memory.

#include "kernels/data/energy.hpp"
#include "kernels/data/level.hpp"

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
SweepState state;

} // namespace

/// Room for a level and its field; all pointers are new.
EXPORTED("load") void load(int width, int height, int rule, int update, float penalty, int seed) {
  const Extent extent{width, height};
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

/// The displacement, then what the level has, in the order of the page's data.
EXPORTED("array") float* array(int index) {
  std::vector<float>* const all[] = {&field[0],
                                     &field[1],
                                     &level.modulus.values,
                                     &level.inverse_modulus.values,
                                     &level.target[0],
                                     &level.target[1],
                                     &level.confidence[0],
                                     &level.confidence[1],
                                     &level.inverse_curvature[0],
                                     &level.inverse_curvature[1]};
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
