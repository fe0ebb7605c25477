#include "harness/applications/detection.hpp"

#include "harness/applications/picture.hpp"
#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace hdmbench {

namespace {

constexpr double blur = 1.0;            // standard deviation, pixels
constexpr double least_deviation = 1.0; // gray values
constexpr double least_radius = 3.0;    // pixels: less is hardly a place
constexpr double serious_share = 0.2;   // of the disc, beyond what is usual
constexpr double other_modulus = 1.1;   // factor: less is the same tissue

struct Tissue {
  std::vector<float> grays{};
  double modulus = 0.0; ///< MPa, mean
  double median = 0.0;
  double deviation = 0.0;
};

/// Whether a site and its eight neighbours have one label.
bool is_inside(const LabelField& labels, int x, int y) {
  const Extent extent = labels.extent;
  for (int row = std::max(y - 1, 0); row <= std::min(y + 1, extent.height - 1); ++row) {
    for (int column = std::max(x - 1, 0); column <= std::min(x + 1, extent.width - 1); ++column) {
      if (labels.values[extent.index(column, row)] != labels.values[extent.index(x, y)]) {
        return false;
      }
    }
  }
  return true;
}

} // namespace

bool LabelDoubt::is_serious() const {
  return share > usual + serious_share;
}

LabelDoubt doubt_labels(const ScalarField& source, const Scene& scene, const Detection& found) {
  const Extent extent = scene.extent();
  const ScalarField gray = blurred(source, blur);
  std::map<int, Tissue> tissues;
  const auto for_each_inside = [&](const auto& visit) {
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      if (scene.labels.values[site] > 0 && is_inside(scene.labels, x, y)) {
        visit(x, y, site);
      }
    });
  };
  for_each_inside([&](int, int, std::size_t site) {
    Tissue& tissue = tissues[scene.labels.values[site]];
    tissue.grays.push_back(gray.values[site]);
    tissue.modulus += static_cast<double>(scene.full.modulus.values[site]);
  });
  for (auto& [label, tissue] : tissues) {
    tissue.modulus /= static_cast<double>(tissue.grays.size());
    tissue.median = static_cast<double>(median_of(tissue.grays));
    for (float& value : tissue.grays) {
      value = std::abs(value - static_cast<float>(tissue.median));
    }
    tissue.deviation = std::max(static_cast<double>(median_of(tissue.grays)) / 0.6745, least_deviation);
  }
  const auto looks_like = [&](std::size_t site) {
    const auto distance = [&](const Tissue& tissue) {
      return std::abs(static_cast<double>(gray.values[site]) - tissue.median) / tissue.deviation;
    };
    const Tissue& own = tissues.at(scene.labels.values[site]);
    int nearest = 0;
    double least = distance(own);
    for (const auto& [label, tissue] : tissues) {
      const double ratio = tissue.modulus / own.modulus;
      const bool explains = found.largest > 0.0 ? ratio > other_modulus : ratio * other_modulus < 1.0;
      if (explains && distance(tissue) < least) {
        least = distance(tissue);
        nearest = label;
      }
    }
    return nearest;
  };
  struct Share {
    double sites = 0.0, other = 0.0;
    [[nodiscard]] double value() const { return sites > 0.0 ? other / sites : 0.0; }
  } everywhere, here;
  std::map<int, int> others;
  const double radius = std::max(found.radius, least_radius);
  for_each_inside([&](int x, int y, std::size_t site) {
    const int other = looks_like(site);
    const double counts = other != 0 ? 1.0 : 0.0;
    everywhere.sites += 1.0;
    everywhere.other += counts;
    if (std::hypot(x - found.x, y - found.y) <= radius) {
      here.sites += 1.0;
      here.other += counts;
      ++others[other];
    }
  });
  others.erase(0);
  const auto most = std::ranges::max_element(others, {}, &std::pair<const int, int>::second);
  return {
      .label = most == others.end() ? 0 : most->first, .share = here.value(), .usual = everywhere.value()};
}

} // namespace hdmbench
