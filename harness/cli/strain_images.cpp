#include "harness/cli/strain_images.hpp"

#include "harness/judge/diagnosis/deformation.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/images/images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::commands {

namespace {

/// The site with the value of largest size.
std::size_t extreme(const ScalarField& field) {
  const auto found = std::ranges::max_element(field.values, {}, [](float value) { return std::abs(value); });
  return static_cast<std::size_t>(found - field.values.begin());
}

} // namespace

std::vector<std::string> strain_image_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const char* const what : {"strain-xx", "strain-yy", "strain-xy", "von-mises", "area-change"}) {
    names.push_back(fmt::format("{}-{}.nrrd", scene.name, what));
    names.push_back(fmt::format("{}-{}.png", scene.name, what));
  }
  names.pop_back(); // the area's picture is every run's
  return names;
}

std::vector<std::string> write_strain_images(const Scene& scene, const VectorField& displacement,
                                             const std::filesystem::path& folder) {
  const Strains strains = strains_of(displacement, scene.full.modulus, scene.poisson);
  const ScalarField area = area_change_map(displacement);
  const std::vector<std::string> names = strain_image_names(scene);
  auto name = names.begin();
  Table table({"<strains", "farthest from 0", "x", "y"});
  const auto write = [&](const char* what, const ScalarField& field, bool with_png) {
    const std::size_t at = extreme(field);
    const double largest = std::max(std::abs(static_cast<double>(field.values[at])), 1e-30);
    write_scalar(folder / *name++, field, scene.spacing, scene.placement);
    if (with_png) {
      write_signed_png(folder / *name++, field.extent, field.values, largest);
    }
    const auto width = static_cast<std::size_t>(field.extent.width);
    table.add({what, fmt::format("{:.4g}", field.values[at]), std::to_string(at % width),
               std::to_string(at / width)});
  };
  write("strain-xx", strains.xx, true);
  write("strain-yy", strains.yy, true);
  write("strain-xy", strains.xy, true);
  write("von-mises", strains.von_mises, true);
  write("area-change", area, false);
  fmt::print("{}  von-mises: MPa, plane stress, Poisson ratio {:.4g}; area-change: det(I + grad d) - 1\n",
             table.text(), scene.poisson);
  return names;
}

} // namespace hdmbench::commands
