#include "harness/applications/detection.hpp"

#include "harness/applications/registration.hpp"
#include "harness/scene/images/images.hpp"
#include "kernels/data/input_error.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <numbers>

namespace hdmbench {

namespace {

constexpr double first_logarithm = 0.5; // of the disc, before it is fitted
constexpr double smallest_jump = 0.03;  // of log modulus: below, total variation is quadratic
constexpr double pull_to_labels = 0.02;
constexpr double least_noise = 1e-3; // pixels: what a displacement is worth that has no noise
constexpr int fewest_simulations = 3;

/// The total variation of the logarithms, 0 outside the region, and a weak pull to 0. Adds its derivative.
double add_variation(const RegionSheet& sheet, double smoothness, std::span<const double> at,
                     std::span<double> derivative) {
  const Extent extent = sheet.extent();
  const auto value = [&](int x, int y) {
    const int index = sheet.index(extent.index(x, y));
    return index < 0 ? 0.0 : at[static_cast<std::size_t>(index)];
  };
  const auto add = [&](int x, int y, double slope) {
    const int index = sheet.index(extent.index(x, y));
    if (index >= 0) {
      derivative[static_cast<std::size_t>(index)] += slope;
    }
  };
  double sum = 0.0;
  for (int y = 0; y + 1 < extent.height; ++y) {
    for (int x = 0; x + 1 < extent.width; ++x) {
      const double here = value(x, y);
      const double across = value(x + 1, y) - here;
      const double down = value(x, y + 1) - here;
      const double length = std::sqrt(across * across + down * down + smallest_jump * smallest_jump);
      sum += smoothness * (length - smallest_jump);
      const double slope = smoothness / length;
      add(x + 1, y, slope * across);
      add(x, y + 1, slope * down);
      add(x, y, -slope * (across + down));
    }
  }
  for (std::size_t i = 0; i < at.size(); ++i) {
    sum += 0.5 * pull_to_labels * at[i] * at[i];
    derivative[i] += pull_to_labels * at[i];
  }
  return sum;
}

struct Explanation {
  std::vector<double> logarithms; ///< log(modulus / label's) of the inside sites
  VectorField displacement;
};

Explanation explain(const RegionSheet& sheet, const VectorField& observed, double noise,
                    const DetectionOptions& options) {
  const Level level = sheet.with_border(observed);
  ModulusProblem problem(level, sheet.poisson(), sheet.inside(), sheet.session());
  const double weight = 1.0 / (noise * noise);
  std::vector<double> logarithms = minimise(
      [&](std::span<const double> at, std::span<double> derivative) {
        const double misfit = problem.misfit(at, observed, derivative);
        for (double& slope : derivative) {
          slope *= weight;
        }
        return weight * misfit + add_variation(sheet, options.smoothness, at, derivative);
      },
      sheet.inside().size(), largest_logarithm, options.iterations);
  VectorField displacement = problem.displacement(logarithms);
  return {std::move(logarithms), std::move(displacement)};
}

/// Of a component, pixels.
double white_noise_of(const VectorField& field) {
  ScalarField component(field.extent);
  double square = 0.0;
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    component.values = field[axis];
    square += std::pow(noise_of(component), 2) / static_cast<double>(field.extent.axes());
  }
  return std::max(std::sqrt(square), least_noise);
}

void add_noise(std::vector<float>& values, double deviation, GaussianNoise& random) {
  for (float& value : values) {
    value += static_cast<float>(deviation * random());
  }
}

VectorField with_noise(VectorField field, double deviation, GaussianNoise& random) {
  for (std::vector<float>& component : field.planes) {
    add_noise(component, deviation, random);
  }
  return field;
}

/// One detection, of a displacement in the part of the image around the region.
class Search {
public:
  Search(const RegionSheet& sheet, VectorField observed, const DetectionOptions& options, Progress& progress)
      : sheet_(sheet), observed_(std::move(observed)), options_(options), progress_(progress),
        random_(options.seed), scan_(sheet, observed_),
        expected_(sheet.displacement(sheet.with_border(observed_), sheet.poisson())) {}

  /// The observed border continued by the labels' moduli.
  [[nodiscard]] const VectorField& expected() const { return expected_; }
  /// The same with what is not known of the tissue a little different.
  [[nodiscard]] VectorField nothing_hidden() { return scan_.nothing_hidden(random_); }
  [[nodiscard]] GaussianNoise& random() { return random_; }

  /// Scans of what was simulated.
  struct Simulated {
    std::vector<InclusionScan::Scores> scores{};
    std::vector<VectorField> unexplained{};
    VectorField mean{}; ///< of unexplained
  };
  /// `count` of what `simulate` gives.
  [[nodiscard]] Simulated scans(int count, const std::function<VectorField()>& simulate) {
    Simulated result{.mean = VectorField(sheet_.extent())};
    for (int number = 0; number < count; ++number) {
      progress_.describe(
          fmt::format("detect: what is found where nothing is hidden, {} of {}", number + 1, count));
      const VectorField& unexplained = result.unexplained.emplace_back(scan_.unexplained(simulate()));
      result.scores.push_back(scan_.scores(unexplained));
      add(result.mean, 1.0F / static_cast<float>(count), unexplained);
      progress_.advance(1.0);
    }
    return result;
  }

  [[nodiscard]] double deviation_ratio(const Simulated& these, const Simulated& those) const {
    return hdmbench::deviation_ratio(sheet_, these.scores, those.scores);
  }

  /// `noise`: of the displacement, pixels; white noise that makes scores as uncertain as they are. is_white:
  /// it is no other kind of error.
  [[nodiscard]] Detection finish(const Scene& scene, const Simulated& nothing, double noise, bool is_white) {
    VectorField unexplained = scan_.unexplained(observed_);
    ScanResult scan = measure_scan(sheet_, scan_.scores(unexplained), nothing.scores);
    // As significance is: what is left unexplained where nothing is hidden, a registration's bias, is no
    // disc's.
    add(unexplained, -1.0F, nothing.mean);
    progress_.describe("detect: the modulus that explains the deformation");
    const Explanation found = explain(sheet_, observed_, noise, options_);
    // Stiff tissue makes its surroundings look soft, and these may be the more significant.
    const auto fitted = [&](const ScanResult::Peak& peak) {
      const auto width = static_cast<std::size_t>(sheet_.extent().width);
      return scan_.fit({.x = static_cast<double>(peak.site % width),
                        .y = static_cast<double>(peak.site / width),
                        .radius = peak.radius,
                        .logarithm = std::copysign(first_logarithm, peak.significance)},
                       unexplained, noise);
    };
    const Inclusion stiff = fitted(scan.stiffest);
    const Inclusion soft = fitted(scan.softest);
    // How much of it a disc explains, in deviations of what chance would: white noise, or a registration's
    // error.
    const auto explained = [&](const Inclusion& disc) {
      const VectorField response = scan_.response(disc);
      double variance = noise * noise * product(response, response);
      if (!is_white) {
        variance = 0.0;
        const double mean = product(response, nothing.mean);
        for (const VectorField& simulated : nothing.unexplained) {
          variance += std::pow(product(response, simulated) - mean, 2) /
                      (static_cast<double>(nothing.unexplained.size()) - 1.0);
        }
      }
      return variance > 0.0 ? product(response, unexplained) / std::sqrt(variance) : 0.0;
    };
    const bool is_stiff = scan.softest.significance == 0.0 ||
                          (scan.stiffest.significance != 0.0 && explained(stiff) >= explained(soft));
    const Inclusion& disc = is_stiff ? stiff : soft;
    const std::size_t corner = sheet_.site_of_image(0);
    const auto image_width = static_cast<std::size_t>(scene.extent().width);
    Detection result{.modulus = scene.full.modulus,
                     .significance = ScalarField(scene.extent()),
                     .noise = noise,
                     .unexplained_before = sheet_.distance(expected_, observed_),
                     .unexplained = sheet_.distance(found.displacement, observed_),
                     .largest = (is_stiff ? scan.stiffest : scan.softest).significance,
                     .x = static_cast<double>(corner % image_width) + disc.x,
                     .y = static_cast<double>(corner / image_width) + disc.y,
                     .contrast = std::exp(disc.logarithm),
                     .radius = disc.radius,
                     .position_deviation = disc.position_deviation,
                     .contrast_deviation = disc.logarithm_deviation,
                     .by_chance = std::move(scan.by_chance)};
    for (std::size_t i = 0; i < sheet_.inside().size(); ++i) {
      const std::size_t site = sheet_.inside()[i];
      const std::size_t at = sheet_.site_of_image(site);
      result.modulus.values[at] *= static_cast<float>(std::exp(found.logarithms[i]));
      result.significance.values[at] = scan.significance.values[site];
    }
    return result;
  }

private:
  const RegionSheet& sheet_;
  VectorField observed_;
  const DetectionOptions& options_;
  Progress& progress_;
  GaussianNoise random_;
  InclusionScan scan_;
  VectorField expected_;
};

/// Tissue, and enough of it for the smallest disc that is sought; a deformation, as what moves as one says
/// nothing about moduli; and enough simulations.
void require_detectable(const RegionSheet& sheet, const Scene& scene, const VectorField& part,
                        int simulations) {
  if (simulations < fewest_simulations) {
    throw InputError(fmt::format("detection: {} simulations say nothing about chance, at least {} are needed",
                                 simulations, fewest_simulations));
  }
  const double smallest = InclusionScan::radii.front();
  const auto needed = static_cast<std::ptrdiff_t>(std::numbers::pi * smallest * smallest);
  const auto tissue = std::ranges::count_if(sheet.inside(), [&](std::size_t site) {
    return scene.labels.values.empty() || sheet.label(site) != 0;
  });
  if (tissue < needed) {
    throw InputError(fmt::format("detection: the region of interest has {} pixels of tissue (label 0 is "
                                 "none), at least {} are needed: "
                                 "the smallest disc that is sought has a radius of {:g} pixels",
                                 tissue, needed, smallest));
  }
  double variance = 0.0;
  for (std::size_t axis = 0; axis < part.extent.axes(); ++axis) {
    const Eigen::ArrayXd all =
        Eigen::Map<const Eigen::ArrayXf>(part[axis].data(), std::ssize(part[axis])).cast<double>();
    variance += (all - all.mean()).square().mean();
  }
  if (!(std::sqrt(variance) > least_noise)) {
    throw InputError(fmt::format(
        "detection: around the region the tissue moved as one, but for {:.2g} px; without a deformation of "
        "more than {:g} px nothing can be said about moduli",
        std::sqrt(variance), least_noise));
  }
}

} // namespace

Detection detect_modulus(const VectorField& observed, const ScalarField& region, const Scene& scene,
                         const DetectionOptions& options, ElasticSession& session, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const RegionSheet sheet(region, scene, session);
  const VectorField part = sheet.part_of(observed);
  require_detectable(sheet, scene, part, options.fields);
  const double noise = white_noise_of(part);
  Search search(sheet, part, options, progress);
  const auto nothing = search.scans(
      options.fields, [&] { return with_noise(search.nothing_hidden(), noise, search.random()); });
  Detection result = search.finish(scene, nothing, noise, true);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Detection detect_modulus(const ScalarField& source, const ScalarField& target, const VectorField& registered,
                         const ScalarField& region, const Scene& scene, const DetectionOptions& options,
                         ElasticSession& session, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const RegionSheet sheet(region, scene, session);
  const VectorField part = sheet.part_of(registered);
  require_detectable(sheet, scene, part, options.pairs);
  Search search(sheet, part, options, progress);
  const ScalarField like_target = with_values_of(source, pulled_back(target, registered), {});
  const double source_noise = noise_of(source);
  const double target_noise = noise_of(target);
  Progress silent(false);
  const auto nothing = search.scans(options.pairs, [&] {
    ScalarField again = source;
    VectorField moves = registered;
    sheet.put_back(search.nothing_hidden(), moves);
    ScalarField moved_again = warp(like_target, moves);
    add_noise(again.values, source_noise, search.random());
    add_noise(moved_again.values, target_noise, search.random());
    return sheet.part_of(
        register_iteratively(again, moved_again, scene, {}, {}, session, silent).displacement);
  });
  // What white noise of one pixel does to scores tells how much of it the registration's error is worth.
  const auto of_white_noise =
      search.scans(options.pairs, [&] { return with_noise(search.expected(), 1.0, search.random()); });
  Detection result = search.finish(
      scene, nothing, std::max(search.deviation_ratio(nothing, of_white_noise), least_noise), false);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
