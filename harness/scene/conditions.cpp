#include "harness/scene/carried_conditions.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/walls.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/elastic/springs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace hdmbench {

namespace {

/// The sides of an axis stand together, the first one first.
enum class Where { left, right, top, bottom, front, back, border, outside, labels };
constexpr std::array<std::string_view, 9> places{"left", "right",  "top",     "bottom", "front",
                                                 "back", "border", "outside", "labels"};

using Components = std::array<std::optional<double>, 3>; ///< pixels; a component without a value stays free
constexpr std::array<std::string_view, 3> components{"dx", "dy", "dz"};

struct Condition {
  Where where{};
  Components along{};
  std::optional<double> outward{};
  std::vector<float> labels{};  ///< of Where::labels
  std::vector<double> centre{}; ///< of the part of their sites that is meant, fractions; empty: all of them
  std::vector<double> size{};   ///< the same
  double closing = 0.0;         ///< fraction of the image's shorter side
  double confidence = 1.0;
  bool slides = false;                   ///< what is beside it slides along it
  std::optional<double> normal_radius{}; ///< pixels
};

/// What is marked as walls.
struct Walls {
  std::vector<bool> sites{};             ///< that were ever marked; empty: none were
  std::optional<double> normal_radius{}; ///< pixels
};

/// Reads the rest of a condition that is a wall.
void read_wall(TomlReader& table, bool may_be_springs, const Condition& condition) {
  if (!may_be_springs) {
    table.fail("slide", "belongs to the elastic energy; give energy = \"elastic\"");
  }
  if (condition.where != Where::outside && condition.where != Where::labels) {
    table.fail("slide", "belongs to where = \"outside\" or \"labels\": their outline is the wall");
  }
  if (!condition.centre.empty()) {
    table.fail("centre", "cannot stand beside slide: all of the outline is the wall");
  }
  for (const std::string_view key : {"dx", "dy", "dz", "outward", "confidence", "deviation"}) {
    if (table.has(key)) {
      table.fail(key, "cannot stand beside slide: a wall stays where it is");
    }
  }
}

Condition read_condition(TomlReader& table, bool may_be_springs, double spacing, Extent extent) {
  Condition condition;
  if (!table.has("where")) {
    table.fail("where", "is missing: left, right, top, bottom, front, back, border, outside or labels");
  }
  table.read("where", places, condition.where);
  if (extent.axes() == 2 && (condition.where == Where::front || condition.where == Where::back)) {
    table.fail("where", "is a side that only volumes have");
  }
  bool is_physical = false;
  table.read("unit", std::array<std::string_view, 2>{"pixels", "mm"}, is_physical);
  const auto read = [&](std::string_view key, std::optional<double>& value) {
    table.read(key, value);
    if (value && is_physical) {
      *value /= spacing;
    }
    require_possible_displacement(table, key, value.value_or(0.0));
  };
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    read(components[axis], condition.along[axis]);
  }
  if (condition.where == Where::labels) {
    condition.labels = table.get<std::vector<float>>("labels");
    if (table.has("centre") || table.has("size")) {
      condition.centre = table.numbers("centre", extent.axes(), extent.axes());
      condition.size = table.numbers("size", extent.axes(), extent.axes());
    }
  } else {
    read("outward", condition.outward);
  }
  table.read("slide", condition.slides);
  if (condition.slides) {
    read_wall(table, may_be_springs, condition);
  }
  table.read("normal_radius", condition.normal_radius);
  if (condition.normal_radius) {
    if (!condition.slides) {
      table.fail("normal_radius", "belongs to slide = true: it is how far the normals of a wall look");
    }
    *condition.normal_radius /= spacing;
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
  const bool moves_along = condition.along != Components{};
  const std::string keys = fmt::format("{}", fmt::join(std::span(components).first(extent.axes()), ", "));
  if (!moves_along && !condition.outward && !condition.slides) {
    table.fail("where", fmt::format("has no displacement beside it: give {}{}, or slide = true", keys,
                                    condition.where == Where::labels ? "" : " or outward"));
  }
  if (condition.outward && moves_along) {
    table.fail("outward", fmt::format("cannot stand beside {}", keys));
  }
  return condition;
}

/// The confidence of what is beyond a wall, as long as no later condition says something of it.
constexpr float beyond_a_wall = -2.0F;

void mark_beyond(std::size_t site, Level& level, std::vector<bool>& named) {
  named.resize(level.extent.sites());
  named[site] = true;
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    level.confidence[axis][site] = beyond_a_wall;
  }
}

/// Makes walls of what is marked and was not replaced by a later condition, not even in a component.
/// Returns how much their normals turn where nobody has said how far they look.
std::optional<TurnOfNormals> set_marked_walls(TomlReader& scene, const Walls& walls, const Content& content,
                                              Level& level) {
  std::vector<bool> beyond(level.extent.sites(), true);
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t site = 0; site < beyond.size(); ++site) {
      beyond[site] = beyond[site] && level.confidence[axis][site] == beyond_a_wall;
    }
    std::ranges::replace(level.confidence[axis], beyond_a_wall, 0.0F);
  }
  const std::array<double, 3>& step = content.placement.aspect;
  std::optional<double> radius = walls.normal_radius;
  if (radius) {
    const auto [least, most] = limits_of_normal_radius(beyond, level.extent, step);
    if (*radius > most) {
      scene.fail("condition",
                 fmt::format("normal_radius is {:.3g} mm, and normals that look farther than {:.3g} mm see "
                             "the other side of what slides",
                             content.spacing * *radius, content.spacing * most));
    }
    radius = std::max(*radius, least);
  }
  set_wall(beyond, walls.sites, step, level, content.normals, radius);
  return radius || !content.normals[0].empty()
             ? std::nullopt
             : std::optional(turn_of_normals(beyond, walls.sites, step, level));
}

void set(const Condition& condition, std::size_t site, const Components& displacement, Level& level) {
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    if (displacement[axis]) {
      level.target[axis][site] = static_cast<float>(*displacement[axis]);
      level.confidence[axis][site] = static_cast<float>(condition.confidence);
    }
  }
}

/// On one side, or away from the image centre by `outward` pixels. `step`: from a site to the next, pixels.
void apply_on_border(const Condition& condition, const std::array<double, 3>& step, Level& level) {
  const Extent extent = level.extent;
  const std::array<int, 3> sides = extent.sides();
  const auto apply = [&](int x, int y, int z) {
    Components displacement = condition.along;
    if (condition.outward) {
      const std::array<int, 3> place{x, y, z};
      double distance = 0.0;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        displacement[axis] = step[axis] * (place[axis] - 0.5 * (sides[axis] - 1));
        distance = std::hypot(distance, *displacement[axis]);
      }
      const double scale = distance > 0.0 ? *condition.outward / distance : 0.0;
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        *displacement[axis] *= scale;
      }
    }
    set(condition, extent.index(x, y, z), displacement, level);
  };
  for (std::size_t side = 0; side < 2 * extent.axes(); ++side) {
    if (condition.where != Where::border && condition.where != static_cast<Where>(side)) {
      continue;
    }
    std::array<int, 3> from{};
    std::array<int, 3> to = sides;
    from[side / 2] = side % 2 == 0 ? 0 : sides[side / 2] - 1;
    to[side / 2] = from[side / 2] + 1;
    for (int z = from[2]; z < to[2]; ++z) {
      for (int y = from[1]; y < to[1]; ++y) {
        for (int x = from[0]; x < to[0]; ++x) {
          apply(x, y, z);
        }
      }
    }
  }
}

/// On all sites of some labels. In an ellipse or ellipsoid by a share that falls from 1 at its centre to 0 on
/// its outline, as a membrane's that is held there.
void apply_on_labels(const Condition& condition, const LabelField& labels, Level& level,
                     std::vector<bool>& named) {
  const Extent extent = labels.extent;
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    if (std::ranges::find(condition.labels, static_cast<float>(labels.values[site])) ==
        condition.labels.end()) {
      return;
    }
    if (condition.slides) {
      mark_beyond(site, level, named);
      return;
    }
    const std::array<int, 3> place{x, y, z};
    double share = 1.0;
    for (std::size_t axis = 0; axis < condition.centre.size(); ++axis) {
      const double fraction = place[axis] / std::max(1.0, extent.sides()[axis] - 1.0);
      const double from_centre = 2.0 * (fraction - condition.centre[axis]) / condition.size[axis];
      share -= from_centre * from_centre;
    }
    if (share > 0.0) {
      Components displacement = condition.along;
      for (std::optional<double>& component : displacement) {
        component = component ? std::optional(*component * share) : component;
      }
      set(condition, site, displacement, level);
    }
  });
}

/// Pixels from a site along the unit vector n to the last pixel centres on its way.
double distance_to_border(const std::array<int, 3>& place, const std::array<double, 3>& n, Extent extent,
                          const std::array<double, 3>& step) {
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    if (n[axis] != 0.0) {
      const int sites = (n[axis] > 0.0 ? extent.sides()[axis] - 1 : 0) - place[axis];
      distance = std::min(distance, step[axis] * sites / n[axis]);
    }
  }
  return std::isfinite(distance) ? distance : 0.0;
}

/// Thesis 5.12: everything outside is known. `outward` pixels along the normal at the outline, falling
/// linearly along the normal to 0 at the image border.
void apply_outside(TomlReader& scene, const Condition& condition, const LabelField& labels,
                   const std::array<double, 3>& step, Level& level, std::vector<bool>& named) {
  const Extent extent = labels.extent;
  std::vector<bool> inside(extent.sites());
  std::transform(labels.values.begin(), labels.values.end(), inside.begin(),
                 [](int label) { return label != 0; });
  if (std::ranges::find(inside, false) == inside.end()) {
    scene.fail("condition", "where = \"outside\": no pixel has label 0, so nothing is outside");
  }
  const auto side = [&](std::size_t axis) { return step[axis] * extent.sides()[axis]; };
  const double shortest = std::min({side(0), side(1), side(extent.depth > 1 ? 2 : 0)});
  inside = close_gaps(inside, extent, condition.closing * shortest, step);
  for (std::size_t site = 0; condition.slides && site < inside.size(); ++site) {
    if (!inside[site]) {
      mark_beyond(site, level, named);
    }
  }
  if (condition.slides) {
    return;
  }
  if (!condition.outward) {
    for (std::size_t site = 0; site < inside.size(); ++site) {
      if (!inside[site]) {
        set(condition, site, condition.along, level);
      }
    }
    return;
  }
  if (std::ranges::find(inside, true) == inside.end()) {
    scene.fail("condition",
               "where = \"outside\": every pixel has label 0, so there is no outline to move outward");
  }
  const Outline outline = find_outline(inside, extent, step);
  for_each_site(extent, [&](int x, int y, int z) {
    const auto site = extent.index(x, y, z);
    if (inside[site]) {
      return;
    }
    std::array<double, 3> normal{};
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      normal[axis] = static_cast<double>(outline.normal[axis][site]);
    }
    const double from_outline = std::max(0.0, static_cast<double>(outline.distance.values[site]));
    const double to_border = distance_to_border({x, y, z}, normal, extent, step);
    const double path = from_outline + to_border;
    const double length = path > 0.0 ? *condition.outward * to_border / path : 0.0;
    set(condition, site, {normal[0] * length, normal[1] * length, normal[2] * length}, level);
  });
}

void apply(TomlReader& scene, const Condition& condition, const LabelField& labels,
           const std::array<double, 3>& step, Level& level, std::vector<bool>& named) {
  if (condition.where == Where::outside) {
    apply_outside(scene, condition, labels, step, level, named);
  } else if (condition.where == Where::labels) {
    apply_on_labels(condition, labels, level, named);
  } else {
    apply_on_border(condition, step, level);
  }
}

/// Whether it says where something stays: observations and what moves sites came later.
bool only_holds(const Condition& condition) {
  return condition.confidence >= 1.0 && condition.outward.value_or(0.0) == 0.0 &&
         std::ranges::all_of(condition.along, [](const auto& along) { return along.value_or(0.0) == 0.0; });
}

/// Whether it measures distances along all axes from sites outside, which the file's own pixels, where others
/// were made of them, do not tell as well.
bool is_metric(const Condition& condition) {
  return condition.where == Where::outside && (condition.outward || condition.closing > 0.0);
}

/// Returns the labels of the file's pixels: no site is nearer to a pixel's centre than half a site, which is
/// inside.
LabelField labels_of_pixels(const Content& content, const PixelPositions& at) {
  LabelField labels{content.oblong->extent, {}};
  const Extent sites = content.labels.extent;
  const auto nearest = [&](std::size_t axis, int pixel, int count) {
    return static_cast<int>(std::clamp(std::round(at.of(axis, pixel)), 0.0, count - 1.0));
  };
  for_each_site(labels.extent, [&](int x, int y, int z) {
    labels.values.push_back(content.labels.values[sites.index(
        nearest(0, x, sites.width), nearest(1, y, sites.height), nearest(2, z, sites.depth))]);
  });
  return labels;
}

} // namespace

AppliedConditions apply_conditions(TomlReader& scene, const Content& content, bool may_be_springs,
                                   Level& level, When when) {
  const bool is_oblong = content.oblong && !has_equal_sides(*content.oblong);
  const PixelPositions at =
      is_oblong ? positions_of(*content.oblong, content.spacing, content.placement) : PixelPositions{};
  LabelField of_file;
  if (is_oblong) {
    of_file = labels_of_pixels(content, at);
  }
  std::vector<std::string> idle;
  int number = 0;
  Walls walls;
  for (TomlReader& table : scene.tables("condition")) {
    const Condition condition = read_condition(table, may_be_springs, content.spacing, level.extent);
    ++number;
    if (when == When::before && !only_holds(condition)) {
      continue;
    }
    if (condition.slides && is_oblong) {
      table.fail("slide",
                 "takes the file's own pixels, which have other sides along the axes and are resampled "
                 "here; leave --size out");
    }
    if (condition.normal_radius) {
      if (walls.normal_radius && *walls.normal_radius != *condition.normal_radius) {
        table.fail("normal_radius", "is another one than before: the walls of a scene have one");
      }
      walls.normal_radius = condition.normal_radius;
    }
    for (const float label : condition.labels) {
      if (std::ranges::find(content.labels.values, static_cast<int>(label)) == content.labels.values.end()) {
        idle.push_back(fmt::format("[[condition]] {} on label {}, which no pixel has", number, label));
      }
    }
    if (!is_oblong || is_metric(condition)) {
      apply(scene, condition, content.labels, content.placement.aspect, level, walls.sites);
      continue;
    }
    Level file{.extent = content.oblong->extent, .target = VectorField(content.oblong->extent)};
    file.confidence = file.target;
    for (std::vector<float>& component : file.confidence.planes) {
      std::ranges::fill(component, -1.0F); // nothing is said
    }
    apply(scene, condition, of_file, at.step, file, walls.sites);
    (void)carry_conditions({std::move(file.target), std::move(file.confidence), at}, may_be_springs, level);
  }
  AppliedConditions applied{.idle = std::move(idle)};
  if (!walls.sites.empty()) {
    applied.turn_of_normals = set_marked_walls(scene, walls, content, level);
  } else if (!content.normals[0].empty() && when == When::now) {
    scene.fail("image", "has normals, and no [[condition]] slides, whose wall they would be of");
  }
  return applied;
}

} // namespace hdmbench
