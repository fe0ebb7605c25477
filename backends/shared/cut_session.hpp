#pragma once

#include "backends/backend.hpp"
#include "backends/shared/cut.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace hdmbench {

/// A session that cuts an image that is too large for one session of its backend, and no other, into 2, 4, 8
/// ... pieces, each with a session of its own, until they fit. Sweeps go on in each piece as long as its halo
/// holds, then halos are renewed through the host. The same bits. Pieces for annealing are whole
/// rows (seed_from_row()). Not for sequential updates: these are TooLarge, as is what does not fit in the
/// smallest pieces.
class CutSession final : public Session {
public:
  /// `open` makes another session of the backend, with an empty name; called at once for the first one, and
  /// by load() for those of the pieces.
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

  [[nodiscard]] Session& whole() { return *sessions_.front(); }
  [[nodiscard]] bool is_cut() const { return !cut_.pieces.empty(); }
  void sweep(int sweeps);
  /// Every piece into the session of its number; `error` is what the whole image met. Throws TooLarge.
  void load_pieces(const Level& level, const TooLarge& error);

  std::function<std::unique_ptr<Session>()> open_;
  std::vector<std::unique_ptr<Session>> sessions_; ///< the first one has the image where it is not cut
  Cut cut_;                                        ///< of the level; without pieces where it is not cut
  Extent extent_{};                                ///< of the level that is cut
  int sweeps_left_ = 0;                            ///< for which the halos hold
  std::int64_t changed_ = 0;                       ///< by the last sweep
  bool in_one_piece_ = false;                      ///< the pyramid is the first session's
};

} // namespace hdmbench
