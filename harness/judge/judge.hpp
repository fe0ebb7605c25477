#pragma once

#include "backends/backend.hpp"
#include "harness/judge/truths.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What `accuracy` and `tradeoff` have in common: one scene, its truths, and rows of methods and rivals that
/// are timed and measured against them.
namespace hdmbench {

enum class JudgedStatus {
  ok,
  unverified, ///< solved, but the field is not the reference's to the bit for the same setting
  failed,     ///< threw, not finite, or diverged
  skipped,    ///< the backend is not there, or this method or rival is not for such a scene
};

/// In results, in the order of the enumerators.
inline constexpr std::array<std::string_view, 4> status_names{"ok", "unverified", "failed", "skipped"};

[[nodiscard]] inline std::string_view name_of(JudgedStatus status) {
  return status_names.at(static_cast<std::size_t>(status));
}

/// One setting of one method or rival on one backend, against the truths.
struct Judged {
  std::string method; ///< of harness/scene/method.hpp, a rival's name, or what a command calls it
  bool is_rival = false;
  std::string variant{};                ///< what differs from the scene's own schedule; empty: nothing
  std::string note{};                   ///< for people: what the variant shows, or how the run ended
  std::string effort{};                 ///< for people: "4 cycles", "tolerance 1e-04"
  std::optional<int> told{};            ///< the --iterations of a method in `tradeoff`
  std::string_view energy = "none";     ///< that it minimises; of interpolation none
  std::optional<double> poisson_used{}; ///< of finite elements, and of the elastic energy in `tradeoff`
  std::string backend{};                ///< empty for rivals
  Device device{};
  JudgedStatus status = JudgedStatus::ok;
  std::string reason{};                           ///< why the status is not ok
  std::vector<double> seconds{};                  ///< raw samples of the whole solution; none without a field
  std::vector<LevelResult> levels{};              ///< of methods
  std::optional<double> fine_sweep_equivalents{}; ///< site updates over sites of the image; none for rivals
  nlohmann::json differences{};        ///< the picture of JudgeOptions::pictures: {pictures, limit, against}
  std::optional<double> mean_energy{}; ///< the thesis's, of any field; where it knows the scene
  Deviations deviations{};             ///< where there are seconds
  std::optional<double> asked{};       ///< the accuracy that was asked for, pixels
  std::optional<double> estimated{};   ///< the method's own estimate, pixels
  bool is_on_front = false; ///< median seconds against error_to_chart(), over all rows of status ok

  /// Sets the status, and why it is not ok.
  void fail(JudgedStatus why, std::string what) {
    status = why;
    reason = std::move(what);
  }
};

/// Returns the RMSD to finite elements with Poisson ratio 0; where no energy but the elastic one knows the
/// scene, to the scene's own. Pixels.
[[nodiscard]] inline double error_to_chart(const Judged& row) {
  return row.deviations.to_fem_no_poisson.value_or(row.deviations.to_fem);
}

/// Returns what law of large strains the scene's tissues have, as it stands in a result file; null: none.
[[nodiscard]] nlohmann::json law_of(const Scene& scene);

/// The row as it stands in a result file. Lengths and displacements are pixels; what does not apply is left
/// out.
[[nodiscard]] nlohmann::json to_json(const Scene& scene, const Judged& row);

/// What else solves a scene. Names beside those of the methods.
inline constexpr std::array<std::string_view, 8> rival_names{
    "fem", "fem-cg", "fem-amg", "fem-coarse", "newton", "xpbd", "fixed-point", "interpolation"};

/// One setting of a rival.
struct Rival {
  Judged told;                           ///< how its row begins
  std::function<ReferenceField()> solve; ///< the whole solution, assembly included; throws InputError
  const SolvedTruth* solved = nullptr;   ///< where it is one of the truths: its first sample
  std::string refusal{};                 ///< why it is not solved; empty: it is
};

/// All settings of the rivals in the order of their names: finite elements factorised and by conjugate
/// gradients, and by multigrid of others where the build has it, with Poisson ratio 0 and the scene's, coarse
/// finite elements, the fixed point, interpolation of the conditions. Both must outlive them. With `quick`
/// one setting of each.
[[nodiscard]] std::vector<Rival> rivals(const Scene& scene, const Truths& truths, bool quick);
/// The same of a scene that is_of_tissue(): finite elements factorised; by laws Newton's method, and
/// position-based dynamics as simulators have them, at rising numbers of sweeps.
[[nodiscard]] std::vector<Rival> rivals_of_tissue(const Scene& scene, const Truths& truths, bool quick);

/// Where a method is measured.
enum class Where {
  everywhere,
  main_place, ///< on JudgeOptions::charted; else on the CPU, with the most threads, or on the reference
              ///< where no other updates so
  reference,
};

/// One setting of a method.
struct Setting {
  Judged told; ///< how its rows begin; with Judged::asked it is what `run --accuracy` does
  Scene scene;
  Where where = Where::everywhere;
};

struct JudgeOptions {
  SessionOptions session{};
  int repeats = 3;                    ///< samples per row, >= 1, fewer where they take long
  std::vector<std::string> charted{}; ///< backends that are Where::main_place; empty: see there
  std::vector<std::string> methods{}; ///< of `tradeoff`: names of methods and rivals; empty: all
  bool quick = false;                 ///< of `tradeoff` fewer efforts, of `accuracy` no variants
  /// Told all rows so far whenever there is another one; null: nobody is.
  std::function<void(const std::vector<Judged>& rows)> heard{};
  std::filesystem::path pictures{}; ///< where the first field of icm on an image is drawn; empty: nowhere
};

class Judge {
public:
  /// All must outlive the judge. The first backend is the reference for bits. Throws InputError as
  /// find_truths does.
  Judge(const Scene& scene, std::span<const Backend* const> backends, const JudgeOptions& options,
        Progress& progress);

  [[nodiscard]] const Truths& truths() const { return truths_; }
  [[nodiscard]] std::vector<Judged>& rows() { return rows_; }

  /// Adds a row for each backend that the setting is measured on; what fails is a row with the reason. The
  /// field is compared with the reference's, which is not timed where nobody wants it. Returns the index of
  /// the first of the new rows.
  std::size_t add(Setting setting);
  void add(const Rival& rival);

private:
  /// A backend with its sessions, or why it is not there.
  struct Place {
    Place(const Backend& backend_, const SessionOptions& options);

    const Backend* backend;
    Solver solver;
    Device device{};
    std::string missing{}; ///< empty: it is there
  };
  /// What a setting comes to on a place.
  struct Found {
    VectorField displacement;
    std::vector<LevelResult> levels{};
    double fine_sweep_equivalents = 0.0;
    std::optional<double> estimated{};
    std::string unmet{}; ///< why it is not as accurate as was asked for
  };

  [[nodiscard]] std::vector<const Place*> main_places(Update update) const;
  [[nodiscard]] Found solve_on(Place& place, Setting& setting, Progress& progress) const;
  void judge_on(Place& place, Setting& setting, Judged& row);
  void judge_rival(const Rival& rival, Judged& row);
  void tell() const;
  /// Adds samples of `solve` to the row's, after a call of `warm_up` that is not timed. Returns whether there
  /// is a field; what is thrown is the reason why not.
  bool sample(Judged& row, const std::function<void()>& solve,
              const std::function<void()>& warm_up = {}) const;
  /// Measures the field. Returns whether it is one: finite, and no larger than any displacement can be.
  bool measure_field(Judged& row, const ReferenceField& field) const;
  /// Draws how far the field is from finite elements without Poisson effect beside the results, a pixel a
  /// site: black 0 ... light yellow the largest.
  void draw_difference(Judged& row, const ReferenceField& field);
  /// The row is unverified where its field is not the reference's to the bit.
  void check_bits(Judged& row, const VectorField& found) const;

  const Scene& scene_;
  JudgeOptions options_;
  Progress& progress_;
  std::vector<Place> places_; ///< the reference first
  double largest_ = 0.0;      ///< of known displacements, pixels
  Truths truths_;
  VectorField expected_; ///< the reference's field for the present setting; empty: it has none
  std::string reason_without_expected_;
  std::vector<Judged> rows_;
};

} // namespace hdmbench
