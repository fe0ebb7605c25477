#include "harness/scene/carried_conditions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace hdmbench {

namespace {

/// A pixel as near to a site as this lies at it. To prescribe the site beyond as well would make the cell
/// between them rigid for a hundredth of its displacement.
constexpr double at_a_site = 0.01;

/// A site of an axis that a pixel reaches.
struct Reached {
  int site = 0;
  double hat =
      0.0; ///< linear interpolation between the pixels of the file, or of the sites if they are wider
  double share = 0.0; ///< of the site in the linear interpolation between the sites at the pixel
};

/// The sites that each pixel of an axis reaches.
using Reach = std::vector<std::vector<Reached>>;

Reach reach_of(const PixelPositions& at, std::size_t axis, int pixels, int sites) {
  const double step = at.step[axis];
  const double width = std::max(1.0, step);
  Reach reach(static_cast<std::size_t>(pixels));
  for (int pixel = 0; pixel < pixels; ++pixel) {
    const double place = std::clamp(at.of(axis, pixel), 0.0, sites - 1.0);
    auto& reached = reach[static_cast<std::size_t>(pixel)];
    double shares = 0.0;
    const int last = std::min(sites - 1, static_cast<int>(std::floor(place + width)));
    for (int site = std::max(0, static_cast<int>(std::ceil(place - width))); site <= last; ++site) {
      const double away = std::abs(site - place);
      const bool beyond_file = (pixel == 0 && site < place) || (pixel == pixels - 1 && site > place);
      const double share = 1.0 - away > at_a_site ? 1.0 - away : 0.0;
      const double hat = beyond_file && away <= 0.5 * step + same_place ? 1.0 : 1.0 - away / width;
      if (hat > 0.0 || share > 0.0) {
        reached.push_back({site, hat, share});
        shares += share;
      }
    }
    for (Reached& one : reached) {
      one.share /= shares;
    }
  }
  return reach;
}

/// The sites around scattered pixels, which reach no farther.
Reach reach_of(const std::vector<std::array<double, 3>>& pixels, std::size_t axis, int sites) {
  Reach reach;
  for (const std::array<double, 3>& pixel : pixels) {
    PixelPositions at;
    at.first[axis] = pixel[axis];
    reach.push_back(reach_of(at, axis, 1, sites).front());
    std::erase_if(reach.back(), [](const Reached& one) { return one.share == 0.0; });
  }
  return reach;
}

/// One component on its way from the pixels of a file to the sites of a level.
class Carrier {
public:
  Carrier(const FileConditions& conditions, std::size_t component, bool are_springs, Level& level)
      : pixels_(conditions.target.extent), target_(conditions.target[component]),
        confidence_(conditions.confidence[component]), are_springs_(are_springs),
        is_grid_(conditions.scattered.empty()), sites_(level.extent), to_target_(level.target[component]),
        to_confidence_(level.confidence[component]) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int count = sites_.sides()[axis];
      reach_[axis] = !is_grid_              ? reach_of(conditions.scattered, axis, count)
                     : axis < sites_.axes() ? reach_of(conditions.at, axis, pixels_.sides()[axis], count)
                                            : Reach{{{0, 1.0, 1.0}}};
      around_[axis] = reach_[axis];
      for (auto& reached : around_[axis]) {
        std::erase_if(reached, [](const Reached& one) { return one.share == 0.0; });
      }
    }
  }

  /// call(site, share) for the sites around a pixel.
  template <typename Call>
  void for_each_around(int x, int y, int z, const Call& call) const {
    for_each_of(around_, x, y, z, [&](std::size_t site, double /*hat*/, double share) { call(site, share); });
  }

  /// call(x, y, z, pixel, confidence) for the pixels of which something is known.
  template <typename Call>
  void for_each_known(const Call& call) const {
    for_each_site(pixels_, [&](int x, int y, int z) {
      const std::size_t pixel = pixels_.index(x, y, z);
      if (confidence_[pixel] > 0.0F) {
        call(x, y, z, pixel, confidence_[pixel]);
      }
    });
  }

  /// Frees the sites whose nearest pixel is said something of.
  void forget(const PixelPositions& at) {
    const auto nearest = [&](std::size_t axis, int site, int count) {
      const double pixel = axis < sites_.axes() ? (site - at.first[axis]) / at.step[axis] : 0.0;
      return static_cast<int>(std::clamp(std::round(pixel), 0.0, count - 1.0));
    };
    for_each_site(sites_, [&](int x, int y, int z) {
      const std::size_t pixel = pixels_.index(nearest(0, x, pixels_.width), nearest(1, y, pixels_.height),
                                              nearest(2, z, pixels_.depth));
      if (confidence_[pixel] >= 0.0F) {
        const std::size_t site = sites_.index(x, y, z);
        to_target_[site] = to_confidence_[site] = 0.0F;
      }
    });
  }

  /// Sets the sites around certain pixels and between them.
  void prescribe() {
    struct Sum {
      double weight = 0.0;
      double target = 0.0;
      bool is_near = false;
    };
    std::vector<Sum> sums(sites_.sites());
    for_each_known([&](int x, int y, int z, std::size_t pixel, float confidence) {
      if (confidence >= 1.0F) {
        for_each_of(reach_, x, y, z, [&](std::size_t site, double hat, double share) {
          Sum& sum = sums[site];
          sum.weight += hat;
          sum.target += hat * double{target_[pixel]};
          sum.is_near = sum.is_near || share > 0.0;
        });
      }
    });
    prescribed_.resize(sums.size());
    for (std::size_t site = 0; site < sums.size(); ++site) {
      const Sum& sum = sums[site];
      if (sum.is_near || sum.weight >= 1.0 - same_place) {
        prescribed_[site] = true;
        to_target_[site] = static_cast<float>(sum.target / sum.weight);
        to_confidence_[site] = 1.0F;
      }
    }
  }

  /// Moves what is prescribed until the field between the sites is at the targets of the certain pixels,
  /// which it is at once where these are on a plane, and cannot be where there are more of them than sites.
  /// Returns the largest way that is left.
  double meet_targets() {
    constexpr int passes = 8;
    constexpr double near_enough = 1e-6; // pixels: nothing to move
    double farthest = 1.0;
    for (int pass = 0; pass <= passes && farthest > near_enough; ++pass) {
      std::vector<std::pair<double, double>> missing(sites_.sites()); // shares, and shares of gaps
      farthest = 0.0;
      for_each_known([&](int x, int y, int z, std::size_t pixel, float confidence) {
        if (!(confidence >= 1.0F)) {
          return;
        }
        double gap = double{target_[pixel]};
        for_each_around(x, y, z,
                        [&](std::size_t site, double share) { gap -= share * double{to_target_[site]}; });
        farthest = std::max(farthest, std::abs(gap));
        for_each_around(x, y, z, [&](std::size_t site, double share) {
          missing[site].first += share;
          missing[site].second += share * gap;
        });
      });
      for (std::size_t site = 0; site < missing.size() && pass < passes; ++site) {
        if (const auto& [share, gap] = missing[site]; share > 0.0) {
          to_target_[site] = static_cast<float>(double{to_target_[site]} + gap / share);
        }
      }
    }
    return farthest;
  }

  /// Shares the weights of the other pixels out among the sites around each.
  void attach() {
    std::vector<std::pair<double, double>> sums; // of weights, and of weighted targets
    for_each_known([&](int x, int y, int z, std::size_t pixel, float confidence) {
      if (confidence < 1.0F) {
        if (sums.empty()) {
          sums = present_weights();
        }
        const double weight = weight_of(confidence);
        for_each_around(x, y, z, [&](std::size_t site, double share) {
          sums[site].first += share * weight;
          sums[site].second += share * weight * double{target_[pixel]};
        });
      }
    });
    for (std::size_t site = 0; site < sums.size(); ++site) {
      if (const auto& [weight, target] = sums[site];
          weight > 0.0 && !prescribed_[site] && to_confidence_[site] < 1.0F) {
        to_target_[site] = static_cast<float>(target / weight);
        const auto confidence = static_cast<float>(are_springs_ ? weight / (1.0 + weight) : weight);
        to_confidence_[site] = std::min(confidence, std::nextafter(1.0F, 0.0F)); // none becomes certain
      }
    }
  }

  [[nodiscard]] double weight_of(float confidence) const {
    return are_springs_ ? confidence / (1.0 - double{confidence}) : double{confidence};
  }

  /// Weights, and weighted targets, that the sites have already. What is certain is not to be changed.
  [[nodiscard]] std::vector<std::pair<double, double>> present_weights() const {
    std::vector<std::pair<double, double>> sums(sites_.sites());
    for (std::size_t site = 0; site < sums.size(); ++site) {
      if (const float confidence = to_confidence_[site]; confidence > 0.0F && confidence < 1.0F) {
        sums[site] = {weight_of(confidence), weight_of(confidence) * double{to_target_[site]}};
      }
    }
    return sums;
  }

  /// Counts the pixels in `is_known`, `acts` and `is_exact`.
  void mark(std::vector<bool>& is_known, std::vector<bool>& acts, std::vector<bool>& is_exact) const {
    for_each_known([&](int x, int y, int z, std::size_t pixel, float confidence) {
      is_known[pixel] = true;
      is_exact[pixel] = is_exact[pixel] || confidence >= 1.0F;
      for_each_around(x, y, z, [&](std::size_t site, double /*share*/) {
        acts[pixel] = acts[pixel] || confidence >= 1.0F || prescribed_.empty() || !prescribed_[site];
      });
    });
  }

private:
  /// call(site, hat, share) for all sites that a pixel reaches.
  template <typename Call>
  void for_each_of(const std::array<Reach, 3>& reach, int x, int y, int z, const Call& call) const {
    for (const Reached& slice : reach[2][static_cast<std::size_t>(is_grid_ ? z : x)]) {
      for (const Reached& row : reach[1][static_cast<std::size_t>(is_grid_ ? y : x)]) {
        for (const Reached& column : reach[0][static_cast<std::size_t>(x)]) {
          call(sites_.index(column.site, row.site, slice.site), column.hat * row.hat * slice.hat,
               column.share * row.share * slice.share);
        }
      }
    }
  }

  Extent pixels_;
  const std::vector<float>& target_;
  const std::vector<float>& confidence_;
  bool are_springs_;
  bool is_grid_;
  Extent sites_;
  std::vector<float>& to_target_;
  std::vector<float>& to_confidence_;
  std::array<Reach, 3> reach_;
  std::array<Reach, 3> around_; ///< of these the sites with a share
  std::vector<bool> prescribed_;
};

} // namespace

bool are_the_sites(Extent pixels, const PixelPositions& at, Extent sites) {
  bool are_same = pixels == sites;
  for (std::size_t axis = 0; axis < sites.axes(); ++axis) {
    for (const int end : {0, sites.sides()[axis] - 1}) {
      are_same = are_same && std::abs(at.of(axis, end) - end) <= same_place;
    }
  }
  return are_same;
}

CarriedConditions carry_conditions(const FileConditions& conditions, bool are_springs, Level& level) {
  const std::size_t pixels = conditions.target.extent.sites();
  std::vector<bool> is_known(pixels);
  std::vector<bool> acts(pixels);
  std::vector<bool> is_exact(pixels);
  const bool is_copied =
      conditions.scattered.empty() && are_the_sites(conditions.target.extent, conditions.at, level.extent);
  CarriedConditions carried;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    Carrier component(conditions, axis, are_springs, level);
    if (is_copied) {
      for (std::size_t site = 0; site < pixels; ++site) {
        if (conditions.confidence[axis][site] >= 0.0F) {
          level.target[axis][site] = conditions.target[axis][site];
          level.confidence[axis][site] = conditions.confidence[axis][site];
        }
      }
    } else {
      if (conditions.scattered.empty()) {
        component.forget(conditions.at);
      }
      component.prescribe();
      carried.farthest = std::max(carried.farthest, component.meet_targets());
      component.attach();
    }
    component.mark(is_known, acts, is_exact);
  }
  carried.given = static_cast<std::size_t>(std::ranges::count(is_known, true));
  carried.acting = static_cast<std::size_t>(std::ranges::count(acts, true));
  carried.exact = static_cast<std::size_t>(std::ranges::count(is_exact, true));
  return carried;
}

} // namespace hdmbench
