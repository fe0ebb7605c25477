#include "backends/shared/coarse_levels.hpp"

#include "backends/shared/fastest_way.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <span>

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

/// Of a group of 8, one vector, is the last: at a barrier a CPU puts each vector aside (lavapipe, 8, 64, 256,
/// 1024 invocations: 1.2, 1.3, 1.7, 3.3 ms), and a shader takes long to compile.
constexpr std::size_t worth_trying_on_cpu = 2;

constexpr Extent measured_extent{33, 33}; // its levels are 1 x 1 ... 32 x 32 and itself
constexpr int measured_sweeps = 16;       // of a level

/// Variants on levels of 1 x 1 to 32 x 32. Takes some ten milliseconds besides compiling shaders.
Choice measure(const Variants& variants, Session& session, const std::function<void(std::size_t)>& take) {
  const Level full = measured_level(measured_extent, 1.0F);
  Pyramid pyramid{.full = &full};
  for (const Extent extent : pyramid_extents(full.extent)) {
    const int sweeps = extent == full.extent ? 0 : measured_sweeps;
    pyramid.levels.insert(pyramid.levels.begin(), {.extent = extent, .sweeps = sweeps});
  }
  return fastest_way(variants, take, [&] {
    session.load(pyramid);
    session.solve(); // a first time for what drivers put off
    return seconds_of([&] { session.solve(); });
  });
}

bool concerns(const Pyramid& pyramid, std::size_t variant) {
  return variant > 0 && coarse_level_count(pyramid, coarse_groups.at(variant)) > 0;
}

} // namespace

Variants coarse_variants(int most, bool is_software) {
  Variants result{.what = "coarse levels (to 32 x 32)",
                  .names = {"a dispatch per sweep"},
                  .concerns = concerns,
                  .measure = measure};
  for (const int group : std::span(coarse_groups).subspan(1)) {
    if (group <= most) {
      result.names.push_back(fmt::format("one dispatch of {} invocations", group));
    }
  }
  result.worth_trying =
      is_software ? std::min(result.names.size(), worth_trying_on_cpu) : result.names.size();
  return result;
}

bool has_coarse_levels(const Pyramid& pyramid) {
  return concerns(pyramid, coarse_groups.size() - 1);
}

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

double coarse_site_updates(const Pyramid& pyramid, std::size_t count) {
  double updates = 0.0;
  for (const PyramidLevel& level : std::span(pyramid.levels).first(count)) {
    updates += static_cast<double>(level.extent.sites()) * level.sweeps;
  }
  return updates;
}

} // namespace hdmbench
