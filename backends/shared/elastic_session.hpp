#pragma once

#include "backends/shared/timed.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/elastic/law_forces.hpp"
#include "kernels/data/field.hpp"

#include <optional>
#include <string_view>
#include <utility>

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

/// A step of a method as a value, which any session can take: the arguments of the call of ElasticSession
/// that has its name.
struct MethodStep {
  enum class Kind {
    write,
    relax,
    relax_from_zero,
    forces,
    restrict_residual,
    restrict_load,
    interpolate,
    correct,
    solve_coarsest,
    advance
  };

  [[nodiscard]] bool restricts() const {
    return kind == Kind::restrict_residual || kind == Kind::restrict_load;
  }
  /// The level of what it makes.
  [[nodiscard]] int made_on() const { return restricts() ? level + 1 : level; }
  /// For people.
  [[nodiscard]] std::string_view name() const;

  Kind kind{};
  int level = 0;                       ///< that it works on
  ElasticField to{};                   ///< what it makes
  ElasticField from = to;              ///< what it begins with, but for load and corrections
  ElasticField direction{};            ///< of advance
  float factor = 0.0F;                 ///< of advance
  const VectorField* values = nullptr; ///< of write
};

/// Computes with the elastic energy: one step of a method at a time, in the arithmetic and the order of
/// kernels/specification/elastic. Levels are numbered as in the hierarchy. Fields stay where they are
/// computed, but for write() and read(); a field is 0 until it is written or computed. Not thread-safe.
class ElasticSession : public Timed {
  using Kind = MethodStep::Kind;

public:
  /// Makes the levels of a body, and room for the fields. A session of several processes makes what each of
  /// them computes with. Returns the seconds that making them took.
  double load(const ElasticBody& body) { return do_load_body(body); }
  /// Loads levels that are made already. The session has them from now on: of a large volume a second
  /// hierarchy would be half of all memory. One in pieces knows bodies only.
  void load(ElasticHierarchy hierarchy) {
    hierarchy_ = std::move(hierarchy);
    do_load(hierarchy_);
  }
  virtual void take(const MethodStep& step) = 0;

  /// Values of the level's extent.
  void write(int level, ElasticField field, const VectorField& values) {
    take({.kind = Kind::write, .level = level, .to = field, .values = &values});
  }
  virtual void read(int level, ElasticField field, VectorField& values) const = 0;
  /// Gives memory back as far as the session can: displacement may be read, but else load() is next.
  void end() {
    for (ElasticLevel& level : hierarchy_.levels) {
      level.grid = std::exchange(level, {}).grid;
    }
    do_end();
  }

  /// One damped Jacobi sweep over all sites at once: displacement (without a load) or correction (with the
  /// level's load). Prescribed components stay.
  void relax(int level, ElasticField field) { take({.kind = Kind::relax, .level = level, .to = field}); }
  /// The same for a correction that is 0 before.
  void relax_from_zero(int level) {
    take({.kind = Kind::relax_from_zero, .level = level, .to = ElasticField::correction});
  }
  /// On the image: the forces that `of` leaves on components that may move, 0 on the others; no load is
  /// added. `to` is another field.
  void forces(ElasticField of, ElasticField to) { take({.kind = Kind::forces, .to = to, .from = of}); }
  /// load of level + 1 = restricted residual of `of`, displacement or correction, on `level`.
  void restrict_residual(int level, ElasticField of) {
    take({.kind = Kind::restrict_residual, .level = level, .to = ElasticField::load, .from = of});
  }
  /// load of level + 1 = restricted load of `level`.
  void restrict_load(int level) {
    take({.kind = Kind::restrict_load, .level = level, .to = ElasticField::load});
  }
  /// correction of `level` = interpolated correction of level + 1, 0 where prescribed.
  void interpolate(int level) {
    take({.kind = Kind::interpolate, .level = level, .to = ElasticField::correction});
  }
  /// The same added to `field`, displacement or correction.
  void correct(int level, ElasticField field) { take({.kind = Kind::correct, .level = level, .to = field}); }
  /// correction of the coarsest level = coarsest_inverse times its load.
  void solve_coarsest() {
    take({.kind = Kind::solve_coarsest, .level = coarsest(), .to = ElasticField::correction});
  }

  /// On the image: to = value + factor * direction, any of which may be the same field.
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) {
    take({.kind = Kind::advance, .to = to, .from = value, .direction = direction, .factor = factor});
  }
  /// On the image: the sum over all components of first * second, by a tree of 2 x 2 squares, in a volume
  /// of 2 x 2 x 2 cubes (site.inc).
  [[nodiscard]] virtual float dot(ElasticField first, ElasticField second) const = 0;

  /// The level of the tree of dot() whose squares have 2^height sites a side: for who has a part of an image
  /// here. As long as a session has no better way, whole fields are read.
  [[nodiscard]] virtual ScalarField dot_squares(ElasticField first, ElasticField second, int height) const;

  /// Returns whether law_forces() is worth its copies: a processor that is not the host's computes.
  [[nodiscard]] virtual bool has_own_laws() const { return false; }
  /// Sets `force` to what tissues of the image do under a displacement, and returns the cell that has kept
  /// least of its volume: what `tissues` does, to the bit. Returns none, and does nothing, where this session
  /// does not compute that, or not tissues of that size: then `tissues` has to be asked.
  /// ElasticField::image is lost.
  [[nodiscard]] virtual std::optional<LeastVolume>
  law_forces(const LawForces& /*tissues*/, const VectorField& /*displacement*/, VectorField& /*force*/) {
    return {};
  }

protected:
  /// The one that was loaded last, as do_load() left it.
  [[nodiscard]] const ElasticHierarchy& hierarchy() const { return hierarchy_; }
  [[nodiscard]] const ElasticLevel& level_at(int level) const {
    return hierarchy_.levels.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const RingedGrid& grid(int level) const { return level_at(level).grid; }
  [[nodiscard]] int coarsest() const { return static_cast<int>(hierarchy_.levels.size()) - 1; }

  /// Has a hierarchy without arrays from now on: the session's own is elsewhere.
  void set_outline(const ElasticBody& body) { hierarchy_ = outline_of(body.level.extent, body.level.sides); }

private:
  virtual double do_load_body(const ElasticBody& body);
  /// `hierarchy` is the session's own: it may give away what it does not read again.
  virtual void do_load(ElasticHierarchy& hierarchy) = 0;
  virtual void do_end() {}

  ElasticHierarchy hierarchy_;
};

/// The next level of the tree: sums of 2 x 2, of a volume's of 2 x 2 x 2.
[[nodiscard]] ScalarField square_sums(const ScalarField& sums, std::size_t axes);

} // namespace hdmbench
