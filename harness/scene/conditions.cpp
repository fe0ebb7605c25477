#include "harness/scene/scene_content.hpp"

#include "harness/scene/outline.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hdmbench {

namespace {

enum class Where { left, right, top, bottom, border, outside };
constexpr std::array<std::string_view, 6> places{"left", "right", "top", "bottom", "border", "outside"};

struct Condition {
  Where where;
  std::optional<double> dx;
  std::optional<double> dy;
  std::optional<double> outward;
  double closing = 0.0; ///< fraction of the image's shorter side
  float confidence = 1.0F;
};

Condition read_condition(TomlReader& table, EnergyModel energy) {
  if (!table.has("where")) {
    table.fail("where", "is missing: left, right, top, bottom, border or outside");
  }
  Condition condition{.where = static_cast<Where>(table.choice("where", places, 0)),
                      .dx = table.optional_number("dx"),
                      .dy = table.optional_number("dy"),
                      .outward = table.optional_number("outward"),
                      .closing = table.number("closing", 0.0),
                      .confidence = static_cast<float>(table.number("confidence", 1.0))};
  table.refuse_unless(energy == EnergyModel::elastic, "deviation");
  if (const std::optional<double> deviation = table.optional_number("deviation")) {
    if (table.has("confidence")) {
      table.fail("deviation", "cannot stand beside confidence");
    }
    if (!(*deviation >= 0.0)) {
      table.fail("deviation", "must be at least 0 (pixels)");
    }
    condition.confidence = confidence_of_deviation(*deviation);
  }
  table.finish();
  require_possible_displacement(table, "dx", condition.dx.value_or(0.0));
  require_possible_displacement(table, "dy", condition.dy.value_or(0.0));
  require_possible_displacement(table, "outward", condition.outward.value_or(0.0));
  if (!(condition.confidence >= 0.0F && condition.confidence <= 1.0F)) {
    table.fail("confidence", "must be within 0 ... 1");
  }
  if (!(condition.closing >= 0.0 && condition.closing < 1.0)) {
    table.fail("closing", "must be at least 0 and below 1 (a fraction of the image)");
  }
  table.refuse_unless(condition.where == Where::outside, "closing");
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
  if (dx) {
    level.target.x[site] = static_cast<float>(*dx);
    level.confidence.x[site] = condition.confidence;
  }
  if (dy) {
    level.target.y[site] = static_cast<float>(*dy);
    level.confidence.y[site] = condition.confidence;
  }
}

bool is_at(Where where, int x, int y, Extent extent) {
  const bool left = x == 0;
  const bool right = x == extent.width - 1;
  const bool top = y == 0;
  const bool bottom = y == extent.height - 1;
  switch (where) {
  case Where::left:
    return left;
  case Where::right:
    return right;
  case Where::top:
    return top;
  case Where::bottom:
    return bottom;
  case Where::border:
    return left || right || top || bottom;
  case Where::outside:
    return false;
  }
  return false;
}

/// On one side, or away from the image centre by `outward` pixels.
void apply_on_border(const Condition& condition, Level& level) {
  const Extent extent = level.extent;
  const double centre_x = 0.5 * (extent.width - 1);
  const double centre_y = 0.5 * (extent.height - 1);
  for (int y = 0; y < extent.height; ++y) {
    const bool whole_row = y == 0 || y == extent.height - 1;
    for (int x = 0; x < extent.width; ++x) {
      if (!is_at(condition.where, x, y, extent)) {
        x = whole_row ? x : std::max(x, extent.width - 2);
        continue;
      }
      const std::size_t site = extent.index(x, y);
      if (condition.outward) {
        const double distance = std::hypot(x - centre_x, y - centre_y);
        const double scale = distance > 0.0 ? *condition.outward / distance : 0.0;
        set(condition, site, (x - centre_x) * scale, (y - centre_y) * scale, level);
      } else {
        set(condition, site, condition.dx, condition.dy, level);
      }
    }
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
  for (int y = 0; y < extent.height; ++y) {
    for (int x = 0; x < extent.width; ++x) {
      const auto site = extent.index(x, y);
      if (inside[site]) {
        continue;
      }
      const double nx = static_cast<double>(outline.normal.x[site]);
      const double ny = static_cast<double>(outline.normal.y[site]);
      const double from_outline = std::max(0.0, static_cast<double>(outline.distance.values[site]));
      const double to_border = distance_to_border(x, y, nx, ny, extent);
      const double path = from_outline + to_border;
      const double length = path > 0.0 ? *condition.outward * to_border / path : 0.0;
      set(condition, site, nx * length, ny * length, level);
    }
  }
}

} // namespace

void apply_conditions(TomlReader& scene, const LabelField& labels, EnergyModel energy, Level& level) {
  for (TomlReader& table : scene.tables("condition")) {
    const Condition condition = read_condition(table, energy);
    if (condition.where == Where::outside) {
      apply_outside(scene, condition, labels, level);
    } else {
      apply_on_border(condition, level);
    }
  }
}

} // namespace hdmbench
