#pragma once

#include "backends/shared/cut.hpp"
#include "kernels/data/pyramid.hpp"

#include <span>
#include <vector>

/// Sampling and projection between levels (kernels/data/pyramid.hpp) for parts of them: the same values.
namespace hdmbench {

/// A level that samples the full image, of which each rank holds what it owns.
class RankedSampler {
public:
  RankedSampler(Extent full, Extent level, Alignment alignment);

  /// The sites of the level that sample one of `part`.
  [[nodiscard]] Rectangle sites(const Rectangle& part) const;
  /// Sites `part` of the level into an array of `to_sites` of it, from one that holds the sites `held` of the
  /// full image.
  void operator()(const Rectangle& part, std::span<const float> values, const Rectangle& held,
                  std::span<float> to, const Rectangle& to_sites) const;

private:
  std::vector<int> columns_;
  std::vector<int> rows_;
};

/// prolongate() for a part of the fine level.
class RankedProjection {
public:
  RankedProjection(Extent coarse, Extent fine, Alignment alignment);

  /// The coarse sites that it reads for the fine sites `part`.
  [[nodiscard]] Rectangle sites(const Rectangle& part) const;
  /// `coarse` has sites(part).
  [[nodiscard]] VectorField operator()(const VectorField& coarse, const Rectangle& part) const;

private:
  void project(const std::vector<float>& coarse, const Rectangle& part, std::vector<float>& fine) const;

  std::vector<Interpolation> columns_;
  std::vector<Interpolation> rows_;
};

} // namespace hdmbench
