#include "harness/applications/picture.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <numeric>
#include <string_view>

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

constexpr int smallest_side = 16; // pixels

InputError unusable(std::string_view why) {
  return InputError(fmt::format("registration: {}", why));
}

void require_picture(const ScalarField& picture, std::string_view which) {
  const Extent extent = picture.extent;
  if (std::min(extent.width, extent.height) < smallest_side ||
      (extent.depth > 1 && extent.depth < smallest_side)) {
    throw unusable(fmt::format("the pictures are {}, at least {} pixels a side are needed", extent.text(),
                               smallest_side));
  }
  const auto bad = std::ranges::find_if_not(picture.values, [](float gray) { return std::isfinite(gray); });
  if (bad != picture.values.end()) {
    const auto site = static_cast<std::size_t>(bad - picture.values.begin());
    throw unusable(fmt::format("the {} at {} is {}", which, extent.place(site), *bad));
  }
  const auto [low, high] = std::ranges::minmax(picture.values);
  if (low == high || !std::isfinite(high - low)) {
    throw unusable(fmt::format("the gray values of the {} are {} ... {}, there is no contrast to register by",
                               which, low, high));
  }
}

} // namespace

double product(const VectorField& a, const VectorField& b) {
  double sum = 0.0;
  for (std::size_t site = 0; site < a.extent.sites(); ++site) {
    double of_site = 0.0;
    for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
      of_site += static_cast<double>(a[axis][site]) * static_cast<double>(b[axis][site]);
    }
    sum += of_site;
  }
  return sum;
}

void add(VectorField& field, float factor, const VectorField& more) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    std::ranges::transform(field[axis], more[axis], field[axis].begin(),
                           [&](float a, float b) { return a + factor * b; });
  }
}

ScalarField blurred(const ScalarField& picture, double sigma) {
  if (!(sigma > 0.0)) {
    return picture;
  }
  const Extent extent = picture.extent;
  const std::vector<float> weights = gaussian(sigma);
  const int reach = static_cast<int>(weights.size()) / 2;
  ScalarField result = picture;
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const std::vector<float> from = result.values;
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
    for (int row = 0; row < extent.rows(); ++row) {
      const int y = row % extent.height;
      const int z = row / extent.height;
      const float* const own = &from[extent.index(0, row)];
      std::vector<float> beyond(axis == 0 ? weights.size() - 1 : 0, own[0]); // the row with its border
      if (axis == 0) {
        beyond.insert(beyond.begin() + reach, own, own + extent.width);
        std::fill(beyond.end() - reach, beyond.end(), own[extent.width - 1]);
      }
      float* const to = &result.values[extent.index(0, row)];
      std::fill_n(to, extent.width, 0.0F);
      for (int i = -reach; i <= reach; ++i) {
        const float weight = weights[static_cast<std::size_t>(i + reach)];
        const float* const line = axis == 0 ? beyond.data() + reach + i
                                  : axis == 1
                                      ? &from[extent.index(0, std::clamp(y + i, 0, extent.height - 1), z)]
                                      : &from[extent.index(0, y, std::clamp(z + i, 0, extent.depth - 1))];
        for (int x = 0; x < extent.width; ++x) {
          to[x] += weight * line[x];
        }
      }
    }
  }
  return result;
}

VectorField blurred(const VectorField& field, double sigma) {
  VectorField result(field.extent);
  ScalarField component(field.extent);
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    component.values = field[axis];
    result[axis] = blurred(component, sigma).values;
  }
  return result;
}

VectorField gradient(const ScalarField& picture) {
  const Extent extent = picture.extent;
  VectorField result(extent);
  const std::array<std::size_t, 3> strides{1, extent.index(0, 1), extent.index(0, 0, 1)};
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      const std::size_t site = extent.index(x, row);
      const std::array<int, 3> at{x, row % extent.height, row / extent.height};
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        const std::size_t before = at[axis] > 0 ? 1 : 0;
        const std::size_t after = at[axis] + 1 < extent.sides()[axis] ? 1 : 0;
        result[axis][site] =
            (picture.values[site + after * strides[axis]] - picture.values[site - before * strides[axis]]) /
            static_cast<float>(before + after);
      }
    }
  }
  return result;
}

Extent halved(Extent extent) {
  return {(extent.width + 1) / 2, (extent.height + 1) / 2, (extent.depth + 1) / 2};
}

ScalarField halved(const ScalarField& picture) {
  const ScalarField smooth = blurred(picture, blur_before_halving);
  ScalarField result(halved(picture.extent));
  for_each_site(result.extent, [&](int x, int y, int z) {
    result.values[result.extent.index(x, y, z)] = smooth.values[picture.extent.index(2 * x, 2 * y, 2 * z)];
  });
  return result;
}

ScalarField halved_mean(const ScalarField& field) {
  const Extent extent = field.extent;
  ScalarField result(halved(extent));
  const int corners = 1 << extent.axes();
  for_each_site(result.extent, [&](int x, int y, int z) {
    float sum = 0.0F;
    for (int corner = 0; corner < corners; ++corner) {
      sum += field.values[extent.index(std::min(2 * x + (corner & 1), extent.width - 1),
                                       std::min(2 * y + (corner >> 1 & 1), extent.height - 1),
                                       std::min(2 * z + (corner >> 2), extent.depth - 1))];
    }
    result.values[result.extent.index(x, y, z)] = sum / static_cast<float>(corners);
  });
  return result;
}

double mean_inside(const ScalarField& field, const ScalarField& region, double otherwise) {
  double sum = 0.0;
  double sites = 0.0;
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    if (region.values[site] != 0.0F) {
      sum += static_cast<double>(field.values[site]);
      sites += 1.0;
    }
  }
  return sites > 0.0 ? sum / sites : otherwise;
}

void blend_moduli(ScalarField& modulus, const ScalarField& region, float resistance) {
  const auto mean = static_cast<float>(mean_inside(modulus, region, 0.0));
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    if (region.values[site] != 0.0F) {
      float& value = modulus.values[site];
      value = resistance * (mean + resistance * (value - mean));
    }
  }
}

VectorField doubled(const VectorField& displacement, Extent extent) {
  VectorField result(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        result[axis][extent.index(x, row)] =
            2.0F * sample(displacement[axis], displacement.extent, 0.5F * static_cast<float>(x),
                          0.5F * static_cast<float>(row % extent.height),
                          0.5F * static_cast<float>(row / extent.height));
      }
    }
  }
  return result;
}

std::array<float, 3> end_of(const VectorField& displacement, int x, int row) {
  const Extent extent = displacement.extent;
  std::array<float, 3> at{static_cast<float>(x), static_cast<float>(row % extent.height),
                          static_cast<float>(row / extent.height)};
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    at[axis] += displacement[axis][extent.index(x, row)];
  }
  return at;
}

ScalarField pulled_back(const ScalarField& picture, const VectorField& displacement) {
  const Extent extent = picture.extent;
  ScalarField result(extent);
#pragma omp parallel for if (extent.sites() > sites_worth_threads)
  for (int row = 0; row < extent.rows(); ++row) {
    for (int x = 0; x < extent.width; ++x) {
      const auto [at_x, at_y, at_z] = end_of(displacement, x, row);
      result.values[extent.index(x, row)] = sample(picture.values, extent, at_x, at_y, at_z);
    }
  }
  return result;
}

double noise_of(const ScalarField& picture) {
  const Extent extent = picture.extent;
  std::vector<float> differences;
  differences.reserve(extent.sites());
  for (int row = 0; row < extent.rows(); ++row) {
    const int y = row % extent.height;
    for (int x = 1; x + 1 < extent.width && y > 0 && y + 1 < extent.height; ++x) {
      const auto value = [&](int column, int line) { return picture.values[extent.index(column, line)]; };
      const float corners =
          value(x - 1, row - 1) + value(x + 1, row - 1) + value(x - 1, row + 1) + value(x + 1, row + 1);
      const float sides = value(x - 1, row) + value(x + 1, row) + value(x, row - 1) + value(x, row + 1);
      differences.push_back(std::abs(corners - 2.0F * sides + 4.0F * value(x, row)));
    }
  }
  // Of a normal distribution the median of the magnitude is 0.6745 standard deviations; of the difference of
  // differences the standard deviation is 6 times the noise's: 4 * 1 + 4 * 4 + 16 = 36.
  return differences.empty() ? 0.0 : static_cast<double>(median_of(differences)) / (0.6745 * 6.0);
}

ScalarField with_values_of(const ScalarField& source, const ScalarField& target, const ScalarField& unseen) {
  constexpr std::size_t bins = 24;
  constexpr double enough = 20.0; // sites of a bin, for a mean
  const auto [low, high] = std::ranges::minmax(source.values);
  if (!(high > low)) {
    return source;
  }
  const float scale = static_cast<float>(bins - 1) / (high - low);
  const auto position = [&](float gray) {
    const float at = (gray - low) * scale;
    const auto bin = std::min(static_cast<std::size_t>(at), bins - 2);
    return std::pair{bin, at - static_cast<float>(bin)};
  };
  std::array<double, bins> weight{};
  std::array<double, bins> sum{};
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    if (!is_seen(unseen, site)) {
      continue;
    }
    const auto [bin, past] = position(source.values[site]);
    const auto share = static_cast<double>(past);
    const double change = static_cast<double>(target.values[site]) - static_cast<double>(source.values[site]);
    weight[bin] += 1.0 - share;
    weight[bin + 1] += share;
    sum[bin] += (1.0 - share) * change;
    sum[bin + 1] += share * change;
  }
  // What a bin with too few sites changes by is what its neighbours do.
  const double total = std::accumulate(weight.begin(), weight.end(), 0.0);
  double last = total > 0.0 ? std::accumulate(sum.begin(), sum.end(), 0.0) / total : 0.0;
  std::array<float, bins> shift{};
  for (std::size_t bin = 0; bin < bins; ++bin) {
    last = weight[bin] >= enough ? sum[bin] / weight[bin] : last;
    shift[bin] = static_cast<float>(last);
  }
  ScalarField result(source.extent);
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    const auto [bin, past] = position(source.values[site]);
    result.values[site] = source.values[site] + shift[bin] + past * (shift[bin + 1] - shift[bin]);
  }
  return result;
}

void require_pair(const ScalarField& source, const ScalarField& target) {
  if (source.extent != target.extent) {
    throw unusable(fmt::format("the source is {} pixels, the target {}; crop or resample one of them",
                               source.extent.text(), target.extent.text()));
  }
  require_picture(source, "source");
  require_picture(target, "target");
}

void prepare_pair(ScalarField& source, ScalarField& target) {
  require_pair(source, target);
  const auto [low_source, high_source] = std::ranges::minmax(source.values);
  const auto [low_target, high_target] = std::ranges::minmax(target.values);
  const float bright_source = low_source + 0.2F * (high_source - low_source);
  const float bright_target = low_target + 0.2F * (high_target - low_target);
  bool is_bright = false; // somewhere at the same place
  for (std::size_t site = 0; site < source.values.size(); ++site) {
    is_bright |= source.values[site] > bright_source && target.values[site] > bright_target;
  }
  if (!is_bright) {
    throw unusable(
        "the two pictures do not overlap, nothing bright is at one place in both; align them first");
  }
  const float low = std::min(low_source, low_target);
  const float scale = 255.0F / (std::max(high_source, high_target) - low);
  for (ScalarField* const picture : {&source, &target}) {
    for (float& gray : picture->values) {
      gray = (gray - low) * scale;
    }
  }
}

void require_region(const ScalarField& region, std::string_view name) {
  std::size_t inside = 0;
  for (std::size_t site = 0; site < region.values.size(); ++site) {
    const float value = region.values[site];
    if (!std::isfinite(value)) {
      throw InputError(fmt::format("{}: the mask at {} is {}; give 0 outside the region, 1 inside", name,
                                   region.extent.place(site), value));
    }
    inside += value != 0.0F ? 1U : 0U;
  }
  if (inside == 0 || inside == region.values.size()) {
    throw InputError(fmt::format("{}: the region of interest is {}", name,
                                 inside == 0 ? "empty, every pixel is 0"
                                             : "the whole image; something around it must be known"));
  }
}

Similarity similarity(const ScalarField& a, const ScalarField& b) {
  constexpr int bins = Similarity::bins;
  Similarity result;
  const auto values_of = [](const ScalarField& picture) -> Eigen::ArrayXd {
    return Eigen::Map<const Eigen::ArrayXf>(picture.values.data(), std::ssize(picture.values)).cast<double>();
  };
  const Eigen::ArrayXd first = values_of(a);
  const Eigen::ArrayXd second = values_of(b);
  result.mean_squares = (first - second).square().mean();
  const Eigen::ArrayXd from_mean = first - first.mean();
  const Eigen::ArrayXd other_from_mean = second - second.mean();
  const double spread = std::sqrt(from_mean.square().sum() * other_from_mean.square().sum());
  if (!(spread > 0.0)) {
    return result;
  }
  result.correlation = (from_mean * other_from_mean).sum() / spread;
  const auto bin_of = [](const ScalarField& picture) {
    const auto [low, high] = std::ranges::minmax(picture.values);
    return [low = low, scale = static_cast<float>(bins) / (high - low)](float gray) {
      return std::min(static_cast<int>((gray - low) * scale), bins - 1);
    };
  };
  const auto bin_a = bin_of(a);
  const auto bin_b = bin_of(b);
  Eigen::Array<double, bins, bins> joint = Eigen::Array<double, bins, bins>::Zero();
  for (std::size_t site = 0; site < a.values.size(); ++site) {
    joint(bin_a(a.values[site]), bin_b(b.values[site])) += 1.0 / static_cast<double>(a.values.size());
  }
  const Eigen::Array<double, bins, bins> apart =
      (joint.rowwise().sum().matrix() * joint.colwise().sum().matrix()).array();
  result.mutual_information = (joint > 0.0).select(joint * (joint / apart).log(), 0.0).sum() / std::log(2.0);
  return result;
}

} // namespace hdmbench
