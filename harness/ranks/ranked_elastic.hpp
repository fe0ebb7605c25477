#pragma once

#include "backends/shared/elastic_session.hpp"
#include "harness/ranks/elastic_share.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace hdmbench {

/// Sessions of the elastic energy on all ranks as one. Levels that are cut are computed by every rank with a
/// piece, with its halo: each step makes the rim of what it writes wrong, and a halo is renewed when what is
/// left of it is too narrow for the next step. Coarse levels are computed by the first rank. Fields are those
/// of the sites that a rank owns (owned()). The bits of one session. All calls are collective. Throws what
/// sessions and Ranks throw.
class RankedElastic final : public ElasticSteps {
public:
  using Open = std::function<std::unique_ptr<ElasticSession>()>;

  /// `halos`: what brings halos, sums and coarse levels, usually the ranks themselves. `open` is called as
  /// often as this rank needs a session: once for its piece, once on the first rank. All must outlive this.
  RankedElastic(ElasticShare share, Ranks& ranks, Exchange& halos, const Open& open);

  /// `part`: the sites that this rank loads of the image.
  void load(const Level& part, double poisson, Springs springs);

  /// What this rank owns of a level.
  [[nodiscard]] Rectangle owned(int level) const;
  [[nodiscard]] const ElasticShare& share() const { return share_; }

  void write(int level, ElasticField field, const VectorField& values) override;
  void read(int level, ElasticField field, VectorField& values) const override;
  void relax(int level, ElasticField field) override;
  void relax_from_zero(int level) override;
  void forces(ElasticField of, ElasticField to) override;
  void restrict_residual(int level, ElasticField of) override;
  void restrict_load(int level) override;
  void interpolate(int level) override;
  void correct(int level, ElasticField field) override;
  void solve_coarsest() override;
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override;
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override;

  /// What was sent for a level, by this rank: to renew halos of one that is cut, or to bring loads to the
  /// first rank and corrections from it.
  struct Sent {
    std::int64_t times = 0;
    Traffic traffic{};
  };
  /// Of each cut level and the one below.
  [[nodiscard]] const std::vector<Sent>& sent() const { return sent_; }
  /// The same for dot products.
  [[nodiscard]] const Sent& sent_for_sums() const { return sums_; }

private:
  /// How far beyond what a rank owns a field of a level is right, in sites.
  [[nodiscard]] int& valid(int level, ElasticField field);
  [[nodiscard]] int halo(int level) const { return share_.share(level).cut.halo; }
  /// Renews the halo unless it is right that far.
  void want(int level, ElasticField field, int sites);
  /// As the session that computes the level here has them.
  [[nodiscard]] Rectangle local(int level, Rectangle part) const;
  /// Null where no session does.
  [[nodiscard]] ElasticSession* computing(int level) const {
    return share_.is_cut(level) ? piece_.get() : coarse_.get();
  }
  /// What was restricted to the next level was right `sites` sites beyond what is owned.
  void restricted(int level, int sites);
  /// How far corrections of the next level hold on this one.
  [[nodiscard]] int bring_correction(int level);
  void send_load();
  /// What the first rank has, on all.
  [[nodiscard]] float value_of_first(float value) const;

  ElasticShare share_;
  Ranks& ranks_;
  Exchange& halos_;
  std::size_t rank_;
  std::unique_ptr<ElasticSession> piece_;  ///< null where this rank has none
  std::unique_ptr<ElasticSession> coarse_; ///< on the first rank
  ElasticHierarchy piece_sheet_;
  ElasticHierarchy coarse_sheet_;
  std::vector<std::array<int, elastic_fields>> valid_; ///< of cut levels
  std::vector<std::vector<Transfer>> ways_;            ///< of halos
  std::vector<Sent> sent_;
  mutable Sent sums_;
};

} // namespace hdmbench
