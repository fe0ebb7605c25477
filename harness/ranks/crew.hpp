#pragma once

#include "harness/ranks/crew_member.hpp"
#include "harness/ranks/elastic_crew.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_message.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Sessions that all ranks have together, commanded by the first one: it has the levels and fields, hands out
/// to each rank its part, and collects them. So what knows nothing of ranks, as verify, can run them. Errors
/// of another rank end all. On the first rank errors are InputError, in the words of what failed: the others
/// then wait for it in vain.
class Crew {
public:
  /// All must outlive it. `session` as options_of_rank() (rank_devices.hpp) has them.
  Crew(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry, SessionOptions session);
  ~Crew(); ///< without a word to the others: dismiss() them
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// On all ranks but the first one: obeys until dismiss().
  void serve();

  // On the first rank, what a Session does. `fault`: a name of rank_faults(), or empty.
  int open(EnergyModel energy, std::string_view backends, Work work, const Sharing& sharing,
           std::string_view fault);
  void close(int session) noexcept;
  void load(int session, const Level& level);
  void write(int session, const VectorField& displacement);
  void step(int session, int sweeps);
  void read(int session, VectorField& displacement);
  [[nodiscard]] std::int64_t changed(int session);
  void load(int session, const Pyramid& pyramid);
  void solve(int session, const Session::Advance& advance);
  /// The scene's method as a whole.
  [[nodiscard]] VectorField solve(const Scene& scene, std::string_view backends, const Sharing& sharing,
                                  std::string_view fault);
  // What an ElasticSession does.
  void load(int session, const ElasticHierarchy& hierarchy);
  float call(int session, const ElasticOrder& order, const VectorField* field = nullptr,
             VectorField* result = nullptr);
  void dismiss();

  [[nodiscard]] int ranks() const { return ranks_.size(); }

private:
  enum class Order {
    open,
    close,
    load,
    write,
    step,
    read,
    changed,
    load_pyramid,
    solve,
    load_elastic,
    call_elastic,
    solve_scene,
    dismiss
  };

  /// On the first rank: to all, and done here, too.
  void command(RankMessage message, const CrewGiven& given);
  /// On every rank; false after the last order.
  bool obey(RankMessage& message, const CrewGiven& given);
  void open_here(int session, RankMessage& message);
  void solve_here(RankMessage& message, const CrewGiven& given);

  Ranks& ranks_;
  const std::vector<std::unique_ptr<Backend>>& registry_;
  SessionOptions session_;
  std::map<int, CrewMember> members_;
  std::map<int, ElasticCrewMember> elastic_members_;
  int next_ = 0;
  std::int64_t changed_ = 0; ///< answer to the last Order::changed
  float value_ = 0.0F;       ///< answer to the last Order::call_elastic
  bool is_broken_ = false;   ///< an order failed here: the others no longer listen
};

} // namespace hdmbench
