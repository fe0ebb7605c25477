#include "harness/applications/detection.hpp"

#include "harness/applications/minimise.hpp"
#include "harness/applications/modulus_problem.hpp"
#include "harness/applications/noise.hpp"
#include "harness/applications/picture.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace hdmbench {

namespace {

constexpr int margin = 6;                 // sites around the region that are looked at
constexpr double largest_logarithm = 3.0; // moduli are at most 20 times another than the labels say
constexpr double smallest_jump = 0.03;    // of log modulus: below, total variation is quadratic
constexpr double pull_to_labels = 0.02;
constexpr double least_deviation = 0.03; // of log modulus
constexpr float held_gently = 0.1F;      // confidence of what is smoothed before it is prescribed
constexpr double wide = 3.0;             // what deviations are averaged over, standard deviation, pixels

/// A part of the image around the region.
struct Window {
  int left = 0;
  int top = 0;
  Extent extent;
  Extent image;

  [[nodiscard]] std::size_t site_of_image(int x, int y) const { return image.index(left + x, top + y); }
};

Window window_of(const ScalarField& region) {
  int left = region.extent.width;
  int top = region.extent.height;
  int right = -1;
  int bottom = -1;
  for_each_site(region.extent, [&](int x, int y) {
    if (region.values[region.extent.index(x, y)] != 0.0F) {
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  });
  if (right < 0) {
    throw InputError("detection: the region of interest is empty, no pixel of the mask is above 0");
  }
  left = std::max(left - margin, 0);
  top = std::max(top - margin, 0);
  right = std::min(right + margin, region.extent.width - 1);
  bottom = std::min(bottom + margin, region.extent.height - 1);
  return {left, top, {right - left + 1, bottom - top + 1}, region.extent};
}

class Search {
public:
  Search(const VectorField& observed, const ScalarField& region, const Scene& scene,
         const DetectionOptions& options, ElasticSession& session)
      : options_(options), poisson_(scene.poisson), window_(window_of(region)), session_(session) {
    const Extent extent = window_.extent;
    sheet_.extent = extent;
    sheet_.modulus = ScalarField(extent);
    sheet_.target = VectorField(extent);
    sheet_.confidence = VectorField(extent);
    observed_ = VectorField(extent);
    index_.assign(extent.sites(), -1);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      const std::size_t from = window_.site_of_image(x, y);
      sheet_.modulus.values[site] = scene.full.modulus.values[from];
      observed_.x[site] = observed.x[from];
      observed_.y[site] = observed.y[from];
      if (region.values[from] != 0.0F) {
        index_[site] = static_cast<int>(unknown_.size());
        unknown_.push_back(site);
      }
    });
    if (unknown_.size() == extent.sites()) {
      throw InputError(
          "detection: the region of interest is the whole image; something around it must be known");
    }
  }

  [[nodiscard]] const Window& window() const { return window_; }
  [[nodiscard]] const std::vector<std::size_t>& unknown() const { return unknown_; }
  [[nodiscard]] const VectorField& observed() const { return observed_; }
  [[nodiscard]] int solutions() const { return solutions_; }

  /// What the labels' moduli make of the border.
  [[nodiscard]] VectorField expected(const VectorField& observed) {
    const Level level = with_border(observed);
    ModulusProblem problem(level, poisson_, unknown_, session_);
    ++solutions_;
    return problem.displacement(std::vector<double>(unknown_.size()));
  }

  /// log(modulus / label's) of the unknown sites that explains `observed`.
  [[nodiscard]] std::vector<double> explain(const VectorField& observed, double noise, double& unexplained) {
    const Level level = with_border(observed);
    ModulusProblem problem(level, poisson_, unknown_, session_);
    const double weight = 1.0 / (noise * noise);
    const Minimum minimum = minimise(
        [&](std::span<const double> at, std::span<double> derivative) {
          const double misfit = problem.misfit(at, observed, derivative);
          solutions_ += 2;
          for (double& slope : derivative) {
            slope *= weight;
          }
          return weight * misfit + add_variation(at, derivative);
        },
        std::vector<double>(unknown_.size()), largest_logarithm, options_.iterations);
    const VectorField found = problem.displacement(minimum.at);
    unexplained = distance(found, observed);
    return minimum.at;
  }

  /// RMS over the unknown sites, pixels.
  [[nodiscard]] double distance(const VectorField& a, const VectorField& b) const {
    double sum = 0.0;
    for (const std::size_t site : unknown_) {
      sum += std::pow(static_cast<double>(a.x[site]) - static_cast<double>(b.x[site]), 2) +
             std::pow(static_cast<double>(a.y[site]) - static_cast<double>(b.y[site]), 2);
    }
    return std::sqrt(sum / static_cast<double>(unknown_.size()));
  }

private:
  /// The window with the observed displacement prescribed outside the region, but for most of its noise:
  /// springs hold it to a sheet as the labels say.
  [[nodiscard]] Level with_border(const VectorField& observed) {
    Level level = sheet_;
    level.target = observed;
    level.confidence = VectorField(level.extent, held_gently);
    ElasticSolver solver(level, poisson_, session_);
    solver.full_multigrid();
    ++solutions_;
    level.target = solver.displacement();
    for (std::size_t site = 0; site < level.extent.sites(); ++site) {
      const float known = index_[site] < 0 ? 1.0F : 0.0F;
      level.confidence.x[site] = known;
      level.confidence.y[site] = known;
    }
    return level;
  }

  /// The total variation of the logarithms, 0 outside the region, and a weak pull to 0. Adds its derivative.
  double add_variation(std::span<const double> at, std::span<double> derivative) const {
    const Extent extent = window_.extent;
    const auto value = [&](int x, int y) {
      const int index = index_[extent.index(x, y)];
      return index < 0 ? 0.0 : at[static_cast<std::size_t>(index)];
    };
    const auto add = [&](int x, int y, double slope) {
      const int index = index_[extent.index(x, y)];
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
        sum += options_.smoothness * (length - smallest_jump);
        const double slope = options_.smoothness / length;
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

  const DetectionOptions& options_;
  double poisson_;
  Window window_;
  ElasticSession& session_;
  Level sheet_;
  VectorField observed_;
  std::vector<std::size_t> unknown_; ///< sites of the window
  std::vector<int> index_;           ///< of a site among the unknown, -1
  int solutions_ = 0;
};

/// Of a component, pixels.
double displacement_noise(const VectorField& field, double least) {
  ScalarField component(field.extent);
  component.values = field.x;
  const double along_x = noise_of(component);
  component.values = field.y;
  return std::max(std::sqrt(0.5 * (along_x * along_x + std::pow(noise_of(component), 2))), least);
}

} // namespace

Detection detect_modulus(const VectorField& observed, const ScalarField& region, const Scene& scene,
                         const DetectionOptions& options, ElasticSession& session, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  if (region.extent != scene.extent() || observed.extent != scene.extent()) {
    throw InputError(
        fmt::format("detection: the scene is {} x {} pixels, the region {} x {}, the displacement {} x {}",
                    scene.extent().width, scene.extent().height, region.extent.width, region.extent.height,
                    observed.extent.width, observed.extent.height));
  }
  Search search(observed, region, scene, options, session);
  const Extent window = search.window().extent;
  Detection result;
  result.noise = displacement_noise(search.observed(), options.least_noise);
  const VectorField expected = search.expected(search.observed());
  result.unexplained_before = search.distance(expected, search.observed());
  progress.describe("detect: the modulus that explains the deformation");
  const std::vector<double> found = search.explain(search.observed(), result.noise, result.unexplained);
  progress.advance(1.0);

  // What is found where there is nothing but noise.
  ScalarField square(window);
  GaussianNoise random(options.seed);
  for (int repetition = 0; repetition < options.repetitions; ++repetition) {
    progress.describe(
        fmt::format("detect: what noise alone would find, {} of {}", repetition + 1, options.repetitions));
    VectorField noisy = expected;
    for (std::size_t site = 0; site < window.sites(); ++site) {
      noisy.x[site] += static_cast<float>(result.noise * random());
      noisy.y[site] += static_cast<float>(result.noise * random());
    }
    double ignored = 0.0;
    const std::vector<double> by_noise = search.explain(noisy, result.noise, ignored);
    for (std::size_t i = 0; i < by_noise.size(); ++i) {
      square.values[search.unknown()[i]] +=
          static_cast<float>(by_noise[i] * by_noise[i] / options.repetitions);
    }
    progress.advance(1.0);
  }
  square = blurred(square, wide);

  result.modulus = scene.full.modulus;
  result.deviation = ScalarField(scene.extent());
  result.significance = ScalarField(scene.extent());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t site = search.unknown()[i];
    const auto width = static_cast<std::size_t>(window.width);
    const std::size_t at =
        search.window().site_of_image(static_cast<int>(site % width), static_cast<int>(site / width));
    const double deviation =
        std::sqrt(static_cast<double>(square.values[site]) + least_deviation * least_deviation);
    result.modulus.values[at] *= static_cast<float>(std::exp(found[i]));
    result.deviation.values[at] = static_cast<float>(deviation);
    result.significance.values[at] = static_cast<float>(found[i] / deviation);
    if (std::abs(found[i] / deviation) > std::abs(result.largest)) {
      result.largest = found[i] / deviation;
      result.x = static_cast<int>(at) % scene.extent().width;
      result.y = static_cast<int>(at) / scene.extent().width;
    }
  }
  result.solutions = search.solutions();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace hdmbench
