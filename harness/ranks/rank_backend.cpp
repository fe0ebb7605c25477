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

/// The same of the elastic energy.
class RankElasticSession final : public ElasticSession {
  using Call = ElasticOrder::Call;

public:
  RankElasticSession(Crew& crew, int session) : crew_(crew), session_(session) {}
  ~RankElasticSession() override { crew_.close(session_); }

  void load(const ElasticHierarchy& hierarchy) override { crew_.load(session_, hierarchy); }
  void write(int level, ElasticField field, const VectorField& values) override {
    crew_.call(session_, {.call = Call::write, .level = level, .first = field}, &values);
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    crew_.call(session_, {.call = Call::read, .level = level, .first = field}, nullptr, &values);
  }
  void relax(int level, ElasticField field) override { call(Call::relax, level, field); }
  void relax_from_zero(int level) override { call(Call::relax_from_zero, level); }
  void forces(ElasticField of, ElasticField to) override {
    crew_.call(session_, {.call = Call::forces, .first = of, .second = to});
  }
  void restrict_residual(int level, ElasticField of) override { call(Call::restrict_residual, level, of); }
  void restrict_load(int level) override { call(Call::restrict_load, level); }
  void interpolate(int level) override { call(Call::interpolate, level); }
  void correct(int level, ElasticField field) override { call(Call::correct, level, field); }
  void solve_coarsest() override { call(Call::solve_coarsest, 0); }
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    crew_.call(session_,
               {.call = Call::advance, .first = to, .second = value, .third = direction, .factor = factor});
  }
  float dot(ElasticField first, ElasticField second) const override {
    return crew_.call(session_, {.call = Call::dot, .first = first, .second = second});
  }

private:
  void call(Call call, int level, ElasticField field = ElasticField::correction) {
    crew_.call(session_, {.call = call, .level = level, .first = field});
  }

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
  return std::make_unique<RankSession>(
      crew_, crew_.open(EnergyModel::hdm, backends_, options.work, sharing_, fault_));
}

VectorField RankBackend::solve(const Scene& scene) const {
  return crew_.solve(scene, backends_, sharing_, fault_);
}

std::unique_ptr<ElasticSession> RankBackend::do_open_elastic(std::size_t /*index*/,
                                                             const SessionOptions& options) const {
  const int session = crew_.open(EnergyModel::elastic, backends_, options.work, sharing_, fault_);
  return std::make_unique<RankElasticSession>(crew_, session);
}

} // namespace hdmbench
