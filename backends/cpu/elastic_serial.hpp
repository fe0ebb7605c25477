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
    make(level, field, [&](int x, int y, int z) { return answers_->relax(level, field, x, y, z); });
  }
  void relax_from_zero(int level) override {
    make(level, ElasticField::correction,
         [&](int x, int y, int z) { return answers_->relax_from_zero(level, x, y, z); });
  }
  void forces(ElasticField of, ElasticField to) override {
    make(0, to, [&](int x, int y, int z) { return answers_->forces(of, x, y, z); });
  }
  void restrict_residual(int level, ElasticField of) override {
    restrict_sites(level, [&](int x, int y, int z) { return answers_->free_residual(level, of, x, y, z); });
  }
  void restrict_load(int level) override {
    restrict_sites(level, [&](int x, int y, int z) { return answers_->free_load(level, x, y, z); });
  }
  void interpolate(int level) override {
    make(level, ElasticField::correction,
         [&](int x, int y, int z) { return answers_->interpolate(level, x, y, z); });
  }
  void correct(int level, ElasticField field) override {
    make(level, field, [&](int x, int y, int z) { return answers_->correct(level, field, x, y, z); });
  }
  void solve_coarsest() override {
    make(coarsest(), ElasticField::correction,
         [&](int x, int y, int z) { return answers_->solve_coarsest(x, y, z); });
  }
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    make(0, to, [&](int x, int y, int z) { return answers_->advance(value, factor, direction, x, y, z); });
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    return stored(answers_->dot(first, second));
  }

private:
  /// answer(x, y, z) of all sites.
  template <typename At>
  [[nodiscard]] RingedField made(int level, const At& answer) const {
    RingedField field;
    field.require(grid(level));
    const Extent sites = grid(level).sites;
    for (int z = 0; z < sites.depth; ++z) {
      for (int y = 0; y < sites.height; ++y) {
        for (int x = 0; x < sites.width; ++x) {
          const Answer site = answer(x, y, z);
          for (std::size_t axis = 0; axis < sites.axes(); ++axis) {
            field[axis][grid(level).index(x, y, z)] = stored(site[axis]);
          }
        }
      }
    }
    return field;
  }

  /// The field from answer(x, y, z); the old one may be read meanwhile.
  template <typename At>
  void make(int level, ElasticField field, const At& answer) {
    fields_.at(level, field) = made(level, answer);
  }

  /// load of level + 1 from fine(x, y, z), which is stored on the way.
  template <typename Fine>
  void restrict_sites(int level, const Fine& fine) {
    const RingedField from = made(level, fine);
    make(level + 1, ElasticField::load, [&](int x, int y, int z) {
      return answers_->restricted(level, x, y, z, [&](int i, int j, int k) {
        Answer site{};
        for (std::size_t axis = 0; axis < grid(level).axes(); ++axis) {
          site[axis] = Scalar(from[axis][grid(level).index(i, j, k)]);
        }
        return site;
      });
    });
  }

  std::unique_ptr<Answers> answers_; ///< null until load()
};

} // namespace hdmbench
