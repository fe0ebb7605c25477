#pragma once

#include "backends/backend.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace hdmbench {

/// Sites left ... left + width - 1 by top ... top + height - 1.
struct Rectangle {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] Extent extent() const { return {width, height}; }
  bool operator==(const Rectangle&) const = default;
};

/// A part of a cut image.
struct Piece {
  Rectangle owned;  ///< the pieces' own sites are all sites, each once
  Rectangle loaded; ///< those and a halo of them: what a session of its own computes
};

/// An image cut into columns x rows pieces.
struct Cut {
  std::vector<Piece> pieces;
  /// Sites of the halo along every cut. The edge of a piece inside the image is computed as if it were the
  /// image's, which is wrong, in the first sweep in one row, in the next in two: after this many sweeps what
  /// a piece owns is still right.
  int halo = 0;
};

/// `count` pieces, a power of two: the longer side of a piece is halved until there are so many. Cuts and
/// halos are at multiples of 4, so that the colours of an update are the same in a piece as in the image.
/// Without pieces where one would own less than 4 sites along a cut.
[[nodiscard]] Cut cut_image(Extent extent, int count);

/// A session that cuts an image that is too large for one session of its backend, and no other, into 2, 4, 8
/// ... pieces, each with a session of its own, until they fit. Sweeps go on in each piece as long as its halo
/// holds, then halos are renewed through the host. The same bits. Not for annealing, whose random numbers go
/// by column and row, nor for sequential updates: these are TooLarge, as is what does not fit in the smallest
/// pieces.
class CutSession final : public Session {
public:
  /// `open` makes another session of the backend, with an empty name; called at once for the first one, and
  /// by load() for those of the pieces.
  explicit CutSession(std::function<std::unique_ptr<Session>()> open);

private:
  void do_load(const Level& level) override;
  void do_write(const VectorField& displacement) override;
  void do_step(int first, int sweeps) override;
  void do_read(VectorField& displacement) override;
  std::int64_t do_changed() override;
  void do_load_pyramid(const Pyramid& pyramid) override;
  void do_solve(const Advance& advance) override;

  [[nodiscard]] bool is_cut() const { return !cut_.pieces.empty(); }
  [[nodiscard]] Session& whole() { return *sessions_.front(); }
  /// Every piece into the session of its number; `error` is what the whole image met. Throws TooLarge.
  void load_pieces(const Level& level, const TooLarge& error);
  void sweep(int sweeps);
  /// The next sweep, and changed_.
  void sweep_and_count();
  void renew_halos();

  std::function<std::unique_ptr<Session>()> open_;
  std::vector<std::unique_ptr<Session>> sessions_; ///< the first one has the image where it is not cut
  Cut cut_;                                        ///< of the level; without pieces where it is not cut
  int sweeps_left_ = 0;                            ///< for which the halos hold
  bool in_one_piece_ = false;                      ///< the pyramid is the first session's
  std::int64_t changed_ = 0;                       ///< by the last sweep
};

} // namespace hdmbench
