#pragma once

#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/ranked_resampling.hpp"
#include "harness/ranks/ranked_solution.hpp"

#include <span>
#include <vector>

namespace hdmbench {

/// What each rank loads of a level that samples the image: sample_level() and sample_field() of the whole,
/// bit for bit. All calls are collective and throw what Exchange throws.
class RankedSampling {
public:
  /// How the image and the level are shared out; `sites` brings sites, `sums` hands on sums. All must outlive
  /// this.
  RankedSampling(Exchange& sites, Exchange& sums, std::size_t rank, Extent image,
                 const LevelShare& shared_image, Extent level, const LevelShare& shared_level,
                 Alignment alignment);

  /// Of what this rank loads of the image. Material::mean where rows are shared out whole (Sharing::rows).
  [[nodiscard]] Level operator()(const Level& image, Material material) const;
  [[nodiscard]] VectorField operator()(const VectorField& image) const;

private:
  /// In one message from a rank to another.
  [[nodiscard]] std::vector<std::vector<float>>
  values(std::span<const std::vector<float>* const> images) const;
  [[nodiscard]] std::vector<float> mean_moduli(const std::vector<float>& image) const;

  Exchange& sites_;
  Exchange& sums_;
  std::size_t rank_;
  Extent image_;
  const LevelShare& shared_image_;
  Extent level_;
  const LevelShare& shared_level_;
  Alignment alignment_;
  RankedSampler sampler_;
  std::vector<Rectangle> held_; ///< of the level, what each rank's own sites of the image are
};

} // namespace hdmbench
