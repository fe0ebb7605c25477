#include "harness/tradeoff/efforts.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace hdmbench {

namespace {

struct Efforts {
  std::string_view method;
  std::array<int, 4> counts; ///< rising
};

/// A factor of about 4 each; the same number again is nothing new. Annealing takes scalar ten seconds.
constexpr std::array known{Efforts{"icm", {5, 20, 50, 200}},
                           Efforts{"icm-6", {5, 20, 50, 200}},
                           Efforts{"icm-thesis-steps", {5, 20, 50, 200}},
                           Efforts{"sequential", {5, 20, 50, 200}},
                           Efforts{"coloured", {5, 20, 50, 200}},
                           Efforts{"four-coloured", {5, 20, 50, 200}},
                           Efforts{"closed-form", {5, 20, 50, 200}},
                           Efforts{"cascade", {1, 2, 4, 8}},
                           Efforts{"annealing", {20, 200, 200, 200}},
                           Efforts{"multigrid", {1, 2, 3, 4}},
                           Efforts{"krylov", {2, 3, 5, 8}}};

} // namespace

int usual_effort(const Method& method, int own_iterations) {
  return method.usual_effort > 0 ? method.usual_effort : own_iterations;
}

std::vector<int> efforts(const Method& method, int own_iterations, bool quick) {
  const int usual = usual_effort(method, own_iterations);
  const auto found = std::ranges::find(known, method.name, &Efforts::method);
  std::vector<int> counts;
  if (found != known.end()) {
    counts.assign(found->counts.begin(), found->counts.end());
  }
  if (quick && !counts.empty()) {
    counts = {counts.front()};
  }
  counts.push_back(usual);
  std::ranges::sort(counts);
  counts.erase(std::ranges::unique(counts).begin(), counts.end());
  return counts;
}

} // namespace hdmbench
