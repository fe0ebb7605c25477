#pragma once

#include "backends/cpu/elastic_answers.hpp"

#include <memory>

namespace hdmbench {

/// What is kept of a number after a step.
inline float stored(float value) {
  return value;
}

/// Site by site on one thread, as plainly as the specification reads, in any arithmetic whose numbers can be
/// stored().
template <typename Scalar>
class ElasticSerial final : public ElasticInMemory {
  using Answers = ElasticAnswers<Scalar>;
  using Answer = typename Answers::Answer;

public:
  void load(const ElasticHierarchy& hierarchy) override {
    ElasticInMemory::load(hierarchy);
    answers_ = std::make_unique<Answers>(hierarchy, fields_);
  }

  void relax(int level, ElasticField field) override {
    make(level, field, [&](int x, int y) { return answers_->relax(level, field, x, y); });
  }
  void relax_from_zero(int level) override {
    make(level, ElasticField::correction,
         [&](int x, int y) { return answers_->relax_from_zero(level, x, y); });
  }
  void forces(ElasticField of, ElasticField to) override {
    make(0, to, [&](int x, int y) { return answers_->forces(of, x, y); });
  }
  void restrict_residual(int level, ElasticField of) override {
    restrict_sites(level, [&](int x, int y) { return answers_->free_residual(level, of, x, y); });
  }
  void restrict_load(int level) override {
    restrict_sites(level, [&](int x, int y) { return answers_->free_load(level, x, y); });
  }
  void interpolate(int level) override {
    make(level, ElasticField::correction, [&](int x, int y) { return answers_->interpolate(level, x, y); });
  }
  void correct(int level, ElasticField field) override {
    make(level, field, [&](int x, int y) { return answers_->correct(level, field, x, y); });
  }
  void solve_coarsest() override {
    make(coarsest(), ElasticField::correction, [&](int x, int y) { return answers_->solve_coarsest(x, y); });
  }
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    make(0, to, [&](int x, int y) { return answers_->advance(value, factor, direction, x, y); });
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    return stored(answers_->dot(first, second));
  }

private:
  /// answer(x, y) of all sites.
  template <typename At>
  [[nodiscard]] RingedField made(int level, const At& answer) const {
    RingedField field;
    field.require(grid(level));
    for (int y = 0; y < grid(level).sites.height; ++y) {
      for (int x = 0; x < grid(level).sites.width; ++x) {
        const Answer site = answer(x, y);
        field.x[grid(level).index(x, y)] = stored(site.x);
        field.y[grid(level).index(x, y)] = stored(site.y);
      }
    }
    return field;
  }

  /// The field from answer(x, y); the old one may be read meanwhile.
  template <typename At>
  void make(int level, ElasticField field, const At& answer) {
    fields_.at(level, field) = made(level, answer);
  }

  /// load of level + 1 from fine(x, y), which is stored on the way.
  template <typename Fine>
  void restrict_sites(int level, const Fine& fine) {
    const RingedField from = made(level, fine);
    make(level + 1, ElasticField::load, [&](int x, int y) {
      return answers_->restricted(level, x, y, [&](int i, int j) {
        const std::size_t at = grid(level).index(i, j);
        return Answer{Scalar(from.x[at]), Scalar(from.y[at])};
      });
    });
  }

  std::unique_ptr<Answers> answers_; ///< null until load()
};

} // namespace hdmbench
