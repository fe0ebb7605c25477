#pragma once

#include "harness/cli/arguments.hpp"
#include "harness/scene/files.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace hdmbench::commands {

/// What a continuous integration of drivers asks of a command beyond its own verdict: nothing that was not
/// compared may pass.
class Gates {
public:
  /// --require-hardware and --fail-on-skip, and --baseline of `verify`.
  void add_to(CLI::App& command, bool with_baseline = false);

  /// Before the command runs. Where hardware is required, leaves backends with software only out of
  /// `arguments`, with a line on standard output; scalar and openmp, which claim to be no GPU, stay. Where
  /// there is a baseline, `call` gets a file for the results. Throws DeviceError where a backend that was
  /// named has software only, or no hardware is left, and InputError for a baseline that cannot be read.
  void prepare(CommonArguments& arguments, Call& call);

  /// After it: `status`, or disagreement where that was success and a backend was skipped or something that
  /// agreed in the baseline does not agree, or is not there, in the results. Says which. Throws InputError.
  /// The baseline is compared by the process that speaks.
  [[nodiscard]] int judge(int status, const Call& call) const;

private:
  bool require_hardware_ = false;
  bool fail_on_skip_ = false;
  std::filesystem::path baseline_; ///< empty: none
  std::string skipped_;            ///< lines: backends, and why
  std::optional<TemporaryDirectory> folder_{};
};

} // namespace hdmbench::commands
