#include "reference/position_based.hpp"

#include "kernels/data/input_error.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace hdmbench {

namespace {

template <int axes>
class Body {
  using Vector = Eigen::Matrix<double, axes, 1>;
  using Square = Eigen::Matrix<double, axes, axes>;
  static constexpr int nodes = 1 << axes; ///< of a cell: bit a of one is set at the upper end along axis a
  using Nodes = std::array<std::size_t, nodes>;
  using Slopes = std::array<Vector, nodes>; ///< of the nodes' shape functions

public:
  Body(const ElasticProblem& problem, const std::vector<double>& stiffening, double poisson)
      : problem_(problem), stiffening_(stiffening), mu_(0.5 / (1.0 + poisson)),
        lame_(axes == 3 ? poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
                        : poisson / (1.0 - poisson * poisson)),
        way_(problem.extent.sites(), Vector::Zero()), before_(way_) {
    for (int point = 0; point < nodes; ++point) {
      for (int node = 0; node < nodes; ++node) {
        for (int along = 0; along < axes; ++along) {
          double slope = 1.0;
          for (int axis = 0; axis < axes; ++axis) {
            const double at = ((point >> axis & 1) != 0 ? 0.5 : -0.5) / std::sqrt(3.0);
            const double sign = (node >> axis & 1) != 0 ? 1.0 : -1.0;
            slope *= axis == along ? sign / problem.sides[static_cast<std::size_t>(axis)] : 0.5 + sign * at;
          }
          slopes_[point][node][along] = slope;
        }
      }
    }
  }

  /// One time step. `load`: the share of conditions and forces that is there.
  void step(double load) {
    for (std::size_t site = 0; site < way_.size(); ++site) {
      const Vector velocity = way_[site] - before_[site];
      before_[site] = way_[site];
      way_[site] += kept_velocity * velocity;
      for (std::size_t axis = 0; axis < axes; ++axis) {
        double& component = way_[site][static_cast<int>(axis)];
        if (!problem_.force[axis].empty()) {
          component += square_of_step * load * problem_.force[axis][site] / problem_.modulus[site];
        }
        if (problem_.fixed[axis][site] != 0) {
          component = load * problem_.prescribed[axis][site];
        }
      }
    }
    const Extent extent = problem_.extent;
    for (int colour = 0; colour < nodes; ++colour) { // cells of one share no node
      const int first_z = colour >> 2 & 1;
#pragma omp parallel for collapse(2) if (extent.sites() > sites_worth_threads)
      for (int z = first_z; z < std::max(extent.depth - 1, 1); z += 2) {
        for (int y = colour >> 1 & 1; y < extent.height - 1; y += 2) {
          for (int x = colour & 1; x + 1 < extent.width; x += 2) {
            project_cell(x, y, z);
          }
        }
      }
    }
  }

  [[nodiscard]] ReferenceField displacement() const {
    ReferenceField field(problem_.extent);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      std::ranges::transform(way_, field[axis].begin(),
                             [&](const Vector& way) { return way[static_cast<int>(axis)]; });
    }
    return field;
  }

private:
  static constexpr double square_of_step = axes == 3 ? 0.1 : 0.5; ///< over modulus, mass and pixel of 1
  static constexpr double kept_velocity = 0.95;                   ///< the rest is damped

  struct Response {
    double energy = 0.0; ///< for a modulus of 1
    Square stress;       ///< the first of Piola and Kirchhoff
  };

  void project_cell(int x, int y, int z) {
    Nodes at{};
    for (int node = 0; node < nodes; ++node) {
      at[node] = problem_.extent.index(x + (node & 1), y + (node >> 1 & 1), z + (node >> 2));
    }
    for (int point = 0; point < nodes; ++point) {
      Square f = Square::Identity();
      for (int node = 0; node < nodes; ++node) {
        f += way_[at[node]] * slopes_[point][node].transpose();
      }
      const std::size_t tissue = at[point];
      const double share = problem_.modulus[tissue] / nodes; // of the cell
      const Response response = stiffening_[tissue] < 0.0 ? hookean(f) : neo_hookean(f, stiffening_[tissue]);
      project(response, share, slopes_[point], at);
    }
  }

  /// Moves the nodes so that the root of twice the energy is nearer to 0, the less the softer it is.
  void project(const Response& response, double share, const Slopes& slopes, const Nodes& at) {
    constexpr double least_energy = 1e-24;
    if (response.energy < least_energy) {
      return;
    }
    const double value = std::sqrt(2.0 * share * response.energy);
    const Square slope = share / value * response.stress;
    std::array<Vector, nodes> moves;
    double sum = 1.0 / square_of_step;
    for (int node = 0; node < nodes; ++node) {
      const Vector gradient = slope * slopes[node];
      for (int axis = 0; axis < axes; ++axis) {
        const bool is_fixed = problem_.fixed[static_cast<std::size_t>(axis)][at[node]] != 0;
        moves[node][axis] = is_fixed ? 0.0 : gradient[axis] / problem_.modulus[at[node]];
      }
      sum += gradient.dot(moves[node]);
    }
    for (int node = 0; node < nodes; ++node) {
      way_[at[node]] -= value / sum * moves[node];
    }
  }

  [[nodiscard]] Response hookean(const Square& f) const {
    const Square strain = 0.5 * (f + f.transpose()) - Square::Identity();
    return {mu_ * strain.squaredNorm() + 0.5 * lame_ * strain.trace() * strain.trace(),
            2.0 * mu_ * strain + lame_ * strain.trace() * Square::Identity()};
  }

  /// W = mu / (2 b) ((1 + b Q / 8)^8 - 1) + lame / 2 L^2, whose first part is mu / 2 Q for b = 0;
  /// Q = I1 - 3 - 2 L, L = (J - 1 / J) / 2, which goes on as a straight line below J = .1.
  [[nodiscard]] Response neo_hookean(const Square& f, double b) const {
    constexpr double least = 0.1;
    const double j = f.determinant();
    const double at = std::max(j, least);
    const double slope = 0.5 * (1.0 + 1.0 / (at * at));
    const double log = 0.5 * (at - 1.0 / at) + slope * (j - at);
    const double q = std::max(0.0, f.squaredNorm() - axes - 2.0 * log);
    const double stretch = 1.0 + b / 8.0 * q;
    const double of_mu = b > 0.0 ? (std::pow(stretch, 8.0) - 1.0) / b : q;
    Square cofactor;
    if constexpr (axes == 2) {
      cofactor << f(1, 1), -f(1, 0), -f(0, 1), f(0, 0);
    } else {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          cofactor(i, k) = f((i + 1) % 3, (k + 1) % 3) * f((i + 2) % 3, (k + 2) % 3) -
                           f((i + 1) % 3, (k + 2) % 3) * f((i + 2) % 3, (k + 1) % 3);
        }
      }
    }
    return {0.5 * mu_ * of_mu + 0.5 * lame_ * log * log,
            mu_ * std::pow(stretch, 7.0) * (f - slope * cofactor) + lame_ * log * slope * cofactor};
  }

  const ElasticProblem& problem_;
  const std::vector<double>& stiffening_;
  double mu_;
  double lame_;
  std::array<Slopes, nodes> slopes_; ///< at the quadrature points, each beside a node
  std::vector<Vector> way_;
  std::vector<Vector> before_;
};

template <int axes>
ReferenceField relaxed(const ElasticProblem& problem, const std::vector<double>& stiffening, double poisson,
                       int sweeps) {
  Body<axes> body(problem, stiffening, poisson);
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    body.step(std::min(1.0, 4.0 * sweep / sweeps));
  }
  return body.displacement();
}

} // namespace

ReferenceField relax_positions(const ElasticProblem& problem, const std::vector<double>& stiffening,
                               double poisson, int sweeps) {
  (void)ElementRule::of(problem.extent, {poisson});
  if (!problem.spring[0].empty()) {
    throw InputError("position-based dynamics have no springs here");
  }
  return problem.extent.axes() == 3 ? relaxed<3>(problem, stiffening, poisson, sweeps)
                                    : relaxed<2>(problem, stiffening, poisson, sweeps);
}

} // namespace hdmbench
