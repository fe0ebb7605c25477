#pragma once

#include "backends/shared/interface.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/field.hpp"

namespace hdmbench {

/// What a session keeps, the components of every site of a level.
enum class ElasticField {
  displacement, ///< of the image only: pixels, with the prescribed components
  correction,   ///< of displacement, or of the finer level's correction: pixels, 0 where prescribed
  load,         ///< what drives the correction: on the image the residual of displacement
  direction,    ///< of the image only, of conjugate gradients: pixels
  image         ///< of the image only: what direction does to load
};
inline constexpr std::size_t elastic_fields = 5;

/// A level that is not the image has only what it adds to the finer one.
[[nodiscard]] constexpr bool has_field(int level, ElasticField field) {
  return level == 0 || field == ElasticField::correction || field == ElasticField::load;
}

/// Computes with the elastic energy: one step of a method at a time, in the arithmetic and the order of
/// kernels/specification/elastic. Levels are numbered as in the hierarchy. Fields stay where they are
/// computed, but for write() and read(); a field is 0 until it is written or computed. Not thread-safe.
class ElasticSession : public Interface {
public:
  /// Makes room for the fields. `hierarchy` must stay as it is until the next load(); it may be read in
  /// place.
  virtual void load(const ElasticHierarchy& hierarchy) = 0;

  /// Values of the level's extent.
  virtual void write(int level, ElasticField field, const VectorField& values) = 0;
  virtual void read(int level, ElasticField field, VectorField& values) const = 0;

  /// One damped Jacobi sweep over all sites at once: displacement (without a load) or correction (with the
  /// level's load). Prescribed components stay.
  virtual void relax(int level, ElasticField field) = 0;
  /// The same for a correction that is 0 before.
  virtual void relax_from_zero(int level) = 0;
  /// On the image: the forces that `of` leaves on components that may move, 0 on the others; no load is
  /// added. `to` is another field.
  virtual void forces(ElasticField of, ElasticField to) = 0;
  /// load of level + 1 = restricted residual of `of`, displacement or correction, on `level`.
  virtual void restrict_residual(int level, ElasticField of) = 0;
  /// load of level + 1 = restricted load of `level`.
  virtual void restrict_load(int level) = 0;
  /// correction of `level` = interpolated correction of level + 1, 0 where prescribed.
  virtual void interpolate(int level) = 0;
  /// The same added to `field`, displacement or correction.
  virtual void correct(int level, ElasticField field) = 0;
  /// correction of the coarsest level = coarsest_inverse times its load.
  virtual void solve_coarsest() = 0;

  /// On the image: to = value + factor * direction, any of which may be the same field.
  virtual void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) = 0;
  /// On the image: the sum over all components of first * second, by a tree of 2 x 2 squares, in a volume
  /// of 2 x 2 x 2 cubes (site.inc).
  [[nodiscard]] virtual float dot(ElasticField first, ElasticField second) const = 0;

  /// The level of the tree of dot() whose squares have 2^height sites a side: for who has a part of an image
  /// here. As long as a session has no better way, whole fields are read.
  [[nodiscard]] virtual ScalarField dot_squares(ElasticField first, ElasticField second, int height) const;
};

/// The next level of the tree: sums of 2 x 2, of a volume's of 2 x 2 x 2.
[[nodiscard]] ScalarField square_sums(const ScalarField& sums, std::size_t axes);

} // namespace hdmbench
