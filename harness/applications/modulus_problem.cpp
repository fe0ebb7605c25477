#include "harness/applications/modulus_problem.hpp"

#include "harness/applications/picture.hpp"
#include "harness/solve/methods/elastic.hpp"

#include <array>
#include <cmath>

namespace hdmbench {

namespace {

/// After full multigrid: what is left of the error is far below what noise does.
constexpr int steps = 3;

struct Strain {
  double xx, yy, xy; ///< xy is the engineering shear
};

/// Of a field in the cell of which `corner` is the top left site, at (r, s) in [0, 1] x [0, 1].
Strain strain_at(const VectorField& field, std::size_t corner, double r, double s) {
  const auto width = static_cast<std::size_t>(field.extent.width);
  const auto slopes = [&](const std::vector<float>& values) {
    const double top = static_cast<double>(values[corner + 1]) - static_cast<double>(values[corner]);
    const double bottom =
        static_cast<double>(values[corner + width + 1]) - static_cast<double>(values[corner + width]);
    const double left = static_cast<double>(values[corner + width]) - static_cast<double>(values[corner]);
    const double right =
        static_cast<double>(values[corner + width + 1]) - static_cast<double>(values[corner + 1]);
    return std::array{std::lerp(top, bottom, s), std::lerp(left, right, r)};
  };
  const auto [xx, xy] = slopes(field.x);
  const auto [yx, yy] = slopes(field.y);
  return {xx, yy, xy + yx};
}

/// Of plane stress for a modulus of 1, per area.
double twice_energy(const Strain& a, const Strain& b, double poisson) {
  return (a.xx * b.xx + a.yy * b.yy + poisson * (a.xx * b.yy + a.yy * b.xx)) / (1.0 - poisson * poisson) +
         a.xy * b.xy / (2.0 * (1.0 + poisson));
}

/// What the modulus of a site weighs: the quadrature points of finite elements that lie in its pixel.
double energy_of_site(const VectorField& a, const VectorField& b, int x, int y, double poisson) {
  const Extent extent = a.extent;
  const double near = 0.5 - 0.5 / std::sqrt(3.0); // of a Gauss point from its corner
  double sum = 0.0;
  for (int below = 0; below < 2; ++below) {
    for (int right = 0; right < 2; ++right) {
      const int column = x - 1 + right;
      const int row = y - 1 + below;
      if (column >= 0 && row >= 0 && column + 1 < extent.width && row + 1 < extent.height) {
        const double r = right == 1 ? near : 1.0 - near;
        const double s = below == 1 ? near : 1.0 - near;
        const std::size_t corner = extent.index(column, row);
        sum += 0.25 * twice_energy(strain_at(a, corner, r, s), strain_at(b, corner, r, s), poisson);
      }
    }
  }
  return sum;
}

VectorField solved(ElasticSolver& solver) {
  solver.full_multigrid();
  for (int step = 0; step < steps && !solver.conjugate_gradients().ended; ++step) {
  }
  return solver.displacement();
}

} // namespace

ModulusProblem::ModulusProblem(const Level& level, double poisson, const std::vector<std::size_t>& unknown,
                               ElasticSession& session)
    : level_(level), poisson_(poisson), unknown_(unknown), session_(session) {
  for (const std::size_t site : unknown) {
    labelled_.push_back(level.modulus.values[site]);
  }
}

VectorField ModulusProblem::displacement(std::span<const double> logarithms) {
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    level_.modulus.values[unknown_[i]] = labelled_[i] * static_cast<float>(std::exp(logarithms[i]));
  }
  ElasticSolver solver(level_, poisson_, session_);
  return solved(solver);
}

void ModulusProblem::slopes(const VectorField& found, const VectorField& difference,
                            std::span<double> derivative) {
  const SiteSprings none;
  ElasticSolver solver(level_, poisson_, none, session_);
  solver.pull(VectorField(level_.extent), difference);
  const VectorField adjoint = solved(solver);
  for (std::size_t i = 0; i < unknown_.size(); ++i) {
    const auto width = static_cast<std::size_t>(level_.extent.width);
    const int x = static_cast<int>(unknown_[i] % width);
    const int y = static_cast<int>(unknown_[i] / width);
    derivative[i] = -static_cast<double>(level_.modulus.values[unknown_[i]]) *
                    energy_of_site(adjoint, found, x, y, poisson_);
  }
}

double ModulusProblem::misfit(std::span<const double> logarithms, const VectorField& observed,
                              std::span<double> derivative) {
  const VectorField found = displacement(logarithms);
  VectorField difference(level_.extent);
  for (const std::size_t site : unknown_) {
    difference.x[site] = found.x[site] - observed.x[site];
    difference.y[site] = found.y[site] - observed.y[site];
  }
  slopes(found, difference, derivative);
  return 0.5 * product(difference, difference);
}

} // namespace hdmbench
