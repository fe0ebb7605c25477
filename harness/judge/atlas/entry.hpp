#pragma once

#include "harness/scene/scene.hpp"
#include "harness/scene/sites.hpp"
#include "reference/interpolation.hpp"

#include <functional>
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

/// One way to solve the problem: a line of the chart.
struct Series {
  std::string_view name;   ///< as shown: "icm, center"
  std::string_view method; ///< of harness/scene/method.hpp, or truth_methods
  std::optional<int> iterations{};
  /// Changes the scene after the method was chosen; may be null.
  void (*adjust)(Scene& scene, double knob) = nullptr;
};

/// Methods that most entries compare, with a change of the scene after the method was chosen.
[[nodiscard]] std::vector<Series> usual_series(void (*adjust)(Scene& scene, double knob) = nullptr);

/// RMSD to the truth over all sites, pixels.
[[nodiscard]] double rmsd_to_truth(const Problem& problem, const Outcome& outcome);

/// Series that are no method of solution: the exact fixed point and plane-stress finite elements.
inline constexpr std::string_view fixed_point_method = "fixed point";
inline constexpr std::string_view finite_elements_method = "finite elements";

/// Which field of an entry is shown as a picture: its x component - truth, blue negative, red positive, or
/// det(I + grad d) - 1: -1 and below, blue, is folded over, red is stretched.
struct PictureWanted {
  std::string_view series;
  double knob = 0.0;      ///< one of Entry::knobs and quick_knobs
  std::string_view shows; ///< one sentence
  bool area_change = false;
};

struct Entry {
  std::string_view name;                                     ///< as on the command line: "start-level"
  std::string_view title;                                    ///< one line
  std::string_view energy = energy_names[0];                 ///< that its series minimise
  std::string_view mechanism;                                ///< one sentence: why
  std::string_view knob{};                                   ///< its name and unit
  std::string_view measure = "RMSD to the fixed point [px]"; ///< what is measured, and its unit
  double limit = 0.5;                                        ///< a value above it is a failure
  std::string_view survivor{};                               ///< the setting that does not fail
  /// Kinds of warnings (harness/judge/diagnosis) of which every failure brings one at least, and the healthy
  /// end none; empty where nothing that a run knows tells a failure from a success.
  std::vector<std::string_view> warnings{};
  std::vector<double> knobs; ///< from healthy to harmful, rising or falling
  std::vector<double> quick_knobs;
  std::vector<Series> series = usual_series();
  std::function<Problem(double knob)> problem{};
  double (*error)(const Problem& problem, const Outcome& outcome) = rmsd_to_truth;
  std::optional<PictureWanted> picture{};
};

/// All entries, in the order of the page.
[[nodiscard]] const std::vector<Entry>& entries();

/// Throws InputError that lists the names.
[[nodiscard]] const Entry& find_entry(std::string_view name);

// What entries build their scenes of.

/// A shipped scene of `size` x `size` pixels with its displacements multiplied by `size` / 300, so that
/// strains are those of the thesis at every size.
[[nodiscard]] Scene shipped(const char* name, int size);

/// The square scene (left border dx < 0, bottom border dy > 0, the other two 0) of one material.
[[nodiscard]] Scene one_material(int size);

/// Multiplies both components by `factor`.
void scale(VectorField& field, float factor);

/// Gives every site the modulus `modulus_at`(column, row) MPa.
void set_moduli(Scene& scene, const std::function<float(int x, int y)>& modulus_at);

/// Inside the square in the middle, a third of the image wide, of the square scene.
[[nodiscard]] bool in_inclusion(Extent extent, int x, int y);

/// Whether a site of an image is stiff.
using Where = std::function<bool(Extent extent, int x, int y)>;
inline constexpr int two_material_side = 96; ///< pixels

/// The square scene, 10 MPa and `ratio` times that where `is_stiff`.
[[nodiscard]] Scene of_two_materials(const Where& is_stiff, double ratio);

/// Prescribes both components of a site, confidence 1.
void hold(Scene& scene, int x, int y, float dx, float dy);

/// The scene against its own fixed point.
[[nodiscard]] Problem against_fixed_point(Scene scene);

// The groups of entries, each a table in a file of its own.
[[nodiscard]] std::vector<Entry> schedule_entries();
[[nodiscard]] std::vector<Entry> scene_entries();
[[nodiscard]] std::vector<Entry> elastic_entries();

} // namespace hdmbench::atlas
