#pragma once

#include "backends/backend.hpp"
#include "backends/pieces/sharing.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/ranks/message_passing.hpp"
#include "harness/ranks/rank_faults.hpp"
#include "harness/scene/scene.hpp"

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Several ranks as one backend: what solves or verifies on a backend does so on them, unchanged. Every rank
/// makes the same calls, has the same levels and fields on its host, and sees the same results; its own
/// session has its piece of each level only. An error of one rank's device is an InputError, which ends all.
class RankBackend final : public Backend {
public:
  /// Collective. `names`: "openmp", or each rank's in turn (backend_of_rank). `asked`: device and threads,
  /// from which each rank takes its own (options_of_rank); devices() has that one only, so options for open()
  /// must name none. Ranks and registry must outlive it.
  RankBackend(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry, std::string names,
              SessionOptions asked, Sharing sharing, faults::RankFault fault = {});

  /// "openmp on 4 ranks".
  std::string_view name() const override { return name_; }
  std::string_view description() const override { return "a backend on several ranks"; }
  bool supports(Update update) const override {
    return update != Update::sequential && first_.supports(update);
  }
  /// That of this rank. Throws DeviceError on all ranks where one of them has none.
  std::vector<Device> devices() const override;
  int threads(const SessionOptions& /*options*/) const override { return own_.threads(asked_); }
  bool has_elastic() const override { return has_elastic_; }

  /// "openmp", without the ranks.
  [[nodiscard]] const std::string& backends() const { return backends_; }
  [[nodiscard]] int ranks() const { return sharing_.pieces; }
  /// Whether no rounding excuses a difference: what processors compute has the bits of scalar.
  [[nodiscard]] bool has_bits_of_scalar() const { return first_.threads({}) > 0; }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override;
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& options) const override;

  Ranks& ranks_;
  const Backend& first_; ///< the first rank's
  const Backend& own_;
  std::string backends_;
  SessionOptions asked_;
  Sharing sharing_;
  faults::RankFault fault_;
  std::string name_;
  Device device_;
  std::string absence_; ///< why a rank has no device; empty: each has
  bool has_elastic_ = false;
};

/// Which device a rank opens: "by-rank" is the one that has the rank's number among the ranks of its machine,
/// from the first one on again where there are fewer. Threads that nobody asked for: the machine's, shared
/// out. Throws DeviceError.
[[nodiscard]] SessionOptions options_of_rank(SessionOptions asked, const Backend& backend,
                                             const Ranks& ranks);

/// "openmp", or "openmp+vulkan-compute": the backend of each rank in turn, from the first one on again.
/// Throws InputError where one is unknown.
[[nodiscard]] const Backend& backend_of_rank(const std::vector<std::unique_ptr<Backend>>& registry,
                                             std::string_view names, int rank);

/// One level, for `ranks` >= 2 of them: every piece but the first sleeps, until a renewal brings a change
/// that it has to wake for. One site is pulled, just outside the halos of the other pieces, and what it pulls
/// along crosses into the halo before the first renewal and into a piece's own sites soon after. So a check
/// with Work::active sees tiles that sleep through a renewal. 124 x 120 sites: renewals are as frequent as
/// they can be, and on up to 4 ranks all backends but the fragment path, which visits small levels whole,
/// leave tiles out.
[[nodiscard]] Scene sleeping_pieces(int ranks);

} // namespace hdmbench
