#include "harness/solve/methods/restriction.hpp"

#include "harness/scene/sites.hpp"
#include "harness/solve/methods/stationary_weights.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hdmbench {

namespace {

/// Width of a coarse site in fine ones, 1 on an axis of one site: nothing varies along it.
double site_width(int coarse, int fine, Alignment alignment) {
  if (coarse == 1) {
    return 1.0;
  }
  return alignment == Alignment::corner ? static_cast<double>(fine - 1) / (coarse - 1)
                                        : static_cast<double>(fine) / coarse;
}

/// h^2, the product of both sides' where there are two.
double squared_width(Extent coarse, Extent fine, Alignment alignment) {
  const double width = site_width(coarse.width, fine.width, alignment);
  const double height = site_width(coarse.height, fine.height, alignment);
  return coarse.width == 1 ? height * height : coarse.height == 1 ? width * width : width * height;
}

} // namespace

Restriction::Restriction(const Level& fine, Extent from, Extent coarse, Alignment alignment,
                         const LevelParts& parts)
    : parts_(parts), alignment_(alignment), fine_level_(from), coarse_level_(coarse), fine_(fine.extent),
      made_(rows_restricted(from, parts.part(from).owned, coarse, alignment)),
      weights_(stationary_weights(fine)) {
  const Rectangle loaded = parts.part(from).loaded;
  parts.renew(from, weights_);
  columns_ =
      shares({coarse.width, made_.left, made_.width}, {from.width, loaded.left, loaded.width}, alignment);
  rows_ =
      shares({coarse.height, made_.top, made_.height}, {from.height, loaded.top, loaded.height}, alignment);
  scale_x_ = scale_of(weights_.x, alignment);
  scale_y_ = scale_of(weights_.y, alignment);
}

std::vector<double> Restriction::scale_of(const std::vector<float>& weights, Alignment alignment) const {
  std::vector<double> scale = weighted_sums(weights, {});
  const double square = squared_width(coarse_level_, fine_level_, alignment);
  std::ranges::transform(scale, scale.begin(), [square](double sum) { return square / sum; });
  return scale;
}

Restriction::Shares Restriction::shares(const Axis& coarse, const Axis& fine, Alignment alignment) {
  Shares result(static_cast<std::size_t>(coarse.count));
  const auto from = interpolations(coarse.sites, fine.sites, alignment);
  for (int i = 0; i < fine.sites; ++i) {
    const Interpolation& at = from[static_cast<std::size_t>(i)];
    const auto weight = static_cast<double>(at.weight);
    const auto give = [&](int site, double share) {
      if (share <= 0.0 || site < coarse.first || site >= coarse.first + coarse.count) {
        return;
      }
      if (i < fine.first || i >= fine.first + fine.count) {
        throw std::logic_error("a halo is too narrow for a restriction");
      }
      result[static_cast<std::size_t>(site - coarse.first)].push_back({i - fine.first, share});
    };
    give(at.first, 1.0 - weight);
    give(at.second, weight);
  }
  return result;
}

std::vector<double> Restriction::weighted_sums(const std::vector<float>& weights,
                                               const std::vector<double>& values) const {
  std::vector<double> sums(made_.extent().sites());
  const auto width = static_cast<std::size_t>(fine_.width);
#pragma omp parallel for schedule(static) if (fine_.sites() > 4096)
  for (int y = 0; y < made_.height; ++y) {
    std::vector<double> row(width); // summed along y, still of the fine width
    for (const Share& from : rows_[static_cast<std::size_t>(y)]) {
      const std::size_t begin = fine_.index(0, from.fine);
      for (std::size_t x = 0; x < width; ++x) {
        const double weight = from.weight * static_cast<double>(weights[begin + x]);
        row[x] += values.empty() ? weight : weight * values[begin + x];
      }
    }
    for (int x = 0; x < made_.width; ++x) {
      double sum = 0.0;
      for (const Share& from : columns_[static_cast<std::size_t>(x)]) {
        sum += from.weight * row[static_cast<std::size_t>(from.fine)];
      }
      sums[made_.extent().index(x, y)] = sum;
    }
  }
  return sums;
}

std::vector<float> Restriction::restrict_component(const std::vector<float>& weights,
                                                   const std::vector<double>& scale,
                                                   const std::vector<double>& residual) const {
  const std::vector<double> sums = weighted_sums(weights, residual);
  std::vector<float> result(sums.size());
  std::ranges::transform(sums, scale, result.begin(),
                         [](double sum, double factor) { return static_cast<float>(sum * factor); });
  return result;
}

VectorField Restriction::restrict_residual(const DoubleField& residual) const {
  VectorField result;
  result.extent = made_.extent();
  result.x = restrict_component(weights_.x, scale_x_, residual.x);
  result.y = restrict_component(weights_.y, scale_y_, residual.y);
  return parts_.to_coarser(fine_level_, coarse_level_, alignment_, std::move(result));
}

std::vector<float> Restriction::any_in_footprint(const std::vector<float>& held) const {
  std::vector<float> result(made_.extent().sites());
  for_each_site(made_.extent(), [&](int x, int y) {
    float& value = result[made_.extent().index(x, y)];
    for (const Share& row : rows_[static_cast<std::size_t>(y)]) {
      for (const Share& column : columns_[static_cast<std::size_t>(x)]) {
        if (row.weight >= 0.5 && column.weight >= 0.5) {
          value = std::max(value, held[fine_.index(column.fine, row.fine)]);
        }
      }
    }
  });
  return result;
}

VectorField Restriction::restrict_held(const VectorField& held) const {
  VectorField result;
  result.extent = made_.extent();
  result.x = any_in_footprint(held.x);
  result.y = any_in_footprint(held.y);
  return parts_.to_coarser(fine_level_, coarse_level_, alignment_, std::move(result));
}

} // namespace hdmbench
