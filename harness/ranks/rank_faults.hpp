#pragma once

#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/faults/trial.hpp"
#include "harness/ranks/message_passing.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench {

namespace faults {

/// A mistake that ranks could make, planted between the sweeps of a piece and what brings its halos.
struct RankFault {
  std::string name;
  std::string what; ///< one line for people
  int ranks = 2;    ///< with fewer it cannot be planted
  /// Spoils what arrived for a halo; `ways` are all that lead from and to its piece, and others.
  std::function<void(std::vector<Message>&, std::span<const Transfer> ways)> in_halos{};
  /// Spoils this rank's count of changed sites.
  std::function<std::int64_t(std::int64_t, std::size_t rank)> in_count{};
  /// Spoils what the first rank got of a sum.
  std::function<void(std::vector<Message>&)> in_sums{};
  /// Spoils what the first rank got of the cells of other ranks.
  std::function<void(std::vector<Message>&)> in_cells{};
  /// Spoils the piece of a level that this rank loads, or of an elastic body.
  std::function<void(Level&, std::size_t rank)> in_level{};
  std::function<void(ElasticHierarchy&, std::size_t rank)> in_sheet{};
  /// A fault of this rank's own session with Work::active.
  std::optional<Fault> in_active_session{};
  std::string method = "icm";   ///< that it concerns
  std::size_t fewest_sites = 1; ///< Sharing::fewest_sites that it is tried with
  Part part = Part::sweep;
};

/// `sound` with the fault, or as it is where there is none.
class FaultyExchange final : public Exchange {
public:
  /// `sound` must outlive it.
  FaultyExchange(Exchange& sound, RankFault fault) : sound_(sound), fault_(std::move(fault)) {}
  int rank() const override { return sound_.rank(); }
  int size() const override { return sound_.size(); }
  std::vector<Message> exchange(std::span<const Transfer> ways, std::vector<Message> leaving, int arrays,
                                Purpose purpose) override;
  std::int64_t sum(std::int64_t own) override;
  void compute(const std::function<void()>& call) override { sound_.compute(call); }

private:
  Exchange& sound_;
  RankFault fault_;
};

/// Returns the session of a rank with the fault, or as it is where the fault is elsewhere.
[[nodiscard]] std::unique_ptr<Session> spoilt(std::unique_ptr<Session> sound, const RankFault& fault,
                                              int rank, Work work);
[[nodiscard]] std::unique_ptr<ElasticSession> spoilt(std::unique_ptr<ElasticSession> sound,
                                                     const RankFault& fault, int rank);

/// Controls without a mistake, and all faults that so many ranks can have, on `backends` (backend_of_rank).
/// Ranks and registry must outlive the list. What it makes is collective.
[[nodiscard]] std::vector<Planted> planted_on_ranks(Ranks& ranks,
                                                    const std::vector<std::unique_ptr<Backend>>& registry,
                                                    const std::string& backends);

} // namespace faults

} // namespace hdmbench
