#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/solve/methods/buckling.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/local_rotation.hpp"
#include "kernels/data/elastic/law_forces.hpp"

#include <functional>
#include <limits>
#include <string>

namespace hdmbench {

/// What is left on an image that only says where the next finer one begins, its own pixels.
inline constexpr double accuracy_of_starts = 0.05;
inline constexpr int steps_of_starts = 30;

/// RMS over the sites that are not void: what void does follows from them, and no step is chosen for it.
[[nodiscard]] double root_mean_square_of_tissue(const Level& level, const VectorField& field);

/// Sets `to` to value + factor * direction, component by component; all may be one field.
void advance(VectorField& to, const VectorField& value, float factor, const VectorField& direction);

/// Non-linear conjugate gradients on one image whose tissues have laws of large strains: the cycle of the
/// linear energy is the preconditioner, the forces are those of the laws (kernels/data/elastic/law_forces).
class LawSolver {
public:
  /// `start`: what begin() is given, null: it finds one. `say`: of every cycle. All must outlive this object.
  /// Throws as ElasticSolver does.
  LawSolver(const Level& level, const ElasticModel& model, ElasticSession& session, const VectorField* start,
            std::function<void(double left, double moved, double least)> say);

  /// Begins with the linear solution, or with parts of the load where that turns cells over. Returns whether
  /// it is the linear one.
  bool begin();
  void begin(VectorField displacement);

  /// Tells it the smallest eigenvalue (LeftByCycles) that a coarser image has met.
  void expect_slowest(double eigenvalue) { slowest_ = eigenvalue; }
  [[nodiscard]] double slowest() const { return slowest_; }

  /// Steps until what is left is within `accuracy`, pixels, at most so many.
  void iterate(double accuracy, int most);

  /// Returns the site around which the body would buckle out of the balance that iterate() has led to
  /// (buckling.hpp), by so many steps; none where it was not seen to.
  [[nodiscard]] std::optional<std::size_t> site_that_buckles(int most, int fewest = fewest_steps_to_buckling);
  /// Returns around which site a step was last pushed on by the forces that it was to balance; none: never.
  [[nodiscard]] const std::optional<std::size_t>& gave_way_at() const { return gave_way_at_; }
  /// Returns how far tissue has turned at most, and around which site; none where it hardly has.
  [[nodiscard]] std::optional<LocalRotation::Turn> largest_turn() const;

  [[nodiscard]] const VectorField& displacement() const { return displacement_; }
  [[nodiscard]] VectorField take_displacement() { return std::move(displacement_); }
  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] const LeastVolume& least() const { return least_; }
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] const ElasticSolver& linear() const { return linear_; }
  [[nodiscard]] int forces() const { return forces_; }
  [[nodiscard]] double seconds_of_forces() const { return seconds_; }

private:
  /// Sets `residual` to what is left to be balanced under a displacement.
  LeastVolume residual_of(const VectorField& displacement, VectorField& residual);
  /// Returns the moduli of a cycle for the stiffness that the tissues have under a displacement.
  [[nodiscard]] ScalarField modulus_under(const VectorField& displacement) const;
  /// Makes the cycle one for the stiffness that the tissues have where they are.
  void follow_strain();
  void find_residual();
  /// Sets `correction` to what a cycle makes of a residual, in axes that turn with the tissue.
  void correct(const VectorField& residual, VectorField& correction);
  /// Brings prescribed components to their targets, and what is around them along, as the linear energy has
  /// it.
  void meet_conditions();
  /// Goes `factor` times the direction, and changes the factor until the residual has hardly a part along it.
  /// tried_residual_ is the one before then. False where it finds no such: then the field is as it was.
  bool search(const VectorField& direction, double& factor);

  const Level& level_;
  ElasticModel model_;
  ElasticSession& session_;
  LawForces tissues_;
  ElasticSolver linear_;
  std::function<void(double, double, double)> say_;
  VectorField displacement_;
  VectorField residual_;
  VectorField tried_; ///< a displacement that search() looks at
  VectorField tried_residual_;
  float void_modulus_;
  bool slides_;   ///< along walls
  int next_look_; ///< the step before which the cycle follows the strain, in iterate()
  std::optional<LocalRotation> rotation_; ///< of the cycle's axes; none: tissue has hardly turned
  std::optional<std::size_t> gave_way_at_;
  bool gives_way_ = false; ///< in the last step
  LeastVolume least_{};
  double slowest_ = 1.0; ///< eigenvalue that was met
  double load_ = 1.0;    ///< the part of targets and loads that acts
  double left_ = std::numeric_limits<double>::infinity();
  std::string why_; ///< why there is no end; empty: there is
  int forces_ = 0;
  double seconds_ = 0.0;
};

} // namespace hdmbench
