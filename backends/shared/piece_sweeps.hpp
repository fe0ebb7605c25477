#pragma once

#include "backends/backend.hpp"
#include "backends/shared/cut.hpp"
#include "backends/shared/interface.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace hdmbench {

/// cut_image() in whole rows, one piece below the other.
[[nodiscard]] Cut cut_rows(Extent extent, int count, int halo = 0);

/// Level::seed of the rows from `row` on of what has this seed: it carries the row, modulo 4093, so that
/// whole rows of an image have its random numbers (kernels/specification/update.inc).
[[nodiscard]] int seed_from_row(int seed, int row);

/// What goes from one piece to another: some arrays at the sites of a transfer, one after the other.
struct Parcel {
  Transfer way;
  std::vector<float> values;
};

/// How pieces of an image get at what others hold: within a process, or between ranks.
class Exchange : public Interface {
public:
  /// Whether the piece of this number is computed in this process.
  [[nodiscard]] virtual bool is_here(std::size_t piece) const = 0;
  /// Delivers parcels. `ways` are all transfers, the same in every process; `leaving` has a parcel for each
  /// that begins here, in their order, with `arrays` arrays. Returns those that end here, in the same order.
  /// Throws DeviceError where the network fails.
  [[nodiscard]] virtual std::vector<Parcel> exchange(std::span<const Transfer> ways,
                                                     std::vector<Parcel> leaving, int arrays) = 0;
  /// Over all processes.
  [[nodiscard]] virtual std::int64_t sum(std::int64_t own) = 0;
};

/// All pieces are in this process.
class WithinProcess final : public Exchange {
public:
  bool is_here(std::size_t /*piece*/) const override { return true; }
  std::vector<Parcel> exchange(std::span<const Transfer> /*ways*/, std::vector<Parcel> leaving,
                               int /*arrays*/) override {
    return leaving;
  }
  std::int64_t sum(std::int64_t own) override { return own; }
};

/// Sweeps over a cut level whose pieces are loaded in sessions, some of them here, the others in other
/// processes: each piece goes on as long as its halo holds, then halos are renewed. The bits and counts of
/// the level in one piece. Every process makes the same calls. Throws what Session and Exchange throw.
class PieceSweeps {
public:
  struct Own {
    std::size_t piece = 0;
    Session* session = nullptr; ///< has what the piece loads
  };

  /// `own`: the pieces that are here. Sessions and exchange must outlive it.
  PieceSweeps(Cut cut, std::vector<Own> own, Exchange& exchange);

  /// To be called when all sessions have been written with halos that are right.
  void written() { sweeps_left_ = cut_.halo; }

  void sweep(int sweeps);
  /// The next sweep, and changed().
  void sweep_and_count();
  /// In the pieces that are here, by the last sweep_and_count().
  [[nodiscard]] std::int64_t changed() const { return changed_; }

  [[nodiscard]] const Cut& cut() const { return cut_; }
  [[nodiscard]] std::span<const Own> own() const { return own_; }
  [[nodiscard]] const Piece& piece(const Own& own) const { return cut_.pieces[own.piece]; }

private:
  void renew_halos();

  Cut cut_;
  std::vector<Transfer> ways_;
  std::vector<Own> own_;
  Exchange* exchange_;
  int sweeps_left_ = 0; ///< for which the halos hold
  std::int64_t changed_ = 0;
};

} // namespace hdmbench
