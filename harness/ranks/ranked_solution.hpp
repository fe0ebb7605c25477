#pragma once

#include "backends/backend.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/scene/scene_part.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace hdmbench {

/// How a level is shared out among ranks.
struct LevelShare {
  Cut cut;                       ///< piece i is rank i's; ranks beyond the pieces have nothing
  std::vector<Rectangle> owned;  ///< by rank; without sites where it has no piece
  std::vector<Rectangle> loaded; ///< the same with the halo
};
/// `ranks`: that there are, at least as many as the cut has pieces.
[[nodiscard]] LevelShare by_rank(Cut cut, int ranks);

/// What decides how wide a halo is; measured (scaling.hpp), the slowest rank's, the same on every rank.
/// Seconds.
struct HaloCosts {
  double site = 0.0;    ///< to sweep a site
  double message = 0.0; ///< of a message between neighbours, both ways at once
  double byte = 0.0;    ///< the same, for each byte of it
  double rim = 0.0;     ///< to bring the displacement of a site of a rim out of a session and into another
  double piece = 0.0;   ///< the same, for each site of the piece, whatever its rim: what whole fields take

  bool operator==(const HaloCosts&) const = default;
};

/// Seconds to renew the halos of a cut once: of the piece with most of them.
[[nodiscard]] double renewal_seconds(const HaloCosts& costs, const Cut& cut);

/// The rule by which all levels are shared out, the same on every rank.
struct Sharing {
  int ranks = 1;  ///< that there are
  int pieces = 1; ///< at most, of any level; ranks beyond stay idle
  /// A level goes to as many ranks as get so many sites each, at least to one: below, a message costs more
  /// than the sweeps that it saves. 128 x 128.
  std::size_t fewest_sites = std::size_t{1} << 14;
  int halo = 0; ///< as of cut_image()
  /// > 0: pieces are whole rows, at least so many, where there are so many: for what is summed up over the
  /// image row by row, and for random numbers (seed_from_row()).
  int fewest_rows = 0;
  /// Where `halo` is 0: of 8, 16, 32, 64 sites the width with which a sweep and its share of a renewal take
  /// the shortest.
  std::optional<HaloCosts> costs{};

  bool operator==(const Sharing&) const = default;

  [[nodiscard]] LevelShare operator()(Extent extent) const;
};

/// A pyramid of which every rank holds a part.
struct RankedPyramid {
  Extent extent;                    ///< of the image
  Level part;                       ///< the sites of the full resolution that this rank loads
  std::optional<VectorField> start; ///< of the same sites; none on all ranks: the null field
  Alignment alignment = Alignment::corner;
  Material material = Material::nearest;
  std::vector<PyramidLevel> levels; ///< in the order they are computed; the last has the image's extent
  bool until_still = false;         ///< a level ends when no site changed in an iteration
};

/// How an image is shared out for the scene's method, with what `sharing` says; of the thesis's energy.
[[nodiscard]] Sharing sharing_for(const Schedule& schedule, Sharing sharing);

/// Throws InputError where the scene's schedule cannot be computed on ranks yet, and says what can.
void require_shareable(const Scene& scene);

/// Of a scene that is shareable; takes the fields of the part.
[[nodiscard]] RankedPyramid ranked_pyramid(ScenePart part);

/// What ranks did on a level.
struct RankedLevel {
  Extent extent;
  std::size_t pieces = 1;
  int columns = 1; ///< of pieces
  int halo = 0;    ///< 0: in one piece
  int sweeps = 0;
  std::int64_t renewals = 0; ///< of the halos
  std::int64_t changed = 0;  ///< sites over all ranks, by the last sweep, where that was counted
  bool repeated = false;     ///< as of LevelResult
  Traffic before{};          ///< by this rank, to bring the level to its ranks
  Traffic halos{};           ///< by this rank, to renew halos
  double seconds = 0.0;
};

struct RankedSolution {
  Rectangle owned;
  VectorField displacement; ///< of the sites that are owned, pixels
  std::vector<RankedLevel> levels;
};

/// All levels, each on as many ranks as it is worth; every rank computes its piece on its own `session`, of
/// any backend. The bits of one rank. Collective. `halos`: what brings halos, usually the ranks themselves;
/// `counted`: RankedLevel::changed; `advance` is told the image's site updates after each level. Throws what
/// Session and Ranks throw.
[[nodiscard]] RankedSolution solve_on_ranks(RankedPyramid pyramid, const Sharing& sharing, Ranks& ranks,
                                            Exchange& halos, Session& session, bool counted,
                                            const Session::Advance& advance = {});

} // namespace hdmbench
