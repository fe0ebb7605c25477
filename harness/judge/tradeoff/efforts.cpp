#include "harness/judge/tradeoff/efforts.hpp"

#include "harness/scene/joined.hpp"
#include "harness/solve/methods/sampled_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

namespace hdmbench {

namespace {

struct Efforts {
  std::string_view method;
  std::array<int, 4> counts; ///< rising
};

/// A factor of about 4 each; the same number again is nothing new.
constexpr std::array known{Efforts{"icm", {5, 20, 20, 200}},
                           Efforts{"icm-6", {5, 20, 20, 200}},
                           Efforts{"icm-thesis-steps", {5, 20, 20, 20}},
                           Efforts{"sequential", {5, 20, 20, 20}},
                           Efforts{"coloured", {5, 20, 20, 20}},
                           Efforts{"four-coloured", {5, 20, 20, 20}},
                           Efforts{"closed-form", {5, 20, 20, 200}},
                           Efforts{"cascade", {1, 2, 4, 8}},
                           Efforts{"annealing", {5, 10, 20, 20}},
                           Efforts{elastic_full_multigrid, {0, 1, 2, 3}},
                           Efforts{elastic_conjugate_gradients, {1, 2, 4, 8}},
                           Efforts{elastic_sweeps, {10, 50, 50, 200}}};

/// Coarser ones show too little to be a choice.
bool is_shown(Extent image, int stride) {
  constexpr int fewest_sites = 16;
  const Extent sampled = sampled_extent(image, stride);
  return std::min(sampled.width, sampled.height) > fewest_sites;
}

} // namespace

int usual_effort(const Method& method, int own_iterations) {
  constexpr int most_annealing = 40; // 200 take scalar half a minute, and every point is checked against it
  if (method.name == "annealing") {
    return most_annealing;
  }
  return method.usual_effort > 0 ? method.usual_effort : own_iterations;
}

std::string effort_text(const Method& method, Effort effort) {
  if (effort.stride > 1) {
    return fmt::format("{} cycles on every {} pixel", effort.iterations, ordinal(effort.stride));
  }
  std::string text = fmt::format("{} {}", effort.iterations, method.effort);
  if (effort.iterations == 1) {
    for (const std::string_view plural : {"iterations", "cycles", "steps"}) {
      const std::size_t at = text.find(plural);
      if (at != std::string::npos) {
        text.erase(at + plural.size() - 1, 1);
      }
    }
  }
  return text;
}

std::vector<Effort> efforts(const Method& method, int own_iterations, Extent image, bool quick) {
  const int usual = usual_effort(method, own_iterations);
  const auto found = std::ranges::find(known, method.name, &Efforts::method);
  std::vector<int> counts;
  if (found != known.end()) {
    counts.assign(found->counts.begin(), found->counts.end());
  }
  if (quick && !counts.empty()) {
    counts.resize(2);
  } else {
    counts.push_back(usual);
  }
  std::ranges::sort(counts);
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  std::vector<Effort> result;
  if (method.name == elastic_full_multigrid && !quick) {
    for (int stride = 4; is_shown(image, stride); stride *= 2) {
      result.insert(result.begin(), {.iterations = usual, .stride = stride});
    }
  }
  std::ranges::transform(counts, std::back_inserter(result),
                         [](int iterations) { return Effort{.iterations = iterations}; });
  return result;
}

} // namespace hdmbench
