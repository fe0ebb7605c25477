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

constexpr double mesh_width = 0.8; // pixels

using Way = std::array<double, 2>; // pixels

/// The deformation of a scene's tissue on a mesh of its own, at the scene's sites. modulus(x, y, labelled)
/// MPa; prescribed(x, y, label), none: free.
VectorField deformation(const Scene& scene,
                        const std::function<double(double x, double y, double labelled)>& modulus,
                        const std::function<std::optional<Way>(double x, double y, int label)>& prescribed) {
  const Extent extent = scene.extent();
  const auto nodes = [](int side) { return static_cast<int>(std::ceil((side - 1) / mesh_width)) + 1; };
  ElasticProblem problem;
  problem.extent = {nodes(extent.width), nodes(extent.height)};
  problem.modulus.resize(problem.extent.sites());
  problem.fixed = Planes<std::uint8_t>(problem.extent);
  problem.prescribed = ReferenceField(problem.extent);
  for_each_site(problem.extent, [&](int column, int row) {
    const double x = std::min(column * mesh_width, extent.width - 1.0);
    const double y = std::min(row * mesh_width, extent.height - 1.0);
    const std::size_t site = extent.index(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
    const std::size_t node = problem.extent.index(column, row);
    problem.modulus[node] = modulus(x, y, static_cast<double>(scene.full.modulus.values[site]));
    if (const auto way = prescribed(x, y, scene.labels.values[site])) {
      problem.fixed[0][node] = 1;
      problem.fixed[1][node] = 1;
      problem.prescribed[0][node] = (*way)[0] / mesh_width;
      problem.prescribed[1][node] = (*way)[1] / mesh_width;
    }
  });
  const VectorField on_mesh =
      solve_finite_elements(problem, ElementRule::of(problem.extent, planted_poisson)).to_float();
  VectorField field(extent);
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    const auto at_x = static_cast<float>(x / mesh_width);
    const auto at_y = static_cast<float>(y / mesh_width);
    const auto unit = static_cast<float>(mesh_width);
    field[0][site] = unit * sample(on_mesh[0], problem.extent, at_x, at_y);
    field[1][site] = unit * sample(on_mesh[1], problem.extent, at_x, at_y);
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

struct Place {
  double x = 0.0;
  double y = 0.0;
};

Place middle_of(const LabelField& labels) {
  Place middle;
  double sites = 0.0;
  for_each_site(labels.extent, [&](int x, int y) {
    if (labels.values[labels.extent.index(x, y)] > 0) {
      middle.x += x;
      middle.y += y;
      sites += 1.0;
    }
  });
  return {middle.x / sites, middle.y / sites};
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
      return {static_cast<double>(x), static_cast<double>(y)};
    }
  }
}

/// The skull comes in from `angle`, the less the further round; `width` says how far round it does.
Way pressed(const Place& middle, double x, double y, double angle, double amplitude, double width) {
  const double here = std::atan2(y - middle.y, x - middle.x) - angle;
  const double share = amplitude * std::exp(-(1.0 - std::cos(here)) * width);
  return {-share * std::cos(angle), -share * std::sin(angle)};
}
constexpr double wide_pressure = 4.0;
constexpr double narrow_pressure = 12.0;

/// Catmull and Rom; beyond the border the nearest pixel.
float cubic_at(const ScalarField& picture, double x, double y) {
  const Extent extent = picture.extent;
  const double inside_x = std::clamp(x, 0.0, extent.width - 1.0);
  const double inside_y = std::clamp(y, 0.0, extent.height - 1.0);
  const int left = static_cast<int>(inside_x);
  const int top = static_cast<int>(inside_y);
  const auto weights = [](double t) {
    return std::array{((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0,
                      ((-1.5 * t + 2.0) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
  };
  const auto across = weights(inside_x - left);
  const auto down = weights(inside_y - top);
  double sum = 0.0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const int column = std::clamp(left + i - 1, 0, extent.width - 1);
      const int row = std::clamp(top + j - 1, 0, extent.height - 1);
      sum += across[static_cast<std::size_t>(i)] * down[static_cast<std::size_t>(j)] *
             static_cast<double>(picture.values[extent.index(column, row)]);
    }
  }
  return static_cast<float>(sum);
}

/// Where what is at (x, y) afterwards came from: x = s + d(s).
Place origin_of(const VectorField& truth, double x, double y) {
  Place from{x, y};
  for (int iteration = 0; iteration < 60; ++iteration) {
    const auto at_x = static_cast<float>(from.x);
    const auto at_y = static_cast<float>(from.y);
    from.x = 0.5 * (from.x + x - static_cast<double>(sample(truth[0], truth.extent, at_x, at_y)));
    from.y = 0.5 * (from.y + y - static_cast<double>(sample(truth[1], truth.extent, at_x, at_y)));
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
  for_each_site(extent, [&](int x, int y) {
    const Place from = origin_of(pair.truth, x, y);
    const double gray = looks(from, static_cast<double>(cubic_at(scene.picture, from.x, from.y)));
    pair.target.values[extent.index(x, y)] = static_cast<float>(std::clamp(gray, 0.0, 255.0));
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
    mask.values[extent.index(x, y)] = std::hypot(x - centre.x, y - centre.y) <= radius ? 1.0F : 0.0F;
  });
  return mask;
}

} // namespace

PlantedPair plant(const Scene& scene, const PlantedOptions& options) {
  require_anatomy(scene);
  const Extent extent = scene.extent();
  GaussianNoise random(options.seed);
  const double radius = options.region_share * extent.width;
  const ScalarField depth = depth_of(scene.labels);
  const Place middle = middle_of(scene.labels);
  const bool grows = options.kind == Planted::growth;
  const bool resects = options.kind == Planted::resection;
  const Place centre = resects ? random_place(depth, radius + 4.0, radius + 12.0, random)
                               : random_place(depth, radius + 1.5 * options.amplitude + 4.0, 1e6, random);
  const double angle =
      resects ? std::atan2(centre.y - middle.y, centre.x - middle.x) : 2.0 * M_PI * random.uniform();
  const auto is_inside = [&](double x, double y) { return std::hypot(x - centre.x, y - centre.y) <= radius; };
  PlantedPair pair;
  pair.truth = deformation(
      scene, [&](double x, double y, double labelled) { return resects && is_inside(x, y) ? 0.3 : labelled; },
      [&](double x, double y, int label) -> std::optional<Way> {
        if (grows && is_inside(x, y)) {
          return Way{options.amplitude * (x - centre.x) / radius,
                     options.amplitude * (y - centre.y) / radius};
        }
        if (label != 0) {
          return std::nullopt;
        }
        return grows ? Way{0.0, 0.0}
                     : pressed(middle, x, y, angle, options.amplitude,
                               resects ? narrow_pressure : wide_pressure);
      });
  // A segmented mass; of what was taken out, with what lies around.
  pair.region = disc(extent, centre, radius * (grows ? 1.03 : 1.25));
  set_pictures(scene, options.noise, random, pair, [&](const Place& from, double gray) {
    return grows && is_inside(from.x, from.y) ? 200.0 + 20.0 * std::sin(0.9 * from.x) * std::cos(0.7 * from.y)
           : resects && is_inside(from.x, from.y) ? 30.0
                                                  : gray;
  });
  return pair;
}

PlantedField plant(const Scene& scene, const PlantedInclusion& options) {
  require_anatomy(scene);
  const Extent extent = scene.extent();
  GaussianNoise random(options.seed);
  const double region_radius = options.region_share * extent.width;
  const Place middle = middle_of(scene.labels);
  const Place centre = random_place(depth_of(scene.labels), region_radius * 0.7, 1e6, random);
  const double angle = 2.0 * M_PI * random.uniform();
  const double off = std::max(region_radius - options.radius - 3.0, 0.0) * std::sqrt(random.uniform());
  const double direction = 2.0 * M_PI * random.uniform();
  PlantedField field;
  field.x = centre.x + off * std::cos(direction);
  field.y = centre.y + off * std::sin(direction);
  field.region = disc(extent, centre, region_radius);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    if (scene.labels.values[site] == 0) {
      field.region.values[site] = 0.0F;
    }
  }
  field.observed = deformation(
      scene,
      [&](double x, double y, double labelled) {
        return std::hypot(x - field.x, y - field.y) <= options.radius ? options.contrast * labelled
                                                                      : labelled;
      },
      [&](double x, double y, int label) -> std::optional<Way> {
        return label == 0 ? std::optional(pressed(middle, x, y, angle, options.amplitude, wide_pressure))
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
