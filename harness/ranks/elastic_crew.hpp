#pragma once

#include "harness/ranks/crew_member.hpp"
#include "harness/ranks/ranked_elastic.hpp"

#include <memory>
#include <string>

namespace hdmbench {

/// A call of ElasticSteps; what a call does not take is not looked at.
struct ElasticOrder {
  enum class Call {
    write,
    read,
    relax,
    relax_from_zero,
    forces,
    restrict_residual,
    restrict_load,
    interpolate,
    correct,
    solve_coarsest,
    advance,
    dot
  };
  Call call = Call::relax;
  int level = 0;
  /// In the order in which the call has its fields.
  ElasticField first = ElasticField::displacement;
  ElasticField second = ElasticField::displacement;
  ElasticField third = ElasticField::displacement;
  float factor = 0.0F;
};

/// An elastic session that all ranks have together, as one of them has it. As CrewMember.
class ElasticCrewMember {
public:
  ElasticCrewMember(Ranks& ranks, const Sharing& sharing, const std::string& fault, RankedElastic::Open open);

  void load(RankMessage& message, const CrewGiven& given);
  /// The value of a dot product, else 0.
  [[nodiscard]] float call(const ElasticOrder& order, const CrewGiven& given);

private:
  /// What each rank owns of a level.
  [[nodiscard]] std::vector<Rectangle> owned(int level) const;

  Ranks& ranks_;
  Sharing sharing_;
  faults::RankFault fault_;
  std::unique_ptr<Exchange> halos_;
  RankedElastic::Open open_;
  std::unique_ptr<RankedElastic> steps_; ///< null before load()
};

} // namespace hdmbench
