#include "reference/fixed_point.hpp"

#include "kernels/data/input_error.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace hdmbench {

namespace {

struct Offset {
  int x;
  int y;
};

/// One component of a level: what (4.5)-(4.17) ask of it.
struct Component {
  char name;
  std::array<Offset, 3> triples; ///< from the centre to u; s is on the other side
  const std::vector<float>& target;
  const std::vector<float>& confidence;
};

/// Half the derivative of U_t is g_t = sum over the six neighbours of weight * (d_t - d_neighbour).
class Equations {
public:
  Equations(const Level& level, const Component& component)
      : weights_(level.extent.sites()), neighbours_(level.extent.sites()), curvature_(level.extent.sites()) {
    const Extent extent = level.extent;
    for (int y = 0; y < extent.height; ++y) {
      for (int x = 0; x < extent.width; ++x) {
        const std::size_t t = extent.index(x, y);
        const double modulus = static_cast<double>(level.modulus.values[t]);
        const auto site = [&](int nx, int ny) {
          const bool inside = nx >= 0 && nx < extent.width && ny >= 0 && ny < extent.height;
          return inside ? extent.index(nx, ny) : t; // as an outside neighbour has all values of t
        };
        for (std::size_t i = 0; i < 3; ++i) {
          const Offset to = component.triples[i];
          const std::size_t s = site(x - to.x, y - to.y);
          const std::size_t u = site(x + to.x, y + to.y);
          const double k = modulus / static_cast<double>(level.modulus.values[s]);
          const double r = modulus / static_cast<double>(level.modulus.values[u]);
          neighbours_[t][2 * i] = s;
          neighbours_[t][2 * i + 1] = u;
          weights_[t][2 * i] = s == t ? 0.0 : (1.0 + r) * r + (1.0 + k);
          weights_[t][2 * i + 1] = u == t ? 0.0 : (1.0 + r) + (1.0 + k) * k;
          curvature_[t] += (1.0 + r) * (1.0 + r) + (1.0 + k) * (1.0 + k);
        }
      }
    }
  }

  /// call(neighbour, weight) for every neighbour inside the image.
  template <typename Call>
  void for_each_neighbour(std::size_t site, Call&& call) const {
    for (std::size_t i = 0; i < 6; ++i) {
      if (weights_[site][i] > 0.0) {
        call(neighbours_[site][i], weights_[site][i]);
      }
    }
  }

  /// g of a site.
  [[nodiscard]] double gradient(const std::vector<double>& displacement, std::size_t site) const {
    double sum = 0.0;
    for_each_neighbour(site, [&](std::size_t neighbour, double weight) {
      sum += weight * (displacement[site] - displacement[neighbour]);
    });
    return sum;
  }
  /// A of a site, 1 / px^2.
  [[nodiscard]] double curvature(std::size_t site) const { return curvature_[site]; }

private:
  std::vector<std::array<double, 6>> weights_;
  std::vector<std::array<std::size_t, 6>> neighbours_;
  std::vector<double> curvature_;
};

/// Where a component stands to its observation. The derivative of K c |y - d| is -K c below the target and
/// K c above.
enum class State : std::uint8_t {
  unobserved, ///< g = 0
  held,       ///< d = y and |g| <= K c / 2
  below,      ///< d < y and g = K c / 2
  above,      ///< d > y and g = -K c / 2
};

class ComponentSolution {
public:
  ComponentSolution(const Level& level, const Component& component, SparseSolver solver)
      : component_(component), solver_(solver), equations_(level, component), pull_(level.extent.sites()),
        states_(level.extent.sites(), State::unobserved),
        displacement_(component.target.begin(), component.target.end()) {
    double largest = 0.0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (component.confidence[i] > 0.0F) {
        pull_[i] = 0.5 * static_cast<double>(level.penalty) * static_cast<double>(component.confidence[i]);
        states_[i] = State::held;
        largest = std::max(largest, std::abs(displacement_[i]));
      }
    }
    tolerance_ = 1e-12 * (1.0 + largest);
    require_observations(level.extent);
  }

  /// Letting go in both directions at once is Newton's method: few rounds, but nothing forbids a cycle. In
  /// one direction at a time, starting from all held, it is policy iteration on a maximum of minima of
  /// M-matrix equations: slow, but each stage is monotone and so ends, and as long as those above their
  /// targets are taken back before the last site lets go, one can stay held.
  void settle() {
    constexpr int most_quick_rounds = 60;
    constexpr int most_rounds = 1000;
    for (rounds_ = 1; rounds_ <= most_rounds; ++rounds_) {
      solve();
      const bool one_sided = rounds_ > most_quick_rounds;
      if (!update_states(one_sided)) {
        return;
      }
      if (rounds_ == most_quick_rounds) {
        take_back(State::below);
        take_back(State::above);
      } else if (held() == 0) {
        one_sided ? take_back(State::above) : hold_median();
      }
    }
    throw InputError(fmt::format("the fixed point in {} was not found in {} rounds: the sites that their "
                                 "observation holds did not settle",
                                 component_.name, most_rounds));
  }

  [[nodiscard]] std::vector<double>& displacement() { return displacement_; }
  [[nodiscard]] std::size_t held() const {
    return static_cast<std::size_t>(std::ranges::count(states_, State::held));
  }
  [[nodiscard]] int rounds() const { return rounds_; }

private:
  void require_observations(Extent extent) const {
    const int thickness = component_.name == 'x' ? extent.width : extent.height;
    const Undetermined undetermined = find_undetermined(thickness, component_.confidence);
    if (undetermined.sites == 0) {
      return;
    }
    if (thickness > 1) {
      throw InputError(fmt::format("no site has a known displacement in {}, so no field is the only fixed "
                                   "point; give a condition",
                                   component_.name));
    }
    throw InputError(fmt::format("the displacement in {0} at x = {1}, y = {2} is not known, and an image one "
                                 "site thick does not connect it to others; give a condition",
                                 component_.name, undetermined.first % static_cast<std::size_t>(extent.width),
                                 undetermined.first / static_cast<std::size_t>(extent.width)));
  }

  /// The displacement of all components that are not held.
  void solve() {
    std::vector<std::int64_t> unknown(states_.size(), -1);
    std::int64_t count = 0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] != State::held) {
        unknown[i] = count++;
      } else {
        displacement_[i] = static_cast<double>(component_.target[i]);
      }
    }
    if (count == 0) {
      return;
    }
    Eigen::VectorXd right_side = Eigen::VectorXd::Zero(count);
    std::vector<Eigen::Triplet<double, std::int64_t>> entries;
    entries.reserve(7 * static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const std::int64_t row = unknown[i];
      if (row < 0) {
        continue;
      }
      // Divided by the curvature, which grows with the square of the ratio of moduli: sites of all materials
      // weigh the same in the residual that tells whether the system was solved.
      const double scale = 1.0 / equations_.curvature(i);
      const double pull = scale * pull_[i];
      double diagonal = 0.0;
      double right = states_[i] == State::below ? pull : states_[i] == State::above ? -pull : 0.0;
      equations_.for_each_neighbour(i, [&](std::size_t neighbour, double unscaled) {
        const double weight = scale * unscaled;
        diagonal += weight;
        if (unknown[neighbour] >= 0) {
          entries.emplace_back(row, unknown[neighbour], -weight);
        } else {
          right += weight * displacement_[neighbour];
        }
      });
      entries.emplace_back(row, row, diagonal);
      right_side[row] = right;
    }
    const Eigen::VectorXd solution = solved(count, entries, right_side);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (unknown[i] >= 0) {
        displacement_[i] = solution[unknown[i]];
      }
    }
  }

  void take_back(State state) { std::ranges::replace(states_, state, State::held); }

  /// Where every site has let go the system is singular: its left null vector p says that the pulls, p_i K
  /// c_i / 2 up or down, must balance by themselves. They do when the whole field is shifted by the weighted
  /// median of what is left to the targets, so that site is held.
  void hold_median() {
    if (balance_.empty()) {
      balance_ = left_null_vector();
    }
    std::vector<std::pair<double, std::size_t>> ways; // y - d, site
    double sum = 0.0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] != State::unobserved) {
        ways.emplace_back(static_cast<double>(component_.target[i]) - displacement_[i], i);
        sum += balance_[i] * pull_[i];
      }
    }
    std::ranges::sort(ways);
    double passed = 0.0;
    const auto median = std::ranges::find_if(ways, [&](const auto& way) {
      passed += balance_[way.second] * pull_[way.second];
      return passed >= 0.5 * sum;
    });
    states_[median->second] = State::held;
  }

  /// p > 0 with p' G = 0 for the matrix G of all equations without observations; p = 1 at site 0.
  [[nodiscard]] std::vector<double> left_null_vector() const {
    const auto count = static_cast<std::int64_t>(states_.size()) - 1;
    Eigen::VectorXd right_side = Eigen::VectorXd::Zero(count);
    std::vector<Eigen::Triplet<double, std::int64_t>> entries;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const std::int64_t column = static_cast<std::int64_t>(i) - 1;
      equations_.for_each_neighbour(i, [&](std::size_t neighbour, double weight) {
        const std::int64_t row = static_cast<std::int64_t>(neighbour) - 1;
        if (column < 0) {
          right_side[row] = weight;
          return;
        }
        entries.emplace_back(column, column, weight);
        if (row >= 0) {
          entries.emplace_back(row, column, -weight);
        }
      });
    }
    const Eigen::VectorXd solution = solved(count, entries, right_side);
    std::vector<double> result{1.0};
    result.insert(result.end(), solution.begin(), solution.end());
    return result;
  }

  [[nodiscard]] Eigen::VectorXd solved(std::int64_t count,
                                       const std::vector<Eigen::Triplet<double, std::int64_t>>& entries,
                                       const Eigen::VectorXd& right_side) const {
    SparseMatrix matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    auto solution = solve_general(matrix, right_side, solver_);
    if (!solution) {
      throw InputError(
          fmt::format("the system of the fixed point in {} is singular to working precision: the "
                      "moduli differ too much",
                      component_.name));
    }
    return *std::move(solution);
  }

  /// Whether any state contradicted the displacement. One-sided: what is or would be below its target waits
  /// until all others agree.
  bool update_states(bool one_sided) {
    bool changed = change([&](std::size_t i, double beyond, double gradient) {
      switch (states_[i]) {
      case State::held:
        return gradient < -pull_[i] - equations_.curvature(i) * tolerance_ ? State::above : State::held;
      case State::above:
        return beyond < -tolerance_ ? State::held : State::above;
      default:
        return states_[i];
      }
    });
    if (one_sided && changed) {
      return true;
    }
    changed =
        change([&](std::size_t i, double beyond, double gradient) {
          switch (states_[i]) {
          case State::held:
            return gradient > pull_[i] + equations_.curvature(i) * tolerance_ ? State::below : State::held;
          case State::below:
            return beyond > tolerance_ ? State::held : State::below;
          default:
            return states_[i];
          }
        }) ||
        changed;
    return changed;
  }

  /// choose(site, d - y, g) gives the new state.
  template <typename Choose>
  bool change(Choose&& choose) {
    std::size_t changes = 0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] != State::unobserved) {
        const State next = choose(i, displacement_[i] - static_cast<double>(component_.target[i]),
                                  equations_.gradient(displacement_, i));
        changes += next != states_[i] ? 1 : 0;
        states_[i] = next;
      }
    }
    return changes > 0;
  }

  Component component_;
  SparseSolver solver_;
  Equations equations_;
  std::vector<double> pull_; ///< K c / 2
  std::vector<State> states_;
  std::vector<double> displacement_;
  std::vector<double> balance_; ///< left null vector, once it was needed
  double tolerance_ = 0.0;      ///< pixels by which a state must be contradicted
  int rounds_ = 0;
};

/// The distance of d from the minimiser of its own energy, from three values of the energy without the
/// observation: at d - 1, d and d + 1.
double distance_to_minimiser(double below, double at, double above, double pull, double to_target) {
  const double curvature = 0.5 * (below + above) - at;
  const double free_minimiser = 0.25 * (below - above) / curvature; // relative to d
  const double reach = pull / curvature;
  const double remaining = to_target - free_minimiser;
  return std::abs(free_minimiser + std::clamp(remaining, -reach, reach));
}

double largest_residual(const Level& level, const ReferenceField& displacement) {
  Level unobserved = level;
  unobserved.confidence = VectorField(level.extent);
  const ThesisEnergyOf<ReferenceField> energy(unobserved, displacement);
  const double half_penalty = 0.5 * static_cast<double>(level.penalty);
  double largest = 0.0;
#pragma omp parallel for schedule(static) reduction(max : largest)
  for (int y = 0; y < level.extent.height; ++y) {
    for (int x = 0; x < level.extent.width; ++x) {
      const std::size_t i = level.extent.index(x, y);
      const double dx = displacement.x[i];
      const double dy = displacement.y[i];
      const auto below = energy.at(x, y, {dx - 1.0, dy - 1.0});
      const auto at = energy.at(x, y, {dx, dy});
      const auto above = energy.at(x, y, {dx + 1.0, dy + 1.0});
      const double in_x = distance_to_minimiser(below.x, at.x, above.x,
                                                half_penalty * static_cast<double>(level.confidence.x[i]),
                                                static_cast<double>(level.target.x[i]) - dx);
      const double in_y = distance_to_minimiser(below.y, at.y, above.y,
                                                half_penalty * static_cast<double>(level.confidence.y[i]),
                                                static_cast<double>(level.target.y[i]) - dy);
      largest = std::max({largest, in_x, in_y});
    }
  }
  return largest;
}

} // namespace

FixedPoint solve_fixed_point(const Level& level, SparseSolver solver) {
  validate(level);
  FixedPoint result{.displacement = ReferenceField(level.extent)};
  const auto add = [&](const Component& component, std::vector<double>& displacement) {
    ComponentSolution solution(level, component, solver);
    solution.settle();
    displacement = std::move(solution.displacement());
    result.held += solution.held();
    result.rounds = std::max(result.rounds, solution.rounds());
  };
  add({'x', {{{1, 0}, {1, 1}, {1, -1}}}, level.target.x, level.confidence.x}, result.displacement.x);
  add({'y', {{{0, 1}, {1, 1}, {1, -1}}}, level.target.y, level.confidence.y}, result.displacement.y);
  result.residual = largest_residual(level, result.displacement);
  return result;
}

} // namespace hdmbench
