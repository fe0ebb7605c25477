#pragma once

#include "backends/cpu/dense.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hdmbench::openmp {

/// Sweeps that leave out the tiles in which nothing can change (Work::active): those that did not change in
/// the sweep before, and in whose rim nothing did. Such a tile has the same values in both buffers: it was
/// computed from one into the other and came out the same. Only for levels with changes_spread_by_contact().
class ActiveTiles {
public:
  /// The field is another one, of which nothing is known.
  void wake_all(const Tiling& tiling, int threads);

  /// As sweep_densely(), of which a first sweep after wake_all() visits as much.
  [[nodiscard]] std::int64_t sweep(const Sweeper& sweeper, Fields& fields, int first, int sweeps,
                                   const FieldProjection* projection = nullptr);

private:
  /// One thread's, on a cache line of its own.
  struct alignas(64) Woken {
    std::vector<int> tiles;
  };
  using Lists = std::vector<Woken>;

  struct Turn;
  struct Call;
  [[nodiscard]] std::int64_t visit_all(Call& call, int thread, const FieldProjection* projection);
  [[nodiscard]] std::int64_t visit_row(Call& call, int row, std::vector<char>& suspects, Woken& next);
  [[nodiscard]] bool changed_tile(const Call& call, int row, int column) const;
  [[nodiscard]] std::int64_t visit(Call& call, std::size_t begin, std::size_t end, Woken& next);
  [[nodiscard]] std::int64_t visit_tile(Call& call, int row, int column, Woken& next);
  void wake_around(Call& call, int row, int column, Woken& next);
  void wake(Call& call, int row, int column, Woken& next);
  [[nodiscard]] std::size_t awake(int lists) const;

  Tiling tiling_;
  int threads_ = 1;
  bool all_awake_ = true;
  std::array<Lists, 2> lists_; ///< of this sweep and of the next one
  int current_ = 0;
  std::vector<std::uint32_t> woken_for_; ///< per tile, the last visit it was put on a list for
  std::uint32_t visits_ = 0;             ///< sweeps since wake_all()
};

} // namespace hdmbench::openmp
