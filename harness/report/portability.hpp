#pragma once

#include "harness/report/results.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

/// Machines laid side by side, in the terms of S. J. Pennycook, J. D. Sewall, V. W. Lee, "A Metric for
/// Performance Portability" (2016): an application is a backend, a problem is a scene of a size with a
/// method, a platform is a processor. Nothing here knows HTML.
namespace hdmbench::report {

/// Of an application on a platform.
struct PlatformTime {
  enum class State { ran, absent, wrong };
  State state = State::absent;
  std::optional<double> seconds{}; ///< median of a whole solution
  std::optional<double> msites_per_second{};
  std::optional<double> application_efficiency{};   ///< seconds of the platform's fastest over its own
  std::optional<double> architectural_efficiency{}; ///< share of the ceiling that binds
};

struct ApplicationPortability {
  std::string application;
  std::vector<PlatformTime> times; ///< as PortableProblem::platforms
  double of_applications = 0.0;    ///< performance portability by application efficiency
  /// By architectural efficiency; none where a platform on which it ran has no ceiling.
  std::optional<double> of_architecture{};
};

struct PortableProblem {
  std::string name;                   ///< "square, 1200 x 1200, icm"
  std::vector<std::string> platforms; ///< on which an application solved it
  std::vector<ApplicationPortability> applications;
};

/// The processor of a machine, named as that, where the device is that or a driver that computes on it, as
/// `devices` rows tell; else the device.
[[nodiscard]] std::string platform_of(const Results& results, std::size_t source, const std::string& backend,
                                      const std::string& device);

/// What cross-check said of an application on a platform.
struct PlatformTier {
  std::string application;
  std::string platform;
  Tier tier = Tier::none;
  std::int64_t comparisons = 0; ///< not skipped
  bool disagrees = false;
};
[[nodiscard]] std::vector<PlatformTier> tiers_by_platform(const Results& results);

/// Problems in the order of the thesis's scenes as they were read. A time whose field was not scalar's, or
/// whose backend disagrees on that platform, is `wrong` and counts as if it could not run.
[[nodiscard]] std::vector<PortableProblem> portability(const Results& results);

/// The harmonic mean; 0 where one of them is 0 or there is none.
[[nodiscard]] double performance_portability(std::span<const double> efficiencies);

/// "problem,platform,application,fom" as the P3 Analysis Library reads it: fom is the median in seconds,
/// empty where the application did not run. Lower is better.
[[nodiscard]] std::string p3_csv(const std::vector<PortableProblem>& problems);

} // namespace hdmbench::report
