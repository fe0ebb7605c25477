#pragma once

#include "backends/shared/piece_sweeps.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// What a rank has sent to others, without what collective operations move.
struct Traffic {
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  double seconds = 0.0; ///< until they were there, and what others sent: with waiting for others
};

/// A file that is there and that every rank writes its own parts of, by MPI-IO, each for itself: so that one
/// that fails keeps no other one waiting. Throws InputError in the words of MPI.
class SharedFile {
public:
  SharedFile() = default;
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;
  virtual ~SharedFile() = default;

  virtual void write_at(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
  /// What was written is then in the file.
  virtual void close() = 0;
};

/// The processes that mpirun started together; piece i of a cut image is computed by rank i. What is called
/// collective has to be called by all ranks, in the same order. Where MPI reports an error: DeviceError in
/// its words.
class Ranks : public Exchange {
public:
  /// Null where mpirun did not start this process, or started it alone: then MPI is left alone. Throws
  /// InputError where mpirun started several and this build has no MPI: each would do the whole work.
  [[nodiscard]] static std::unique_ptr<Ranks> of_this_process();

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  /// Of the ranks on the same machine.
  [[nodiscard]] virtual int rank_on_machine() const = 0;
  [[nodiscard]] virtual int size_on_machine() const = 0;
  [[nodiscard]] bool is_first() const { return rank() == 0; }
  [[nodiscard]] bool is_here(std::size_t piece) const override {
    return piece == static_cast<std::size_t>(rank());
  }

  /// Collective: what the first rank has, to all. Who waits for long leaves its processor to others.
  virtual void broadcast(std::vector<std::byte>& bytes) = 0;
  /// Collective: the text of every rank, by rank, on the first one; nothing on the others.
  [[nodiscard]] virtual std::vector<std::string> gather(const std::string& own) = 0;
  /// Collective.
  [[nodiscard]] virtual double largest(double own) = 0;
  [[nodiscard]] virtual std::unique_ptr<SharedFile> open(const std::filesystem::path& file) = 0;
  /// By exchange(), so far.
  [[nodiscard]] virtual Traffic traffic() const = 0;
  /// Ends all ranks. Those behind the first one wait a moment, so that where all meet the same error only the
  /// first one says so: call it before anything is printed.
  virtual void give_way() const = 0;
  [[noreturn]] virtual void end_all(int status) = 0;
};

} // namespace hdmbench
