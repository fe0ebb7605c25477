#include "harness/applications/gradient.hpp"

#include "harness/scene/method.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "kernels/data/elastic/conditions.hpp"
#include "kernels/data/elastic/springs.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/interruption.hpp"
#include "kernels/data/modulus.hpp"
#include "kernels/specification/laws/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hdmbench {

namespace {

using InDouble = laws::neo_hookean::Laws<double>;

constexpr int most_adjoint_steps = 200;

/// The Gauss points beside the corners, x in the lowest bit.
constexpr std::array<InDouble::Gradient InDouble::Gradients::*, 8> points{
    &InDouble::Gradients::p000, &InDouble::Gradients::p100, &InDouble::Gradients::p010,
    &InDouble::Gradients::p110, &InDouble::Gradients::p001, &InDouble::Gradients::p101,
    &InDouble::Gradients::p011, &InDouble::Gradients::p111};

double product(const InDouble::Stress& s, const InDouble::Gradient& h) {
  return (s.xx * h.xx + s.xy * h.xy + s.xz * h.xz) + (s.yx * h.yx + s.yy * h.yy + s.yz * h.yz) +
         (s.zx * h.zx + s.zy * h.zy + s.zz * h.zz);
}

/// The cells of a level under two displacements: that of the scene and the second one, the adjoint.
class Cells {
public:
  Cells(const Level& level, double poisson, const VectorField& displacement, const VectorField& adjoint)
      : level_(level), is_volume_(level.extent.axes() == 3), displacement_(displacement), adjoint_(adjoint),
        mu_(1.0 / (2.0 * (1.0 + poisson))),
        lame_(is_volume_ ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
                         : poisson / (1.0 - poisson * poisson)),
        sides_{1.0 / level.sides[0], 1.0 / level.sides[1], is_volume_ ? 1.0 / level.sides[2] : 1.0} {}

  /// Adds what cells are to the gradient: by moduli, and by targets that are prescribed.
  void add_to(SceneGradient& gradient) const {
    const Extent extent = level_.extent;
    const int slabs = (is_volume_ ? extent.depth : extent.height) - 1;
    for (const int parity : {0, 1}) { // two slabs that are not neighbours have no site in common
#pragma omp parallel for schedule(dynamic, 1) if (extent.sites() > sites_worth_threads)
      for (int slab = parity; slab < slabs; slab += 2) {
        for (int y = is_volume_ ? 0 : slab; y < (is_volume_ ? extent.height - 1 : slab + 1); ++y) {
          for (int x = 0; x + 1 < extent.width; ++x) {
            add_cell(x, y, is_volume_ ? slab : 0, gradient);
          }
        }
      }
    }
  }

private:
  /// The sites of a cell's corners. An image is a layer, both of whose faces are the image.
  [[nodiscard]] std::array<std::size_t, 8> corners_of(int x, int y, int z) const {
    std::array<std::size_t, 8> sites{};
    for (int corner = 0; corner < 8; ++corner) {
      sites[static_cast<std::size_t>(corner)] =
          level_.extent.index(x + (corner & 1), y + (corner >> 1 & 1), is_volume_ ? z + (corner >> 2) : 0);
    }
    return sites;
  }

  [[nodiscard]] InDouble::Coefficients coefficients(const VectorField& field, std::size_t axis,
                                                    const std::array<std::size_t, 8>& sites) const {
    return InDouble::coefficients_of(corners(field, axis, sites));
  }
  [[nodiscard]] InDouble::CellCorners corners(const VectorField& field, std::size_t axis,
                                              const std::array<std::size_t, 8>& sites) const {
    return InDouble::corners_of([&](std::size_t corner) {
      return axis < level_.extent.axes() ? double{field[axis][sites[corner]]} : 0.0;
    });
  }
  [[nodiscard]] InDouble::Gradients gradients(const VectorField& field,
                                              const std::array<std::size_t, 8>& sites) const {
    const auto slopes = [&](std::size_t axis) {
      return InDouble::slopes_at_points(coefficients(field, axis, sites), sides_);
    };
    return InDouble::gradients_of(slopes(0), slopes(1), slopes(2));
  }

  void add_cell(int x, int y, int z, SceneGradient& gradient) const {
    const std::array<std::size_t, 8> sites = corners_of(x, y, z);
    const InDouble::Gradients of_field = gradients(displacement_, sites);
    const InDouble::Gradients of_adjoint = gradients(adjoint_, sites);
    for (std::size_t corner = 0; corner < 8; ++corner) { // each point weighs an eighth
      const InDouble::Stress stress = InDouble::hookean_stress({mu_, lame_, -1.0}, of_field.*points[corner]);
      float& by_modulus = gradient.modulus.values[sites[corner]];
      by_modulus = static_cast<float>(by_modulus - 0.125 * product(stress, of_adjoint.*points[corner]));
    }
    const bool is_observed = std::ranges::any_of(sites, [&](std::size_t site) {
      return std::ranges::any_of(level_.confidence.planes,
                                 [&](const auto& of) { return !of.empty() && of[site] >= 1.0F; });
    });
    if (!is_observed) {
      return;
    }
    constexpr double by_coefficients = 1.0 / 32.0; // as cell.inc has energies
    const auto tissue = [&](int corner) {
      const double modulus =
          by_coefficients * double{level_.modulus.values[sites[static_cast<std::size_t>(corner)]]};
      return InDouble::Tissue{modulus * mu_, modulus * lame_, -1.0};
    };
    (void)InDouble::for_each_force_by_law(
        [&](int axis) { return corners(adjoint_, static_cast<std::size_t>(axis), sites); }, tissue,
        [](int /*corner*/) { return InDouble::NoFibre{}; }, sides_,
        [&](int along, int corner, double force) {
          const auto axis = static_cast<std::size_t>(along);
          const std::size_t site = sites[static_cast<std::size_t>(corner)];
          if (axis < level_.extent.axes() && level_.confidence[axis][site] >= 1.0F) {
            float& by_target = gradient.target[axis][site];
            by_target = static_cast<float>(by_target + force);
          }
        });
  }

  const Level& level_;
  bool is_volume_;
  const VectorField& displacement_;
  const VectorField& adjoint_;
  double mu_; ///< Lamé's constants for a modulus of 1
  double lame_;
  InDouble::Sides sides_;
};

/// The springs of observations, whose stiffness is the modulus of their site times a weight.
void add_springs(const Level& level, const VectorField& displacement, SceneGradient& gradient) {
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    for (std::size_t site = 0; site < level.extent.sites(); ++site) {
      const double weight = weight_of_confidence(level.confidence[axis][site]);
      if (weight > 0.0) {
        const double pull = weight * double{gradient.force[axis][site]};
        const double way = double{level.target[axis][site]} - double{displacement[axis][site]};
        float& by_modulus = gradient.modulus.values[site];
        by_modulus = static_cast<float>(by_modulus + pull * way);
        gradient.target[axis][site] = static_cast<float>(pull * double{level.modulus.values[site]});
      }
    }
  }
}

/// The level, at rest but for a load: `by_displacement` on all components that may move, times a power of two
/// that makes the largest one about the largest modulus, so that float holds products of the solution.
Level loaded(const Level& level, const VectorField& by_displacement, double& scale) {
  Level adjoint = without_fields(level);
  adjoint.confidence = level.confidence;
  adjoint.modulus = level.modulus;
  adjoint.inverse_modulus = level.inverse_modulus;
  adjoint.target = VectorField(level.extent);
  adjoint.force = by_displacement;
  const double largest = largest_component(by_displacement);
  scale = std::exp2(std::round(std::log2(double{modulus_range(level.modulus).stiffest} / largest)));
  for (std::vector<float>& component : adjoint.force.planes) {
    for (float& value : component) {
      value = static_cast<float>(scale * value);
    }
  }
  return adjoint;
}

} // namespace

std::string why_no_gradient(const Scene& scene) {
  if (!scene.energy->is_of_cells()) {
    return fmt::format("gradients are those of the elastic energy, and the scene has {}", scene.energy->name);
  }
  if (has_springs_by_direction(scene.full)) {
    return scene.full.has_walls
               ? "gradients are those of conditions by components, and the scene has walls to slide along"
               : "gradients are those of conditions by components, and the scene has a precision, which is "
                 "by direction";
  }
  if (has_laws(scene.full)) {
    return "gradients are those of linear tissue, and some has a law of large strains";
  }
  if (scene.extent().axes() == 3 && scene.elastic.integration != Integration::full) {
    return "gradients are those of elements that are integrated in full, and the scene's are "
           "selective-reduced";
  }
  return "";
}

SceneGradient gradient_of(const Scene& scene, const VectorField& displacement,
                          const VectorField& by_displacement, Solver& solver, Progress& progress) {
  if (const std::string why = why_no_gradient(scene); !why.empty()) {
    throw InputError(why);
  }
  const Level& level = scene.full;
  validate(by_displacement, level.extent, "the derivative by the displacement");
  SceneGradient gradient{ScalarField(level.extent), VectorField(level.extent), VectorField(level.extent)};
  if (largest_component(by_displacement) == 0.0) {
    return gradient;
  }
  if (const std::optional<Scene> scaled = with_safe_moduli(scene)) {
    gradient = gradient_of(*scaled, displacement, by_displacement, solver, progress);
    const double times = double{scaled->full.modulus.values[0]} / double{level.modulus.values[0]};
    const auto scale = [times](float value) { return static_cast<float>(times * value); };
    std::ranges::transform(gradient.modulus.values, gradient.modulus.values.begin(), scale);
    for (std::vector<float>& component : gradient.force.planes) {
      std::ranges::transform(component, component.begin(), scale);
    }
    return gradient;
  }
  progress.describe(fmt::format("{}: gradient", scene.name));
  double scale = 1.0;
  const Level adjoint = loaded(level, by_displacement, scale);
  {
    ElasticSolver elastic(adjoint, scene.elastic, solver.elastic());
    SolutionToShare solution = solve_to_share(gradient_share, most_adjoint_steps, adjoint, elastic);
    gradient.force = std::move(solution.displacement);
    gradient.converged = solution.is_within;
  }
  may_end_here();
  Cells(level, scene.elastic.poisson, displacement, gradient.force).add_to(gradient);
  add_springs(level, displacement, gradient);
  const auto unscaled = [scale](float value) { return static_cast<float>(value / scale); };
  const float least = void_modulus(level);
  for (std::size_t site = 0; site < level.extent.sites(); ++site) {
    float& value = gradient.modulus.values[site];
    value = level.modulus.values[site] < least ? 0.0F : unscaled(value);
    for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
      float& target = gradient.target[axis][site];
      const bool is_held = level.confidence[axis][site] >= 1.0F;
      target = unscaled(target) + (is_held ? by_displacement[axis][site] : 0.0F);
      gradient.force[axis][site] = is_held ? 0.0F : unscaled(gradient.force[axis][site]);
    }
  }
  return gradient;
}

} // namespace hdmbench
