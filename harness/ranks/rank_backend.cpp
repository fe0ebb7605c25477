#include "harness/ranks/rank_backend.hpp"

#include "backends/pieces/elastic_pieces.hpp"
#include "backends/pieces/level_pieces.hpp"
#include "backends/registry.hpp"

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
  RankSession(std::unique_ptr<Exchange> exchange, const Sharing& sharing, LevelPieces::Open open)
      : sharing_(sharing), pieces_(std::move(exchange), std::move(open)) {
    pieces_.open(1);
  }

private:
  void do_load(const Level& level) override {
    pieces_.load(level, sharing_.level(level.extent, level.rule == Rule::annealing));
  }
  void do_write(const VectorField& displacement) override { pieces_.write(displacement); }
  void do_step(int /*first*/, int sweeps) override { pieces_.step(sweeps); }
  void do_read(VectorField& displacement) override { displacement = pieces_.read(); }
  std::int64_t do_changed() override { return pieces_.changed(); }

  Sharing sharing_;
  LevelPieces pieces_;
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

void Ranks::compute(const std::function<void()>& call) {
  ended_by_error_of_one(call);
}

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
  const auto open = [this, own] { return faults::spoilt(own_.open(own), fault_, ranks_.rank(), own.work); };
  return std::make_unique<RankSession>(std::make_unique<faults::FaultyExchange>(ranks_, fault_), sharing_,
                                       open);
}

std::unique_ptr<ElasticSession> RankBackend::do_open_elastic(std::size_t /*index*/,
                                                             const SessionOptions& /*options*/) const {
  const auto open = [this] { return faults::spoilt(own_.open_elastic(asked_), fault_, ranks_.rank()); };
  return std::make_unique<ElasticPieces>(std::make_unique<faults::FaultyExchange>(ranks_, fault_), sharing_,
                                         open);
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
