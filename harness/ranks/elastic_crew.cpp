#include "harness/ranks/elastic_crew.hpp"

#include "harness/ranks/hand_out.hpp"

#include <utility>

namespace hdmbench {

ElasticCrewMember::ElasticCrewMember(Ranks& ranks, const Sharing& sharing, const std::string& fault,
                                     RankedElastic::Open open)
    : ranks_(ranks), sharing_(sharing), fault_(faults::find_rank_fault(fault)),
      halos_(std::make_unique<faults::FaultyExchange>(ranks, fault_, static_cast<std::size_t>(ranks.rank()))),
      open_(std::move(open)) {}

void ElasticCrewMember::load(RankMessage& message, const CrewGiven& given) {
  const auto extent = message.get<Extent>();
  const auto poisson = message.get<double>();
  const auto springs = message.get<Springs>();
  if (steps_ == nullptr || steps_->share().levels.front() != extent) {
    steps_ = std::make_unique<RankedElastic>(share_elastic(extent, sharing_), ranks_, *halos_, open_);
  }
  Level part;
  hand_out(ranks_, extent, steps_->share().image().loaded, given.level, false, 0, part);
  if (fault_.in_level) {
    fault_.in_level(part, static_cast<std::size_t>(ranks_.rank()));
  }
  steps_->load(part, poisson, springs);
}

std::vector<Rectangle> ElasticCrewMember::owned(int level) const {
  const ElasticShare& share = steps_->share();
  return share.is_cut(level) ? share.share(level).owned
                             : all_on_first(share.levels.at(static_cast<std::size_t>(level)), ranks_.size());
}

float ElasticCrewMember::call(const ElasticOrder& order, const CrewGiven& given) {
  RankedElastic& steps = *steps_;
  const auto extent = [&] { return steps.share().levels.at(static_cast<std::size_t>(order.level)); };
  using Call = ElasticOrder::Call;
  switch (order.call) {
  case Call::write:
    steps.write(order.level, order.first, hand_out(ranks_, extent(), owned(order.level), given.field));
    break;
  case Call::read: {
    VectorField own;
    steps.read(order.level, order.first, own);
    collect(ranks_, extent(), owned(order.level), own, given.result);
    break;
  }
  case Call::relax:
    steps.relax(order.level, order.first);
    break;
  case Call::relax_from_zero:
    steps.relax_from_zero(order.level);
    break;
  case Call::forces:
    steps.forces(order.first, order.second);
    break;
  case Call::restrict_residual:
    steps.restrict_residual(order.level, order.first);
    break;
  case Call::restrict_load:
    steps.restrict_load(order.level);
    break;
  case Call::interpolate:
    steps.interpolate(order.level);
    break;
  case Call::correct:
    steps.correct(order.level, order.first);
    break;
  case Call::solve_coarsest:
    steps.solve_coarsest();
    break;
  case Call::advance:
    steps.advance(order.first, order.second, order.factor, order.third);
    break;
  case Call::dot:
    return steps.dot(order.first, order.second);
  }
  return 0.0F;
}

} // namespace hdmbench
