#include "harness/ranks/crew.hpp"

#include "harness/ranks/crew_solution.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "kernels/data/input_error.hpp"

#include <utility>

namespace hdmbench {

namespace {

/// An order begins with these.
template <typename Order>
RankMessage message_of(Order order, int session) {
  RankMessage message;
  message.put(order);
  message.put(session);
  return message;
}

} // namespace

Crew::Crew(Ranks& ranks, const std::vector<std::unique_ptr<Backend>>& registry, SessionOptions session)
    : ranks_(ranks), registry_(registry), session_(std::move(session)) {}

Crew::~Crew() = default;

void Crew::serve() {
  RankMessage message;
  do {
    message = {};
    ranks_.broadcast(message.bytes);
  } while (obey(message, {}));
}

void Crew::command(RankMessage message, const CrewGiven& given) {
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

int Crew::open(EnergyModel energy, std::string_view backends, Work work, const Sharing& sharing,
               std::string_view fault) {
  const int session = next_++;
  RankMessage message = message_of(Order::open, session);
  message.put(energy);
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
    command(message_of(Order::close, session), {});
  } catch (const std::exception&) {
    is_broken_ = true; // the next order says so
  }
}

void Crew::load(int session, const Level& level) {
  if (level.energy != &thesis_energy) {
    throw InputError("an energy that is not the thesis's runs on one rank");
  }
  RankMessage message = message_of(Order::load, session);
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
  command(message_of(Order::write, session), {.field = &displacement});
}

void Crew::step(int session, int sweeps) {
  RankMessage message = message_of(Order::step, session);
  message.put(sweeps);
  command(std::move(message), {});
}

void Crew::read(int session, VectorField& displacement) {
  command(message_of(Order::read, session), {.result = &displacement});
}

std::int64_t Crew::changed(int session) {
  command(message_of(Order::changed, session), {});
  return changed_;
}

void Crew::load(int session, const Pyramid& pyramid) {
  const Level& full = *pyramid.full;
  if (needs_inverse_curvature(full.rule) || full.energy != &thesis_energy) {
    throw InputError("a pyramid in one piece, on several ranks, is computed by candidates only");
  }
  RankMessage message = message_of(Order::load_pyramid, session);
  message.put(full.extent);
  message.put(full.penalty);
  message.put(std::vector<float>(full.steps.values().begin(), full.steps.values().end()));
  message.put(full.update);
  message.put(full.rule);
  message.put(full.seed);
  message.put(pyramid.alignment);
  message.put(std::uint64_t{pyramid.levels.size()});
  for (const PyramidLevel& level : pyramid.levels) {
    message.put(level.extent);
    message.put(level.sweeps);
    message.put(level.strengths);
  }
  command(std::move(message), {.level = &full});
}

void Crew::solve(int session, const Session::Advance& advance) {
  command(message_of(Order::solve, session), {.advance = &advance});
}

VectorField Crew::solve(const Scene& scene, std::string_view backends, const Sharing& sharing,
                        std::string_view fault) {
  if (scene.full.energy != &thesis_energy) {
    throw InputError("an energy that is not the thesis's runs on one rank");
  }
  RankMessage message = message_of(Order::solve_scene, 0);
  message.put(backends);
  message.put(sharing);
  message.put(fault);
  put_outline(scene, message);
  VectorField result;
  command(std::move(message),
          {.level = &scene.full, .field = scene.start ? &*scene.start : nullptr, .result = &result});
  return result;
}

void Crew::dismiss() {
  command(message_of(Order::dismiss, 0), {});
}

void Crew::load(int session, const ElasticHierarchy& hierarchy) {
  const ElasticOrigin& origin = hierarchy.origin;
  if (origin.image == nullptr) {
    throw InputError("a sheet with springs of its own is computed on one rank");
  }
  RankMessage message = message_of(Order::load_elastic, session);
  message.put(origin.image->extent);
  message.put(origin.poisson);
  message.put(origin.springs);
  command(std::move(message), {.level = origin.image});
}

float Crew::call(int session, const ElasticOrder& order, const VectorField* field, VectorField* result) {
  RankMessage message = message_of(Order::call_elastic, session);
  message.put(order);
  command(std::move(message), {.field = field, .result = result});
  return value_;
}

bool Crew::obey(RankMessage& message, const CrewGiven& given) {
  const auto order = message.get<Order>();
  const auto session = message.get<int>();
  switch (order) {
  case Order::dismiss:
    return false;
  case Order::open:
    open_here(session, message);
    break;
  case Order::close:
    members_.erase(session);
    elastic_members_.erase(session);
    break;
  case Order::load:
    members_.at(session).load(message, given);
    break;
  case Order::write:
    members_.at(session).write(given);
    break;
  case Order::step:
    members_.at(session).step(message.get<int>());
    break;
  case Order::read:
    members_.at(session).read(given);
    break;
  case Order::changed:
    changed_ = members_.at(session).changed();
    break;
  case Order::load_pyramid:
    members_.at(session).load_pyramid(message, given);
    break;
  case Order::solve:
    members_.at(session).solve(given);
    break;
  case Order::load_elastic:
    elastic_members_.at(session).load(message, given);
    break;
  case Order::solve_scene:
    solve_here(message, given);
    break;
  case Order::call_elastic:
    value_ = elastic_members_.at(session).call(message.get<ElasticOrder>(), given);
    break;
  }
  return true;
}

void Crew::open_here(int session, RankMessage& message) {
  const auto energy = message.get<EnergyModel>();
  const auto names = message.get<std::string>();
  const auto work = message.get<Work>();
  const auto sharing = message.get<Sharing>();
  const auto fault = message.get<std::string>();
  const Backend& backend = backend_of_rank(registry_, names, ranks_.rank());
  SessionOptions options = options_of_rank(session_, backend, ranks_);
  options.work = work;
  if (energy == EnergyModel::hdm) {
    std::unique_ptr<Session> own = backend.open(options);
    if (const auto planted = faults::find_rank_fault(fault).in_active_session;
        planted && work == Work::active) {
      own = planted(std::move(own));
    }
    members_.try_emplace(session, ranks_, sharing, fault, std::move(own));
  } else {
    elastic_members_.try_emplace(session, ranks_, sharing, fault,
                                 [&backend, options] { return backend.open_elastic(options); });
  }
}

void Crew::solve_here(RankMessage& message, const CrewGiven& given) {
  const auto names = message.get<std::string>();
  const auto sharing = message.get<Sharing>();
  const auto fault = message.get<std::string>();
  const Backend& backend = backend_of_rank(registry_, names, ranks_.rank());
  solve_scene(message, given, ranks_, sharing, fault, backend, options_of_rank(session_, backend, ranks_));
}

} // namespace hdmbench
