#include "harness/ranks/crew.hpp"

#include "backends/registry.hpp"
#include "harness/ranks/redistribution.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

namespace hdmbench {

namespace {

/// Processors that this process may run on; 0 where the system does not tell.
int own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

} // namespace

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

/// An order with what belongs to it, as bytes.
class Crew::Message {
public:
  Message() = default;
  Message(Order order, int session) {
    put(order);
    put(session);
  }

  template <typename Value>
  void put(const Value& value) {
    if constexpr (requires { value.data(); }) { // a text or a list
      put(std::uint64_t{value.size()});
      append(value.data(), value.size() * sizeof(*value.data()));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      append(&value, sizeof value);
    }
  }

  template <typename Value>
  [[nodiscard]] Value get() {
    Value value;
    if constexpr (requires { value.data(); }) {
      value.resize(get<std::uint64_t>());
      take(value.data(), value.size() * sizeof(*value.data()));
    } else {
      static_assert(std::is_trivially_copyable_v<Value>);
      take(&value, sizeof value);
    }
    return value;
  }

  std::vector<std::byte> bytes;

private:
  void append(const void* from, std::size_t size) {
    const std::size_t end = bytes.size();
    bytes.resize(end + size);
    std::memcpy(bytes.data() + end, from, size);
  }
  void take(void* to, std::size_t size) {
    if (size > 0) {
      std::memcpy(to, bytes.data() + read_, size);
    }
    read_ += size;
  }

  std::size_t read_ = 0;
};

struct Crew::Member {
  Sharing sharing;
  std::unique_ptr<Session> session;
  faults::RankFault fault;
  std::unique_ptr<Exchange> halos;
  // Of the last load: a level, or a pyramid.
  LevelShare share;
  Extent extent;
  std::optional<PieceSweeps> sweeps;
  RankedPyramid pyramid;
  RankedSolution solution;
};

namespace {

/// All on the first rank.
std::vector<Rectangle> on_first(Extent extent, int ranks) {
  std::vector<Rectangle> held(static_cast<std::size_t>(ranks));
  held.front() = all_of(extent);
  return held;
}

} // namespace

Crew::Crew(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry, SessionOptions session)
    : ranks_(ranks), registry_(registry), session_(std::move(session)) {}

Crew::~Crew() = default;

void Crew::serve() {
  Message message;
  do {
    message = {};
    ranks_.broadcast(message.bytes);
  } while (obey(message, {}));
}

void Crew::command(Message message, const Given& given) {
  if (is_broken_) {
    throw InputError("the ranks do not work together any more");
  }
  try {
    ranks_.broadcast(message.bytes);
    (void)obey(message, given);
  } catch (const DeviceError& error) {
    is_broken_ = true;
    throw InputError(error.what());
  } catch (...) {
    is_broken_ = true;
    throw;
  }
}

int Crew::open(std::string_view backends, Work work, const Sharing& sharing, std::string_view fault) {
  const int session = next_++;
  Message message(Order::open, session);
  message.put(backends);
  message.put(work);
  message.put(sharing);
  message.put(fault);
  command(std::move(message), {});
  return session;
}

void Crew::close(int session) noexcept {
  if (is_broken_) {
    return;
  }
  try {
    command({Order::close, session}, {});
  } catch (const std::exception&) {
    is_broken_ = true; // the next order says so
  }
}

void Crew::load(int session, const Level& level) {
  if (level.rule == Rule::annealing || level.energy != &thesis_energy) {
    throw InputError(level.rule == Rule::annealing
                         ? "annealing runs on one rank: it draws its random numbers by column and row"
                         : "an energy that is not the thesis's runs on one rank");
  }
  Message message(Order::load, session);
  message.put(level.extent);
  message.put(level.penalty);
  message.put(std::vector<float>(level.steps.values().begin(), level.steps.values().end()));
  message.put(level.update);
  message.put(level.rule);
  message.put(level.strengths);
  message.put(level.seed);
  command(std::move(message), {.level = &level});
}

void Crew::write(int session, const VectorField& displacement) {
  command({Order::write, session}, {.field = &displacement});
}

void Crew::step(int session, int sweeps) {
  Message message(Order::step, session);
  message.put(sweeps);
  command(std::move(message), {});
}

void Crew::read(int session, VectorField& displacement) {
  command({Order::read, session}, {.result = &displacement});
}

std::int64_t Crew::changed(int session) {
  command({Order::changed, session}, {});
  return changed_;
}

void Crew::load(int session, const Pyramid& pyramid) {
  const Level& full = *pyramid.full;
  if (full.rule != Rule::steps || full.energy != &thesis_energy) {
    throw InputError("a pyramid on several ranks is computed by candidates only");
  }
  Message message(Order::load_pyramid, session);
  message.put(full.extent);
  message.put(full.penalty);
  message.put(std::vector<float>(full.steps.values().begin(), full.steps.values().end()));
  message.put(full.update);
  message.put(pyramid.alignment);
  message.put(std::uint64_t{pyramid.levels.size()});
  for (const PyramidLevel& level : pyramid.levels) {
    message.put(level.extent);
    message.put(level.sweeps);
  }
  command(std::move(message), {.level = &full});
}

void Crew::solve(int session, const Session::Advance& advance) {
  command({Order::solve, session}, {.advance = &advance});
}

void Crew::dismiss() {
  command({Order::dismiss, 0}, {});
}

bool Crew::obey(Message& message, const Given& given) {
  const auto order = message.get<Order>();
  const auto session = message.get<int>();
  if (order == Order::dismiss) {
    return false;
  }
  if (order == Order::open) {
    open_here(session, message);
    return true;
  }
  Member& member = *members_.at(session);
  switch (order) {
  case Order::close:
    members_.erase(session);
    break;
  case Order::load:
    load_here(member, message, given);
    break;
  case Order::write:
    write_here(member, given);
    break;
  case Order::step:
    member.sweeps.value().sweep(message.get<int>() - 1);
    member.sweeps->sweep_and_count();
    break;
  case Order::read:
    read_here(member, given);
    break;
  case Order::changed:
    changed_ =
        member.sweeps ? member.halos->sum(member.sweeps->changed()) : member.solution.levels.back().changed;
    break;
  case Order::load_pyramid:
    load_pyramid_here(member, message, given);
    break;
  case Order::solve:
    solve_here(member, given);
    break;
  default:
    break;
  }
  return true;
}

void Crew::open_here(int session, Message& message) {
  const auto names = message.get<std::string>();
  const auto work = message.get<Work>();
  auto member = std::make_unique<Member>();
  member->sharing = message.get<Sharing>();
  member->fault = faults::find_rank_fault(message.get<std::string>());
  member->halos = std::make_unique<faults::FaultyExchange>(ranks_, member->fault,
                                                           static_cast<std::size_t>(ranks_.rank()));
  const Backend& backend = backend_of_rank(registry_, names, ranks_.rank());
  SessionOptions options = options_of_rank(session_, backend, ranks_);
  options.work = work;
  member->session = backend.open(options);
  members_.emplace(session, std::move(member));
}

std::vector<float> Crew::hand_out(Extent extent, std::span<const Rectangle> wanted,
                                  const std::vector<float>* whole) {
  return redistribute(ranks_, static_cast<std::size_t>(ranks_.rank()), on_first(extent, ranks_.size()),
                      wanted, whole != nullptr ? std::span<const float>(*whole) : std::span<const float>());
}

void Crew::hand_out_fields(Extent extent, std::span<const Rectangle> wanted, const Level* whole,
                           bool curvature, std::size_t inputs, Level& part) {
  part.extent = wanted[static_cast<std::size_t>(ranks_.rank())].extent();
  const auto scalar = [&](const ScalarField* from, ScalarField& to) {
    to.extent = part.extent;
    to.values = hand_out(extent, wanted, from != nullptr ? &from->values : nullptr);
  };
  const auto vector = [&](const VectorField* from, VectorField& to) {
    to.extent = part.extent;
    to.x = hand_out(extent, wanted, from != nullptr ? &from->x : nullptr);
    to.y = hand_out(extent, wanted, from != nullptr ? &from->y : nullptr);
  };
  vector(whole != nullptr ? &whole->target : nullptr, part.target);
  vector(whole != nullptr ? &whole->confidence : nullptr, part.confidence);
  scalar(whole != nullptr ? &whole->modulus : nullptr, part.modulus);
  scalar(whole != nullptr ? &whole->inverse_modulus : nullptr, part.inverse_modulus);
  for (std::size_t i = 0; i < inputs; ++i) {
    scalar(whole != nullptr ? &whole->inputs[i] : nullptr, part.inputs.emplace_back());
  }
  if (curvature) {
    vector(whole != nullptr ? &whole->inverse_curvature : nullptr, part.inverse_curvature);
  }
}

void Crew::load_here(Member& member, Message& message, const Given& given) {
  Level part;
  member.extent = message.get<Extent>();
  part.penalty = message.get<float>();
  part.steps = StepSet(message.get<std::vector<float>>());
  part.update = message.get<Update>();
  part.rule = message.get<Rule>();
  part.strengths = message.get<std::vector<float>>();
  part.seed = message.get<int>();
  member.share = member.sharing(member.extent);
  hand_out_fields(member.extent, member.share.loaded, given.level, needs_inverse_curvature(part.rule),
                  static_cast<std::size_t>(part.energy->inputs), part);
  const auto rank = static_cast<std::size_t>(ranks_.rank());
  std::vector<PieceSweeps::Own> own;
  if (rank < member.share.cut.pieces.size()) {
    if (member.fault.in_level) {
      member.fault.in_level(part, rank);
    }
    member.session->load(part);
    own.push_back({rank, member.session.get()});
  }
  member.sweeps.emplace(member.share.cut, std::move(own), *member.halos);
}

void Crew::write_here(Member& member, const Given& given) {
  VectorField part;
  part.extent = member.share.loaded[static_cast<std::size_t>(ranks_.rank())].extent();
  part.x = hand_out(member.extent, member.share.loaded, given.field != nullptr ? &given.field->x : nullptr);
  part.y = hand_out(member.extent, member.share.loaded, given.field != nullptr ? &given.field->y : nullptr);
  for (const PieceSweeps::Own& own : member.sweeps.value().own()) {
    own.session->write(part);
  }
  member.sweeps->written();
}

void Crew::read_here(Member& member, const Given& given) {
  const auto rank = static_cast<std::size_t>(ranks_.rank());
  VectorField own = member.solution.displacement;
  if (member.sweeps) {
    own = VectorField(member.share.owned[rank].extent());
    for (const PieceSweeps::Own& piece : member.sweeps->own()) {
      VectorField loaded;
      piece.session->read(loaded);
      copy(member.share.owned[rank], loaded, member.share.loaded[rank], own, member.share.owned[rank]);
    }
  }
  VectorField whole =
      redistribute(ranks_, rank, member.share.owned, on_first(member.extent, ranks_.size()), own);
  if (given.result != nullptr) {
    *given.result = std::move(whole);
  }
}

void Crew::load_pyramid_here(Member& member, Message& message, const Given& given) {
  RankedPyramid& pyramid = member.pyramid;
  pyramid = {};
  pyramid.extent = member.extent = message.get<Extent>();
  pyramid.part.penalty = message.get<float>();
  pyramid.part.steps = StepSet(message.get<std::vector<float>>());
  pyramid.part.update = message.get<Update>();
  pyramid.alignment = message.get<Alignment>();
  pyramid.levels.resize(message.get<std::uint64_t>());
  for (PyramidLevel& level : pyramid.levels) {
    level.extent = message.get<Extent>();
    level.sweeps = message.get<int>();
  }
  member.share = member.sharing(member.extent);
  hand_out_fields(member.extent, member.share.loaded, given.level, false,
                  static_cast<std::size_t>(pyramid.part.energy->inputs), pyramid.part);
  if (member.fault.in_level) {
    member.fault.in_level(pyramid.part, static_cast<std::size_t>(ranks_.rank()));
  }
  member.sweeps.reset();
}

void Crew::solve_here(Member& member, const Given& given) {
  member.solution = solve_on_ranks(member.pyramid, member.sharing, ranks_, *member.halos, *member.session,
                                   true, given.advance != nullptr ? *given.advance : Session::Advance{});
}

} // namespace hdmbench
