#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// What `hdmbench accuracy` wrote, typed and checked. Lengths and displacements are pixels of the full image.
namespace hdmbench::report {

class JsonReader;

/// Root of the mean squared distance to a truth (thesis 5.1); none where the truth or a finite field is
/// missing.
struct Rmsd {
  std::optional<double> all;  ///< over all sites, as in the thesis
  std::optional<double> free; ///< over the sites that no condition prescribes
};

/// The same distance near material interfaces and away from them, free sites only, against FEM.
struct InterfaceRmsd {
  std::optional<double> near; ///< within 5 pixels of an interface
  std::optional<double> elsewhere;
  std::int64_t near_sites = 0;
  std::int64_t elsewhere_sites = 0;
};

/// total^2 = model^2 + optimisation^2 + 2 covariance + remainder, against FEM with one Poisson ratio.
struct Decomposition {
  double poisson = 0.0;
  double total = 0.0;        ///< RMSD(field, FEM)
  double model = 0.0;        ///< RMSD(fixed point, FEM)
  double optimisation = 0.0; ///< RMSD(field, fixed point)
  double covariance = 0.0;   ///< px^2
  double remainder = 0.0;    ///< px^2, at rounding
};

/// What float32 costs: the run against the same schedule in double.
struct Arithmetic {
  std::optional<double> run_rmsd;  ///< after the whole run, each on its own
  std::int64_t iterations = 0;     ///< compared one by one, each from the same field
  std::int64_t steps_compared = 0; ///< components of sites
  std::int64_t steps_differing = 0;
  std::optional<double> largest_gap_over_bound; ///< none: no step differs
  std::optional<double> iteration_rmsd;         ///< after one iteration from the same field
  std::int64_t beyond_bound = 0; ///< differing steps that the derived bound does not explain: a failure
};

/// Whole runs with so many iterations on every level; all of one length >= 1.
struct Convergence {
  std::vector<double> iterations_per_level; ///< rising
  std::vector<double> rmsd_to_fem;
  std::vector<double> rmsd_to_fixed_point;
  std::vector<double> mean_energy;
};

/// Displacement along four lines; NaN where there is no value.
struct Profiles {
  std::vector<double> horizontal; ///< dx along the middle row, `width` values
  std::vector<double> vertical;   ///< dy along the middle column, `height` values
  std::vector<double> falling;    ///< |d| from the top left to the bottom right corner
  std::vector<double> rising;     ///< |d| from the bottom left to the top right corner, as many values
};

struct LevelIterations {
  std::int64_t level = 0; ///< 0 is the full image
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t iterations = 0;
};

/// Both components along the middle row and the middle column of one level.
struct LevelProfiles {
  struct Components {
    std::vector<double> x;
    std::vector<double> y;
  };
  std::int64_t level = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  Components horizontal; ///< `width` values each
  Components vertical;   ///< `height` values each
};

/// Pictures of field - truth, one pixel per site.
struct Differences {
  std::filesystem::path magnitude; ///< black 0 ... light yellow `limit`
  std::filesystem::path x;         ///< blue -limit ... white 0 ... red +limit
  std::filesystem::path y;         ///< as x
  double limit = 0.0;              ///< > 0
  std::string against;             ///< "fem nu 0"
};

/// x0, y0, x1, y1, ...: pixels, y down, at least two points.
using Polyline = std::vector<double>;

/// One field judged against the truths.
struct AccuracyRow {
  std::size_t context = 0; ///< index into Results::contexts
  std::string scene;
  std::string title;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0; ///< the scene's
  std::string method;   ///< icm, sequential, fixed-point, fem, fem-coarse, interpolation, b-spline
  std::string variant;  ///< empty: as the scene says
  std::string note;
  std::optional<double> poisson_used; ///< of this very solve; always there for fem and fem-coarse
  std::string backend;                ///< empty for truths and rivals
  std::string device;
  std::string status;          ///< "ok", else why there is no result
  bool valid = false;          ///< false: not finite, or other bits than scalar
  std::vector<double> seconds; ///< raw samples; never empty unless `failed`
  std::optional<double> seconds_median;
  std::optional<std::int64_t> iterations; ///< over all levels
  std::vector<LevelIterations> levels;    ///< coarsest first; empty or summing to `iterations`
  std::optional<double> mean_energy;
  Rmsd to_fem;     ///< FEM with the scene's Poisson ratio
  Rmsd to_fem_nu0; ///< FEM with Poisson ratio 0
  Rmsd to_fixed_point;
  std::optional<InterfaceRmsd> interface; ///< none where the scene has one material
  std::vector<Decomposition> decompositions;
  std::optional<Arithmetic> arithmetic;
  std::optional<Convergence> convergence;
  std::optional<Profiles> profiles;
  std::vector<LevelProfiles> level_profiles; ///< coarsest first
  std::optional<Differences> differences;
  double grid_spacing = 0.0;
  std::vector<Polyline> grid;       ///< deformed; empty: none
  std::vector<Polyline> interfaces; ///< deformed outlines of the materials, beside `grid`

  /// Without a figure to show.
  [[nodiscard]] bool failed() const { return status != "ok" || !valid; }
  /// Failed for want of a backend.
  [[nodiscard]] bool skipped() const { return status.starts_with("skipped"); }
  /// Why it failed, a plain text.
  [[nodiscard]] std::string failure() const;
};

/// One element of "results". Throws InputError naming file and key for what is missing, mistyped or
/// contradicts itself: a negative RMSD, lists of different lengths, a decomposition that does not add up to
/// 1e-9 (total^2 + 1) px^2, more differing steps than were compared.
[[nodiscard]] AccuracyRow read_accuracy(const JsonReader& json);

} // namespace hdmbench::report
