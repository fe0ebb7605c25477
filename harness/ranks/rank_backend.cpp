#include "harness/ranks/rank_backend.hpp"

#include <fmt/format.h>

#include <utility>

namespace hdmbench {

namespace {

/// Hands every call to the crew.
class RankSession final : public Session {
public:
  RankSession(Crew& crew, int session) : crew_(crew), session_(session) {}
  ~RankSession() override { crew_.close(session_); }

private:
  void do_load(const Level& level) override { crew_.load(session_, level); }
  void do_write(const VectorField& displacement) override { crew_.write(session_, displacement); }
  void do_step(int /*first*/, int sweeps) override { crew_.step(session_, sweeps); }
  void do_read(VectorField& displacement) override { crew_.read(session_, displacement); }
  std::int64_t do_changed() override { return crew_.changed(session_); }
  void do_load_pyramid(const Pyramid& pyramid) override { crew_.load(session_, pyramid); }
  void do_solve(const Advance& advance) override { crew_.solve(session_, advance); }

  Crew& crew_;
  int session_;
};

} // namespace

RankBackend::RankBackend(Crew& crew, const Backend& first, std::string backends, Sharing sharing,
                         std::string fault)
    : crew_(crew), first_(first), backends_(std::move(backends)), sharing_(sharing), fault_(std::move(fault)),
      name_(fmt::format("{} on {} ranks", backends_, sharing_.pieces)) {
  sharing_.ranks = crew.ranks();
}

std::unique_ptr<Session> RankBackend::do_open(std::size_t /*index*/, const SessionOptions& options) const {
  return std::make_unique<RankSession>(crew_, crew_.open(backends_, options.work, sharing_, fault_));
}

} // namespace hdmbench
