#pragma once

#include "harness/check/compare.hpp"
#include "harness/check/verify.hpp"
#include "harness/scene/level_sequence.hpp"

#include <functional>
#include <memory>
#include <string>

namespace hdmbench {

/// What the reference did in one sweep of one level.
struct ReferenceStep {
  const Level& level;
  int level_index;
  int iteration; ///< 1 is the first
  int number;    ///< of the sweep, since the level was loaded
  const VectorField& before;
  const VectorField& after;
  std::int64_t changed; ///< sites that differ between the two
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

/// What differs at a site, without energies and certificate.
[[nodiscard]] FirstDifference difference_at(std::size_t site, const VectorField& expected,
                                            const VectorField& found);

/// Counts a site that differs; describe() says what is kept of it where it is the first of its kind.
void count_site(Comparison& comparison, const Certificate& certificate,
                const std::function<FirstDifference()>& describe);

/// Counts what differs at the end of a method, of which only a field of so many sites is known;
/// describe(site) says what is kept of the first site. `explained`: rounding made the difference.
void count_end(Comparison& comparison, const FieldDifference& difference, Extent extent, bool explained,
               const std::function<FirstDifference(std::size_t site)>& describe);

/// What differs at a site, the energies with all else as in `before`.
[[nodiscard]] FirstDifference describe_difference(const ReferenceStep& step, const VectorField& before,
                                                  const VectorField& expected, const VectorField& found,
                                                  std::size_t site);

/// One backend that follows the reference sweep by sweep in one mode, and all that is found about it. In free
/// and active it is on its own.
class Follower {
public:
  /// A backend that cannot be opened, or cannot update as the scene wants, is skipped with the reason.
  /// `options` but for the work, which goes by the mode.
  Follower(const Backend& backend, SessionOptions options, const Scene& scene, Mode mode);

  void begin_level(const LevelSequence& levels, const Level& level, int index);
  /// From the field that the level began with.
  void begin_again(const Level& level);
  void follow(const ReferenceStep& step);
  /// A level without iterations still hands its field on.
  void end_level();

  [[nodiscard]] Comparison finish(const Conditions& conditions);

  /// Null where the backend is skipped.
  [[nodiscard]] Session* session() { return session_.get(); }
  /// So far.
  [[nodiscard]] const Comparison& comparison() const { return comparison_; }
  /// What the backend itself has, and how many sites its last sweep on this level really changed.
  [[nodiscard]] const VectorField& displacement() const { return displacement_; }
  [[nodiscard]] std::int64_t last_changed() const { return last_changed_; }

private:
  [[nodiscard]] bool is_on_its_own() const { return comparison_.mode != Mode::resync; }
  /// The specification's answer to what this backend had before the sweep.
  [[nodiscard]] const VectorField& specified(const ReferenceStep& step, const VectorField& before);
  void judge_site(const ReferenceStep& step, const VectorField& before, const VectorField& expected,
                  std::size_t site);

  std::unique_ptr<Session> session_; ///< null: skipped
  bool exact_;                       ///< Scene::exact
  bool drifted_ = false; ///< on its own: whether displacement_ is another field than the reference's
  VectorField displacement_;
  std::int64_t last_changed_ = 0;
  VectorField before_; ///< on its own: displacement_ of the sweep before
  VectorField answer_; ///< of the specification, where it is not the reference's
  VectorField begin_;  ///< of the level
  Comparison comparison_;
};

} // namespace hdmbench
