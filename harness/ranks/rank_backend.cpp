#include "harness/ranks/rank_backend.hpp"

#include "backends/shared/piece_sweeps.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/ranks/rank_elastic.hpp"
#include "harness/ranks/redistribution.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

namespace hdmbench {

namespace {

/// A session that all ranks have together: each sweeps over its piece, halos come from the others.
class RankSession final : public Session {
public:
  RankSession(Ranks& ranks, const Sharing& sharing, const faults::RankFault& fault,
              std::unique_ptr<Session> own)
      : ranks_(ranks), rank_(static_cast<std::size_t>(ranks.rank())), sharing_(sharing), fault_(fault),
        halos_(ranks, fault, rank_), session_(std::move(own)) {}

private:
  void do_load(const Level& level) override {
    extent_ = level.extent;
    share_ = sharing_.level(level.extent, level.rule == Rule::annealing);
    std::vector<PieceSweeps::Own> own;
    if (rank_ < share_.cut.pieces.size()) {
      Level piece = part_of(level, share_.loaded[rank_]);
      piece.seed = seed_from_row(level.seed, share_.loaded[rank_].top);
      if (fault_.in_level) {
        fault_.in_level(piece, rank_);
      }
      ended_by_error_of_one([&] { session_->load(piece); });
      own.push_back({rank_, session_.get()});
    }
    sweeps_.emplace(share_.cut, std::move(own), halos_);
  }

  void do_write(const VectorField& displacement) override {
    ended_by_error_of_one([&] {
      for (const PieceSweeps::Own& own : sweeps_.value().own()) {
        own.session->write(part_of(displacement, share_.loaded[rank_]));
      }
    });
    sweeps_->written();
  }

  /// The sessions number their sweeps as this one does.
  void do_step(int /*first*/, int sweeps) override {
    ended_by_error_of_one([&] {
      sweeps_.value().sweep(sweeps - 1);
      sweeps_->sweep_and_count();
    });
  }

  void do_read(VectorField& displacement) override {
    const Rectangle& owned = share_.owned[rank_];
    VectorField values(owned.extent());
    ended_by_error_of_one([&] {
      for (const PieceSweeps::Own& own : sweeps_.value().own()) {
        const FieldPart part{local(sweeps_->piece(own), owned), values.x, values.y};
        own.session->read_parts(std::span(&part, 1));
      }
    });
    displacement = redistribute(ranks_, rank_, share_.owned, all_on_each(extent_, ranks_.size()), values);
  }

  std::int64_t do_changed() override { return halos_.sum(sweeps_.value().changed()); }

  Ranks& ranks_;
  std::size_t rank_;
  Sharing sharing_;
  faults::RankFault fault_;
  faults::FaultyExchange halos_;
  std::unique_ptr<Session> session_;
  Extent extent_{};
  LevelShare share_;
  std::optional<PieceSweeps> sweeps_; ///< of the level that was loaded
};

} // namespace

RankBackend::RankBackend(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry,
                         std::string names, SessionOptions asked, Sharing sharing, faults::RankFault fault)
    : ranks_(ranks), first_(backend_of_rank(registry, names, 0)),
      own_(backend_of_rank(registry, names, ranks.rank())), backends_(std::move(names)),
      asked_(std::move(asked)), sharing_(sharing), fault_(std::move(fault)),
      name_(fmt::format("{} on {} ranks", backends_, sharing.pieces)) {
  sharing_.ranks = ranks.size();
  try {
    asked_ = options_of_rank(asked_, own_, ranks);
    device_ = own_.device(asked_);
  } catch (const DeviceError& error) {
    absence_ = error.what();
  }
  if (ranks.largest(absence_.empty() ? 0.0 : 1.0) > 0.0 && absence_.empty()) {
    absence_ = "another rank has no such device";
  }
  has_elastic_ = ranks.largest(own_.has_elastic() ? 0.0 : 1.0) == 0.0;
}

std::vector<Device> RankBackend::devices() const {
  if (!absence_.empty()) {
    throw DeviceError(absence_);
  }
  return {device_};
}

std::unique_ptr<Session> RankBackend::do_open(std::size_t /*index*/, const SessionOptions& options) const {
  SessionOptions own = asked_;
  own.work = options.work;
  std::unique_ptr<Session> session = ended_by_error_of_one([&] { return own_.open(own); });
  if (fault_.in_active_session && options.work == Work::active) {
    session = fault_.in_active_session(std::move(session));
  }
  return std::make_unique<RankSession>(ranks_, sharing_, fault_, std::move(session));
}

std::unique_ptr<ElasticSession> RankBackend::do_open_elastic(std::size_t /*index*/,
                                                             const SessionOptions& /*options*/) const {
  return open_elastic_on_ranks(ranks_, sharing_, fault_, [this] { return own_.open_elastic(asked_); });
}

} // namespace hdmbench
