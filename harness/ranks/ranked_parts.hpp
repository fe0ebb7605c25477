#pragma once

#include "harness/ranks/ranked_solution.hpp"
#include "harness/solve/methods/level_parts.hpp"
#include "harness/solve/progress.hpp"

#include <map>
#include <vector>

namespace hdmbench {

/// Parts of levels on ranks: whole rows each, a halo as wide as LevelParts says.
class RankedParts final : public LevelParts {
public:
  /// `sharing`: by sharing_for(). `halos`: what brings halos, sums and what goes from level to level, usually
  /// the ranks themselves. Both must outlive this.
  RankedParts(Extent image, const Sharing& sharing, Ranks& ranks, Exchange& halos);

  Extent image(const Scene& /*scene*/) const override { return image_; }
  LevelPart part(Extent level) const override;
  Level sample(const Level& image, Extent level, Alignment alignment, Material material) const override;
  VectorField sample(const VectorField& image, Extent level, Alignment alignment) const override;
  void renew(Extent level, VectorField& field) const override;
  void renew(Extent level, DoubleField& field) const override;
  VectorField to_coarser(Extent fine, Extent coarse, Alignment alignment, VectorField rows) const override;
  VectorField to_finer(Extent coarse, Extent fine, Alignment alignment,
                       const VectorField& field) const override;
  double sum(Extent level, std::span<const double> rows) const override;
  double largest(double own) const override { return ranks_.largest(own); }

  /// What was sent for a level, by this rank.
  struct Sent {
    std::int64_t renewals = 0; ///< of its halos
    Traffic halos{};
    Traffic between{}; ///< from finer and coarser levels, and for sums
  };
  [[nodiscard]] const Sent& sent(Extent level) const { return sent_[level]; }
  [[nodiscard]] const LevelShare& share(Extent level) const;

private:
  [[nodiscard]] Traffic since(const Traffic& before) const;

  Extent image_;
  Sharing sharing_;
  Ranks& ranks_;
  Exchange& halos_;
  std::size_t rank_;
  mutable std::map<Extent, LevelShare> shares_;
  mutable std::map<Extent, Sent> sent_;
};

/// multigrid and krylov on all ranks; `halos` as above. The bits of one process. Collective. Throws what
/// solve_on_parts() throws.
[[nodiscard]] RankedSolution solve_cycles_on_ranks(ScenePart part, const Backend& backend,
                                                   const SessionOptions& options, const Sharing& sharing,
                                                   Ranks& ranks, Exchange& halos, Progress& progress);

} // namespace hdmbench
