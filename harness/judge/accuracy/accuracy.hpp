#pragma once

#include "backends/backend.hpp"
#include "harness/judge/accuracy/arithmetic.hpp"
#include "harness/judge/accuracy/figures.hpp"
#include "harness/judge/accuracy/truths.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// The whole pyramid run with different numbers of iterations per level (thesis Figs. 5.3a, 5.8a, 5.11, ...).
struct Convergence {
  std::vector<int> iterations_per_level;
  std::vector<double> rmsd_to_fem;         ///< Poisson ratio of the scene, pixels
  std::vector<double> rmsd_to_fixed_point; ///< pixels
  std::vector<double> mean_energy;
};

/// A deformed grid and the deformed material interfaces.
struct GridFigure {
  int spacing = 0; ///< pixels between lines
  std::vector<figures::Polyline> lines;
  std::vector<figures::Polyline> interfaces;
};

/// One field against the truths.
struct JudgedField {
  /// icm, sequential, fixed-point, fem, fem-coarse, interpolation, b-spline, or one of elastic_methods()
  std::string method;
  std::string variant;                ///< what differs from the scene's own schedule; empty: nothing
  std::string note;                   ///< for people: what the variant shows, or how the run ended
  std::optional<EnergyModel> energy;  ///< that it minimises; none: interpolation, registration
  std::optional<double> poisson_used; ///< of a finite element solution
  std::string backend;                ///< of icm, sequential and the elastic methods
  Device device;
  std::string status = "ok"; ///< else why there is no result
  /// A result, finite, and the bits of scalar where a backend computed it; of a registration, one that found
  /// its way.
  bool valid = true;
  std::vector<double> seconds; ///< raw samples
  std::vector<LevelResult> levels;
  ReferenceField field;     ///< empty without a result
  double mean_energy = 0.0; ///< the thesis's, of any field
  Deviations deviations;
  struct Split {
    double poisson = 0.0;
    Decomposition parts;
  };
  std::vector<Split> decompositions;         ///< of icm and sequential, one per Poisson ratio
  std::optional<ArithmeticError> arithmetic; ///< of icm
  std::optional<double> rmsd_to_double; ///< of icm: float32 against double over the whole schedule, pixels
  std::optional<Convergence> convergence;
  std::optional<figures::Profiles> profiles;
  std::vector<figures::LevelProfile> level_profiles;
  std::optional<GridFigure> grid;
  bool with_difference = false; ///< the picture of field - finite elements is wanted
};

struct AccuracyOptions {
  SessionOptions session{};
  int repeats = 3;            ///< samples of seconds per backend
  bool quick = false;         ///< no variants, no other backends' arithmetic, no convergence
  int arithmetic_stride = 10; ///< see measure_arithmetic
  bool registration = false;  ///< also the elastic registration of the pictures (thesis 5.11); needs ITK
};

struct SceneAccuracy {
  Truths truths;
  std::vector<JudgedField> rows;
};

/// What the elastic registration, a rival, is called.
inline constexpr std::string_view registration_name = "b-spline";

/// Why the field that a registration found cannot be taken for one: it moves a site by more than the image is
/// long, or is farther from the truth than no displacement at all. Empty where neither holds.
[[nodiscard]] std::string why_astray(const ReferenceField& found, const ReferenceField& truth);

/// Solves the scene by every method of its energy and measures each field against the truths. The first
/// backend is the reference for bits; it also runs the sequential method. Throws InputError as find_truths
/// does; a backend that is not there becomes a row without result.
[[nodiscard]] SceneAccuracy measure_accuracy(const Scene& scene, std::span<const Backend* const> backends,
                                             const AccuracyOptions& options, Progress& progress);

} // namespace hdmbench
