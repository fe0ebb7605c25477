#pragma once

#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_faults.hpp"
#include "harness/ranks/rank_message.hpp"
#include "harness/ranks/ranked_solution.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace hdmbench {

/// What only the first rank has of an order; null on the others, and where the order has no such thing.
struct CrewGiven {
  const Level* level = nullptr;
  const VectorField* field = nullptr;
  VectorField* result = nullptr;
  const Session::Advance* advance = nullptr;
};

/// A session that all ranks have together, as one of them has it. All calls but the constructor are
/// collective; messages are those of Crew.
class CrewMember {
public:
  /// `fault`: as find_rank_fault() takes it.
  CrewMember(Ranks& ranks, const Sharing& sharing, const std::string& fault,
             std::unique_ptr<Session> session);

  void load(RankMessage& message, const CrewGiven& given);
  void load_pyramid(RankMessage& message, const CrewGiven& given);
  void write(const CrewGiven& given);
  void step(int sweeps);
  void read(const CrewGiven& given);
  [[nodiscard]] std::int64_t changed();
  void solve(const CrewGiven& given);

private:
  Ranks& ranks_;
  Sharing sharing_;
  faults::RankFault fault_;
  std::unique_ptr<Exchange> halos_;
  std::unique_ptr<Session> session_;
  // Of the last load: a level, or a pyramid.
  LevelShare share_;
  Extent extent_;
  std::optional<PieceSweeps> sweeps_;
  RankedPyramid pyramid_;
  RankedSolution solution_;
};

} // namespace hdmbench
