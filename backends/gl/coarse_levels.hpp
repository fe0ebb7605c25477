#pragma once

#include "backends/gl/buffer_texture.hpp"
#include "backends/gl/objects.hpp"
#include "kernels/pyramid.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <vector>

namespace hdmbench::gl {

/// The first levels of a pyramid in one dispatch (kernels/coarse_levels.comp). The context must be current in
/// all calls.
class CoarseLevels {
public:
  explicit CoarseLevels(const Api& api) : gl_(api), entries_(api) {}

  /// For solve(). `group` as SessionOptions::coarse_group; with 0 there is nothing to solve.
  void load(const Pyramid& pyramid, int group, bool stops_at_rest);

  /// Number of levels that solve() computes.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of the last one; of none 0 x 0.
  [[nodiscard]] Extent extent() const { return extent_; }
  /// In all of them.
  [[nodiscard]] double site_updates() const { return site_updates_; }

  /// `material` and `observation` are the full level's; the last coarse level's field goes to `displacement`.
  void solve(const BufferTexture& material, const BufferTexture& observation,
             const BufferTexture& displacement) const;

private:
  /// What a program is compiled for.
  struct Variant {
    int invocations = 1;
    int step_count = 1;
    bool stops_at_rest = false;

    auto operator<=>(const Variant&) const = default;
  };

  const Program& program(const Variant& variant);

  const Api& gl_;
  BufferTexture entries_; ///< of ResamplingEntries
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
