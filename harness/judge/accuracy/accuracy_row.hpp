#pragma once

#include "harness/judge/accuracy/accuracy.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// Root of the mean squared distance to a truth (thesis 5.1); none where the truth or a finite field is
/// missing.
struct Rmsd {
  std::optional<double> all{};  ///< over all sites, as in the thesis
  std::optional<double> free{}; ///< over the sites that no condition prescribes
};

/// The same distance near material interfaces and away from them, free sites only, against FEM.
struct InterfaceRmsd {
  std::optional<double> near{}; ///< within 5 pixels of an interface
  std::optional<double> elsewhere{};
  std::int64_t near_sites = 0;
  std::int64_t elsewhere_sites = 0;
};

/// What float32 costs: the run against the same schedule in double.
struct Arithmetic {
  /// One by one, each from the same field. See ArithmeticError.
  struct Iterations {
    std::int64_t iterations = 0;
    std::int64_t steps_compared = 0;
    std::int64_t steps_differing = 0;
    std::int64_t beyond_bound = 0;
    std::optional<double> largest_gap_over_bound{}; ///< none: no step differs
    std::optional<double> rmsd{};                   ///< after one iteration
  };
  Iterations resynchronised;
  std::optional<double> run_rmsd{}; ///< after the whole run, each on its own
};

/// Both components along the middle row and the middle column of one level; NaN where there is no value.
struct LevelProfiles {
  struct Components {
    std::vector<double> x;
    std::vector<double> y;
  };
  int level = 0;
  int width = 0;
  int height = 0;
  Components horizontal; ///< `width` values each
  Components vertical;   ///< `height` values each
};

/// Pictures of field - truth, one pixel per site; files relative to the result file.
struct Differences {
  struct Files {
    std::string magnitude; ///< black 0 ... light yellow `limit`
    std::string x;         ///< blue -limit ... white 0 ... red +limit
    std::string y;         ///< as x
  };
  Files pictures;
  double limit = 0.0;  ///< > 0
  std::string against; ///< "fem nu 0"
};

/// One row of `accuracy`'s results: one field judged against the truths, see JudgedField. Lengths and
/// displacements are pixels of the full image, figures of the truth to four significant digits; what does not
/// apply is left out.
struct AccuracyRow {
  struct Grid {
    double spacing = 0.0; ///< pixels between lines
    std::vector<figures::Polyline> lines;
  };
  std::string scene{};
  std::string title{};
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0; ///< the scene's
  std::string method{};
  std::string variant{};
  std::string note{};
  /// That the field minimises: of energy_names, or "none" (interpolation, registration, a file of before).
  std::string energy = "none";
  std::string backend{}; ///< empty for truths and rivals
  std::string device{};
  std::string status{};                 ///< "ok", else why there is no result
  bool valid = false;                   ///< false: not finite, or other bits than scalar
  std::optional<double> poisson_used{}; ///< of this very solve; always there for fem and fem-coarse
  std::vector<double> seconds{};        ///< raw samples; never empty unless failed()
  std::optional<double> seconds_median{};
  std::optional<double> mean_energy{};
  Rmsd to_fem{};     ///< FEM with the scene's Poisson ratio
  Rmsd to_fem_nu0{}; ///< FEM with Poisson ratio 0
  Rmsd to_fixed_point{};
  std::optional<InterfaceRmsd> interface {}; ///< none where the scene has one material
  std::optional<std::int64_t> iterations{};  ///< over all levels
  std::vector<LevelResult> levels{};         ///< coarsest first; empty or summing to `iterations`
  std::optional<double> fine_sweep_equivalents{};
  std::vector<JudgedField::Split> decompositions{};
  std::optional<Arithmetic> arithmetic{};
  std::optional<Convergence> convergence{};
  std::optional<figures::Profiles> profiles{};
  std::vector<LevelProfiles> level_profiles{}; ///< coarsest first
  std::optional<Differences> differences{};
  std::optional<Grid> grid{};
  std::vector<figures::Polyline> interfaces{}; ///< deformed outlines of the materials, beside `grid`

  /// Without a figure to show.
  [[nodiscard]] bool failed() const { return status != "ok" || !valid; }
  /// Failed for want of a backend.
  [[nodiscard]] bool skipped() const { return status.starts_with("skipped"); }
  /// Why it failed, a plain text.
  [[nodiscard]] std::string failure() const {
    return status != "ok" ? status : "not finite, or not the bits of scalar";
  }
};

void list_fields(Fields& fields, AccuracyRow& row);

/// Rows of one scene. Where `pictures` is not empty the difference images are written into that folder and
/// named relative to `json_folder`. Throws InputError where a file cannot be written.
[[nodiscard]] std::vector<AccuracyRow> accuracy_rows(const Scene& scene, const SceneAccuracy& accuracy,
                                                     const std::filesystem::path& pictures,
                                                     const std::filesystem::path& json_folder);

} // namespace hdmbench
