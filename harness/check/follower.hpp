#pragma once

#include "backends/device/recording.hpp"
#include "backends/shared/stopwatch.hpp"
#include "harness/check/compare.hpp"
#include "harness/check/verify.hpp"
#include "harness/solve/methods/solver.hpp"

#include <functional>
#include <memory>
#include <string>

/// What it takes to lead a backend along a reference, whatever the energy.
namespace hdmbench {

/// Calls open(), which throws DeviceError, unless the backend is not there or cannot solve the scene; then
/// the comparison has the reason.
template <typename Open>
Comparison begun(const Scene& scene, const Backend& backend, const SessionOptions& options, Mode mode,
                 const Open& open) {
  Comparison comparison{.backend = std::string(backend.name()), .device = {}, .mode = mode};
  try {
    comparison.device = backend.device(options);
    comparison.reason = why_not_solved(scene, backend);
    if (comparison.reason.empty()) {
      open();
    }
  } catch (const DeviceError& error) {
    comparison.reason = error.what();
    comparison.was_not_opened = true;
  }
  return comparison;
}

/// What is left of a comparison whose backend cannot go on: no verdict on the scene. TooLarge is no failure.
[[nodiscard]] Comparison broken_off(const Comparison& comparison, const DeviceError& error);

/// call(follower), unless it is skipped. A backend that fails takes its own comparison with it and no other.
template <typename Follower, typename Call>
void if_present(Follower& follower, const Call& call) {
  if (follower.session != nullptr) {
    const Stopwatch watch(follower.comparison.seconds);
    try {
      call(follower);
    } catch (const DeviceError& error) {
      follower.session.reset();
      follower.comparison = broken_off(follower.comparison, error);
    }
  }
}

/// Calls it for every follower that is there.
template <typename Followers, typename Call>
void each_present(Followers& followers, const Call& call) {
  for (auto& follower : followers) {
    if_present(follower, call);
  }
}

/// Counts one more field of the reference's extent, and by how much it is not the reference's.
void count_field(Comparison& comparison, const VectorField& reference, const FieldDifference& drift);

/// Judges every site in which a step made `found` in place of `expected`. `place`: level, iteration, step.
/// Returns whether the first difference of the comparison is one of this step now.
bool judge_step(Comparison& comparison, const VectorField& expected, const VectorField& found,
                const FirstDifference& place, const std::function<Certificate(int x, int y, int z)>& certify);

/// The same of the end of a method, of which no step is known. `explained`: rounding made the difference.
void judge_end(Comparison& comparison, const VectorField& expected, const VectorField& found,
               const FirstDifference& place, bool explained);

/// Keeps for a comparison the step of its first difference, as the device was told it.
class FirstStep {
public:
  /// Keeps nothing unless it records.
  explicit FirstStep(bool records) : recording_(records ? std::make_unique<DeviceRecording>() : nullptr) {}

  /// For SessionOptions::recording of the session that takes the steps, which must not outlive this.
  [[nodiscard]] DeviceRecording* recording() const { return recording_.get(); }

  /// Calls take(), which takes a step, and keeps it while it may become the first.
  void record(const Comparison& comparison, const std::function<void()>& take);
  /// That step made `found` in place of `expected`, and is the first (judge_step()). read(values) and
  /// write(values) are the session's, which has to be written to after that.
  void keep(Comparison& comparison, const VectorField& expected, const VectorField& found,
            const std::function<void(VectorField&)>& read,
            const std::function<void(const VectorField&)>& write);

private:
  std::unique_ptr<DeviceRecording> recording_; ///< null: it keeps nothing
};

/// What a comparison is worth.
struct Conditions {
  bool exact = false;         ///< Scene::exact
  std::string why_mistrusted; ///< turns agreement into mistrust where it is not empty
  std::int64_t sites_at_rest = 0;
};

/// Why agreement on this scene would say nothing; empty where it does. `moved`: whether any site did.
[[nodiscard]] std::string why_mistrusted(const Scene& scene, bool moved);

/// Gives the comparison its verdict and tier.
void conclude(Comparison& comparison, const Conditions& conditions);

/// verify() of a scene with the elastic energy.
[[nodiscard]] std::vector<Comparison> verify_elastic(const Scene& scene, const Backend& reference,
                                                     std::span<const Backend* const> backends,
                                                     const VerifyOptions& options, Progress& progress);

} // namespace hdmbench
