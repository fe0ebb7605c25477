#include "backends/session/ways.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace hdmbench {

namespace {

using Take = std::function<void(std::size_t)>;

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

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Some samples of seconds() of each way worth trying, after take(); in turn, so that a drift of the machine
/// hits all alike.
Choice fastest_way(const Variants& variants, const Take& take, const std::function<double()>& seconds) {
  constexpr int repeats = 5; // odd
  Choice choice{.what = variants.what, .options = {}};
  for (std::size_t way = 0; way < variants.worth_trying; ++way) {
    choice.options.push_back({.name = variants.names[way]});
  }
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t way = 0; way < choice.options.size(); ++way) {
      take(way);
      choice.options[way].seconds.push_back(seconds());
    }
  }
  const auto median = [](const Choice::Option& option) {
    std::vector<double> samples = option.seconds;
    std::ranges::nth_element(samples, samples.begin() + repeats / 2);
    return samples[repeats / 2];
  };
  const auto fastest = std::ranges::min_element(choice.options, {}, median);
  choice.chosen = static_cast<std::size_t>(fastest - choice.options.begin());
  return choice;
}

/// An image of one modulus but for a square in it, with its border held and one corner of that displaced.
Level measured_level(Extent extent, float modulus_of_square) {
  Level level{.extent = extent,
              .target = VectorField(extent),
              .confidence = VectorField(extent),
              .modulus = ScalarField(extent, 1.0F),
              .penalty = 1000.0F};
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t site = extent.index(x, y);
      if (x == 0 || y == 0 || x == extent.width - 1 || y == extent.height - 1) {
        level.confidence.x[site] = level.confidence.y[site] = 1.0F;
      }
      if (x >= extent.width / 4 && x < extent.width / 2 && y >= extent.height / 4 && y < extent.height / 2) {
        level.modulus.values[site] = modulus_of_square;
      }
    }
  }
  set_inverse_modulus(level);
  level.target.x.front() = 8.0F;
  return level;
}

/// On levels of 1 x 1 to 32 x 32. Takes some ten milliseconds besides compiling shaders.
Choice measure_coarse_levels(const Variants& variants, Session& session, const Take& take) {
  const Level full = measured_level({33, 33}, 1.0F);
  Pyramid pyramid{.full = &full};
  for (const Extent extent : pyramid_extents(full.extent)) {
    const int sweeps = extent == full.extent ? 0 : 16;
    pyramid.levels.insert(pyramid.levels.begin(), {.extent = extent, .sweeps = sweeps});
  }
  return fastest_way(variants, take, [&] {
    session.load(pyramid);
    session.solve(); // a first time for what drivers put off
    return seconds_of([&] { session.solve(); });
  });
}

Choice measure_shapes(const Variants& variants, Session& session, const Take& take) {
  // Of a sample: long against a clock and against waking a device up, short where a device is slow.
  constexpr double wanted_seconds = 0.01;
  constexpr double most_sweeps = 64;
  Level level = measured_level({512, 512}, 10.0F);
  try {
    session.load(level);
  } catch (const TooLarge&) { // SwiftShader's buffers end at 65536 sites
    level = measured_level({256, 256}, 10.0F);
  }
  const VectorField start(level.extent);
  int sweeps = 0; // of a sample, the same for all
  return fastest_way(variants, take, [&] {
    session.load(level);
    session.write(start);
    session.step(1); // a first time for what drivers put off
    if (sweeps == 0) {
      const double seconds = seconds_of([&] { session.step(1); });
      sweeps = static_cast<int>(std::clamp(wanted_seconds / seconds, 1.0, most_sweeps));
    }
    return seconds_of([&] { session.step(sweeps); }) / sweeps;
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
                  .measure = measure_coarse_levels};
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

Variants sweep_variants(std::span<const SweepShape> shapes) {
  Variants result{.what = "sweeps (dense)", .worth_trying = shapes.size(), .measure = measure_shapes};
  for (const SweepShape& shape : shapes) {
    result.names.push_back(fmt::format("{} x {} sites by {}", shape.tile.width, shape.tile.height,
                                       shape.simd_width > 1
                                           ? fmt::format("SIMD of {}", shape.simd_width)
                                           : fmt::format("{} invocations", shape.invocations())));
  }
  return result;
}

} // namespace hdmbench
