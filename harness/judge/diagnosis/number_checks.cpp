#include "harness/judge/diagnosis/checks.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hdmbench::diagnosis {

namespace {

/// What a result in pixels is usually read to, where the rule has no candidates of its own.
constexpr double wanted_resolution = 0.01;

/// The smallest difference of displacements that matters: that of the candidates, else wanted_resolution.
double resolution(const Scene& scene) {
  const double smallest = quantum(scene);
  return smallest > 0.0 ? smallest : wanted_resolution;
}

void check_rest_candidate(const Scene& scene, Warnings& warnings) {
  if (scene.schedule.rule == Rule::steps && std::ranges::count(scene.full.steps.values(), 0.0F) == 0) {
    warnings.push_back(
        {"never-rests",
         fmt::format("0 is none of the candidates {}: every site moves in every sweep, by at least "
                     "{:.3g} px, and the field never comes to rest",
                     scene.full.steps.text(), step_sizes(scene.full.steps).smallest),
         "--steps default, which has 0 as its first candidate"});
  }
}

/// Near rest a component is about a smallest candidate e from its target, and |gap - e| is rounded by up to
/// u e with u = 2^-24, |gap| as well: K times 2 u e stands against the prior's A e^2, A = 24 in one material.
/// So above K = A e / 2u rounding decides which candidate is best.
void check_swamping_penalty(const Scene& scene, Warnings& warnings) {
  const double smallest = quantum(scene);
  const double penalty = static_cast<double>(scene.full.penalty);
  const double most = 24.0 * smallest * 0x1p23;
  const auto observed = [](float confidence) { return confidence > 0.0F; };
  const bool any = std::ranges::any_of(scene.full.confidence.x, observed) ||
                   std::ranges::any_of(scene.full.confidence.y, observed);
  if (any && smallest > 0.0 && penalty > most) {
    warnings.push_back(
        {"swamping-penalty",
         fmt::format(
             "K = {:.3g} is so large that its rounding in float32 outweighs the prior at steps of {:.3g} px "
             "(from K = {:.2g}): at conditions that are nearly met chance decides",
             penalty, smallest, most),
         "--penalty 1000 holds conditions as well"});
  }
}

/// A value of size D is stored to ulp(D) / 2. A site's own minimum is a mean of its neighbours (the weights
/// (1 + r) r + (1 + k) sum to A, so the contrast r drops out): it and the site are each off by ulp(D) / 2,
/// together ulp(D). From half the smallest candidate on that decides where a site rests, and the field is no
/// longer the same wherever it is shifted to.
void check_offset(const Scene& scene, Warnings& warnings) {
  Range range;
  for (const Component& component : components(scene)) {
    for (std::size_t i = 0; i < component.target.size(); ++i) {
      if (component.confidence[i] > 0.0F) {
        range.include(static_cast<double>(component.target[i]));
      }
      range.include(component.start_of(i));
    }
  }
  const auto largest = static_cast<float>(std::max(std::abs(range.least), std::abs(range.most)));
  const double spacing =
      static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest);
  if (spacing >= 0.5 * resolution(scene)) {
    warnings.push_back(
        {"offset",
         fmt::format(
             "displacements of up to {:.4g} px are stored in steps of {:.2g} px (float32): a site cannot "
             "rest nearer to its minimum, where {:.3g} px are wanted",
             static_cast<double>(largest), spacing, resolution(scene)),
         fmt::format(
             "subtract the mean displacement ({:.4g} px) from targets and start, and add it to the result",
             0.5 * (range.least + range.most))});
  }
}

/// Largest modulus of a site over that of a neighbour.
struct Contrast {
  double ratio = 1.0;
  std::size_t site = 0; ///< the stiffer one
};

Contrast largest_contrast(const Level& level) {
  Contrast found;
  const Extent extent = level.extent;
  const auto& modulus = level.modulus.values;
  const auto compare = [&](std::size_t a, std::size_t b) {
    const std::size_t stiff = modulus[a] < modulus[b] ? b : a;
    const double ratio =
        static_cast<double>(modulus[stiff]) / static_cast<double>(modulus[stiff == a ? b : a]);
    if (ratio > found.ratio) {
      found = {.ratio = ratio, .site = stiff};
    }
  };
  for_each_site(extent, [&](int x, int y) {
    const std::size_t at = extent.index(x, y);
    if (x + 1 < extent.width) {
      compare(at, extent.index(x + 1, y));
    }
    if (y + 1 < extent.height) {
      compare(at, extent.index(x, y + 1));
      if (x + 1 < extent.width) {
        compare(at, extent.index(x + 1, y + 1));
      }
      if (x > 0) {
        compare(at, extent.index(x - 1, y + 1));
      }
    }
  });
  return found;
}

/// On a straight boundary each triple of a stiff site has a softer neighbour u on one side, r = m_t / m_u,
/// and its own material on the other: u pulls with the weight w = (1 + r) + 2 out of A = (1 + r)^2 + 4. The
/// site moves by e only where its minimum is more than e / 2 away, so where the soft side is e A / 2w ahead;
/// no two sites can be farther apart than the targets. Below w / A = 2^-24 float32 does not feel the softer
/// side at all; where 6 (1 + r)^2 e^2 leaves its range every energy is infinite.
void check_contrast(const Scene& scene, Warnings& warnings) {
  const Contrast contrast = largest_contrast(scene.full);
  const double r = contrast.ratio;
  const double lag = ((1.0 + r) * (1.0 + r) + 4.0) / (3.0 + r);
  const std::string where =
      fmt::format("{:.4g} times stiffer than its neighbour at {}", r, place(scene.extent(), contrast.site));
  const double largest_step = std::max(1.0, step_sizes(scene.full.steps).largest);
  const bool overflows =
      6.0 * (1.0 + r) * (1.0 + r) * largest_step * largest_step > double{std::numeric_limits<float>::max()};
  if (overflows || lag > 0x1p24) {
    warnings.push_back(
        {"contrast",
         overflows ? fmt::format("tissue is {}: the square of that is beyond float32", where)
                   : fmt::format("tissue is {}: in float32 the stiffer side does not feel the "
                                 "softer one (from a ratio of 1.7e+07 on)",
                                 where),
         "give void and rigid parts as conditions, or limit the moduli: a ratio of 1000 is rigid"});
    return;
  }
  double range = 0.0;
  for (const Component& component : components(scene)) {
    range = std::max(range, target_range(component).width());
  }
  const double ahead = 0.5 * step_sizes(scene.full.steps).smallest * lag;
  if (scene.schedule.rule == Rule::steps && range > 0.0 && ahead > range) {
    warnings.push_back(
        {"stiff-boundary",
         fmt::format(
             "tissue is {}: no candidate moves a straight boundary there before the softer side is {:.3g} "
             "px ahead, and conditions are {:.3g} px apart",
             where, ahead, range),
         "--method cascade, which has no smallest step, or limit the moduli"});
  }
}

} // namespace

/// Layers two pixels thin: from a ratio of 10,000 on, cycles leave pixels while they move nothing any more.
void check_elastic_cycles(const Scene& scene, Warnings& warnings) {
  constexpr double most = 100.0;
  const Contrast contrast = largest_contrast(scene.full);
  if (contrast.ratio > most && scene.schedule.method == elastic_full_multigrid) {
    warnings.push_back(
        {"stalling-cycles",
         fmt::format("tissue is {:.4g} times stiffer than its neighbour at {}: from {:.0f} on cycles by "
                     "themselves can stall far from the end, and estimate too small a distance",
                     contrast.ratio, place(scene.extent(), contrast.site), most),
         "--method conjugate-gradients, or --accuracy"});
  }
}

void check_numbers(const Scene& scene, Warnings& warnings) {
  check_swamping_penalty(scene, warnings);
  check_offset(scene, warnings);
  check_contrast(scene, warnings);
  check_rest_candidate(scene, warnings);
}

} // namespace hdmbench::diagnosis
