#pragma once

#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

namespace hdmbench {

/// Rows of numbers of an image or a volume. One that is as the row before, to the bit, or as the one at its
/// place in the plane before, has no memory of its own: most of a body, whose tissues are larger than a row,
/// is alike.
class SharedRows {
public:
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
    kept_.shrink_to_fit();
  }

  /// `index` of a row's first number in the values.
  [[nodiscard]] const float* row(std::size_t index) const {
    return kept_.data() + first_[(index - margin_) / pitch_];
  }
  /// All values; those of the margin are 0.
  [[nodiscard]] std::vector<float> values() const {
    std::vector<float> all(margin_);
    all.reserve(margin_ + first_.size() * pitch_);
    for (const std::size_t begin : first_) {
      all.insert(all.end(), kept_.data() + begin, kept_.data() + begin + pitch_);
    }
    return all;
  }

private:
  std::size_t pitch_;
  std::size_t margin_;
  std::vector<std::size_t> first_; ///< where each row begins in what is kept
  std::vector<float> kept_;
};

} // namespace hdmbench
