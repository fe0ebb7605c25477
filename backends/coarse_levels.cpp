#include "backends/coarse_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace hdmbench {

namespace {

/// Of all loops of an invocation together. llvmpipe leaves them without a word after 65,535; it also keeps
/// the dispatch below the watchdogs of drivers.
constexpr std::int64_t most_turns = 60'000;

/// Of a level by a group, at most: a site takes one of the loop over sites and two of that over a tile's
/// rows, a sweep three more (counted on llvmpipe: four to be safe). To sample and to store take no more than
/// two sweeps.
std::int64_t turns(const PyramidLevel& level, int group) {
  const auto sites = static_cast<std::int64_t>(level.extent.sites());
  return (3 * ((sites + group - 1) / group) + 4) * (level.sweeps + 2);
}

constexpr Extent measured_extent{33, 33}; // its levels are 1 x 1 ... 32 x 32 and itself
constexpr int measured_sweeps = 16;       // of a level
constexpr int repeats = 5;

/// A uniform image with its border held, one corner of it displaced.
Level measured_level() {
  const std::size_t sites = measured_extent.sites();
  Level level{.extent = measured_extent,
              .target = VectorField(measured_extent),
              .confidence = VectorField(measured_extent),
              .modulus = ScalarField(measured_extent),
              .penalty = 1000.0F};
  std::ranges::fill(level.modulus.values, 1.0F);
  set_inverse_modulus(level);
  for (std::size_t i = 0; i < sites; i += static_cast<std::size_t>(measured_extent.width) / 2) {
    level.confidence.x[i] = 1.0F;
    level.confidence.y[i] = 1.0F;
    level.target.x[i] = i == 0 ? 8.0F : 0.0F;
  }
  return level;
}

double seconds_of_solution(Session& session) {
  const auto begin = std::chrono::steady_clock::now();
  session.solve();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

} // namespace

std::size_t coarse_level_count(const Pyramid& pyramid, int group) {
  if (!changes_spread_by_contact(*pyramid.full)) {
    return 0;
  }
  std::size_t count = 0;
  std::int64_t turns_so_far = 0;
  while (count + 1 < pyramid.levels.size() && pyramid.levels[count].extent.sites() <= most_coarse_sites) {
    turns_so_far += turns(pyramid.levels[count], group);
    if (turns_so_far > most_turns) {
      break;
    }
    ++count;
  }
  return count;
}

std::string coarse_group_name(int group) {
  return group == 0 ? "a dispatch per sweep" : fmt::format("one dispatch of {} invocations", group);
}

double coarse_site_updates(const Pyramid& pyramid, std::size_t count) {
  double updates = 0.0;
  for (const PyramidLevel& level : std::span(pyramid.levels).first(count)) {
    updates += static_cast<double>(level.extent.sites()) * level.sweeps;
  }
  return updates;
}

Choice measure_coarse_levels(std::span<const int> groups, Session& session,
                             const std::function<void(int)>& set_group) {
  const Level full = measured_level();
  Pyramid pyramid{.full = &full};
  for (const Extent extent : pyramid_extents(full.extent)) {
    const int sweeps = extent == full.extent ? 0 : measured_sweeps;
    pyramid.levels.insert(pyramid.levels.begin(), {.extent = extent, .sweeps = sweeps});
  }
  Choice choice{.what = "coarse levels (to 32 x 32)",
                .options = {{.name = coarse_group_name(0), .coarse_group = 0}}};
  for (const int group : groups) {
    choice.options.push_back({.name = coarse_group_name(group), .coarse_group = group});
  }
  for (int repeat = 0; repeat < repeats; ++repeat) { // in turn, so that a drift of the machine hits all
    for (Choice::Option& option : choice.options) {
      set_group(option.coarse_group);
      session.load(pyramid);
      session.solve(); // a first time for what drivers put off
      option.seconds.push_back(seconds_of_solution(session));
    }
  }
  const auto fastest = std::ranges::min_element(
      choice.options, {}, [](const Choice::Option& option) { return std::ranges::min(option.seconds); });
  choice.chosen = static_cast<std::size_t>(fastest - choice.options.begin());
  return choice;
}

} // namespace hdmbench
