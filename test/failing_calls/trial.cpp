#include "test/failing_calls/trial.hpp"

#include "backends/cpu/cpu.hpp"
#include "harness/check/compare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace hdmbench::failing_calls {

namespace {

std::string joined(const std::vector<std::string>& all) {
  return fmt::format("{}", fmt::join(all, "; "));
}

/// Whether a message says which call failed, and why. What may go unnoticed is said by a later call, if at
/// all.
bool explains(const std::string& message, const Kind& kind, const Call& call) {
  const auto has = [&](std::string_view word) { return message.find(word) != std::string::npos; };
  const bool named = call.words.empty() ? has(call.name) : std::ranges::any_of(call.words, has);
  return has(kind.reason) && (named || call.can_fail_unnoticed);
}

} // namespace

bool Trial::Result::operator==(const Result& other) const {
  if (counts != other.counts || fields.size() != other.fields.size()) {
    return false;
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (compare(fields[i], other.fields[i]).sites > 0) {
      return false;
    }
  }
  return true;
}

Trial::Trial(const Backend& backend)
    : backend_(backend), problems_{test::random_problem({3, 4}, test::Texture::dyadic, 1, {},
                                                        Rule::closed_form),
                                   test::random_problem({8, 8}, test::Texture::tie_rich, 2)},
      pyramid_(test::random_problem({128, 128}, test::Texture::tie_rich, 3)),
      expected_(compute(*make_scalar()->open({}))) {}

std::unique_ptr<Session> Trial::open() const {
  // With a variant named nothing is measured, where each call would be made to fail, too.
  return backend_.open({.device = {}, .work = Work::active, .variant = 1});
}

Trial::Result Trial::compute(Session& session) const {
  Result result;
  for (const test::Problem& problem : problems_) {
    session.load(problem.level);
    session.write(problem.start);
    session.step(2);
    result.counts.push_back(session.changed());
    session.read(result.fields.emplace_back());
  }
  const Level& full = pyramid_.level;
  session.load(Pyramid{.full = &full,
                       .levels = {{.extent = {4, 4}, .sweeps = 2},   // by one work group, where that is known
                                  {.extent = {40, 40}, .sweeps = 2}, // too large for that
                                  {.extent = full.extent, .sweeps = 2}}});
  session.solve();
  result.counts.push_back(session.changed());
  session.read(result.fields.emplace_back());
  return result;
}

std::string Trial::wrong_with_next() {
  disarm();
  try {
    if (compute(*open()) != expected_) {
      return "the next session computes something else";
    }
  } catch (const std::exception& error) {
    return fmt::format("the next session: {}", error.what());
  }
  return joined(take_complaints());
}

int Trial::calls(const Kind& kind) {
  arm(kind, 0);
  if (compute(*open()) != expected_) {
    throw std::runtime_error("wrong bits without any fault");
  }
  counted_ = kind;
  called_ = tally().called;
  const std::string wrong = joined(take_complaints());
  if (!wrong.empty()) {
    throw std::runtime_error(fmt::format("without any fault: {}", wrong));
  }
  return tally().calls;
}

Outcome Trial::run_armed() {
  Outcome outcome;
  std::unique_ptr<Session> session;
  try {
    session = open();
    const bool right = compute(*session) == expected_;
    const bool over = !tally().struck; // what is left is to clean up
    session.reset();
    const Call& call = tally().call;
    const bool unnoticed =
        over || call.can_fail_unnoticed || (armed().event == Event::look_up && !called_.contains(call.name));
    outcome.ending = right && unnoticed ? Ending::succeeded : Ending::unclean;
    outcome.what = !right      ? "no error, and wrong bits"
                   : unnoticed ? ""
                               : "no error, although the call is needed";
    return outcome;
  } catch (const DeviceError& error) {
    outcome.what = error.what();
    outcome.ending = explains(outcome.what, armed(), tally().call) ? Ending::clean : Ending::unclean;
  } catch (const std::exception& error) {
    outcome.what = fmt::format("no DeviceError: {}", error.what());
    return outcome;
  }
  if (session != nullptr) {
    try {
      outcome.went_on = compute(*session) == expected_;
      if (!outcome.went_on) {
        outcome.ending = Ending::unclean;
        outcome.what = "the session went on, with wrong bits";
      }
    } catch (const DeviceError&) { // says so again
    } catch (const std::exception& error) {
      outcome.ending = Ending::unclean;
      outcome.what = fmt::format("the session went on: {}", error.what());
    }
  }
  return outcome;
}

Outcome Trial::run(const Kind& kind, int at) {
  arm(kind, at);
  Outcome outcome = run_armed();
  if (!tally().struck) {
    throw std::logic_error(fmt::format("{} of {}: there is no such call", at, kind.name));
  }
  outcome.call = tally().call.name;
  std::string wrong = joined(take_complaints());
  if (wrong.empty() && !outcome.went_on) {
    wrong = wrong_with_next();
  }
  if (!wrong.empty() && outcome.ending != Ending::unclean) {
    outcome.ending = Ending::unclean;
    outcome.what = wrong;
  }
  return outcome;
}

} // namespace hdmbench::failing_calls
