#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/elastic/conditions.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What a body is moved by beside its conditions.
struct Disturbance {
  VectorField rest;  ///< where each spring is at rest, pixels from where it was; read where there is one
  VectorField force; ///< at each site, MPa * thickness or voxel, in pixels of area or volume 1
};

/// What becomes of laws of large strains.
enum class Strains {
  small,     ///< they are refused: the linear energy knows none
  linearised ///< they are left out, by who has their forces from elsewhere
};

/// The methods of the elastic energy, step by step on a session, from the conditions extended into the image.
class ElasticSolver {
public:
  /// What a cycle did to displacement: the root mean square over all components, pixels.
  struct Step {
    double change = 0.0;  ///< root mean square over sites, pixels
    double factor = 0.0;  ///< of conjugate gradients: how many times the direction
    double product = 0.0; ///< of conjugate gradients: of the load and the cycle's correction before it
    bool ended = false;   ///< nothing was changed
    bool at_rest = false; ///< ... for what is left is rounding; else numbers left what float can hold
  };

  /// Makes the hierarchy of the image and loads it; displacement is the extended conditions. Both must
  /// outlive this object. Throws InputError where no condition holds the sheet (require_held). Where
  /// observations pull with springs, or the level has forces, the session has the way from the extended
  /// conditions for displacement, and for its load what is left of their residual, which is made once and
  /// then followed. Throws InputError, too, where the level has laws that are not `strains`' own.
  ElasticSolver(const Level& full, const ElasticModel& model, ElasticSession& session,
                Strains strains = Strains::small);
  /// Makes the cycle of follow() with these moduli: for carry() and correct() alone, before which there is
  /// nothing to solve. Throws InputError where no condition holds the sheet.
  ElasticSolver(const Level& full, const ElasticModel& model, ElasticSession& session, ScalarField modulus);
  /// A sheet that is held by `springs`, at rest where pull() says; empty springs: none, so conditions must
  /// hold the sheet. It makes the hierarchy and loads it once, for any number of pull(), before which there
  /// is nothing to solve. All must outlive this object.
  ElasticSolver(const Level& full, const ElasticModel& model, const SiteSprings& springs,
                ElasticSession& session);
  /// Sets what is solved from now on, on a sheet with springs. `forces` (on sites that are not prescribed,
  /// MPa * pixel * thickness) pull at the sheet, which is displaced by `start`, where its springs are at
  /// rest: the way w from start that solves A (start + w) + springs w = forces. Prescribed components keep
  /// the value that start has.
  void pull(VectorField start, const VectorField& forces);

  /// Sets what is solved from now on, any number of times: how far `other` moves the body, whose prescribed
  /// components stay where they are. `level` is the one of the first constructor.
  void disturb(const Level& level, double poisson, const Disturbance& other);

  /// Sets what is solved from now on, any number of times: where prescribed components have the values of
  /// `gap`, the others 0, and nothing else acts, as full_multigrid() finds it.
  void carry(VectorField gap);
  /// Sets `correction` to what one W cycle makes of a load, in the unit of sessions. What is solved has no
  /// meaning afterwards.
  void correct(const VectorField& load, VectorField& correction);
  /// Makes the cycle that of a body with these moduli from now on, its conditions and the spring constants of
  /// its observations as they were; for carry() and correct(). `level` is the one of the first constructor.
  void follow(const Level& level, const ElasticModel& model, ScalarField modulus);

  /// From the coarsest level to the finest, one W cycle each: the error of the result is of the size of the
  /// discretisation's. Without `on_image` the image only gets what the next level has.
  void full_multigrid(bool on_image = true);
  /// A damped Jacobi sweep over the image: what ICM is to the thesis's energy.
  void sweep();
  /// One W cycle for what is missing.
  Step cycle();
  /// One step of conjugate gradients with the cycle as its preconditioner (flexible: Polak and Ribière). The
  /// residual is followed by recursion. Computed anew it would bring in the rounding of the displacement,
  /// which moduli of very different size multiply.
  Step conjugate_gradients();

  /// Where springs alone keep the sheet from moving without strain: brings it to where they are in balance.
  /// Steps see the less of such motions the weaker the springs are beside the tissue, in the end nothing.
  /// Returns the RMS of the way, pixels. The last thing to do. Reads the sheet only where springs pull.
  double settle(const Level& full);

  [[nodiscard]] VectorField displacement() const;
  /// The same as the last thing to do: the session gives its memory back.
  [[nodiscard]] VectorField result();
  /// What float leaves at least of the error of a field that reaches `largest`, pixels. Weak springs on soft
  /// tissue hold what is stiff the less exactly the more their moduli differ, and rounded forces bend what is
  /// slender.
  [[nodiscard]] double rounding(double largest, double contrast) const;
  /// Sweeps and residuals so far, the image first.
  [[nodiscard]] const std::vector<LevelResult>& work() const { return work_; }
  [[nodiscard]] const Timings& timings() const { return timings_; }

private:
  void load(const ElasticBody& body);
  /// What corrections are made from: the residual of displacement.
  void find_load();
  /// Takes the correction of the image.
  void take_correction();
  [[nodiscard]] int coarsest() const { return static_cast<int>(work_.size()) - 1; }
  [[nodiscard]] double root_mean_square(float square) const;
  void improve(int level, ElasticField field, bool from_zero);
  void restrict_residual(int level, ElasticField field);
  void relax(int level, ElasticField field);
  void forces(ElasticField of, ElasticField to);

  ElasticSession& session_;
  double slenderness_; ///< of the sheet or body
  Timings timings_;
  std::vector<LevelResult> work_;
  /// Whether a W cycle improves each level twice. One that is coarser along a single axis only has half as
  /// many sites as the finer one, and would take longer than it helps.
  std::vector<bool> visited_twice_;
  VectorField start_;        ///< extended conditions, or that of pull(); only where sprung_
  bool sprung_ = false;      ///< the session has the way from start_, and its load was made once
  bool has_springs_ = false; ///< of the level: only then settle() reads it
  struct Sheet {
    const Level* level = nullptr;
    const SiteSprings* springs = nullptr;
    double poisson = 0.0;
  };
  Sheet sheet_;               ///< of pull()
  float last_product_ = 0.0F; ///< load * correction of the last step of conjugate gradients; 0: none yet
  float last_factor_ = 0.0F;
  double last_change_ = 0.0;  ///< pixels
  double least_change_ = 0.0; ///< of conjugate gradients: what moves a component by no bit, pixels
};

/// Throws InputError where loads act on the level, or a tissue has a law of large strains: `who` solves
/// linear tissue with conditions alone.
void require_conditions_alone(const Level& level, std::string_view who);

/// Full multigrid, then conjugate gradients until what is left is within `accuracy`, pixels, at most so many
/// steps. `level` is the solver's.
void solve_within(double accuracy, int most_steps, const Level& level, ElasticSolver& solver);

/// A field and whether what it lacks is known to be within a share of it, or rounding.
struct SolutionToShare {
  VectorField displacement;
  bool is_within = false;
};

/// Full multigrid, then conjugate gradients until what is left is within that share of the field, RMS, at
/// most so many steps. The session keeps the field. `level` is the solver's, or has its confidences and
/// moduli and the targets that settle() is to see.
[[nodiscard]] SolutionToShare solve_to_share(double share, int most_steps, const Level& level,
                                             ElasticSolver& solver);

/// The scene by the method that its schedule names. Throws as ElasticSolver does.
[[nodiscard]] Solution solve_elastic(const Scene& scene, ElasticSession& session, Progress& progress,
                                     const SolveOptions& options = {});

} // namespace hdmbench
