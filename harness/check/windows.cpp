#include "harness/check/windows.hpp"

#include <algorithm>
#include <random>

namespace hdmbench {

namespace {

struct Site {
  int x;
  int y;
};

bool overlap(const Window& a, const Window& b) {
  return a.x < b.x + b.extent.width && b.x < a.x + a.extent.width && a.y < b.y + b.extent.height &&
         b.y < a.y + a.extent.height;
}

class Chooser {
public:
  Chooser(const Level& level, const WindowPlan& plan) : level_(level), plan_(plan), engine_(plan.seed) {
    const auto side = [&](int of_image) { return std::clamp(of_image / 2, 1, plan.side); };
    extent_ = {side(level.extent.width), side(level.extent.height)};
  }

  [[nodiscard]] std::vector<Window> choose() {
    const int right = level_.extent.width - extent_.width;
    const int bottom = level_.extent.height - extent_.height;
    for (const Site corner : {Site{0, 0}, Site{right, 0}, Site{0, bottom}, Site{right, bottom}}) {
      (void)add(corner);
    }
    if (!add_telling([&](int x, int y) { return is_interface(x, y); })) {
      (void)add_telling([&](int x, int y) { return is_observed(x, y); });
    }
    constexpr int tries = 1000; // of an image that is nearly full
    for (int i = 0; i < tries && !is_full(); ++i) {
      (void)add({random(right + 1), random(bottom + 1)});
    }
    return std::move(windows_);
  }

private:
  [[nodiscard]] bool is_full() const { return std::ssize(windows_) >= plan_.windows; }

  /// Below `limit`.
  [[nodiscard]] int random(int limit) {
    return static_cast<int>(engine_() % static_cast<std::uint64_t>(limit));
  }

  /// Whether there was room.
  bool add(Site first) {
    const Window window{.x = first.x, .y = first.y, .extent = extent_};
    const bool room = !is_full() && std::ranges::none_of(windows_, [&](const Window& other) {
      return overlap(window, other);
    });
    if (room) {
      windows_.push_back(window);
    }
    return room;
  }

  /// Around the first such site, in reading order from a random one on, whose window has room.
  template <typename IsTelling>
  bool add_telling(IsTelling is_telling) {
    const Extent image = level_.extent;
    const Site begin{random(image.width), random(image.height)};
    for (int i = 0; i < image.height && !is_full(); ++i) {
      const int y = (begin.y + i) % image.height;
      for (int k = 0; k < image.width; ++k) {
        const int x = (begin.x + k) % image.width;
        if (is_telling(x, y) && add({std::clamp(x - extent_.width / 2, 0, image.width - extent_.width),
                                     std::clamp(y - extent_.height / 2, 0, image.height - extent_.height)})) {
          return true;
        }
      }
    }
    return false;
  }

  [[nodiscard]] bool is_interface(int x, int y) const {
    const auto modulus = [&](int column, int row) {
      return level_.modulus.values[level_.extent.index(std::min(column, level_.extent.width - 1),
                                                       std::min(row, level_.extent.height - 1))];
    };
    return modulus(x, y) != modulus(x + 1, y) || modulus(x, y) != modulus(x, y + 1);
  }
  [[nodiscard]] bool is_observed(int x, int y) const {
    const bool inside = x > 0 && y > 0 && x + 1 < level_.extent.width && y + 1 < level_.extent.height;
    const std::size_t site = level_.extent.index(x, y);
    return inside && (level_.confidence.x[site] > 0.0F || level_.confidence.y[site] > 0.0F);
  }

  const Level& level_;
  const WindowPlan& plan_;
  std::mt19937_64 engine_;
  Extent extent_; ///< of every window
  std::vector<Window> windows_;
};

std::vector<float> crop(const std::vector<float>& values, Extent image, const Window& window) {
  std::vector<float> part;
  if (!values.empty()) {
    part.reserve(window.extent.sites());
    for (int y = window.y; y < window.y + window.extent.height; ++y) {
      const auto row = values.begin() + static_cast<std::ptrdiff_t>(image.index(window.x, y));
      part.insert(part.end(), row, row + window.extent.width);
    }
  }
  return part;
}

} // namespace

std::vector<Window> choose_windows(const Level& level, const WindowPlan& plan) {
  return Chooser(level, plan).choose();
}

Window with_influence(const Window& inner, int sweeps, Extent image) {
  const auto reach = static_cast<long long>(sweeps);
  const auto first = [&](int at) { return static_cast<int>(std::max(0LL, at - reach)) & ~1; };
  const auto last = [&](int at, int size) { return static_cast<int>(std::min<long long>(at + reach, size)); };
  const int x = first(inner.x);
  const int y = first(inner.y);
  return {.x = x,
          .y = y,
          .extent = {last(inner.x + inner.extent.width, image.width) - x,
                     last(inner.y + inner.extent.height, image.height) - y}};
}

VectorField crop(const VectorField& field, const Window& window) {
  VectorField part;
  part.extent = window.extent;
  part.x = crop(field.x, field.extent, window);
  part.y = crop(field.y, field.extent, window);
  return part;
}

Level crop(const Level& level, const Window& window) {
  Level part = without_fields(level);
  part.extent = window.extent;
  const auto scalar = [&](const ScalarField& field) {
    ScalarField cropped;
    cropped.extent = window.extent;
    cropped.values = crop(field.values, level.extent, window);
    return cropped;
  };
  part.target = crop(level.target, window);
  part.confidence = crop(level.confidence, window);
  part.modulus = scalar(level.modulus);
  part.inverse_modulus = scalar(level.inverse_modulus);
  if (needs_inverse_curvature(level.rule)) {
    part.inverse_curvature = crop(level.inverse_curvature, window);
  }
  return part;
}

} // namespace hdmbench
