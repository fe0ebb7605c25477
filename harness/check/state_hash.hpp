#pragma once

#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/level.hpp"

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A value is NaN or infinite; what() says which.
class NotFinite : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// 64 bits that stand for numbers in a given order, the same on every machine: FNV-1a (Fowler, Noll and Vo;
/// offset basis 0xcbf29ce484222325, prime 0x100000001b3) over bytes, low byte first. Finds differences; no
/// protection against people.
class StateHash {
public:
  void add(int number);  ///< 4 bytes, two's complement
  void add(float value); ///< its 4 bytes (IEEE 754), -0 as 0; throws NotFinite
  void add(std::string_view text);
  void add(Extent extent);                 ///< width, height
  void add(std::span<const float> values); ///< their number, then they
  void add(const ScalarField& field);      ///< extent, then all values in raster order; throws NotFinite
  void add(const VectorField& field);      ///< extent, then all x, then all y; throws NotFinite

  [[nodiscard]] std::uint64_t value() const { return hash_; }

private:
  void add_word(std::uint32_t word);
  void add_component(const char* name, std::span<const float> values, Extent extent);

  std::uint64_t hash_ = 0xcbf29ce484222325;
};

/// Of one field: extent, all x, all y. Throws NotFinite naming the component and the site.
[[nodiscard]] std::uint64_t state_hash(const VectorField& field);

/// Of all that a session is loaded with: extent, moduli, their inverses, targets, confidences, K, candidates,
/// update, rule, inverse curvatures, strengths, seed. Throws NotFinite.
[[nodiscard]] std::uint64_t level_hash(const Level& level);

/// Of all that an elastic session is loaded with, level by level, the coarsest (with the inverse) first.
/// Throws NotFinite.
[[nodiscard]] std::vector<std::uint64_t> level_hashes(const ElasticHierarchy& hierarchy);

} // namespace hdmbench
