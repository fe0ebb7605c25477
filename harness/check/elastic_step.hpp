#pragma once

#include "backends/cpu/elastic_answers.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/check/bounded_real.hpp"

#include <functional>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What a session of the elastic energy makes of a site, each number with a bound of its rounding error.
using BoundedElastic = ElasticAnswers<bounded::real>;

/// One step of a method of the elastic energy, as a value that any session can take.
struct ElasticStep {
  /// A field of level `at`, which the step reads up to `reach` sites around each site of that level.
  struct Read {
    ElasticField field;
    int reach;
  };

  std::string_view name;
  int level; ///< and field: what the step makes
  ElasticField field;
  std::function<void(ElasticSession&)> take;
  /// What the step has to make of a site; of the fields before the step.
  std::function<BoundedElastic::Answer(const BoundedElastic&, int x, int y, int z)> answer;
  int at; ///< the level that it works on: `level`, or the next finer one, which it restricts
  std::vector<Read> reads{}; ///< in the order in which they are wanted
  bool interpolates = false; ///< reads the correction of level + 1
};

// What mistakes are made in, by name (harness/check/faults).
inline constexpr std::string_view sweep_step = "sweep";
inline constexpr std::string_view correction_step = "correction";

/// A session whose calls, but load(), read() and dot(), all arrive at one function.
class SteppedElasticSession : public ElasticSession {
public:
  void write(int level, ElasticField field, const VectorField& values) override;
  void relax(int level, ElasticField field) final;
  void relax_from_zero(int level) final;
  void forces(ElasticField of, ElasticField to) final;
  void restrict_residual(int level, ElasticField of) final;
  void restrict_load(int level) final;
  void interpolate(int level) final;
  void correct(int level, ElasticField field) final;
  void solve_coarsest() final;
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) final;

private:
  /// Of the hierarchy that was loaded last.
  [[nodiscard]] virtual int coarsest() const = 0;
  virtual void take(const ElasticStep& step) = 0;
};

} // namespace hdmbench
