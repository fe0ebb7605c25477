#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace hdmbench {

/// Rows of numbers of an image or a volume. One that is as the row before, to the bit, or as the one at its
/// place in the plane before, has no memory of its own: most of a body, whose tissues are larger than a row,
/// is alike.
class SharedRows {
public:
  SharedRows() = default;
  /// Takes `values` away: behind `margin` others rows of `pitch`, so many in a plane.
  SharedRows(std::vector<float>& values, std::size_t pitch, std::size_t rows_in_plane, std::size_t margin = 0)
      : pitch_(pitch), margin_(margin), first_((values.size() - margin) / pitch), kept_(std::move(values)) {
    std::size_t end = 0;
    for (std::size_t row = 0; row < first_.size(); ++row) {
      const float* const from = kept_.data() + margin_ + row * pitch_;
      const auto is_as = [&](std::size_t before) {
        return row >= before &&
               std::memcmp(from, kept_.data() + first_[row - before], sizeof(float) * pitch_) == 0;
      };
      first_[row] = end;
      if (row > 0 && (is_as(1) || is_as(rows_in_plane))) {
        first_[row] = first_[row - (is_as(1) ? 1 : rows_in_plane)];
        continue;
      }
      std::memmove(kept_.data() + end, from, sizeof(float) * pitch_);
      end += pitch_;
    }
    kept_.resize(end);
  }

  /// Gives the memory back that the rows do not need. There is no values() afterwards.
  void shrink() { kept_.shrink_to_fit(); }
  /// The memory behind the rows, whose content nobody needs, until shrink().
  [[nodiscard]] std::span<float> spare() {
    return {kept_.data() + kept_.size(), kept_.capacity() - kept_.size()};
  }

  /// `index` of a row's first number in the values.
  [[nodiscard]] const float* row(std::size_t index) const {
    return kept_.data() + first_[(index - margin_) / pitch_];
  }
  /// Returns all values in the memory that they came in: none is allocated. Those of the margin are 0.
  [[nodiscard]] std::vector<float> values() && noexcept {
    kept_.resize(margin_ + first_.size() * pitch_);
    for (std::size_t row = first_.size(); row-- > 0;) { // no row is kept behind its place
      std::memmove(kept_.data() + margin_ + row * pitch_, kept_.data() + first_[row], sizeof(float) * pitch_);
    }
    std::fill_n(kept_.data(), margin_, 0.0F);
    return std::move(kept_);
  }

private:
  std::size_t pitch_ = 0;
  std::size_t margin_ = 0;
  std::vector<std::size_t> first_; ///< where each row begins in what is kept
  std::vector<float> kept_;
};

} // namespace hdmbench
