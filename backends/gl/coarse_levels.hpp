#pragma once

#include "backends/gl/objects.hpp"
#include "backends/shared/resampling_entries.hpp"
#include "kernels/data/pyramid.hpp"

#include <array>
#include <cstddef>
#include <map>

namespace hdmbench::gl {

/// The first levels of a pyramid in one dispatch (kernels/shaders/coarse_levels.comp). The context must be
/// current in all calls.
class CoarseLevels {
public:
  explicit CoarseLevels(const Api& api) : gl_(api) {}

  /// For solve(). `group` of coarse_groups (backends/shared/coarse_levels.hpp); with 0 there is nothing to
  /// solve.
  void load(const Pyramid& pyramid, const ResamplingEntries& entries, int group, bool stops_at_rest);

  /// Number of levels that solve() computes.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of the last one; of none 0 x 0.
  [[nodiscard]] Extent extent() const { return extent_; }
  /// In all of them.
  [[nodiscard]] double site_updates() const { return site_updates_; }

  /// The full level's constants, the pyramid's entries and what takes the last coarse level's field are
  /// bound.
  void solve() const;

private:
  /// What a program is compiled for.
  struct Variant {
    const Energy* energy = &thesis_energy;
    int invocations = 1;
    int step_count = 1;
    bool stops_at_rest = false;

    auto operator<=>(const Variant&) const = default;
  };

  const Program& program(const Variant& variant);

  const Api& gl_;
  std::map<Variant, Program> programs_;
  const Program* program_ = nullptr; ///< of what was loaded
  std::size_t count_ = 0;
  Extent extent_{};
  double site_updates_ = 0.0;
  int levels_begin_ = 0; ///< in the entries
  int full_width_ = 0;
  float penalty_ = 0.0F;
  std::array<float, 16> steps_{};
};

} // namespace hdmbench::gl
