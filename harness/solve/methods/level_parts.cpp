#include "harness/solve/methods/level_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

class WholeImage final : public LevelParts {
public:
  Extent image(const Scene& scene) const override { return scene.extent(); }
  LevelPart part(Extent level) const override {
    return {.level = level, .owned = all_of(level), .loaded = all_of(level)};
  }
  Level sample(const Level& image, Extent level, Alignment alignment, Material material) const override {
    return sample_level(image, level, alignment, material);
  }
  VectorField sample(const VectorField& image, Extent level, Alignment alignment) const override {
    return sample_field(image, level, alignment);
  }
  void renew(Extent /*level*/, VectorField& /*field*/) const override {}
  void renew(Extent /*level*/, DoubleField& /*field*/) const override {}
  VectorField to_coarser(Extent /*fine*/, Extent /*coarse*/, Alignment /*alignment*/,
                         VectorField rows) const override {
    return rows;
  }
  VectorField to_finer(Extent /*coarse*/, Extent fine, Alignment alignment,
                       const VectorField& field) const override {
    return prolongate(field, fine, alignment);
  }
  double sum(Extent /*level*/, std::span<const double> rows) const override {
    double sum = 0.0;
    for (const double row : rows) {
      sum += row;
    }
    return sum;
  }
  double largest(double own) const override { return own; }
};

} // namespace

double LevelParts::root_mean(Extent level, std::span<const double> rows) const {
  return std::sqrt(sum(level, rows) / static_cast<double>(level.sites()));
}

const LevelParts& whole_image() {
  static const WholeImage whole;
  return whole;
}

Rectangle rows_restricted(Extent fine, const Rectangle& owned, Extent coarse, Alignment alignment) {
  const std::vector<int> rows = sampled_indices(coarse.height, fine.height, alignment);
  const auto first = std::ranges::lower_bound(rows, owned.top);
  const auto end = std::ranges::lower_bound(rows, owned.top + owned.height);
  return {.left = 0,
          .top = static_cast<int>(first - rows.begin()),
          .width = first == end ? 0 : coarse.width,
          .height = static_cast<int>(end - first)};
}

} // namespace hdmbench
