#pragma once

#include "backends/backend.hpp"
#include "harness/check/certificate.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

struct RecordedStep;

/// How a backend is compared with the reference.
enum class Mode {
  resync, ///< every iteration starts from the reference's field: errors of one iteration
  free,   ///< each runs on its own from the start: errors that accumulate
  active, ///< the same with Work::active: nothing that can change is left out
  /// The whole pyramid by one call of Session::solve(), with Work::dense and with Work::active, and in every
  /// way to compute its coarse levels: the last field and the last count.
  pyramid,
};

enum class Verdict { // the worst last
  agree,             ///< all bits equal, at every iteration
  certified,         ///< bits differ, and rounding alone explains every differing site (certificate.hpp)
  skipped,           ///< the backend is not there
  mistrusted,        ///< nothing differed, but the scene could not have shown a difference
  disagree,          ///< a site differs without an explanation, or a count of changes is wrong
};

/// How strongly a backend was seen to agree on a scene.
enum class Tier {
  none,      ///< skipped, mistrusted or disagreeing
  certified, ///< every differing site is a near-tie within the derived bound of rounding
  bitwise,   ///< no bit differs
  exact,     ///< no bit differs, and none may on any device: every operation on this scene is exact in float
};

/// What results call them, in the order of the enumerators.
inline constexpr std::array<std::string_view, 4> mode_names{"resync", "free", "active", "pyramid"};
inline constexpr std::array<std::string_view, 5> verdict_names{"agree", "certified", "skipped", "mistrusted",
                                                               "disagree"};
inline constexpr std::array<std::string_view, 4> tier_names{"none", "certified", "bitwise", "exact"};

[[nodiscard]] constexpr const auto& names_of(Mode) {
  return mode_names;
}
[[nodiscard]] constexpr const auto& names_of(Verdict) {
  return verdict_names;
}
[[nodiscard]] constexpr const auto& names_of(Tier) {
  return tier_names;
}
template <typename Enumerator>
requires requires(Enumerator one) {
  names_of(one);
}
[[nodiscard]] constexpr std::string_view name_of(Enumerator one) {
  return names_of(one)[static_cast<std::size_t>(one)];
}

/// The first site that differs without an explanation; where all have one, the first that differs.
struct FirstDifference {
  int level = 0;
  int iteration = 0; ///< 1 is the first; in pyramid the last, after which alone there is a field
  int x = 0;
  int y = 0;
  int z = 0;                             ///< 0 of images
  std::vector<float> expected{NAN, NAN}; ///< displacement, pixels, by axis; NaN: not recorded
  std::vector<float> found{NAN, NAN};
  Certificate certificate{};
  std::string step{}; ///< of the elastic energy: what the method did, "sweep"; iteration counts these steps

  /// "level 0, iteration 2, x = 1, y = 0: expected (1.5, 0), found (1.25, 0)".
  [[nodiscard]] std::string text() const;
};

/// One backend against the reference on one scene in one mode.
struct Comparison {
  std::string backend;
  Device device;
  Mode mode = Mode::resync;
  int levels = 0;
  std::int64_t iterations = 0;
  std::int64_t sweeps = 0;         ///< compared; one, two or four an iteration (level.hpp); in pyramid done
  std::int64_t sites_compared = 0; ///< over all sweeps
  /// Over all sweeps, from the specification's answer to what the site saw before the sweep.
  std::int64_t sites_differing = 0;
  std::int64_t sites_drifted = 0;      ///< over all sweeps, from the reference's field; in resync the same
  std::int64_t not_finite = 0;         ///< of these, NaN or infinite
  std::int64_t certified_ties = 0;     ///< of the differing ones, explained by rounding
  std::int64_t uncertified = 0;        ///< of the differing ones, not explained
  double largest_gap_over_bound = 0.0; ///< over the certified sites, at most 1
  std::int64_t counts_differing = 0;   ///< sweeps after which changed() was wrong
  double largest_difference = 0.0;     ///< from the reference's field, pixels
  double seconds = 0.0;                ///< in which the backend computed and was judged
  /// The site updates that active work could leave out (RestingTiles).
  std::int64_t sites_at_rest = 0;
  bool has_hosts_laws =
      false; ///< its forces of laws of large strains are the host's: there is nothing to compare
  std::optional<FirstDifference> first{};
  /// In resync, where bits differ: which rewrites of the arithmetic make what was found, or that none does.
  std::string why{};
  /// In resync, where VerifyOptions::records: the step in which `first` differed, as its device was told it
  /// (backends/device/recording.hpp). Null: none differed, or the backend is not programmed by kernels.
  std::shared_ptr<const RecordedStep> step{};
  Verdict verdict = Verdict::skipped;
  Tier tier = Tier::none;
  std::string reason{}; ///< for mistrusted and skipped
  bool failed = false;  ///< skipped because the device broke off what it had begun, or is there no longer
  bool was_not_opened = false; ///< skipped because the device is not there or could not be opened
};

struct VerifyOptions {
  SessionOptions session;
  std::optional<int> iteration_limit; ///< per level, for a shorter run
  bool explains = true;               ///< Comparison::why, which takes up to seconds where bits differ
  bool records = false;               ///< Comparison::step: every step takes longer until one differs
};

/// Judges a backend that has to have the reference's bits: what rounding explains is wrong all the same.
void excuse_nothing(Comparison& comparison);

/// Why a mode does not apply to the scene on any backend, as a part of a sentence; empty: it is compared.
/// active where another rule or order of sites lets every site change in every sweep; pyramid where something
/// wants the host between the levels (LevelSequence::pyramid()).
[[nodiscard]] std::string why_left_out(Mode mode, const Scene& scene);

/// Runs the scene's schedule on `reference` and on all `backends` side by side and compares the whole field
/// and the count of changed sites after every sweep of every level. A site that differs is judged by
/// certificate.hpp: in resync against the reference's answer, in free against the specification's answer to
/// what the backend itself had before the sweep. In pyramid only the end is known: a field that is not the
/// reference's is certified if it is, to the bit, what the same backend made level by level and every
/// difference of that is certified. On a scene that is declared exact (Scene::exact) no difference is
/// explained, and a step that is not exact makes the comparison mistrusted. Active is skipped where it agrees
/// and no tile was ever at rest. A backend whose devices() or open() throws DeviceError is skipped with that
/// reason, and so is one that breaks off later (Comparison::failed); all others go on. An error of the
/// reference is not caught.
///
/// With the elastic energy every step of the method (sweep, residual, transfer, sum) is taken by all sessions
/// at the same time. resync: what a step made is compared on all sites, and mended where it differs; a
/// difference is certified within the bound of rounding (bounded_real.hpp) of what the step was made from;
/// Comparison::counts_differing are sums over the image (ElasticSession::dot) beyond their bound. pyramid:
/// the method runs on the backend alone; a result that differs is certified if it is, to the bit, what the
/// backend makes when every step is waited for, and all steps of resync were certified.
///
/// Returns a comparison per backend and mode that is not left out, in their orders.
[[nodiscard]] std::vector<Comparison> verify(const Scene& scene, const Backend& reference,
                                             std::span<const Backend* const> backends,
                                             const VerifyOptions& options, Progress& progress);

/// Marks what is skipped in `now` as broken off where its backend could be opened for one of `before`.
void find_lost(std::span<Comparison> now, std::span<const Comparison> before);

} // namespace hdmbench
