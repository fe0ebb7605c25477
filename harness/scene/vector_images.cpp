#include "harness/scene/carried_conditions.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace hdmbench {

namespace {

/// `why_wrong` returns what is wrong with a value, or nothing.
template <typename WhyWrong>
void require(TomlReader& image, std::string_view key, const VectorField& field, const WhyWrong& why_wrong) {
  for (std::size_t axis = 0; axis < field.extent.axes(); ++axis) {
    for (std::size_t site = 0; site < field[axis].size(); ++site) {
      if (const char* const why = why_wrong(field[axis][site]); why != nullptr) {
        image.fail(
            key, fmt::format("{} (its value at {} is {})", why, field.extent.place(site), field[axis][site]));
      }
      require_possible_displacement(image, key, key == "deviation" ? 0.0 : double{field[axis][site]});
    }
  }
}

} // namespace

void read_vector_images(TomlReader& image, const SceneText& file, std::optional<Extent> size,
                        const Content& content, Scene& scene) {
  bool is_physical = false;
  const auto read = [&](std::string_view key, bool as_stored) {
    ReadOptions options{.size = as_stored ? std::nullopt : size,
                        .spacing = content.stated_spacing,
                        .takes_volumes = true,
                        .as_stored = as_stored};
    if (is_physical && key == "target") {
      options.physical_side = content.spacing;
    }
    const std::filesystem::path vectors = file.image(image, key, options);
    Image<VectorField> found = read_vector(vectors, options);
    require_same_grid(image, key, found.grid, content.grid);
    return std::move(found.pixels);
  };
  const auto is_displacement = [](float value) {
    return std::isfinite(value) ? nullptr : "must be finite; where nothing is observed the confidence is 0";
  };
  image.refuse_unless(scene.energy->is_of_cells(), "deviation");
  image.refuse_unless(!scene.energy->is_of_cells(), "start");
  const bool has_deviation = image.has("deviation");
  if (image.has("target") != (image.has("confidence") || has_deviation)) {
    image.fail("target", "and confidence (or deviation): give both images or none");
  }
  if (image.has("confidence") && has_deviation) {
    image.fail("deviation", "cannot stand beside confidence");
  }
  if (image.has("target")) {
    image.read("target_unit", std::array<std::string_view, 2>{"pixels", "mm"}, is_physical);
    const char* const certainty = has_deviation ? "deviation" : "confidence";
    FileConditions known{.target = read("target", true),
                         .confidence = read(certainty, true),
                         .at = positions_of(content.grid, content.spacing, content.placement)};
    require(image, "target", known.target, is_displacement);
    require(image, certainty, known.confidence, [&](float value) -> const char* {
      if (has_deviation) {
        return value >= 0.0F ? nullptr : "has a value below 0 (pixels); infinite is not observed";
      }
      return value >= 0.0F && value <= 1.0F ? nullptr : "must be 0 ... 1";
    });
    for (std::vector<float>& plane : known.confidence.planes) {
      for (float& value : plane) {
        value = has_deviation ? confidence_of_deviation(static_cast<double>(value)) : value; // 0 of infinity
      }
    }
    scene.observed = carry_conditions(known, scene.energy->is_of_cells(), scene.full);
  }
  if (image.has("start")) {
    scene.start = read("start", false);
    require(image, "start", *scene.start, is_displacement);
  }
}

} // namespace hdmbench
