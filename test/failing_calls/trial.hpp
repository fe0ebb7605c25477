#pragma once

#include "backends/backend.hpp"
#include "test/failing_calls/faults.hpp"
#include "test/random_level.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench::failing_calls {

/// What became of one run in which a call failed.
enum class Ending {
  clean,     ///< DeviceError with the call's name and the driver's reason
  succeeded, ///< the right bits all the same: the work can be done without the call
  unclean    ///< anything else
};

struct Outcome {
  Ending ending = Ending::unclean;
  bool went_on = false; ///< after the error the same session computed the right bits
  std::string call;     ///< that failed
  std::string what;     ///< the message, or what is wrong
};

/// Short runs of one backend, each with another call that fails: opens a session that may leave work out,
/// loads, writes, steps, counts and reads two levels of different sizes and rules, solves a pyramid whose
/// last level is large enough for every backend to leave tiles out, and closes the session.
class Trial {
public:
  /// The backend must work. Throws DeviceError.
  explicit Trial(const Backend& backend);

  /// The number of calls that a kind can befall in one run. Throws std::runtime_error where a run without any
  /// fault is not clean.
  [[nodiscard]] int calls(const Kind& kind);
  /// The `at`-th of them fails; calls(kind) must have been asked. Afterwards the session goes on if it can:
  /// then it must compute the right bits. Else the next one must, which is opened for that.
  [[nodiscard]] Outcome run(const Kind& kind, int at);
  /// Whether another session computes the right bits and leaves nothing. Else says what is wrong.
  [[nodiscard]] std::string wrong_with_next();

private:
  struct Result {
    std::vector<VectorField> fields;
    std::vector<std::int64_t> counts;

    bool operator==(const Result& other) const;
  };

  [[nodiscard]] std::unique_ptr<Session> open() const;
  [[nodiscard]] Result compute(Session& session) const;
  /// What a run with a fault came to, before anything is asked of the next one.
  [[nodiscard]] Outcome run_armed();

  const Backend& backend_;
  std::vector<test::Problem> problems_;
  test::Problem pyramid_; ///< its full level
  Result expected_;
  Kind counted_{};                            ///< that calls() was asked for last
  std::set<std::string, std::less<>> called_; ///< without a fault
};

} // namespace hdmbench::failing_calls
