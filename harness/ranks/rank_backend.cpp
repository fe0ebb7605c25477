#include "harness/ranks/rank_backend.hpp"

#include "backends/registry.hpp"
#include "harness/check/compare.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
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
    if (has_piece()) {
      Level piece = part_of(level, share_.loaded[rank_]);
      piece.seed = seed_from_row(level.seed, share_.loaded[rank_].first[1]);
      if (fault_.in_level) {
        fault_.in_level(piece, rank_);
      }
      ended_by_error_of_one([&] { session_->load(piece); });
    }
  }

  void do_write(const VectorField& displacement) override {
    write_loaded(part_of(displacement, share_.loaded[rank_]));
  }

  /// The session numbers its sweeps as this one does. Its own count has the halo in it, so the field is
  /// compared with the one before.
  void do_step(int /*first*/, int sweeps) override {
    sweep(sweeps - 1);
    const VectorField before = owned();
    sweep(1);
    changed_ = compare(before, owned()).sites;
  }

  void do_read(VectorField& displacement) override {
    displacement = redistribute(ranks_, rank_, share_.owned, all_on_each(extent_, ranks_.size()), owned());
  }

  std::int64_t do_changed() override { return halos_.sum(changed_); }

  [[nodiscard]] bool has_piece() const { return rank_ < share_.cut.pieces.size(); }

  /// With halos that are right.
  void write_loaded(const VectorField& displacement) {
    if (has_piece()) {
      ended_by_error_of_one([&] { session_->write(displacement); });
    }
    sweeps_left_ = share_.cut.halo;
  }

  /// The displacement of this rank's own sites.
  VectorField owned() {
    VectorField values(share_.owned[rank_].extent());
    if (has_piece()) {
      VectorField field;
      ended_by_error_of_one([&] { session_->read(field); });
      copy(share_.owned[rank_], field, share_.loaded[rank_], values, share_.owned[rank_]);
    }
    return values;
  }

  /// Each piece goes on as long as its halo holds, then halos are renewed.
  void sweep(int sweeps) {
    while (sweeps > 0) {
      if (sweeps_left_ == 0 && share_.cut.pieces.size() > 1) {
        write_loaded(redistribute(halos_, rank_, share_.owned, share_.loaded, owned()));
      }
      const int now = share_.cut.pieces.size() > 1 ? std::min(sweeps, sweeps_left_) : sweeps;
      if (has_piece()) {
        ended_by_error_of_one([&] { session_->step(now); });
      }
      sweeps_left_ -= now;
      sweeps -= now;
    }
  }

  Ranks& ranks_;
  std::size_t rank_;
  Sharing sharing_;
  faults::RankFault fault_;
  faults::FaultyExchange halos_;
  std::unique_ptr<Session> session_;
  Extent extent_{};
  LevelShare share_;
  int sweeps_left_ = 0;      ///< for which the halos hold
  std::int64_t changed_ = 0; ///< of this rank's own sites, by the last sweep
};

/// Processors that this process may run on; 0 where the system does not tell.
int own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

} // namespace

int launched_together() {
  for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (const char* const size = std::getenv(name)) {
      return std::atoi(size);
    }
  }
  return 0;
}

void set_environment(char** argv) {
  bool is_new = false;
  const auto is_set = [](const char* name) { return std::getenv(name) != nullptr; };
  const auto set = [&](const char* name, const char* value) {
    is_new = is_new || !is_set(name);
    setenv(name, value, 0);
  };
  if (launched_together() > 1) {
    set("OPENBLAS_NUM_THREADS", "1");
  }
  if (!is_set("OMP_WAIT_POLICY")) {
    set("GOMP_SPINCOUNT", "1000");
  }
  set("GLIBC_TUNABLES", "glibc.malloc.hugetlb=1");
  if (is_new) {
    execv("/proc/self/exe", argv); // returns only where that cannot be started: then it goes on as it is
  }
}

#ifndef HDMBENCH_WITH_MPI
std::unique_ptr<Ranks> Ranks::of_this_process() {
  if (launched_together() > 1) {
    throw InputError("mpirun started several processes, but this build has no MPI, so that each would do the "
                     "whole work (-DHDMBENCH_MPI=ON, with libopenmpi-dev)");
  }
  return nullptr;
}
#endif

void require_same(Ranks& ranks, const std::string& own,
                  const std::function<std::string(std::size_t rank, std::string_view text,
                                                  std::string_view first)>& differ) {
  const std::vector<std::string> all = ranks.gather(own); // nothing but on the first rank
  const auto other = std::ranges::find_if(all, [&](const std::string& text) { return text != all.front(); });
  if (ranks.sum(other != all.end() ? 1 : 0) > 0) {
    throw InputError(other == all.end()
                         ? "the ranks were not started alike"
                         : differ(static_cast<std::size_t>(other - all.begin()), *other, all.front()));
  }
}

void let_first_check(Ranks* ranks, const std::function<void()>& check) {
  if (ranks == nullptr) {
    return check();
  }
  std::string why;
  try {
    if (ranks->is_first()) {
      check();
    }
  } catch (const InputError& error) {
    why = error.what();
  }
  if (ranks->sum(why.empty() ? 0 : 1) > 0) {
    throw InputError(why.empty() ? "the first rank cannot write its files" : why);
  }
}

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
    session = faults::spoilt(std::move(session), *fault_.in_active_session);
  }
  return std::make_unique<RankSession>(ranks_, sharing_, fault_, std::move(session));
}

std::unique_ptr<ElasticSession> RankBackend::do_open_elastic(std::size_t /*index*/,
                                                             const SessionOptions& /*options*/) const {
  return open_elastic_on_ranks(ranks_, sharing_, fault_, [this] { return own_.open_elastic(asked_); });
}

SessionOptions options_of_rank(SessionOptions asked, const Backend& backend, const Ranks& ranks) {
  if (asked.device == "by-rank") {
    const std::size_t devices = backend.devices().size();
    asked.device = std::to_string(static_cast<std::size_t>(ranks.rank_on_machine()) % devices);
  }
  if (asked.threads == 0) {
    const int online = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
    const int own = own_processors();
    const int share = online / ranks.size_on_machine();
    asked.threads = std::max(1, own > 0 ? std::min(own, share) : share);
  }
  return asked;
}

const Backend& backend_of_rank(const std::vector<std::unique_ptr<Backend>>& registry, std::string_view names,
                               int rank) {
  std::vector<const Backend*> found;
  for (std::size_t first = 0; first <= names.size();) {
    const std::size_t end = std::min(names.find('+', first), names.size());
    found.push_back(&find_backend(registry, names.substr(first, end - first)));
    first = end + 1;
  }
  return *found[static_cast<std::size_t>(rank) % found.size()];
}

Scene sleeping_pieces(int ranks) {
  constexpr Extent extent{124, 120};
  constexpr float pull = 1000.0F; // pixels: further than the iterations get
  Scene scene = load_scene("square", {.size = extent});
  scene.name = "sleeping-pieces";
  scene.source.clear();
  Level& level = scene.full;
  level.target = level.confidence = VectorField(extent);
  level.modulus = ScalarField(extent, 1.0F);
  set_inverse_modulus(level);
  // A neighbour of what has moved is best moved by a quarter as far: a front that goes on by a site a sweep.
  level.steps = StepSet::parse("0,-16,16,-4,4,-1,1,-0.25,0.25,-0.0625,0.0625,-0.015625,0.015625");
  scene.schedule.start_level = 0;
  scene.schedule.iterations = 12; // three renewals

  const Cut cut = Sharing{.ranks = ranks, .pieces = ranks, .fewest_sites = 1}.level(extent, false).cut;
  const Box& first = cut.pieces.front().owned;
  const std::size_t site = extent.index(first.end[0] - cut.halo - 1, first.end[1] - cut.halo - 1);
  level.target[0][site] = level.target[1][site] = pull;
  level.confidence[0][site] = level.confidence[1][site] = 1.0F;
  return scene;
}

} // namespace hdmbench
