#pragma once

#include "backends/backend.hpp"
#include "backends/pieces/exchange.hpp"
#include "kernels/data/input_error.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What a rank has sent to others, without what collective operations move.
struct Traffic {
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
  double seconds = 0.0; ///< until they were there, and what others sent: with waiting for others
};

/// The processes that mpirun started together; piece i of a cut image is computed by rank i. What is called
/// collective has to be called by all ranks, in the same order. Where MPI reports an error: DeviceError in
/// its words.
class Ranks : public Exchange {
public:
  /// Null where mpirun did not start this process, or started it alone: then MPI is left alone. Throws
  /// InputError where mpirun started several and this build has no MPI: each would do the whole work.
  [[nodiscard]] static std::unique_ptr<Ranks> of_this_process();

  /// Return the number of this rank, and how many there are, on the same machine.
  [[nodiscard]] virtual int rank_on_machine() const = 0;
  [[nodiscard]] virtual int size_on_machine() const = 0;
  [[nodiscard]] bool is_first() const { return rank() == 0; }
  /// An error of this rank's device is an InputError: ended_by_error_of_one().
  void compute(const std::function<void()>& call) override;

  /// Collective: the text of every rank, by rank, on the first one; nothing on the others.
  [[nodiscard]] virtual std::vector<std::string> gather(const std::string& own) = 0;
  /// Collective.
  [[nodiscard]] virtual double largest(double own) = 0;
  /// By exchange(), so far.
  [[nodiscard]] virtual Traffic traffic() const = 0;
  /// To be called by a rank that cannot go on, before anything is printed. True where all ranks do so within
  /// a moment: then the first one speaks for all, and each may return from main(). False where others go on,
  /// or wait for this one: then it has to say so itself and to end_all().
  [[nodiscard]] virtual bool all_end() const = 0;
  [[noreturn]] virtual void end_all(int status) = 0;
};

/// Throws InputError on all ranks where one has another text than the first: `differ` makes the sentence of a
/// rank's number, its text and that of the first, on the first rank, which speaks for all. Collective.
void require_same(Ranks& ranks, const std::string& own,
                  const std::function<std::string(std::size_t rank, std::string_view text,
                                                  std::string_view first)>& differ);

/// check() by the first rank, which alone writes files; what it refuses, all refuse. Throws InputError.
/// Collective. `ranks` null: this process is alone.
void let_first_check(Ranks* ranks, const std::function<void()>& check);

/// Returns call(). An error of this rank's device becomes an InputError in its words: who takes a DeviceError
/// for a device that is left out would go on without the other ranks.
template <typename Call>
decltype(auto) ended_by_error_of_one(const Call& call) {
  try {
    return call();
  } catch (const DeviceError& error) {
    throw InputError(error.what());
  }
}

/// How many processes mpirun or srun started together, by the environment that they give them; 0: none did.
[[nodiscard]] int launched_together();

/// Starts the program again, with the arguments of main(), where the environment lacks what libraries read
/// before main(): among several processes that OpenBLAS shall have one thread; that a thread of OpenMP which
/// waits for others gives its processor away after some microseconds (by default it turns in a loop for
/// milliseconds, and on a busy machine the thread that it waits for does not run meanwhile); and that large
/// arrays lie on large pages: each page that is touched first costs a call of the system, and a volume has
/// half a million small ones. To be called before anything else; what the user has set stays.
void set_environment(char** argv);

} // namespace hdmbench
