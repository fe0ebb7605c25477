#include "harness/applications/detection.hpp"

#include <Eigen/Cholesky>

#include <map>
#include <set>

namespace hdmbench {

namespace {

constexpr double other_poisson = 0.1;
constexpr double largest_poisson = 0.49;
constexpr double other_modulus = 0.25; // logarithm
constexpr double border_error = 0.5;   // of labels, standard deviation, pixels
constexpr double border_length = 1.5;  // over which it changes, pixels
constexpr int most_iterations = 15;
constexpr double least_gain = 1e-4;    // of the squared differences, less ends the fit
constexpr double least_way = 1e-2;     // pixels, root of the sum of squares: below, it is rounding
constexpr double variances_over = 3.0; // pixels, standard deviation of what they are averaged with

/// How far labels' borders are from where they should be, from place to place, pixels.
VectorField wandering(Extent extent, GaussianNoise& random) {
  VectorField way(extent);
  // What the Gaussian leaves of white noise.
  const auto unit = static_cast<float>(border_error * 2.0 * std::sqrt(M_PI) * border_length);
  for (std::vector<float>& component : way.planes) {
    std::ranges::generate(component, [&] { return unit * static_cast<float>(random()); });
  }
  return blurred(way, border_length);
}

/// Sums over the disc around each site.
ScalarField disc_sums(const ScalarField& slopes, double radius) {
  const Extent extent = slopes.extent;
  // Of every row: the sum of all values before x.
  std::vector<double> before(static_cast<std::size_t>((extent.width + 1) * extent.height));
  const auto sum_before = [&](int x, int y) -> double& {
    return before[static_cast<std::size_t>(y * (extent.width + 1) + x)];
  };
  for_each_site(extent, [&](int x, int y) {
    sum_before(x + 1, y) = sum_before(x, y) + static_cast<double>(slopes.values[extent.index(x, y)]);
  });
  ScalarField sums(extent);
  const int reach = static_cast<int>(radius);
  for_each_site(extent, [&](int x, int y) {
    double sum = 0.0;
    for (int row = std::max(y - reach, 0); row <= std::min(y + reach, extent.height - 1); ++row) {
      const int half = static_cast<int>(std::sqrt(radius * radius - (row - y) * (row - y)));
      sum += sum_before(std::min(x + half + 1, extent.width), row) - sum_before(std::max(x - half, 0), row);
    }
    sums.values[extent.index(x, y)] = static_cast<float>(sum);
  });
  return sums;
}

/// Mean and deviation of every disc's score.
class Moments {
public:
  /// Of all scans but number `without`.
  Moments(const RegionSheet& sheet, std::span<const InclusionScan::Scores> scans, std::size_t without) {
    const double count = static_cast<double>(scans.size()) - (without < scans.size() ? 1.0 : 0.0);
    ScalarField inside(sheet.extent());
    for (const std::size_t site : sheet.inside()) {
      inside.values[site] = 1.0F;
    }
    const ScalarField weight = blurred(inside, variances_over);
    for (std::size_t radius = 0; radius < InclusionScan::radii.size(); ++radius) {
      ScalarField& mean = means_[radius] = ScalarField(sheet.extent());
      ScalarField variance(sheet.extent());
      for (const std::size_t site : sheet.inside()) {
        double sum = 0.0;
        double squares = 0.0;
        for (std::size_t scan = 0; scan < scans.size(); ++scan) {
          if (scan != without) {
            const auto score = static_cast<double>(scans[scan][radius].values[site]);
            sum += score;
            squares += score * score;
          }
        }
        mean.values[site] = static_cast<float>(sum / count);
        // One more for the mean: it is estimated too.
        variance.values[site] =
            static_cast<float>((squares - sum * sum / count) / (count - 1.0) * (1.0 + 1.0 / count));
      }
      deviations_[radius] = blurred(variance, variances_over);
      for (const std::size_t site : sheet.inside()) {
        float& value = deviations_[radius].values[site];
        value = std::sqrt(std::max(value, 0.0F) / weight.values[site]);
      }
    }
  }

  [[nodiscard]] double deviation(std::size_t radius, std::size_t site) const {
    return static_cast<double>(deviations_[radius].values[site]);
  }
  /// 0 where no scan says anything.
  [[nodiscard]] double significance(const InclusionScan::Scores& scores, std::size_t radius,
                                    std::size_t site) const {
    const double unit = deviation(radius, site);
    return unit > 0.0 ? static_cast<double>(scores[radius].values[site] - means_[radius].values[site]) / unit
                      : 0.0;
  }

private:
  InclusionScan::Scores means_;
  InclusionScan::Scores deviations_;
};

} // namespace

InclusionScan::InclusionScan(const RegionSheet& sheet, const VectorField& reference)
    : sheet_(sheet), level_(sheet.with_border(reference)),
      problem_(level_, sheet.poisson(), sheet.inside(), sheet.session()) {
  expected_ = sheet.displacement(level_, sheet.poisson());
  const double most = std::min(sheet.poisson() + other_poisson, largest_poisson);
  add_excuse(sheet.displacement(level_, most), sheet.displacement(level_, most - 2.0 * other_poisson));
  std::set<int> labels;
  for (const std::size_t site : sheet.inside()) {
    labels.insert(sheet.label(site));
  }
  if (labels.size() == 1) { // one label's modulus alone changes nothing where the border is given
    return;
  }
  for (const int label : labels) {
    const auto with_modulus = [&](double logarithm) {
      std::vector<double> logarithms;
      for (const std::size_t site : sheet.inside()) {
        logarithms.push_back(sheet.label(site) == label ? logarithm : 0.0);
      }
      return sheet.displacement(level_, sheet.poisson(), std::move(logarithms));
    };
    add_excuse(with_modulus(other_modulus), with_modulus(-other_modulus));
  }
}

VectorField InclusionScan::inexcusable(const VectorField& a, const VectorField& b) const {
  VectorField difference = difference_at(sheet_.inside(), a, b);
  for (const VectorField& excuse : excuses_) {
    add(difference, -static_cast<float>(product(excuse, difference)), excuse);
  }
  return difference;
}

void InclusionScan::add_excuse(const VectorField& more, const VectorField& less) {
  VectorField excuse = inexcusable(more, less);
  const double length = std::sqrt(product(excuse, excuse));
  if (length > least_way) {
    add(excuse, static_cast<float>(1.0 / length - 1.0), excuse); // of length 1 now
    excuses_.push_back(std::move(excuse));
  }
}

VectorField InclusionScan::unexplained(const VectorField& observed) const {
  return inexcusable(observed, sheet_.displacement(sheet_.with_border(observed), sheet_.poisson()));
}

InclusionScan::Scores InclusionScan::scores(const VectorField& unexplained) const {
  std::vector<double> slopes(sheet_.inside().size());
  problem_.slopes(expected_, unexplained, slopes);
  ScalarField of_sites(sheet_.extent());
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    of_sites.values[sheet_.inside()[i]] = static_cast<float>(slopes[i]);
  }
  Scores scores;
  for (std::size_t radius = 0; radius < radii.size(); ++radius) {
    scores[radius] = disc_sums(of_sites, radii[radius]);
  }
  return scores;
}

VectorField InclusionScan::with_disc(const Inclusion& disc) const {
  std::vector<double> logarithms(sheet_.inside().size());
  const auto width = static_cast<std::size_t>(sheet_.extent().width);
  for (std::size_t i = 0; i < logarithms.size(); ++i) {
    const std::size_t site = sheet_.inside()[i];
    const double distance =
        std::hypot(static_cast<double>(site % width) - disc.x, static_cast<double>(site / width) - disc.y);
    logarithms[i] = disc.logarithm * std::clamp(disc.radius + 0.5 - distance, 0.0, 1.0);
  }
  return problem_.displacement(logarithms);
}

VectorField InclusionScan::response(const Inclusion& disc) const {
  return inexcusable(with_disc(disc), expected_);
}

Inclusion InclusionScan::fit(Inclusion start, const VectorField& unexplained, double noise) const {
  using Parameters = Eigen::Vector4d; // x, y, radius, logarithm
  const auto disc_of = [](const Parameters& at) {
    return Inclusion{.x = at[0], .y = at[1], .radius = at[2], .logarithm = at[3]};
  };
  const Parameters steps(0.25, 0.25, 0.25, 0.1);
  const bool is_stiffer = start.logarithm > 0.0;
  const Parameters least(0.0, 0.0, 1.5, is_stiffer ? 0.0 : -largest_logarithm);
  const Parameters most(sheet_.extent().width - 1.0, sheet_.extent().height - 1.0, radii.back() + 5.0,
                        is_stiffer ? largest_logarithm : 0.0);
  Parameters at(start.x, start.y, start.radius, start.logarithm);
  const auto left_by = [&](const VectorField& displacement) {
    return inexcusable(unexplained, inexcusable(displacement, expected_));
  };
  VectorField here = with_disc(start);
  VectorField missing = left_by(here);
  double misfit = product(missing, missing);
  double damping = 1e-2;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Identity();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    std::array<VectorField, 4> ways;
    Parameters slope;
    for (int i = 0; i < 4; ++i) {
      Parameters beside = at;
      beside[i] += steps[i];
      ways[static_cast<std::size_t>(i)] = inexcusable(with_disc(disc_of(beside)), here);
      slope[i] = product(ways[static_cast<std::size_t>(i)], missing) / steps[i];
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        normal(i, j) = product(ways[static_cast<std::size_t>(i)], ways[static_cast<std::size_t>(j)]) /
                       (steps[i] * steps[j]);
      }
    }
    bool better = false;
    while (!better && damping < 1e4) {
      Eigen::Matrix4d damped = normal;
      damped.diagonal() += damping * normal.diagonal() + Parameters::Constant(1e-12);
      const Parameters next = (at + damped.ldlt().solve(slope)).cwiseMax(least).cwiseMin(most);
      VectorField there = with_disc(disc_of(next));
      VectorField left = left_by(there);
      const double then = product(left, left);
      better = then < misfit;
      if (better) {
        const bool ends = misfit - then < least_gain * misfit;
        at = next;
        here = std::move(there);
        missing = std::move(left);
        misfit = then;
        damping = ends ? 1e9 : damping * 0.2;
      } else {
        damping *= 5.0;
      }
    }
    if (damping >= 1e4) {
      break;
    }
  }
  Inclusion found = disc_of(at);
  // Not Eigen's inverse(): its 4 x 4 has wrong signs under -fno-signed-zeros.
  const Eigen::Matrix4d covariance =
      noise * noise * (normal + 1e-9 * Eigen::Matrix4d::Identity()).ldlt().solve(Eigen::Matrix4d::Identity());
  found.position_deviation = std::sqrt(std::max(covariance(0, 0) + covariance(1, 1), 0.0));
  found.logarithm_deviation = std::sqrt(std::max(covariance(3, 3), 0.0));
  return found;
}

VectorField InclusionScan::nothing_hidden(GaussianNoise& random) const {
  Level level = level_;
  const Extent extent = sheet_.extent();
  std::map<int, double> factors;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    factors.try_emplace(sheet_.label(site), 0.0);
  }
  for (auto& [label, factor] : factors) {
    factor = std::exp(other_modulus * random());
  }
  const auto right = static_cast<float>(random.uniform() - 0.5);
  const auto down = static_cast<float>(random.uniform() - 0.5);
  const VectorField border = wandering(extent, random);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    level.modulus.values[site] =
        sample(sheet_.modulus().values, extent, static_cast<float>(x) + right + border[0][site],
               static_cast<float>(y) + down + border[1][site]) *
        static_cast<float>(factors[sheet_.label(site)]);
  });
  sheet_.loosen(level);
  const double poisson =
      std::min(sheet_.poisson() + other_poisson * (2.0 * random.uniform() - 1.0), largest_poisson);
  return sheet_.displacement(level, poisson);
}

ScanResult measure_scan(const RegionSheet& sheet, const InclusionScan::Scores& found,
                        std::span<const InclusionScan::Scores> nothing) {
  const Moments moments(sheet, nothing, nothing.size());
  ScanResult result;
  result.significance = ScalarField(sheet.extent());
  for (const std::size_t site : sheet.inside()) {
    for (std::size_t radius = 0; radius < InclusionScan::radii.size(); ++radius) {
      const double here = moments.significance(found, radius, site);
      float& most = result.significance.values[site];
      if (std::abs(here) > std::abs(static_cast<double>(most))) {
        most = static_cast<float>(here);
      }
      ScanResult::Peak& peak = here > 0.0 ? result.stiffest : result.softest;
      if (std::abs(here) > std::abs(peak.significance)) {
        peak = {here, site, InclusionScan::radii[radius]};
      }
    }
  }
  for (std::size_t scan = 0; scan < nothing.size(); ++scan) {
    const Moments others(sheet, nothing, scan);
    double largest = 0.0;
    for (const std::size_t site : sheet.inside()) {
      for (std::size_t radius = 0; radius < InclusionScan::radii.size(); ++radius) {
        largest = std::max(largest, std::abs(others.significance(nothing[scan], radius, site)));
      }
    }
    result.by_chance.push_back(largest);
  }
  return result;
}

double deviation_ratio(const RegionSheet& sheet, std::span<const InclusionScan::Scores> these,
                       std::span<const InclusionScan::Scores> those) {
  const Moments first(sheet, these, these.size());
  const Moments second(sheet, those, those.size());
  std::vector<double> ratios;
  for (const std::size_t site : sheet.inside()) {
    for (std::size_t radius = 0; radius < InclusionScan::radii.size(); ++radius) {
      if (second.deviation(radius, site) > 0.0) {
        ratios.push_back(first.deviation(radius, site) / second.deviation(radius, site));
      }
    }
  }
  return ratios.empty() ? 1.0 : median_of(ratios);
}

} // namespace hdmbench
