#include "harness/scene/method.hpp"
#include "harness/scene/scene_content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <ranges>
#include <vector>

namespace hdmbench {

namespace {

/// The share of a pixel that a site stands for along an axis: a half where the image ends.
double share_along(Extent extent, std::size_t axis, int at) {
  return axis >= extent.axes() || (at > 0 && at + 1 < extent.sides()[axis]) ? 1.0 : 0.5;
}

/// Forces are added up in double, by component.
using Forces = std::vector<std::vector<double>>;

/// kg/m^3 times m/s^2 are N/m^3, of which 1e9 are a N/mm^3, or a MPa/mm.
void add_gravity(TomlReader& load, const Content& content, const Level& level, Forces& forces) {
  const Extent extent = level.extent;
  std::vector<double> gravity = load.numbers("gravity", extent.axes(), 3);
  gravity.resize(3);
  std::array<double, 3> pull{}; // along the axes of the image
  for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
    const Placement::Vector& to = content.placement.axes[axis];
    pull[axis] = 1e-9 * content.spacing * std::inner_product(to.begin(), to.end(), gravity.begin(), 0.0);
  }
  if (!content.segmented) {
    load.fail("gravity", "needs the [[tissue]] tables of labels: their densities are what it pulls at");
  }
  if (!content.knows_millimetres) {
    load.fail("gravity", "needs a spacing: how many millimetres a pixel has decides how heavy it is");
  }
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    if (level.modulus.values[site] == 0.0F) {
      return; // void
    }
    const int label = content.labels.values[site];
    const auto density = content.densities.find(label);
    if (density == content.densities.end()) {
      load.fail("gravity", fmt::format("needs the density of every tissue, and that of label {} has none; "
                                       "0 is one that weighs nothing",
                                       label));
    }
    const double share = share_along(extent, 0, x) * share_along(extent, 1, y) * share_along(extent, 2, z);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      forces[axis][site] += density->second * pull[axis] * share;
    }
  });
}

/// A face between two sites has the area of a pixel's side.
void add_pressure(TomlReader& load, const Content& content, Extent extent, Forces& forces) {
  const double pressure = load.get<double>("pressure");
  const int from = load.get<int>("from");
  const int on = load.get<int>("on");
  if (!content.segmented) {
    load.fail("pressure", "needs labels: it acts where two of them meet");
  }
  bool meet = false;
  const std::vector<int>& labels = content.labels.values;
  for_each_site(extent, [&](int x, int y, int z) {
    const std::array<int, 3> here{x, y, z};
    const std::size_t site = extent.index(x, y, z);
    for (std::size_t axis = 0; axis < extent.axes() && labels[site] == on; ++axis) {
      double area = 1.0; // over the area or volume of a pixel
      for (std::size_t other = 0; other < extent.axes(); ++other) {
        area *=
            other == axis ? 1.0 / content.placement.aspect[axis] : share_along(extent, other, here[other]);
      }
      for (const int way : {-1, 1}) {
        std::array<int, 3> beside = here;
        beside[axis] += way;
        if (beside[axis] >= 0 && beside[axis] < extent.sides()[axis] &&
            labels[extent.index(beside[0], beside[1], beside[2])] == from) {
          forces[axis][site] -= way * pressure * area;
          meet = true;
        }
      }
    }
  });
  if (!meet) {
    load.fail("pressure",
              fmt::format("acts nowhere: no site of label {} is beside one of label {}", on, from));
  }
}

/// Returns them without those on void, which carries nothing.
Forces forces_of_image(const VectorField& force, const Level& level) {
  const Extent extent = force.extent;
  Forces forces(extent.axes(), std::vector<double>(extent.sites()));
  for_each_site(extent, [&](int x, int y, int z) {
    const std::size_t site = extent.index(x, y, z);
    for (std::size_t axis = 0; axis < extent.axes() && level.modulus.values[site] > 0.0F; ++axis) {
      forces[axis][site] = double{force[axis][site]} * share_along(extent, 0, x) * share_along(extent, 1, y) *
                           share_along(extent, 2, z);
    }
  });
  return forces;
}

} // namespace

std::vector<std::string> apply_loads(TomlReader& scene, const Content& content,
                                     const RegisteredEnergy& energy, Level& level, When when) {
  const Extent extent = level.extent;
  Forces forces;
  bool weighs = false;
  bool acted = false;
  if (!content.force[0].empty() && when == When::now) {
    forces = forces_of_image(content.force, level);
  }
  for (TomlReader& load : scene.tables("load")) {
    bool was_there = false;
    load.read("before", was_there);
    acted = acted || was_there;
    weighs = weighs || load.has("gravity");
    if (was_there != (when == When::before)) {
      continue;
    }
    if (!energy.takes_forces) {
      scene.fail("load",
                 fmt::format("is nothing that the {} energy knows; give energy = \"elastic\"", energy.name));
    }
    forces.resize(extent.axes(), std::vector<double>(extent.sites()));
    if (load.has("gravity") == load.has("pressure")) {
      load.fail("gravity", "or pressure: a load is one of the two");
    }
    if (load.has("gravity")) {
      add_gravity(load, content, level, forces);
    } else {
      add_pressure(load, content, extent, forces);
    }
    load.finish();
  }
  if (!forces.empty()) {
    level.force = VectorField(extent);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      level.force[axis].assign(forces[axis].begin(), forces[axis].end());
    }
  }
  const auto has_weight = [](double density) { return density > 0.0; }; // void says 0 by itself
  std::vector<std::string> idle;
  if (!weighs && std::ranges::any_of(content.densities | std::views::values, has_weight)) {
    idle.emplace_back("the density of a [[tissue]], as no [[load]] has a gravity");
  }
  if (acted && !scene.has("resect")) {
    idle.emplace_back("a [[load]] with before = true, as no [[resect]] takes out what bore it");
  }
  return idle;
}

std::array<double, 3> resultant_of_loads(const Scene& scene) {
  const Level& full = scene.full;
  const auto& sides = full.sides;
  const bool is_volume = full.extent.axes() == 3;
  // Over the area or volume of a pixel, MPa over a shortest side; a MPa is a N/mm^2.
  const double unit = sides[0] * sides[1] * sides[2] * scene.spacing * (is_volume ? scene.spacing : 1.0);
  std::array<double, 3> sum{};
  for (std::size_t axis = 0; has_forces(full) && axis < full.extent.axes(); ++axis) {
    sum[axis] = unit * std::accumulate(full.force[axis].begin(), full.force[axis].end(), 0.0);
  }
  return scene.placement.vector(sum[0], sum[1], sum[2]);
}

} // namespace hdmbench
