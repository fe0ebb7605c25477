#include "harness/ranks/crew_member.hpp"

#include "backends/shared/cut_rows.hpp"
#include "harness/ranks/hand_out.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// Of single levels.
Sharing sharing_of_rule(Rule rule, const Sharing& sharing) {
  Schedule schedule;
  schedule.rule = rule;
  return sharing_for(schedule, sharing);
}

} // namespace

CrewMember::CrewMember(Ranks& ranks, const Sharing& sharing, const std::string& fault,
                       std::unique_ptr<Session> session)
    : ranks_(ranks), sharing_(sharing), fault_(faults::find_rank_fault(fault)),
      halos_(std::make_unique<faults::FaultyExchange>(ranks, fault_, static_cast<std::size_t>(ranks.rank()))),
      session_(std::move(session)) {}

void CrewMember::step(int sweeps) {
  sweeps_.value().sweep(sweeps - 1);
  sweeps_->sweep_and_count();
}

std::int64_t CrewMember::changed() {
  return sweeps_ ? halos_->sum(sweeps_->changed()) : solution_.levels.back().changed;
}

void CrewMember::load(RankMessage& message, const CrewGiven& given) {
  Level part;
  extent_ = message.get<Extent>();
  part.penalty = message.get<float>();
  part.steps = StepSet(message.get<std::vector<float>>());
  part.update = message.get<Update>();
  part.rule = message.get<Rule>();
  part.strengths = message.get<std::vector<float>>();
  part.seed = message.get<int>();
  share_ = sharing_of_rule(part.rule, sharing_)(extent_);
  part.seed = seed_from_row(part.seed, share_.loaded[static_cast<std::size_t>(ranks_.rank())].top);
  hand_out(ranks_, extent_, share_.loaded, given.level, needs_inverse_curvature(part.rule),
           static_cast<std::size_t>(part.energy->inputs), part);
  const auto rank = static_cast<std::size_t>(ranks_.rank());
  std::vector<PieceSweeps::Own> own;
  if (rank < share_.cut.pieces.size()) {
    if (fault_.in_level) {
      fault_.in_level(part, rank);
    }
    session_->load(part);
    own.push_back({rank, session_.get()});
  }
  sweeps_.emplace(share_.cut, std::move(own), *halos_);
}

void CrewMember::write(const CrewGiven& given) {
  const VectorField part = hand_out(ranks_, extent_, share_.loaded, given.field);
  for (const PieceSweeps::Own& own : sweeps_.value().own()) {
    own.session->write(part);
  }
  sweeps_->written();
}

void CrewMember::read(const CrewGiven& given) {
  const auto rank = static_cast<std::size_t>(ranks_.rank());
  VectorField own = solution_.displacement;
  if (sweeps_) {
    own = VectorField(share_.owned[rank].extent());
    for (const PieceSweeps::Own& piece : sweeps_->own()) {
      VectorField loaded;
      piece.session->read(loaded);
      copy(share_.owned[rank], loaded, share_.loaded[rank], own, share_.owned[rank]);
    }
  }
  collect(ranks_, extent_, share_.owned, own, given.result);
}

void CrewMember::load_pyramid(RankMessage& message, const CrewGiven& given) {
  RankedPyramid& pyramid = pyramid_;
  pyramid = {};
  pyramid.extent = extent_ = message.get<Extent>();
  pyramid.part.penalty = message.get<float>();
  pyramid.part.steps = StepSet(message.get<std::vector<float>>());
  pyramid.part.update = message.get<Update>();
  pyramid.part.rule = message.get<Rule>();
  pyramid.part.seed = message.get<int>();
  pyramid.alignment = message.get<Alignment>();
  pyramid.levels.resize(message.get<std::uint64_t>());
  for (PyramidLevel& level : pyramid.levels) {
    level.extent = message.get<Extent>();
    level.sweeps = message.get<int>();
    level.strengths = message.get<std::vector<float>>();
  }
  share_ = sharing_of_rule(pyramid.part.rule, sharing_)(extent_);
  hand_out(ranks_, extent_, share_.loaded, given.level, false,
           static_cast<std::size_t>(pyramid.part.energy->inputs), pyramid.part);
  if (fault_.in_level) {
    fault_.in_level(pyramid.part, static_cast<std::size_t>(ranks_.rank()));
  }
  sweeps_.reset();
}

void CrewMember::solve(const CrewGiven& given) {
  solution_ = solve_on_ranks(pyramid_, sharing_of_rule(pyramid_.part.rule, sharing_), ranks_, *halos_,
                             *session_, true, given.advance != nullptr ? *given.advance : Session::Advance{});
}

} // namespace hdmbench
