#include "backends/opencl/sweeps.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench::opencl {

namespace {

/// Levels of up to so many sites are swept by one group in one dispatch: starting another one takes longer.
/// No flags are kept for them either.
constexpr std::size_t most_for_one_group = std::size_t{64} * 64;

/// Site updates between two waits, by all groups and by one: no driver takes that for hung.
constexpr double most_in_flight = 1e9;
constexpr double most_by_one_group = 2e7;

/// Arguments of sweep.cl.
enum Argument : cl_uint {
  displacement,
  improved,
  material,
  observation,
  inverse_curvature,
  inputs_of_energy,
  classes,
  flags,
  parameters
};

} // namespace

Sweeps::Sweeps(const Queue& queue, Kernels& kernels, const Shape& shape, const Level& full, Extent extent,
               Alignment alignment, std::vector<float> strengths, Work work, const InputTexels& inputs,
               std::size_t first_input)
    : queue_(&queue), lanes_(static_cast<std::size_t>(shape.lanes)), level_(without_fields(full)),
      layout_(extent), tiles_(tiles_of(extent, shape.tile)) {
  level_.extent = extent;
  level_.strengths = std::move(strengths);
  const bool fast = changes_spread_by_contact(full);
  active_ = work == Work::active && fast && extent.sites() > most_for_one_group;
  kernel_ = &kernels.sweep(
      {.constants = shader_constants(full), .shape = shape, .active = active_, .general = !fast});

  const auto input_count = static_cast<std::size_t>(full.energy->inputs);
  queue.make_room(inputs_, std::max(layout_.bytes(input_count), sizeof(float)));
  for (std::size_t number = 0; number < input_count; ++number) {
    queue.write(inputs_, layout_.offset(number),
                std::span(inputs.planes.at(number)).subspan(first_input, extent.sites()));
  }
  std::vector<std::uint8_t> classes_of_tiles{0};
  if (fast) {
    classes_of_tiles =
        classify_tiles(full, extent, alignment, {.tile = shape.tile, .classes = classes_with_code}).classes;
  }
  queue.make_room(classes_, classes_of_tiles.size());
  queue.write_bytes(classes_, classes_of_tiles.size(), classes_of_tiles.data());
  const std::size_t flag_bytes = active_ ? 2 * tiles_.sites() * sizeof(cl_uint) : sizeof(cl_uint);
  queue.make_room(flags_, flag_bytes);
  queue.clear(flags_, flag_bytes);
}

int Sweeps::run(int first, int count, const Fields& fields, Displacements& displacements) {
  kernel_->set(material, fields.material);
  kernel_->set(observation, fields.observation);
  kernel_->set(inverse_curvature, fields.inverse_curvature);
  kernel_->set(inputs_of_energy, inputs_);
  kernel_->set(classes, classes_);
  kernel_->set(flags, flags_);
  const double most = by_one_group() ? most_by_one_group : most_in_flight;
  count =
      std::min(count, static_cast<int>(std::clamp(most / static_cast<double>(extent().sites()), 1.0, 1e6)));
  if (by_one_group()) {
    sweep(first, count, displacements);
  } else {
    for (int number = first; number < first + count; ++number) {
      sweep(number, 1, displacements);
    }
  }
  return count;
}

bool Sweeps::by_one_group() const {
  return extent().sites() <= most_for_one_group && changes_spread_by_contact(level_);
}

void Sweeps::sweep(int first, int together, Displacements& displacements) {
  const SweepState state = sweep_state(level_, first);
  if (active_) {
    ++stamp_;
  }
  kernel_->set(displacement, displacements.field());
  kernel_->set(improved, displacements.other());
  kernel_->set(parameters, SweepParameters{.steps = level_.steps.padded(),
                                           .penalty = level_.penalty,
                                           .colour = state.colour,
                                           .strength = state.strength,
                                           .number = state.number,
                                           .seed = state.seed,
                                           .width = extent().width,
                                           .height = extent().height,
                                           .origin = static_cast<cl_uint>(layout_.origin),
                                           .plane = static_cast<cl_uint>(layout_.plane),
                                           .tiles_across = tiles_.width,
                                           .tile_count = static_cast<cl_int>(tiles_.sites()),
                                           .sweeps = together,
                                           .every = every_ ? 1 : 0,
                                           .stamp = stamp_});
  queue_->run(*kernel_, by_one_group() ? 1 : tiles_.sites(), lanes_);
  every_ = false;
  if (together % 2 == 1) {
    displacements.swap();
  }
}

} // namespace hdmbench::opencl
