#pragma once

#include "backends/pieces/sharing.hpp"
#include "backends/pieces/uncut_level.hpp"
#include "backends/shared/elastic_session.hpp"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace hdmbench {

/// A session of the elastic energy in pieces, each with a session of its own, on one device or on ranks:
/// every process makes the same calls, with the same body and the same fields, and makes the levels of its
/// own part. Levels that are cut are computed by pieces, with their halos: each step makes the rim of what it
/// writes wrong, and a halo is renewed when what is left of it is too narrow for the next step. Coarse levels
/// are computed by one session of the first process. The bits of one session. Calls throw what sessions and
/// exchanges throw.
class ElasticPieces final : public ElasticSession {
public:
  using Open = std::function<std::unique_ptr<ElasticSession>()>;

  /// `open` makes another session: one for each piece of this process, one for coarse levels.
  ElasticPieces(std::unique_ptr<Exchange> exchange, const Sharing& sharing, Open open)
      : exchange_(std::move(exchange)), sharing_(sharing), open_(std::move(open)) {}

  void take(const MethodStep& step) override;
  void read(int level, ElasticField field, VectorField& values) const override;
  /// The tree of one session: its squares, or cubes, of 2^cut_levels sites a side lie within pieces, and the
  /// first process adds up the rest.
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override;
  [[nodiscard]] std::optional<double> device_seconds() override;

private:
  double do_load_body(const ElasticBody& body) override;
  /// Throws std::logic_error: levels that are made already are those of a whole body.
  void do_load(ElasticHierarchy& hierarchy) override;
  void do_end() override;

  /// Makes the levels of a piece, and takes from them what coarser ones are made of.
  [[nodiscard]] ElasticHierarchy piece_of(const ElasticBody& whole, std::size_t piece, OwnCells& cells) const;
  [[nodiscard]] ElasticHierarchy coarse_of(const ElasticBody& whole, ParentLevel uncut) const;
  void write_pieces(const MethodStep& step);

  /// How far beyond what a piece owns a field of a level is right, in sites.
  [[nodiscard]] int& valid(int level, ElasticField field) {
    return valid_.at(static_cast<std::size_t>(level)).at(static_cast<std::size_t>(field));
  }
  [[nodiscard]] int halo(int level) const { return share_.share(level).cut.halo; }
  [[nodiscard]] Extent sites(int level) const { return share_.levels.at(static_cast<std::size_t>(level)); }
  [[nodiscard]] PieceRange here() const { return own_pieces(*exchange_, share_.image().owned.size()); }
  [[nodiscard]] bool is_first() const { return exchange_->rank() == 0; }

  /// call(session, number of the piece), for pieces of this process.
  template <typename Call>
  void on_pieces(const Call& call) const;
  /// call(session) of coarse levels, where this process has it.
  template <typename Call>
  void on_coarse(const Call& call) const;

  /// Returns what the pieces here own of a cut level, or of the one below.
  [[nodiscard]] std::vector<VectorField> owned(int level, ElasticField field) const;
  /// Returns sites of a cut level, or of the one below, as the session of a piece numbers them.
  [[nodiscard]] Box in_piece(int level, std::size_t piece, Box part) const;
  /// Renews the halo unless it is right that far.
  void want(int level, ElasticField field, int sites);
  void send_load();
  /// Returns how far corrections of the next level hold on this one.
  [[nodiscard]] int bring_correction(int level);
  [[nodiscard]] float value_of_first(float value) const;

  std::unique_ptr<Exchange> exchange_;
  Sharing sharing_;
  Open open_;
  ElasticShare share_;
  std::vector<std::unique_ptr<ElasticSession>> pieces_; ///< of this process; null where one has no sites
  std::unique_ptr<ElasticSession> coarse_;              ///< of the first process
  std::vector<std::array<int, elastic_fields>> valid_;  ///< of cut levels
};

/// Returns the sites of its levels, the image first.
[[nodiscard]] std::vector<Extent> sites_of(const ElasticHierarchy& hierarchy);

} // namespace hdmbench
