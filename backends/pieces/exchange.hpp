#pragma once

#include "backends/pieces/cut.hpp"
#include "backends/shared/interface.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace hdmbench {

/// What goes from one piece to another: some arrays at the sites of a transfer, one after the other.
struct Message {
  Transfer way;
  std::vector<float> values;
};

/// What messages are for.
enum class Purpose {
  halos, ///< and levels on their way to or from the first piece
  sums,
  cells,  ///< of the finest level that is not cut, on their way to the first piece
  results ///< what leaves the sessions for the host
};

/// How pieces of an image get at what others hold: among processes, each of which computes one, or in the
/// memory of one that computes all of them.
class Exchange : public Interface {
public:
  /// Return the number of this process, and how many there are.
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  /// Delivers messages. `ways` are all transfers, the same in every process; `leaving` has a message for each
  /// that begins here, in their order, with `arrays` arrays. Returns those that end here, in the same order.
  /// Throws DeviceError where the network fails.
  [[nodiscard]] virtual std::vector<Message>
  exchange(std::span<const Transfer> ways, std::vector<Message> leaving, int arrays, Purpose purpose) = 0;
  /// Returns the sum over all processes.
  [[nodiscard]] virtual std::int64_t sum(std::int64_t own) = 0;
  /// Calls what works with the sessions of this process.
  virtual void compute(const std::function<void()>& call) { call(); }
};

/// One process has all pieces.
class InMemory final : public Exchange {
public:
  [[nodiscard]] int rank() const override { return 0; }
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] std::vector<Message> exchange(std::span<const Transfer> /*ways*/,
                                              std::vector<Message> leaving, int /*arrays*/,
                                              Purpose /*purpose*/) override {
    return leaving;
  }
  [[nodiscard]] std::int64_t sum(std::int64_t own) override { return own; }
};

} // namespace hdmbench
