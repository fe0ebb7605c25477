#pragma once

#include "backends/backend.hpp"
#include "backends/pieces/elastic_pieces.hpp"
#include "backends/pieces/level_pieces.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace hdmbench {

/// A session that cuts an image that is too large for one session of its backend, and no other, into 2, 4, 8
/// ... pieces until they fit (LevelPieces). The same bits. Not for sequential updates: these are TooLarge, as
/// is what does not fit in the smallest pieces.
class CutSession final : public Session {
public:
  /// `open` makes another session of the backend, with an empty name; called at once for the one that has the
  /// whole image, and by load() for those of pieces.
  explicit CutSession(std::function<std::unique_ptr<Session>()> open);

  std::optional<double> device_seconds() override;

private:
  void do_load(const Level& level) override;
  void do_write(const VectorField& displacement) override;
  void do_step(int first, int sweeps) override;
  void do_read(VectorField& displacement) override;
  std::int64_t do_changed() override;
  void do_load_pyramid(const Pyramid& pyramid) override;
  void do_solve(const Advance& advance) override;

  /// Loads pieces; `error` is what the whole image met. Throws TooLarge.
  void load_pieces(const Level& level, const TooLarge& error);

  std::unique_ptr<Session> whole_;
  LevelPieces pieces_;
  bool is_cut_ = false;       ///< the level that was loaded last
  bool in_one_piece_ = false; ///< the pyramid is the session's that has the whole image
};

/// Cuts an elastic body that is too large in the same way (ElasticPieces).
class CutElasticSession final : public ElasticSession {
public:
  /// `open` makes another session of the backend, as above.
  explicit CutElasticSession(ElasticPieces::Open open);

  void take(const MethodStep& step) override { session_->take(step); }
  void read(int level, ElasticField field, VectorField& values) const override {
    session_->read(level, field, values);
  }
  bool has_own_laws() const override { return session_->has_own_laws(); }
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    return session_->law_forces(tissues, displacement, force);
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    return session_->dot(first, second);
  }
  [[nodiscard]] ScalarField dot_squares(ElasticField first, ElasticField second, int height) const override {
    return session_->dot_squares(first, second, height);
  }
  [[nodiscard]] std::optional<double> device_seconds() override { return session_->device_seconds(); }

private:
  double do_load_body(const ElasticBody& body) override;
  void do_load(ElasticHierarchy& hierarchy) override;
  void do_end() override { session_->end(); }
  /// Begins with a session of the whole image.
  void join();
  /// Loads pieces; `error` is what the whole image met. Throws TooLarge.
  double load_pieces(const ElasticBody& body, const TooLarge& error);

  ElasticPieces::Open open_;
  std::unique_ptr<ElasticSession> session_; ///< of the whole image, or of its pieces
  bool is_cut_ = false;
};

} // namespace hdmbench
