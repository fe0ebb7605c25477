#pragma once

#include "kernels/data/level.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench {

/// Which fine site a coarse one stands for.
enum class Alignment {
  corner, ///< first and last sites coincide on all levels, so that conditions on the border exist on every
          ///< level
  center, ///< pixel areas coincide: a border one pixel wide is lost on coarse levels
};

/// Which modulus a coarse site has.
enum class Material {
  nearest, ///< that of the site it samples: the thesis
  mean,    ///< the arithmetic mean over the sites it stands for: thin layers keep their share on every level
};

/// Extents of all levels, index 0 the full image, the last one 1 x 1. Per axis: n, then the powers of two
/// below n in falling order, then 1 until the longer axis has arrived: 300 gives 300 256 128 ... 2 1
/// (thesis 4.11). A volume, which must have two sites along every axis, ends with 2 x 2 x 2. Throws as
/// require_sides() does.
[[nodiscard]] std::vector<Extent> pyramid_extents(Extent full);

/// The index on an axis of `fine` sites that site `coarse_index` of an axis of `coarse` sites samples. Exact
/// integer arithmetic, halves round up; an axis of one site samples the middle.
[[nodiscard]] int sampled_index(int coarse_index, int coarse, int fine, Alignment alignment);

/// sampled_index() of every site of an axis.
[[nodiscard]] std::vector<int> sampled_indices(int coarse, int fine, Alignment alignment);

/// The sites that those of a level of `extent` sample.
struct SampledSites {
  SampledSites(Extent full_, Extent extent, Alignment alignment);

  /// Return the site of `full` that the level's site (x, y, z) samples, and the first one of its row.
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return row(y, z) + static_cast<std::size_t>(axes[0][static_cast<std::size_t>(x)]);
  }
  [[nodiscard]] std::size_t row(int y, int z) const {
    return full.index(0, axes[1][static_cast<std::size_t>(y)], axes[2][static_cast<std::size_t>(z)]);
  }

  Extent full;
  std::array<std::vector<int>, 3> axes; ///< sampled_indices() along each
};

/// Target, confidence, inputs and moduli of `full` at the sampled sites, the moduli as `material` says;
/// penalty, steps, update, rule, strengths and seed as they are. The inverse curvature is left empty: it
/// belongs to the level's own neighbours.
[[nodiscard]] Level sample_level(const Level& full, Extent extent, Alignment alignment,
                                 Material material = Material::nearest);

/// Level::inputs at the sampled sites.
[[nodiscard]] std::vector<ScalarField> sample_inputs(const Level& full, Extent extent, Alignment alignment);

/// Numbers of sites, by SiteKind.
using SiteCounts = std::array<std::int64_t, site_kinds>;

/// How many sites of each kind the level has that samples `full` (nearest modulus) at `extent`. Nothing as
/// large as the level is allocated.
[[nodiscard]] SiteCounts count_site_kinds(const Level& full, Extent extent, Alignment alignment);

/// The two coarse sites around a fine one on an axis and the weight of the second, the first having the rest.
struct Interpolation {
  int first = 0;
  int second = 0;
  float weight = 0.0F;
};

/// How each of `fine` sites on an axis is interpolated from `coarse` ones.
[[nodiscard]] std::vector<Interpolation> interpolations(int coarse, int fine, Alignment alignment);

/// A displacement's way to a finer level, row by row, as projection.inc has it; in a volume between two
/// slices last.
class Projection {
public:
  /// Where components lie, as many as there are axes.
  template <typename Number>
  using Components = std::array<Number*, 3>;

  /// The components of `coarse`, which must outlive this object: one float per site of its extent.
  Projection(Components<const float> coarse, Extent coarse_extent, Extent fine, Alignment alignment);

  /// A coarse row at all fine columns.
  struct WideRow {
    std::array<std::vector<float>, 3> values; ///< by component
    int coarse = -1;                          ///< which row of all slices
  };
  /// The two coarse rows of a slice that a fine row lies between.
  struct Slice {
    WideRow upper;
    WideRow lower;
  };
  /// Those that the last fine row lay between. Fine rows in rising order share them; one for each thread.
  struct CoarseRows {
    Slice near;
    Slice far; ///< in a volume
  };

  /// Row y of all rows of the fine level into the components of a field of its extent.
  void row(int y, CoarseRows& rows, Components<float> to) const;
  /// All rows, by so many threads.
  void all_rows(Components<float> to, int threads) const;

private:
  void widen(int coarse_row, WideRow& to) const;
  void between(int coarse_slice, Interpolation rows, Slice& slice) const;

  Components<const float> coarse_;
  Extent coarse_extent_;
  Extent fine_;
  std::vector<int> west_; ///< per fine column
  std::vector<int> east_;
  std::vector<float> weight_; ///< of east
  std::vector<Interpolation> rows_;
  std::vector<Interpolation> slices_;
};

/// A displacement from the level above.
[[nodiscard]] VectorField prolongate(const VectorField& coarse, Extent fine, Alignment alignment);

/// A displacement of the full image at the sites of `extent`, nearest neighbour: where a pyramid starts from.
[[nodiscard]] VectorField sample_field(const VectorField& full, Extent extent, Alignment alignment);

/// One level of a Pyramid.
struct PyramidLevel {
  Extent extent;
  int sweeps = 0;                    ///< >= 0
  std::vector<float> strengths = {}; ///< Level::strengths of these sweeps
};

/// A whole solution in one piece (thesis Alg. 3): what a device can compute without the host in between. Each
/// level samples `full` (nearest modulus) and begins with the field of the one before, projected; the first
/// one begins with the null field.
struct Pyramid {
  const Level* full = nullptr; ///< not owned; rule, update, steps, penalty and seed are those of all levels
  Alignment alignment = Alignment::corner;
  std::vector<PyramidLevel> levels =
      {}; ///< in the order they are computed; the last has the extent of `full`
};

} // namespace hdmbench
