#include "harness/check/state_hash.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>

namespace hdmbench {

void StateHash::add_word(std::uint32_t word) {
  for (int byte = 0; byte < 4; ++byte) {
    hash_ ^= (word >> (8 * byte)) & 0xff;
    hash_ *= 0x100000001b3;
  }
}

void StateHash::add(int number) {
  add_word(static_cast<std::uint32_t>(number));
}

void StateHash::add(float value) {
  if (!std::isfinite(value)) {
    throw NotFinite(fmt::format("a number is {}", value));
  }
  add_word(value == 0.0F ? 0 : std::bit_cast<std::uint32_t>(value));
}

void StateHash::add(Extent extent) {
  add(extent.width);
  add(extent.height);
}

void StateHash::add(std::span<const float> values) {
  add(static_cast<int>(values.size()));
  for (const float value : values) {
    add(value);
  }
}

void StateHash::add_component(const char* name, std::span<const float> values, Extent extent) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      const auto width = static_cast<std::size_t>(extent.width);
      throw NotFinite(fmt::format("{} at ({}, {}) is {}", name, i % width, i / width, values[i]));
    }
    add(values[i]);
  }
}

void StateHash::add(std::string_view text) {
  add(static_cast<int>(text.size()));
  for (const char letter : text) {
    add_word(static_cast<unsigned char>(letter));
  }
}

void StateHash::add(const ScalarField& field) {
  add(field.extent);
  add_component("the value", field.values, field.extent);
}

void StateHash::add(const VectorField& field) {
  add(field.extent);
  add_component("x", field.x, field.extent);
  add_component("y", field.y, field.extent);
}

std::uint64_t state_hash(const VectorField& field) {
  StateHash hash;
  hash.add(field);
  return hash.value();
}

std::uint64_t level_hash(const Level& level) {
  StateHash hash;
  hash.add(level.extent);
  hash.add(level.modulus);
  hash.add(level.inverse_modulus);
  hash.add(level.target);
  hash.add(level.confidence);
  hash.add(level.penalty);
  hash.add(level.steps.values());
  hash.add(static_cast<int>(level.update));
  hash.add(level.rule == Rule::annealing ? 3 : static_cast<int>(level.rule)); // as it was numbered once
  hash.add(level.inverse_curvature);
  hash.add(level.strengths);
  hash.add(level.seed);
  if (level.energy != &thesis_energy) { // whose hashes are older than there were others
    hash.add(level.energy->name);
    for (const ScalarField& input : level.inputs) {
      hash.add(input);
    }
  }
  return hash.value();
}

std::uint64_t hierarchy_hash(const ElasticHierarchy& hierarchy) {
  StateHash hash;
  hash.add(hierarchy.ratio.nu);
  for (const ElasticLevel& level : hierarchy.levels) {
    hash.add(level.grid.sites);
    for (const std::vector<float>& moment : level.moments) {
      hash.add(moment);
    }
    for (const std::vector<float>& response : level.response) {
      hash.add(response);
    }
    for (const MaskedCell& cell : level.masked.cells) {
      hash.add(cell.x);
      hash.add(std::span<const float>(cell.stiffness));
    }
  }
  hash.add(hierarchy.coarsest_inverse);
  return hash.value();
}

} // namespace hdmbench
