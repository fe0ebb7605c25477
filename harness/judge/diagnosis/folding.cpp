#include "harness/judge/diagnosis/folding.hpp"

#include "harness/judge/diagnosis/checks.hpp"
#include "harness/judge/diagnosis/gradient.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace hdmbench {

ScalarField least_area_ratios(const VectorField& displacement) {
  const Extent extent = displacement.extent;
  if (extent.width < 2 || extent.height < 2) {
    return {};
  }
  ScalarField ratios({extent.width - 1, extent.height - 1});
  for (int y = 0; y + 1 < extent.height; ++y) {
    for (int x = 0; x + 1 < extent.width; ++x) {
      double least = 0.0;
      for (const int corner : {0, 1, 2, 3}) {
        const double ratio =
            gradient_in_cell(displacement, x, y, corner % 2 == 0 ? -1.0 : 1.0, corner / 2 == 0 ? -1.0 : 1.0)
                .area_ratio();
        least = corner == 0 ? ratio : std::min(least, ratio);
      }
      ratios.values[ratios.extent.index(x, y)] = static_cast<float>(least);
    }
  }
  return ratios;
}

ScalarField area_change_map(const VectorField& displacement) {
  const ScalarField ratios = least_area_ratios(displacement);
  ScalarField map(displacement.extent);
  if (ratios.values.empty()) {
    return map;
  }
  for_each_site(map.extent, [&](int x, int y) {
    float least = std::numeric_limits<float>::infinity();
    for (int cell_y = std::max(0, y - 1); cell_y <= std::min(y, ratios.extent.height - 1); ++cell_y) {
      for (int cell_x = std::max(0, x - 1); cell_x <= std::min(x, ratios.extent.width - 1); ++cell_x) {
        least = std::min(least, ratios.values[ratios.extent.index(cell_x, cell_y)]);
      }
    }
    map.values[map.extent.index(x, y)] = least - 1.0F;
  });
  return map;
}

namespace diagnosis {

void check_folding(const VectorField& displacement, Warnings& warnings) {
  // A tenth of the area left: from here on linear interpolation of what moved there is unreliable.
  constexpr float nearly_folded = 0.1F;
  const ScalarField ratios = least_area_ratios(displacement);
  if (ratios.values.empty()) {
    return;
  }
  const auto worst = std::ranges::min_element(ratios.values);
  const std::string where = place(ratios.extent, static_cast<std::size_t>(worst - ratios.values.begin()));
  const auto folded = static_cast<std::size_t>(
      std::ranges::count_if(ratios.values, [](float ratio) { return ratio <= 0.0F; }));
  const auto near = static_cast<std::size_t>(std::ranges::count_if(
                        ratios.values, [](float ratio) { return ratio < nearly_folded; })) -
                    folded;
  if (folded > 0) {
    warnings.push_back(
        {"fold-over",
         fmt::format(
             "the image is turned over in {} of {} cells between sites (det(I + grad d) <= 0), and {} more "
             "keep less than a tenth of their area; worst {:.3g} at {}",
             folded, ratios.values.size(), near, *worst, where),
         "smaller displacements, or a wider way for them to fade out; the picture \"jacobian\" shows where",
         folded});
  } else if (near > 0) {
    warnings.push_back(
        {"near-fold",
         fmt::format("{} of {} cells between sites keep less than a tenth of their area; least "
                     "{:.3g} at {}",
                     near, ratios.values.size(), *worst, where),
         "look at the picture \"jacobian\" before you trust what moved there", near});
  }
}

} // namespace diagnosis

} // namespace hdmbench
