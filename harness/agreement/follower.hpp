#pragma once

#include "harness/agreement/verify.hpp"
#include "harness/level_sequence.hpp"

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

/// One backend that follows the reference in one mode, and all that is found about it.
class Follower {
public:
  /// A backend that cannot be opened, or cannot update as the scene wants, is skipped with the reason.
  Follower(const Backend& backend, const SessionOptions& options, const Scene& scene, Mode mode);

  void begin_level(const LevelSequence& levels, const Level& level, int index);
  /// From the field that the level began with.
  void begin_again(const Level& level);
  void follow(const ReferenceStep& step);
  /// A level without iterations still hands its field on.
  void end_level();

  /// `why_mistrusted` turns agreement into mistrust where it is not empty.
  [[nodiscard]] Comparison finish(const std::string& why_mistrusted);

private:
  /// The specification's answer to what this backend had before the sweep.
  [[nodiscard]] const VectorField& specified(const ReferenceStep& step, const VectorField& before);
  void judge_site(const ReferenceStep& step, const VectorField& before, const VectorField& expected,
                  std::size_t site);

  std::unique_ptr<Session> session_; ///< null: skipped
  bool exact_;                       ///< Scene::exact
  bool drifted_ = false; ///< in free mode: whether displacement_ is another field than the reference's
  VectorField displacement_;
  VectorField before_; ///< in free mode: displacement_ of the sweep before
  VectorField answer_; ///< of the specification, where it is not the reference's
  VectorField begin_;  ///< of the level
  Comparison comparison_;
};

} // namespace hdmbench
