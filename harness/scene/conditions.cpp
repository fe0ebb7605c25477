#include "harness/scene/scene_content.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

enum class Where { left, right, top, bottom, border, outside };
constexpr std::array<std::string_view, 6> places{"left", "right", "top", "bottom", "border", "outside"};

struct Condition {
  Where where{};
  std::optional<double> dx{};
  std::optional<double> dy{};
  std::optional<double> outward{};
  double closing = 0.0; ///< fraction of the image's shorter side
  double confidence = 1.0;
};

Condition read_condition(TomlReader& table, bool may_be_springs) {
  Condition condition;
  if (!table.has("where")) {
    table.fail("where", "is missing: left, right, top, bottom, border or outside");
  }
  table.read("where", places, condition.where);
  for (const auto& [key, value] : {std::pair{"dx", &condition.dx}, std::pair{"dy", &condition.dy},
                                   std::pair{"outward", &condition.outward}}) {
    table.read(key, *value);
    require_possible_displacement(table, key, value->value_or(0.0));
  }
  table.read("confidence", condition.confidence);
  if (condition.where == Where::outside) {
    table.read("closing", condition.closing);
  }
  if (std::optional<double> deviation; may_be_springs) {
    table.read("deviation", deviation);
    if (deviation && table.has("confidence")) {
      table.fail("deviation", "cannot stand beside confidence");
    }
    condition.confidence =
        deviation ? static_cast<double>(confidence_of_deviation(*deviation)) : condition.confidence;
  }
  table.finish();
  if (!condition.dx && !condition.dy && !condition.outward) {
    table.fail("where", "has no displacement beside it: give dx, dy or outward");
  }
  if (condition.outward && (condition.dx || condition.dy)) {
    table.fail("outward", "cannot stand beside dx or dy");
  }
  return condition;
}

void set(const Condition& condition, std::size_t site, std::optional<double> dx, std::optional<double> dy,
         Level& level) {
  const auto confidence = static_cast<float>(condition.confidence);
  if (dx) {
    level.target[0][site] = static_cast<float>(*dx);
    level.confidence[0][site] = confidence;
  }
  if (dy) {
    level.target[1][site] = static_cast<float>(*dy);
    level.confidence[1][site] = confidence;
  }
}

/// On one side, or away from the image centre by `outward` pixels.
void apply_on_border(const Condition& condition, Level& level) {
  const Extent extent = level.extent;
  const double centre_x = 0.5 * (extent.width - 1);
  const double centre_y = 0.5 * (extent.height - 1);
  const auto apply = [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    if (condition.outward) {
      const double distance = std::hypot(x - centre_x, y - centre_y);
      const double scale = distance > 0.0 ? *condition.outward / distance : 0.0;
      set(condition, site, (x - centre_x) * scale, (y - centre_y) * scale, level);
    } else {
      set(condition, site, condition.dx, condition.dy, level);
    }
  };
  const auto is_at = [&](Where side) { return condition.where == side || condition.where == Where::border; };
  for (int y = 0; y < extent.height && is_at(Where::left); ++y) {
    apply(0, y);
  }
  for (int y = 0; y < extent.height && is_at(Where::right); ++y) {
    apply(extent.width - 1, y);
  }
  for (int x = 0; x < extent.width && is_at(Where::top); ++x) {
    apply(x, 0);
  }
  for (int x = 0; x < extent.width && is_at(Where::bottom); ++x) {
    apply(x, extent.height - 1);
  }
}

/// Pixels from (x, y) along the unit vector n to the last row or column of pixel centres.
double distance_to_border(double x, double y, double nx, double ny, Extent extent) {
  double distance = std::numeric_limits<double>::infinity();
  if (nx != 0.0) {
    distance = std::min(distance, ((nx > 0.0 ? extent.width - 1 : 0) - x) / nx);
  }
  if (ny != 0.0) {
    distance = std::min(distance, ((ny > 0.0 ? extent.height - 1 : 0) - y) / ny);
  }
  return std::isfinite(distance) ? distance : 0.0;
}

/// Thesis 5.12: everything outside is known. `outward` pixels along the normal at the outline, falling
/// linearly along the normal to 0 at the image border.
void apply_outside(TomlReader& scene, const Condition& condition, const LabelField& labels, Level& level) {
  const Extent extent = labels.extent;
  std::vector<bool> inside(extent.sites());
  std::transform(labels.values.begin(), labels.values.end(), inside.begin(),
                 [](int label) { return label != 0; });
  if (std::ranges::find(inside, false) == inside.end()) {
    scene.fail("condition", "where = \"outside\": no pixel has label 0, so nothing is outside");
  }
  inside = close_gaps(inside, extent, condition.closing * std::min(extent.width, extent.height));
  if (!condition.outward) {
    for (std::size_t site = 0; site < inside.size(); ++site) {
      if (!inside[site]) {
        set(condition, site, condition.dx, condition.dy, level);
      }
    }
    return;
  }
  if (std::ranges::find(inside, true) == inside.end()) {
    scene.fail("condition",
               "where = \"outside\": every pixel has label 0, so there is no outline to move outward");
  }
  const Outline outline = find_outline(inside, extent);
  for_each_site(extent, [&](int x, int y) {
    const auto site = extent.index(x, y);
    if (inside[site]) {
      return;
    }
    const double nx = static_cast<double>(outline.normal[0][site]);
    const double ny = static_cast<double>(outline.normal[1][site]);
    const double from_outline = std::max(0.0, static_cast<double>(outline.distance.values[site]));
    const double to_border = distance_to_border(x, y, nx, ny, extent);
    const double path = from_outline + to_border;
    const double length = path > 0.0 ? *condition.outward * to_border / path : 0.0;
    set(condition, site, nx * length, ny * length, level);
  });
}

} // namespace

void apply_conditions(TomlReader& scene, const LabelField& labels, bool may_be_springs, Level& level) {
  for (TomlReader& table : scene.tables("condition")) {
    const Condition condition = read_condition(table, may_be_springs);
    if (condition.where == Where::outside) {
      apply_outside(scene, condition, labels, level);
    } else {
      apply_on_border(condition, level);
    }
  }
}

} // namespace hdmbench
