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
  void take(const MethodStep& step) override {
    if (!step.restricts()) {
      make(step, [&](int x, int y, int z) { return answers_->of(step, x, y, z); });
      return;
    }
    // What the coarser level gets is stored on the way.
    const RingedField fine =
        made(step.level, [&](int x, int y, int z) { return answers_->handed_down(step, x, y, z); });
    make(step, [&](int x, int y, int z) {
      return answers_->restricted(step.level, x, y, z, [&](int i, int j, int k) {
        Answer site{};
        for (std::size_t axis = 0; axis < grid(step.level).axes(); ++axis) {
          site[axis] = Scalar(fine[axis][grid(step.level).index(i, j, k)]);
        }
        return site;
      });
    });
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    return stored(answers_->dot(first, second));
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    ElasticInMemory::do_load(hierarchy);
    answers_ = std::make_unique<Answers>(hierarchy, fields_);
  }

  /// answer(x, y, z) of all sites.
  template <typename At>
  [[nodiscard]] RingedField made(int level, const At& answer) const {
    RingedField field;
    field.require(grid(level));
    for_each_site(grid(level).sites, [&](int x, int y, int z) {
      const Answer site = answer(x, y, z);
      for (std::size_t axis = 0; axis < grid(level).axes(); ++axis) {
        field[axis][grid(level).index(x, y, z)] = stored(site[axis]);
      }
    });
    return field;
  }

  /// The field that the step makes, from answer(x, y, z); the old one may be read meanwhile.
  template <typename At>
  void make(const MethodStep& step, const At& answer) {
    fields_.at(step.made_on(), step.to) = made(step.made_on(), answer);
  }

  std::unique_ptr<Answers> answers_; ///< null until load()
};

} // namespace hdmbench
