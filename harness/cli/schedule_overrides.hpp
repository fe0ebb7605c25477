#pragma once

#include "harness/cli/commands.hpp"
#include "harness/scene/method.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hdmbench::commands {

/// What the user may change about every scene's schedule.
struct ScheduleOverrides {
  bool takes_energy = false;                ///< whether the command has --energy; say so before add_to()
  const RegisteredEnergy* energy = nullptr; ///< null: the scene's, or that of the method
  std::optional<std::string> method{};      ///< harness/scene/method.hpp
  MethodOptions options{};                  ///< of the method
  std::optional<int> start_level{};
  std::optional<Stop> stop{};
  std::optional<double> epsilon{};
  std::optional<Alignment> alignment{};
  std::optional<double> penalty{};
  std::optional<double> prior_weight{};

  void add_to(CLI::App& command);
  /// With `other_method` in place of `method`, where there is one. Throws InputError.
  void apply(Scene& scene, const std::optional<std::string>& other_method = std::nullopt) const;
  /// The arguments that were given, each with a space before it: " --iterations 5", with `other_method` as
  /// above.
  [[nodiscard]] std::string text(const std::optional<std::string>& other_method = std::nullopt) const;

private:
  CLI::App* command_ = nullptr; ///< of add_to
};

/// The names of the options of ScheduleOverrides that a command has, but those of `but`.
[[nodiscard]] std::vector<std::string> schedule_options(const CLI::App& command,
                                                        const std::vector<std::string>& but);

} // namespace hdmbench::commands
