#include "harness/judge/registration/planted.hpp"

#include "harness/applications/picture.hpp"
#include "harness/judge/diagnosis/measures.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"
#include "reference/finite_elements.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>

namespace hdmbench {

namespace {

constexpr double volume_nodes = 30'000; // of a volume's mesh, about: a direct solver has them in a minute

/// Pixels between the nodes of the mesh.
double mesh_width_of(Extent extent) {
  return extent.depth == 1 ? 0.8
                           : std::max(3.0, std::cbrt(static_cast<double>(extent.sites()) / volume_nodes));
}

using Way = std::array<double, 3>; // pixels
/// The modulus where tissue was taken out over that of the tissue.
constexpr double resected_share = 0.015;

using Place = std::array<double, 3>; // pixels; z is 0 in an image

/// The deformation of a scene's tissue on a mesh of its own, at the scene's sites. modulus(place, labelled)
/// MPa; prescribed(place, label), none: free.
VectorField deformation(const Scene& scene,
                        const std::function<double(const Place& at, double labelled)>& modulus,
                        const std::function<std::optional<Way>(const Place& at, int label)>& prescribed) {
  const Extent extent = scene.extent();
  const double mesh_width = mesh_width_of(extent);
  const auto nodes = [&](int side) { return static_cast<int>(std::ceil((side - 1) / mesh_width)) + 1; };
  ElasticProblem problem;
  problem.extent = {nodes(extent.width), nodes(extent.height), nodes(extent.depth)};
  problem.modulus.resize(problem.extent.sites());
  problem.fixed = Planes<std::uint8_t>(problem.extent);
  problem.prescribed = ReferenceField(problem.extent);
  for_each_site(problem.extent, [&](int column, int row, int plane) {
    const Place at{std::min(column * mesh_width, extent.width - 1.0),
                   std::min(row * mesh_width, extent.height - 1.0),
                   std::min(plane * mesh_width, extent.depth - 1.0)};
    const auto nearest = [](double of) { return static_cast<int>(std::lround(of)); };
    const std::size_t site = extent.index(nearest(at[0]), nearest(at[1]), nearest(at[2]));
    const std::size_t node = problem.extent.index(column, row, plane);
    problem.modulus[node] = modulus(at, static_cast<double>(scene.full.modulus.values[site]));
    if (const auto way = prescribed(at, scene.labels.values[site])) {
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        problem.fixed[axis][node] = 1;
        problem.prescribed[axis][node] = (*way)[axis] / mesh_width;
      }
    }
  });
  const VectorField on_mesh =
      solve_finite_elements(problem, ElementRule::of(problem.extent, planted_poisson)).to_float();
  VectorField field(extent);
  for_each_site(extent, [&](int x, int y, int z) {
    const auto unit = static_cast<float>(mesh_width);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      field[axis][extent.index(x, y, z)] =
          unit * sample(on_mesh[axis], problem.extent, static_cast<float>(x / mesh_width),
                        static_cast<float>(y / mesh_width), static_cast<float>(z / mesh_width));
    }
  });
  return field;
}

/// Pixels to the nearest site of label 0, about: 0 there.
ScalarField depth_of(const LabelField& labels) {
  std::vector<float> around(labels.values.size());
  std::ranges::transform(labels.values, around.begin(), [](int label) { return label > 0 ? 0.0F : 1.0F; });
  ScalarField depth(labels.extent);
  depth.values = diagnosis::distance_to_nearest(labels.extent, around, 1.414F);
  return depth;
}

Place middle_of(const LabelField& labels) {
  Place middle{};
  double sites = 0.0;
  for_each_site(labels.extent, [&](int x, int y, int z) {
    if (labels.values[labels.extent.index(x, y, z)] > 0) {
      middle[0] += x;
      middle[1] += y;
      middle[2] += z;
      sites += 1.0;
    }
  });
  return {middle[0] / sites, middle[1] / sites, middle[2] / sites};
}

/// A random site between `least` and `most` deep; least is lowered where the tissue is not as deep.
Place random_place(const ScalarField& depth, double least, double most, GaussianNoise& random) {
  const double deepest = static_cast<double>(std::ranges::max(depth.values));
  least = std::min(least, deepest - 1.0);
  for (;;) {
    const int x = static_cast<int>(random.uniform() * depth.extent.width);
    const int y = static_cast<int>(random.uniform() * depth.extent.height);
    const auto here = static_cast<double>(depth.values[depth.extent.index(x, y)]);
    if (here >= least && here <= std::max(most, least + 2.0)) {
      return {static_cast<double>(x), static_cast<double>(y), 0.0};
    }
  }
}

/// The skull comes in from `angle`, in a volume also from above, the less the further round; `width` says how
/// far round it does.
Way pressed(const Place& middle, const Place& at, double angle, double amplitude, double width,
            bool in_volume) {
  const double tilt = in_volume ? 0.5 : 0.0;
  const double x = at[0] - middle[0];
  const double y = at[1] - middle[1];
  const double z = at[2] - middle[2];
  const double here = std::atan2(y, x) - angle;
  const double across = std::hypot(x, y);
  const double far = in_volume ? std::max(std::hypot(across, z), 1.0) : across;
  const double level = in_volume ? across / far * std::cos(tilt) : 1.0;
  const double along = std::cos(here) * level + (in_volume ? std::sin(tilt) * z / far : 0.0);
  const double share = amplitude * std::exp(-(1.0 - along) * width);
  return {-share * std::cos(angle) * std::cos(tilt), -share * std::sin(angle) * std::cos(tilt),
          -share * std::sin(tilt)};
}
constexpr double wide_pressure = 4.0;
constexpr double narrow_pressure = 12.0;

/// Catmull and Rom; beyond the border the nearest pixel.
float cubic_at(const ScalarField& picture, const Place& at) {
  const Extent extent = picture.extent;
  std::array<int, 3> first{};
  std::array<std::array<double, 4>, 3> weights{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double inside = std::clamp(at[axis], 0.0, extent.sides()[axis] - 1.0);
    first[axis] = static_cast<int>(inside);
    const double t = inside - first[axis];
    weights[axis] = {((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0,
                     ((-1.5 * t + 2.0) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
  }
  const auto near = [&](std::size_t axis, std::size_t tap) {
    return std::clamp(first[axis] + static_cast<int>(tap) - 1, 0, extent.sides()[axis] - 1);
  };
  double sum = 0.0;
  for (std::size_t k = extent.depth > 1 ? 0 : 1; k < (extent.depth > 1 ? 4 : 2); ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        sum += weights[0][i] * weights[1][j] * weights[2][k] *
               static_cast<double>(picture.values[extent.index(near(0, i), near(1, j), near(2, k))]);
      }
    }
  }
  return static_cast<float>(sum);
}

/// Where what is there afterwards came from: at = s + d(s).
Place origin_of(const VectorField& truth, const Place& at) {
  Place from = at;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const auto x = static_cast<float>(from[0]);
    const auto y = static_cast<float>(from[1]);
    const auto z = static_cast<float>(from[2]);
    for (std::size_t axis = 0; axis < truth.extent.axes(); ++axis) {
      const auto way = static_cast<double>(sample(truth[axis], truth.extent, x, y, z));
      from[axis] = 0.5 * (from[axis] + at[axis] - way);
    }
  }
  return from;
}

void require_anatomy(const Scene& scene) {
  if (scene.picture.values.empty() || scene.labels.values.empty() ||
      std::ranges::count(scene.labels.values, 0) == 0 ||
      std::ranges::none_of(scene.labels.values, [](int label) { return label > 0; })) {
    throw InputError(fmt::format("{}: a pair can only be planted in a scene with a picture, tissue, and "
                                 "label 0 around it",
                                 scene.name));
  }
}

/// The scene's picture and what the pair's truth makes of it, both with noise. looks(from, gray): what tissue
/// from there has become.
void set_pictures(const Scene& scene, double noise, GaussianNoise& random, PlantedPair& pair,
                  const std::function<double(const Place& from, double gray)>& looks) {
  const Extent extent = scene.extent();
  pair.source = scene.picture;
  pair.target = ScalarField(extent);
  (void)random.uniform(); // results of before drew two numbers here
  (void)random.uniform();
  const auto rows = static_cast<std::size_t>(extent.rows());
  on_all_threads(rows, extent.sites() > sites_worth_threads, [&](std::size_t number) {
    const int row = static_cast<int>(number);
    for (int x = 0; x < extent.width; ++x) {
      const Place from =
          origin_of(pair.truth, {static_cast<double>(x), static_cast<double>(row % extent.height),
                                 static_cast<double>(row / extent.height)});
      const double gray = looks(from, static_cast<double>(cubic_at(scene.picture, from)));
      pair.target.values[extent.index(x, row)] = static_cast<float>(std::clamp(gray, 0.0, 255.0));
    }
  });
  for (ScalarField* const picture : {&pair.source, &pair.target}) {
    for (float& gray : picture->values) {
      gray += static_cast<float>(noise * 255.0 * random());
    }
  }
}

ScalarField disc(Extent extent, const Place& centre, double radius) {
  ScalarField mask(extent);
  for_each_site(extent, [&](int x, int y) {
    mask.values[extent.index(x, y)] = std::hypot(x - centre[0], y - centre[1]) <= radius ? 1.0F : 0.0F;
  });
  return mask;
}

} // namespace

PlantedPair plant(const Scene& scene, const PlantedOptions& options) {
  require_anatomy(scene);
  const Extent extent = scene.extent();
  const bool in_volume = extent.axes() == 3;
  const bool grows = options.kind == Planted::growth;
  const bool resects = options.kind == Planted::resection;
  if (in_volume && (grows || resects)) {
    throw InputError(fmt::format("{} is a volume, in which only pressure can be planted", scene.name));
  }
  GaussianNoise random(options.seed);
  const double radius = options.region_share * extent.width;
  const Place middle = middle_of(scene.labels);
  Place centre{};
  if (!in_volume) {
    const ScalarField depth = depth_of(scene.labels);
    centre = resects ? random_place(depth, radius + 4.0, radius + 12.0, random)
                     : random_place(depth, radius + 1.5 * options.amplitude + 4.0, 1e6, random);
  }
  const double angle =
      resects ? std::atan2(centre[1] - middle[1], centre[0] - middle[0]) : 2.0 * M_PI * random.uniform();
  const auto is_inside = [&](const Place& at) {
    return std::hypot(at[0] - centre[0], at[1] - centre[1]) <= radius;
  };
  const std::size_t around =
      extent.index(static_cast<int>(std::lround(centre[0])), static_cast<int>(std::lround(centre[1])), 0);
  const double resected = resected_share * static_cast<double>(scene.full.modulus.values[around]);
  PlantedPair pair;
  pair.truth = deformation(
      scene, [&](const Place& at, double labelled) { return resects && is_inside(at) ? resected : labelled; },
      [&](const Place& at, int label) -> std::optional<Way> {
        if (grows && is_inside(at)) {
          return Way{options.amplitude * (at[0] - centre[0]) / radius,
                     options.amplitude * (at[1] - centre[1]) / radius};
        }
        if (label != 0) {
          return std::nullopt;
        }
        return grows ? Way{}
                     : pressed(middle, at, angle, options.amplitude,
                               resects ? narrow_pressure : wide_pressure, in_volume);
      });
  // A segmented mass; of what was taken out, with what lies around.
  pair.region = in_volume ? ScalarField(extent) : disc(extent, centre, radius * (grows ? 1.03 : 1.25));
  set_pictures(scene, options.noise, random, pair, [&](const Place& from, double gray) {
    return grows && is_inside(from)     ? 200.0 + 20.0 * std::sin(0.9 * from[0]) * std::cos(0.7 * from[1])
           : resects && is_inside(from) ? 30.0
                                        : gray;
  });
  return pair;
}

PlantedField plant(const Scene& scene, const PlantedInclusion& options) {
  require_anatomy(scene);
  if (scene.extent().axes() == 3) {
    throw InputError(fmt::format("{} is a volume: inclusions are hidden in images only", scene.name));
  }
  const Extent extent = scene.extent();
  GaussianNoise random(options.seed);
  const double region_radius = options.region_share * extent.width;
  const Place middle = middle_of(scene.labels);
  const Place centre = random_place(depth_of(scene.labels), region_radius * 0.7, 1e6, random);
  const double angle = 2.0 * M_PI * random.uniform();
  const double off = std::max(region_radius - options.radius - 3.0, 0.0) * std::sqrt(random.uniform());
  const double direction = 2.0 * M_PI * random.uniform();
  PlantedField field;
  field.x = centre[0] + off * std::cos(direction);
  field.y = centre[1] + off * std::sin(direction);
  field.region = disc(extent, centre, region_radius);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (scene.labels.values[site] == 0) {
      field.region.values[site] = 0.0F;
    }
  }
  field.observed = deformation(
      scene,
      [&](const Place& at, double labelled) {
        const bool is_inside = std::hypot(at[0] - field.x, at[1] - field.y) <= options.radius;
        return is_inside ? options.contrast * labelled : labelled;
      },
      [&](const Place& at, int label) -> std::optional<Way> {
        return label == 0 ? std::optional(pressed(middle, at, angle, options.amplitude, wide_pressure, false))
                          : std::nullopt;
      });
  double largest = 0.0;
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    largest = std::max(largest, std::hypot(static_cast<double>(field.observed[0][site]),
                                           static_cast<double>(field.observed[1][site])));
  }
  for (auto* const component : {&field.observed[0], &field.observed[1]}) {
    for (float& value : *component) {
      value += static_cast<float>(options.noise * largest * random());
    }
  }
  return field;
}

PlantedPair pictures_of(const Scene& scene, const PlantedField& field, double noise, std::uint32_t seed) {
  GaussianNoise random(seed);
  PlantedPair pair;
  pair.truth = field.observed;
  pair.region = field.region;
  set_pictures(scene, noise, random, pair, [](const Place&, double gray) { return gray; });
  return pair;
}

} // namespace hdmbench
