#include "backends/shared/coarse_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <span>
#include <utility>
#include <vector>

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
constexpr int repeats = 5;                // odd

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

/// Of an odd number.
double median(std::vector<double> samples) {
  const auto middle = samples.begin() + repeats / 2;
  std::ranges::nth_element(samples, middle);
  return *middle;
}

/// Variants on levels of 1 x 1 to 32 x 32. Takes some ten milliseconds besides compiling shaders.
Choice measure(const Variants& variants, Session& session, const std::function<void(std::size_t)>& take) {
  const Level full = measured_level();
  Pyramid pyramid{.full = &full};
  for (const Extent extent : pyramid_extents(full.extent)) {
    const int sweeps = extent == full.extent ? 0 : measured_sweeps;
    pyramid.levels.insert(pyramid.levels.begin(), {.extent = extent, .sweeps = sweeps});
  }
  Choice choice{.what = "coarse levels (to 32 x 32)", .options = {}};
  for (std::size_t variant = 0; variant < variants.worth_trying; ++variant) {
    choice.options.push_back({.name = variants.names[variant]});
  }
  for (int repeat = 0; repeat < repeats; ++repeat) { // in turn, so that a drift of the machine hits all
    for (std::size_t variant = 0; variant < choice.options.size(); ++variant) {
      take(variant);
      session.load(pyramid);
      session.solve(); // a first time for what drivers put off
      choice.options[variant].seconds.push_back(seconds_of_solution(session));
    }
  }
  const auto fastest = std::ranges::min_element(
      choice.options, {}, [](const Choice::Option& option) { return median(option.seconds); });
  choice.chosen = static_cast<std::size_t>(fastest - choice.options.begin());
  return choice;
}

bool concerns(const Pyramid& pyramid, std::size_t variant) {
  return variant > 0 && coarse_level_count(pyramid, coarse_groups.at(variant)) > 0;
}

} // namespace

Variants coarse_variants(int most, bool is_software) {
  Variants result{.names = {"a dispatch per sweep"}, .concerns = concerns, .measure = measure};
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
