#include "harness/scene/carried_conditions.hpp"
#include "harness/scene/images/pixels.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/points.hpp"
#include "harness/scene/scene_content.hpp"
#include "harness/scene/surfaces.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hdmbench {

namespace {

/// Millimetres along the scene's axes.
std::array<double, 3> along(const Placement& placement, const Placement::Vector& vector) {
  std::array<double, 3> result{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 3; ++i) {
      result[axis] += placement.axes[axis][i] * vector[i];
    }
  }
  return result;
}

/// Throws InputError where the point is beside the scene.
KnownPoint known_point(const PointPair& pair, double deviation, const Content& content, Extent extent) {
  Placement::Vector from_origin{};
  Placement::Vector way{};
  for (std::size_t i = 0; i < 3; ++i) {
    from_origin[i] = pair.before[i] - content.placement.origin[i];
    way[i] = pair.after[i] - pair.before[i];
  }
  KnownPoint point{pair.name, along(content.placement, from_origin), along(content.placement, way),
                   pair.deviation.value_or(deviation) / content.spacing,
                   pair.area ? std::optional(*pair.area / (point_reach * point_reach)) : std::nullopt};
  const double half_slice = 0.5 * std::max(content.spacing, content.placement.thickness);
  bool is_inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis >= extent.axes()) {
      is_inside = is_inside && std::abs(point.at[axis]) <= half_slice;
      point.at[axis] = point.target[axis] = 0.0;
      continue;
    }
    point.at[axis] /= content.spacing * content.placement.aspect[axis];
    point.target[axis] /= content.spacing;
    is_inside = is_inside && point.at[axis] >= -0.5 && point.at[axis] <= extent.sides()[axis] - 0.5;
  }
  if (!is_inside) {
    throw InputError(
        fmt::format("point {} at {:.4g}, {:.4g}, {:.4g} mm is beside the scene, which has {} pixels of "
                    "{:.4g} mm from {:.4g}, {:.4g}, {:.4g} on",
                    pair.name, pair.before[0], pair.before[1], pair.before[2], extent.text(), content.spacing,
                    content.placement.origin[0], content.placement.origin[1], content.placement.origin[2]));
  }
  return point;
}

std::vector<PointPair> read(std::span<const std::filesystem::path> files, std::string_view space) {
  if (files.size() > 2) {
    throw InputError(fmt::format(
        "points are in one file, of pairs, or in two, of before and of after; these are {}", files.size()));
  }
  if (files.size() == 2 && std::ranges::all_of(files, is_surface)) {
    return read_surface_pairs(files[0], files[1], space);
  }
  return files.size() == 1 ? read_point_pairs(files[0]) : read_point_pairs(files[0], files[1]);
}

/// Adds what files and options say of points to `to`.
void take_points(TomlReader& scene, const std::filesystem::path& folder, const SceneOptions& options,
                 const Content& content, Scene& to) {
  const auto take = [&](const std::vector<PointPair>& pairs, double deviation) {
    for (const PointPair& pair : pairs) {
      to.points.push_back(known_point(pair, deviation, content, to.extent()));
    }
  };
  for (TomlReader& table : scene.tables("points")) {
    if (table.has("file") == table.has("before") || table.has("before") != table.has("after")) {
      table.fail("file", "or before and after: give one file of pairs, or the points before and after");
    }
    std::vector<std::filesystem::path> files;
    for (const char* const key : {"file", "before", "after"}) {
      if (table.has(key)) {
        files.push_back(folder / table.get<std::string>(key));
      }
    }
    double deviation = 0.0;
    table.read("deviation", deviation);
    std::string_view space;
    if (std::ranges::all_of(files, is_surface) && table.has("space")) {
      static constexpr std::array<std::string_view, 2> spaces{"LPS", "RAS"};
      space = spaces[table.choice("space", spaces)]; // NOLINT(*-constant-array-index): it is one of them
    }
    table.finish();
    take(read(files, space), deviation);
  }
  if (!options.points.empty()) {
    take(read(options.points, ""), 0.0);
  }
  take(options.pairs, 0.0);
}

/// What is known at points: certain ones by themselves, and of the others one spring a site, which is what
/// all that reach it come to. A surface has many thousands.
class Known {
public:
  explicit Known(Extent extent) : extent_(extent) {}

  void add_certain(const KnownPoint& point) { add(point.at, point.target, 1.0F); }

  void add_springs(const KnownPoint& point, const Content& content) {
    for (const auto& [at, weight] :
         point_springs(point, extent_, content.placement.aspect, content.spacing)) {
      Spring& spring = springs_[extent_.index(at[0], at[1], at[2])];
      spring.at = {1.0 * at[0], 1.0 * at[1], 1.0 * at[2]};
      spring.weight += weight;
      for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
        spring.pull[axis] += weight * point.target[axis];
      }
    }
  }

  [[nodiscard]] FileConditions conditions() {
    for (auto& [site, spring] : springs_) {
      for (double& component : spring.pull) {
        component /= spring.weight;
      }
      add(spring.at, spring.pull, confidence_of_weight(spring.weight));
    }
    conditions_.target.extent =
        conditions_.confidence.extent = {static_cast<int>(conditions_.scattered.size()), 1, 1};
    return std::move(conditions_);
  }

private:
  struct Spring {
    std::array<double, 3> at{};
    double weight = 0.0;
    std::array<double, 3> pull{}; ///< weights times targets
  };

  void add(const std::array<double, 3>& at, const std::array<double, 3>& target, float confidence) {
    conditions_.scattered.push_back(at);
    for (std::size_t axis = 0; axis < extent_.axes(); ++axis) {
      conditions_.target[axis].push_back(static_cast<float>(target[axis]));
      conditions_.confidence[axis].push_back(confidence);
    }
  }

  Extent extent_;
  FileConditions conditions_{.target = {}, .confidence = {}};
  std::map<std::size_t, Spring> springs_;
};

} // namespace

double residual_at(const KnownPoint& point, const VectorField& displacement) {
  double square = 0.0;
  for (std::size_t axis = 0; axis < displacement.extent.axes(); ++axis) {
    const double found =
        images::linear_at(displacement[axis], displacement.extent, point.at[0], point.at[1], point.at[2]);
    square += (found - point.target[axis]) * (found - point.target[axis]);
  }
  return std::sqrt(square);
}

std::vector<PointSpring> point_springs(const KnownPoint& point, Extent extent,
                                       const std::array<double, 3>& sides, double spacing) {
  std::array<std::vector<std::pair<int, double>>, 3> reach{{{{0, 1.0}}, {{0, 1.0}}, {{0, 1.0}}}};
  double weight = point.share.value_or(1.0) / (point.deviation * point.deviation);
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const double side = sides[axis] * spacing;
    const double width = std::max(1.0, point_reach / side); // sites
    const int last = extent.sides()[axis] - 1;
    const double place = std::clamp(point.at[axis], 0.0, static_cast<double>(last));
    reach[axis].clear();
    double sum = 0.0;
    for (int site = std::max(0, static_cast<int>(std::ceil(place - width)));
         site <= std::min(last, static_cast<int>(std::floor(place + width))); ++site) {
      if (const double share = 1.0 - std::abs(site - place) / width; share > 0.0) {
        reach[axis].emplace_back(site, share);
        sum += share;
      }
    }
    weight *= point_reach / (side * sum);
  }
  std::vector<PointSpring> springs;
  for (const auto& [z, of_z] : reach[2]) {
    for (const auto& [y, of_y] : reach[1]) {
      for (const auto& [x, of_x] : reach[0]) {
        springs.push_back({{x, y, z}, weight * of_x * of_y * of_z});
      }
    }
  }
  return springs;
}

void apply_points(TomlReader& scene, const std::filesystem::path& folder, const SceneOptions& options,
                  const Content& content, Scene& to) {
  take_points(scene, folder, options, content, to);
  Known known(to.extent());
  for (std::size_t number = 0; number < to.points.size(); ++number) {
    const KnownPoint& point = to.points[number];
    if (point.deviation > 0.0 && !to.energy->is_of_cells()) {
      throw InputError(
          fmt::format("point {} has a deviation, which only the elastic energy knows: give --energy "
                      "elastic, or leave it out",
                      point.name));
    }
    if (options.idle_point == number) {
      continue;
    }
    if (point.deviation == 0.0) {
      known.add_certain(point);
    } else {
      known.add_springs(point, content);
    }
  }
  if (const FileConditions conditions = known.conditions(); !conditions.scattered.empty()) {
    (void)carry_conditions(conditions, to.energy->is_of_cells(), to.full);
  }
}

} // namespace hdmbench
