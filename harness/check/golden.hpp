#pragma once

#include "harness/check/cases.hpp"
#include "harness/check/verify.hpp"
#include "harness/solve/methods/solver.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// 64 bits that stand for a field (extent, all x, all y; -0 is 0), the same on every machine.
[[nodiscard]] std::uint64_t state_hash(const VectorField& field);

/// The same of all that a session is loaded with: extent, moduli, their inverses, targets, confidences, K,
/// candidates, update, rule, inverse curvatures, strengths, seed.
[[nodiscard]] std::uint64_t level_hash(const Level& level);

/// Hashes of what the host makes for all backends, so that a difference in libm or ITK (scene), in sampling,
/// 1/A or strengths (levels) and in the sweep are told apart.
struct GoldenInputs {
  std::uint64_t scene = 0; ///< target, confidence, modulus, K, candidates and start at full resolution
  /// level_hash() of each level, coarsest first; of the elastic energy hierarchy_hash() alone.
  std::vector<std::uint64_t> levels;
};

/// What came out of a level.
struct GoldenLevel {
  int level = 0; ///< 0: full resolution
  int iterations = 0;
  std::uint64_t hash = 0; ///< state_hash() of the displacement

  bool operator==(const GoldenLevel&) const = default;
};

/// What is golden of a case.
struct GoldenEntry {
  Case problem; ///< scene, size and method_name()
  GoldenInputs inputs;
  std::vector<GoldenLevel> levels; ///< coarsest first
};

/// How one backend did on one case.
struct GoldenOutcome {
  std::string backend;
  Device device{};
  /// agree: golden. mistrusted: as scalar, but there is nothing golden to compare with. disagree, skipped.
  Verdict verdict = Verdict::skipped;
  std::vector<GoldenLevel> levels{};
  bool is_sound = true; ///< all numbers are finite, and the last level is the same, all made by one call
  std::optional<int> first_difference{}; ///< level
  std::string reason{};                  ///< where it is not `agree`
};

/// One backend, kept open from case to case.
class GoldenSolver {
public:
  /// `backend` must outlive this object. One that is not there, or cannot be opened, says so in absence().
  GoldenSolver(const Backend& backend, const SessionOptions& options);

  [[nodiscard]] const Backend& backend() const { return *backend_; }
  /// Why the backend is not there; empty: it is.
  [[nodiscard]] const std::string& absence() const { return absence_; }
  /// Why it cannot solve the scene; empty: it can.
  [[nodiscard]] std::string absence(const Scene& scene) const;
  /// Level by level, and in one piece but where the schedule wants the host on the way
  /// (LevelSequence::pyramid()). Not yet compared: skipped, disagree where it is not sound, else agree.
  /// Throws what Session throws.
  [[nodiscard]] GoldenOutcome solve(const Scene& scene, Progress& progress);

private:
  const Backend* backend_;
  Device device_;
  std::string absence_;
  std::unique_ptr<Solver> solver_; ///< null: absent
};

struct GoldenResult {
  Case problem;
  std::string absence{}; ///< why the scene is not there; empty: it is
  GoldenInputs inputs{};
  bool known = false;                    ///< whether there is anything golden of this case
  std::string inputs_reason{};           ///< why they are not golden; empty: they are
  std::vector<GoldenOutcome> outcomes{}; ///< as the solvers, scalar first
};

/// Solves the scene on all `solvers`, scalar first, and compares with `golden`; null: there is none, so that
/// scalar's hashes are what is compared with. So it is too where the inputs are not golden.
[[nodiscard]] GoldenResult check_golden(const Scene& scene, std::span<GoldenSolver> solvers,
                                        const GoldenEntry* golden, Progress& progress);

/// Why the hashes of a case cannot become golden: scalar has none, or another backend has others. Empty: they
/// can.
[[nodiscard]] std::string doubt_about(const GoldenResult& result);

/// A golden file: {"schema": 1, "cases": [{"scene", "width", "height", "method", "inputs", "levels":
/// [{"level", "iterations", "loaded", "hash"}]}]}, hashes as 16 hexadecimal digits, levels coarsest first,
/// one to a line; "loaded" is missing where GoldenInputs has no levels.
[[nodiscard]] std::string golden_text(const std::vector<GoldenEntry>& entries);

/// `name` is what errors call the text. Throws InputError.
[[nodiscard]] std::vector<GoldenEntry> read_golden(std::string_view text, std::string_view name);

/// Returns the entries of harness/check/golden.json, as it was when the program was built.
[[nodiscard]] const std::vector<GoldenEntry>& committed_golden();

/// Null where there is none.
[[nodiscard]] const GoldenEntry* find_golden(const std::vector<GoldenEntry>& entries, const Case& problem);

/// One row of `golden`'s results, a case on a backend: {"scene", "width", "height", "method", "inputs",
/// "inputs_reason", "backend", "device", "levels": [{"level", "iterations", "hash"}], "first_difference",
/// "verdict", "reason"}; hashes as above.
[[nodiscard]] nlohmann::json golden_row(const GoldenResult& result, const GoldenOutcome& outcome);

} // namespace hdmbench
