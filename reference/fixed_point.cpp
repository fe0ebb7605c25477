#include "reference/fixed_point.hpp"

#include "kernels/data/input_error.hpp"
#include "reference/sparse_solver.hpp"
#include "reference/thesis_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace hdmbench {

namespace {

/// One component of a level: what (4.5)-(4.17) ask of it.
struct Component {
  std::size_t axis;
  const std::vector<float>& target;
  const std::vector<float>& confidence;

  [[nodiscard]] char name() const { return "xyz"[axis]; }
};

/// The equations without observations. A row divided by the curvature, which grows with the square of the
/// ratio of moduli, is the way of a site from its minimiser: sites of all materials weigh the same in the
/// residual that tells whether the system was solved.
struct Equations {
  SparseMatrix matrix;       ///< g_t / A_t, g_t = sum over the neighbours of weight * (d_t - d_neighbour)
  Eigen::VectorXd curvature; ///< A_t, 1 / px^2
};

Equations equations_of(const Level& level, const Component& component) {
  const Extent extent = level.extent;
  const auto count = static_cast<std::int64_t>(extent.sites());
  Equations result{SparseMatrix(count, count), Eigen::VectorXd::Zero(count)};
  std::vector<Eigen::Triplet<double, std::int64_t>> entries;
  for (std::size_t t = 0; t < extent.sites(); ++t) {
    const auto row = static_cast<std::int64_t>(t);
    const auto ratio_to = [&](std::size_t site) {
      return static_cast<double>(level.modulus.values[t]) / static_cast<double>(level.modulus.values[site]);
    };
    const auto add = [&](std::size_t neighbour, double weight) {
      if (neighbour != t) { // an outside one has all values of t
        entries.emplace_back(row, row, weight);
        entries.emplace_back(row, static_cast<std::int64_t>(neighbour), -weight);
      }
    };
    for (const auto& line : thesis_lines) {
      if (line[component.axis] != 0 && (line[2] == 0 || extent.axes() == 3)) {
        const std::size_t s = neighbour_along(extent, t, line, -1);
        const std::size_t u = neighbour_along(extent, t, line, 1);
        const double k = ratio_to(s);
        const double r = ratio_to(u);
        add(s, (1.0 + r) * r + (1.0 + k));
        add(u, (1.0 + r) + (1.0 + k) * k);
        result.curvature[row] += (1.0 + r) * (1.0 + r) + (1.0 + k) * (1.0 + k);
      }
    }
  }
  result.matrix.setFromTriplets(entries.begin(), entries.end());
  result.matrix = result.curvature.cwiseInverse().asDiagonal() * result.matrix;
  return result;
}

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
  ComponentSolution(const Level& level, const Component& component)
      : component_(component), is_volume_(level.extent.axes() == 3),
        equations_(equations_of(level, component)), states_(level.extent.sites(), State::unobserved),
        target_(Eigen::Map<const Eigen::VectorXf>(component.target.data(), equations_.matrix.rows())
                    .cast<double>()),
        displacement_(target_) {
    const auto confidence =
        Eigen::Map<const Eigen::VectorXf>(component.confidence.data(), target_.size()).cast<double>();
    reach_ = 0.5 * static_cast<double>(level.penalty) * confidence.cwiseQuotient(equations_.curvature);
    double largest = 0.0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (component.confidence[i] > 0.0F) {
        states_[i] = State::held;
        largest = std::max(largest, std::abs(static_cast<double>(component.target[i])));
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
                                 component_.name(), most_rounds));
  }

  [[nodiscard]] const Eigen::VectorXd& displacement() const { return displacement_; }
  [[nodiscard]] std::size_t held() const {
    return static_cast<std::size_t>(std::ranges::count(states_, State::held));
  }
  [[nodiscard]] int rounds() const { return rounds_; }

private:
  void require_observations(Extent extent) const {
    const int thickness = extent.sides()[component_.axis];
    const Undetermined undetermined = find_undetermined(thickness, component_.confidence);
    if (undetermined.sites == 0) {
      return;
    }
    if (thickness > 1) {
      throw InputError(fmt::format("no site has a known displacement in {}, so no field is the only fixed "
                                   "point; give a condition",
                                   component_.name()));
    }
    throw InputError(fmt::format("the displacement in {0} at {1} is not known, and an image one site thick "
                                 "does not connect it to others; give a condition",
                                 component_.name(), extent.place(undetermined.first)));
  }

  /// A column for each of the sites for which wanted(site): takes their rows, or their columns, out of all.
  template <typename Wanted>
  [[nodiscard]] SparseMatrix selection(const Wanted& wanted) const {
    std::vector<Eigen::Triplet<double, std::int64_t>> ones;
    for (std::int64_t i = 0; i < target_.size(); ++i) {
      if (wanted(i)) {
        ones.emplace_back(i, static_cast<std::int64_t>(ones.size()), 1.0);
      }
    }
    SparseMatrix result(target_.size(), static_cast<std::int64_t>(ones.size()));
    result.setFromTriplets(ones.begin(), ones.end());
    return result;
  }

  /// The displacement of all components that are not held.
  void solve() {
    const auto state = [&](std::int64_t i) { return states_[static_cast<std::size_t>(i)]; };
    const SparseMatrix free = selection([&](std::int64_t i) { return state(i) != State::held; });
    Eigen::VectorXd pull = Eigen::VectorXd::Zero(target_.size());
    for (std::int64_t i = 0; i < target_.size(); ++i) {
      pull[i] = state(i) == State::below ? reach_[i] : state(i) == State::above ? -reach_[i] : 0.0;
      displacement_[i] = state(i) == State::held ? target_[i] : 0.0;
    }
    displacement_ += free * solved(free.transpose() * equations_.matrix * free,
                                   free.transpose() * (pull - equations_.matrix * displacement_));
  }

  void take_back(State state) { std::ranges::replace(states_, state, State::held); }

  /// Where every site has let go the system is singular: its left null vector p says that the pulls, p_i K
  /// c_i / 2A_i up or down, must balance by themselves. They do when the whole field is shifted by the
  /// weighted median of what is left to the targets, so that site is held.
  void hold_median() {
    if (balance_.size() == 0) {
      balance_ = left_null_vector();
    }
    std::vector<std::pair<double, std::int64_t>> ways; // y - d, site
    for (std::int64_t i = 0; i < target_.size(); ++i) {
      if (states_[static_cast<std::size_t>(i)] != State::unobserved) {
        ways.emplace_back(target_[i] - displacement_[i], i);
      }
    }
    std::ranges::sort(ways);
    const double sum = balance_.dot(reach_); // those that are not observed reach nothing
    double passed = 0.0;
    const auto median = std::ranges::find_if(ways, [&](const auto& way) {
      passed += balance_[way.second] * reach_[way.second];
      return passed >= 0.5 * sum;
    });
    states_[static_cast<std::size_t>(median->second)] = State::held;
  }

  /// p > 0 with p' M = 0 for the matrix M of all equations; p = 1 at site 0.
  [[nodiscard]] Eigen::VectorXd left_null_vector() const {
    const SparseMatrix rest = selection([](std::int64_t i) { return i > 0; });
    const SparseMatrix transposed = equations_.matrix.transpose();
    const Eigen::VectorXd first = Eigen::VectorXd::Unit(target_.size(), 0);
    return first +
           rest * solved(rest.transpose() * transposed * rest, -(rest.transpose() * (transposed * first)));
  }

  [[nodiscard]] Eigen::VectorXd solved(const SparseMatrix& matrix, const Eigen::VectorXd& right_side) const {
    auto solution =
        is_volume_ ? solve_without_factors(matrix, right_side) : solve_general(matrix, right_side);
    if (!solution) {
      throw InputError(
          fmt::format("the system of the fixed point in {} is singular to working precision: the "
                      "moduli differ too much",
                      component_.name()));
    }
    return *std::move(solution);
  }

  /// Whether any state contradicted the displacement. One-sided: what is or would be below its target waits
  /// until all others agree.
  bool update_states(bool one_sided) {
    const Eigen::VectorXd gradient = equations_.matrix * displacement_;
    const auto update = [&](State beyond, double side) {
      bool changed = false;
      for (std::int64_t i = 0; i < target_.size(); ++i) {
        State& state = states_[static_cast<std::size_t>(i)];
        const bool lets_go = state == State::held && side * gradient[i] < -reach_[i] - tolerance_;
        const bool returns = state == beyond && side * (displacement_[i] - target_[i]) < -tolerance_;
        state = lets_go ? beyond : returns ? State::held : state;
        changed = changed || lets_go || returns;
      }
      return changed;
    };
    const bool changed = update(State::above, 1.0);
    return (one_sided && changed) || update(State::below, -1.0) || changed;
  }

  Component component_;
  bool is_volume_;
  Equations equations_;
  Eigen::VectorXd reach_; ///< K c / 2A, pixels
  std::vector<State> states_;
  Eigen::VectorXd target_;
  Eigen::VectorXd displacement_;
  Eigen::VectorXd balance_; ///< left null vector, once it was needed
  double tolerance_ = 0.0;  ///< pixels by which a state must be contradicted
  int rounds_ = 0;
};

} // namespace

FixedPoint solve_fixed_point(const Level& level) {
  validate(level);
  FixedPoint result{.displacement = ReferenceField(level.extent)};
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    ComponentSolution solution(level, {axis, level.target[axis], level.confidence[axis]});
    solution.settle();
    result.displacement[axis].assign(solution.displacement().begin(), solution.displacement().end());
    result.held += solution.held();
    result.rounds = std::max(result.rounds, solution.rounds());
  }
  return result;
}

} // namespace hdmbench
