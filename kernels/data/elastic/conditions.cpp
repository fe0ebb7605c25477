#include "kernels/data/elastic/conditions.hpp"

#include "kernels/data/elastic/cell_kinds.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// The mean of all that is known, where nothing else is.
void fill(Known& coarsest) {
  double weight = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < coarsest.value.size(); ++i) {
    weight += static_cast<double>(coarsest.weight[i]);
    sum += static_cast<double>(coarsest.weight[i]) * static_cast<double>(coarsest.value[i]);
  }
  for (std::size_t i = 0; i < coarsest.value.size(); ++i) {
    if (coarsest.weight[i] <= 0.0F && weight > 0.0) {
      coarsest.value[i] = static_cast<float>(sum / weight);
    }
  }
}

} // namespace

Known averaged(const Known& fine) {
  Known coarse({fine.extent.width / 2 + 1, fine.extent.height / 2 + 1});
#pragma omp parallel for if (fine.extent.sites() > sites_worth_threads)
  for (int y = 0; y < coarse.extent.height; ++y) {
    for (int x = 0; x < coarse.extent.width; ++x) {
      float weight = 0.0F;
      float sum = 0.0F;
      for (int j = std::max(2 * y - 1, 0); j <= std::min(2 * y + 1, fine.extent.height - 1); ++j) {
        for (int i = std::max(2 * x - 1, 0); i <= std::min(2 * x + 1, fine.extent.width - 1); ++i) {
          const std::size_t at = fine.extent.index(i, j);
          const float share = (i == 2 * x ? 1.0F : 0.5F) * (j == 2 * y ? 1.0F : 0.5F) * fine.weight[at];
          weight += share;
          sum += share * fine.value[at];
        }
      }
      if (weight > 0.0F) {
        coarse.value[coarse.extent.index(x, y)] = sum / weight;
        coarse.weight[coarse.extent.index(x, y)] = std::min(weight, 1.0F);
      }
    }
  }
  return coarse;
}

void fill(Known& fine, const Known& coarse) {
#pragma omp parallel for if (fine.extent.sites() > sites_worth_threads)
  for (int y = 0; y < fine.extent.height; ++y) {
    for (int x = 0; x < fine.extent.width; ++x) {
      const std::size_t at = fine.extent.index(x, y);
      const float missing = 1.0F - fine.weight[at];
      if (missing > 0.0F) {
        const auto coarse_value = [&](int i, int j) { return coarse.value[coarse.extent.index(i, j)]; };
        const int west = x / 2;
        const int north = y / 2;
        const int east = west + x % 2;
        const int south = north + y % 2;
        const float mean = 0.25F * ((coarse_value(west, north) + coarse_value(east, north)) +
                                    (coarse_value(west, south) + coarse_value(east, south)));
        fine.value[at] = fine.weight[at] * fine.value[at] + missing * mean;
      }
    }
  }
}

Known known_component(Extent extent, const std::vector<float>& target, const std::vector<float>& confidence) {
  Known known(extent);
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    const bool prescribed = confidence[i] > 0.0F;
    known.weight[i] = prescribed ? 1.0F : 0.0F;
    known.value[i] = prescribed ? target[i] : 0.0F;
  }
  return known;
}

void extend(Known& known) {
  if (known.extent.width <= 2 && known.extent.height <= 2) {
    fill(known);
    return;
  }
  Known coarse = averaged(known);
  extend(coarse);
  fill(known, coarse);
}

void require_held(Extent image, const Hold& hold) {
  if (image.width < 2 || image.height < 2) {
    throw InputError(fmt::format("the elastic energy needs at least 2 x 2 pixels, the image is {} x {}",
                                 image.width, image.height));
  }
  if (const std::string freedom = hold.freedom(); !freedom.empty()) {
    throw InputError(fmt::format("the conditions leave the elastic sheet free to move: all {} x {} sites {}",
                                 image.width, image.height, freedom));
  }
}

void require_held(const Level& level) {
  Hold hold;
  for (int y = 0; y < level.extent.height && hold.is_free(); ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      hold.add(level, x, y);
    }
  }
  require_held(level.extent, hold);
  require_parts_held(level);
}

VectorField extended_conditions(const Level& level) {
  VectorField field;
  field.extent = level.extent;
  const auto extended = [&](const std::vector<float>& target, const std::vector<float>& confidence) {
    Known known = known_component(level.extent, target, confidence);
    extend(known);
    return std::move(known.value);
  };
  field.x = extended(level.target.x, level.confidence.x);
  field.y = extended(level.target.y, level.confidence.y);
  return field;
}

} // namespace hdmbench
