#pragma once

#include "backends/backend.hpp"
#include "backends/pieces/sharing.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace hdmbench {

/// The pieces of a level, each with a session of its own, on one device or on ranks. Sweeps go on in each
/// piece as long as its halo holds, then halos are renewed. The bits of one session. All calls are collective
/// and throw what sessions and exchanges throw.
class LevelPieces {
public:
  using Open = std::function<std::unique_ptr<Session>()>;

  /// `open` makes another session; it is called as often as this process has pieces.
  LevelPieces(std::unique_ptr<Exchange> exchange, Open open)
      : exchange_(std::move(exchange)), open_(std::move(open)) {}

  /// Opens sessions until there are so many; load() does so where it needs more.
  void open(std::size_t sessions);
  /// Pieces for annealing are whole rows, as their random numbers want it (seed_from_row()).
  void load(const Level& level, LevelShare share);
  void write(const VectorField& displacement);
  /// Sessions number their sweeps as the caller does. Their own counts have the halos in them, so the field
  /// is compared with the one before.
  void step(int sweeps);
  [[nodiscard]] VectorField read();
  /// Returns the number of sites that the last sweep changed.
  [[nodiscard]] std::int64_t changed() { return exchange_->sum(changed_); }
  [[nodiscard]] std::optional<double> device_seconds();

private:
  /// call(session, number of the piece), for pieces of this process.
  template <typename Call>
  void for_each_own(const Call& call);
  /// Returns the displacement of the sites that the pieces of this process own.
  [[nodiscard]] std::vector<VectorField> owned();
  void sweep(int sweeps);

  std::unique_ptr<Exchange> exchange_;
  Open open_;
  std::vector<std::unique_ptr<Session>> sessions_;
  Extent extent_{};
  LevelShare share_;
  int sweeps_left_ = 0;      ///< for which the halos hold
  std::int64_t changed_ = 0; ///< of the sites that are owned here, by the last sweep
};

} // namespace hdmbench
