#include "harness/applications/picture.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/sites_worth_threads.hpp"

#include <cmath>
#include <vector>

namespace hdmbench {

namespace {

/// Weights of the pixels from `reach` before to `reach` after.
std::vector<float> gaussian(double sigma) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = -reach; i <= reach; ++i) {
    sum += weights.emplace_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  }
  std::vector<float> result;
  std::ranges::transform(weights, std::back_inserter(result),
                         [sum](double weight) { return static_cast<float>(weight / sum); });
  return result;
}

constexpr double blur_before_halving = 1.0; // pixels

} // namespace

ScalarField blurred(const ScalarField& picture, double sigma) {
  if (!(sigma > 0.0)) {
    return picture;
  }
  const Extent extent = picture.extent;
  const std::vector<float> weights = gaussian(sigma);
  const int reach = static_cast<int>(weights.size()) / 2;
  ScalarField across(extent);
  ScalarField result(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int y = 0; y < extent.height; ++y) {
    const float* const from = &picture.values[extent.index(0, y)];
    for (int x = 0; x < extent.width; ++x) {
      float sum = 0.0F;
      for (int i = -reach; i <= reach; ++i) {
        sum += weights[static_cast<std::size_t>(i + reach)] * from[std::clamp(x + i, 0, extent.width - 1)];
      }
      across.values[extent.index(x, y)] = sum;
    }
  }
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int y = 0; y < extent.height; ++y) {
    float* const to = &result.values[extent.index(0, y)];
    for (int i = -reach; i <= reach; ++i) {
      const float* const from = &across.values[extent.index(0, std::clamp(y + i, 0, extent.height - 1))];
      for (int x = 0; x < extent.width; ++x) {
        to[x] += weights[static_cast<std::size_t>(i + reach)] * from[x];
      }
    }
  }
  return result;
}

VectorField gradient(const ScalarField& picture) {
  const Extent extent = picture.extent;
  VectorField result(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const int left = std::max(x - 1, 0);
      const int right = std::min(x + 1, extent.width - 1);
      const int top = std::max(y - 1, 0);
      const int bottom = std::min(y + 1, extent.height - 1);
      const auto value = [&](int column, int row) { return picture.values[extent.index(column, row)]; };
      const std::size_t site = extent.index(x, y);
      result.x[site] = (value(right, y) - value(left, y)) / static_cast<float>(right - left);
      result.y[site] = (value(x, bottom) - value(x, top)) / static_cast<float>(bottom - top);
    }
  }
  return result;
}

ScalarField halved(const ScalarField& picture) {
  const ScalarField smooth = blurred(picture, blur_before_halving);
  ScalarField result({(picture.extent.width + 1) / 2, (picture.extent.height + 1) / 2});
  for_each_site(result.extent, [&](int x, int y) {
    result.values[result.extent.index(x, y)] = smooth.values[picture.extent.index(2 * x, 2 * y)];
  });
  return result;
}

ScalarField halved_mean(const ScalarField& field) {
  ScalarField result({(field.extent.width + 1) / 2, (field.extent.height + 1) / 2});
  for_each_site(result.extent, [&](int x, int y) {
    float sum = 0.0F;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        sum += field.values[field.extent.index(std::min(2 * x + i, field.extent.width - 1),
                                               std::min(2 * y + j, field.extent.height - 1))];
      }
    }
    result.values[result.extent.index(x, y)] = 0.25F * sum;
  });
  return result;
}

void blend_moduli(ScalarField& modulus, const ScalarField& region, float resistance) {
  double sum = 0.0;
  double sites = 0.0;
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    if (region.values[site] != 0.0F) {
      sum += static_cast<double>(modulus.values[site]);
      sites += 1.0;
    }
  }
  const auto mean = static_cast<float>(sum / std::max(sites, 1.0));
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    if (region.values[site] != 0.0F) {
      float& value = modulus.values[site];
      value = resistance * (mean + resistance * (value - mean));
    }
  }
}

VectorField doubled(const VectorField& displacement, Extent extent) {
  VectorField result(extent);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    const float half_x = 0.5F * static_cast<float>(x);
    const float half_y = 0.5F * static_cast<float>(y);
    result.x[site] = 2.0F * sample(displacement.x, displacement.extent, half_x, half_y);
    result.y[site] = 2.0F * sample(displacement.y, displacement.extent, half_x, half_y);
  });
  return result;
}

ScalarField pulled_back(const ScalarField& picture, const VectorField& displacement) {
  const Extent extent = picture.extent;
  ScalarField result(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t site = extent.index(x, y);
      result.values[site] = sample(picture.values, extent, static_cast<float>(x) + displacement.x[site],
                                   static_cast<float>(y) + displacement.y[site]);
    }
  }
  return result;
}

double noise_of(const ScalarField& picture) {
  const Extent extent = picture.extent;
  std::vector<float> differences;
  for (int y = 1; y + 1 < extent.height; ++y) {
    for (int x = 1; x + 1 < extent.width; ++x) {
      const auto value = [&](int column, int row) { return picture.values[extent.index(column, row)]; };
      const float corners =
          value(x - 1, y - 1) + value(x + 1, y - 1) + value(x - 1, y + 1) + value(x + 1, y + 1);
      const float sides = value(x - 1, y) + value(x + 1, y) + value(x, y - 1) + value(x, y + 1);
      differences.push_back(std::abs(corners - 2.0F * sides + 4.0F * value(x, y)));
    }
  }
  if (differences.empty()) {
    return 0.0;
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::ranges::nth_element(differences, middle);
  // Of a normal distribution the median of the magnitude is 0.6745 standard deviations; of the difference of
  // differences the standard deviation is 6 times the noise's: 4 * 1 + 4 * 4 + 16 = 36.
  return static_cast<double>(*middle) / (0.6745 * 6.0);
}

} // namespace hdmbench
