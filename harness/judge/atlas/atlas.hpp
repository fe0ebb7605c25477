#pragma once

#include "backends/backend.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "reference/interpolation.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The failure atlas: every entry is one way in which methods fail, a family of scenes along one knob that
/// leads from where all is well to where it is not.
namespace hdmbench::atlas {

/// A scene at one value of the knob, and what its field is compared with.
struct Problem {
  Scene scene;
  ReferenceField truth{}; ///< pixels; empty where the measure needs none
};

/// What a method makes of a problem.
struct Outcome {
  VectorField displacement;            ///< full resolution, pixels
  double share_moving = 0.0;           ///< of the sites, changed by the last sweep; 0 ... 1
  std::vector<std::string> warnings{}; ///< kinds, before and after the run, each once
};

/// Series that are no method of solution: the exact fixed point and plane-stress finite elements.
inline constexpr std::string_view fixed_point_method = "fixed point";
inline constexpr std::string_view finite_elements_method = "finite elements";

/// One way to solve the problem: a line of the chart.
struct Series {
  std::string name{};                ///< as shown: "icm, center"
  std::string method{};              ///< of harness/scene/method.hpp, or one of the two above
  std::vector<std::string> adjust{}; ///< steps of families.cpp after the method was chosen
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Series, name, method, adjust)

/// Which field of an entry is shown as a picture: its x component - truth, blue negative, red positive, or
/// det(I + grad d) - 1: -1 and below, blue, is folded over, red is stretched.
struct PictureWanted {
  std::string series{};
  double knob = 0.0;   ///< one of Entry::knobs and quick_knobs
  std::string shows{}; ///< one sentence
  bool area_change = false;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(PictureWanted, series, knob, shows, area_change)

/// A family of families.json.
struct Entry {
  std::string name{};      ///< as on the command line: "start-level-late"
  std::string title{};     ///< one line
  std::string energy{};    ///< that its series minimise
  std::string mechanism{}; ///< one sentence: why
  std::string knob{};      ///< its name and unit
  std::string measure{};   ///< what is measured, and its unit
  double limit = 0.0;      ///< a value above it is a failure
  std::string survivor{};  ///< the setting that does not fail
  /// Kinds of warnings (harness/judge/diagnosis) of which every failure brings one at least, and the healthy
  /// end none; empty where nothing that a run knows tells a failure from a success.
  std::vector<std::string> warnings{};
  std::vector<double> knobs{}; ///< from healthy to harmful, rising or falling
  std::vector<double> quick_knobs{};
  std::vector<Series> series{};
  std::optional<PictureWanted> picture{};
  std::string scene{}; ///< that is shipped, its displacements scaled to `size`: strains as the thesis has
  int size = 0;        ///< pixels or voxels a side
  std::vector<std::string> problem{}; ///< steps of families.cpp that make it and its truth
  std::string error{};                ///< of families.cpp; empty: RMSD to the truth
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Entry, name, title, energy, mechanism, knob, measure, limit,
                                                survivor, warnings, knobs, quick_knobs, series, picture,
                                                scene, size, problem, error)

/// Takes steps of families.cpp in turn.
void change(Problem& problem, const std::vector<std::string>& by, double knob);

/// The sites of its scenes: those of a volume where its scene is one.
[[nodiscard]] Extent extent_of(const Entry& entry);

[[nodiscard]] Problem problem_of(const Entry& entry, double knob);

/// Returns the error of an outcome, in the unit that Entry::measure names.
[[nodiscard]] double error_of(const Entry& entry, const Problem& problem, const Outcome& outcome);

/// All entries, in the order of the page.
[[nodiscard]] const std::vector<Entry>& entries();

/// Throws InputError that lists the names.
[[nodiscard]] const Entry& find_entry(std::string_view name);

/// One method at one value of the knob.
struct Point {
  double knob = 0.0;
  std::optional<double> error{};       ///< in Entry::measure; none: not finite, or there is no field
  bool failed = false;                 ///< error above Entry::limit, or not finite
  std::vector<std::string> warnings{}; ///< kinds, before and after the run, each once
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Point, knob, error, failed, warnings)

/// One method along the knob, from the healthy to the harmful end.
struct SeriesResult {
  std::string name;
  std::string absence{}; ///< why there are no points, or none from some knob on; empty: all are there
  std::vector<Point> points{};
  std::optional<double>
      last_good{}; ///< value of the knob before the first failure; none: the first one fails
  std::optional<double> first_failed{}; ///< none: none does
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SeriesResult, name, absence, points, last_good, first_failed)

struct EntryResult {
  const Entry* entry = nullptr;
  std::vector<SeriesResult> series{};
  ScalarField picture{}; ///< as Entry::picture wants it, else empty
  double seconds = 0.0;
};

/// Runs one entry on one backend. A method that cannot run (a backend or a build without it) is a series with
/// an `absence`. Throws what the truths throw, DeviceError.
[[nodiscard]] EntryResult run_entry(const Entry& entry, const Backend& backend, bool quick,
                                    Progress& progress);

/// One row of `atlas`'s results. Writes the picture into `json_folder` where images are built, as
/// "atlas-NAME.png". Throws InputError.
[[nodiscard]] nlohmann::json atlas_row(const EntryResult& result, const std::filesystem::path& json_folder);

} // namespace hdmbench::atlas
