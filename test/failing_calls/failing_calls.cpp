// failing_calls: every call of a driver fails once, see faults.hpp. The stand-ins are found by the program's
// run path.

#include "backends/cpu/cpu.hpp"
#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/solve/progress.hpp"
#include "kernels/data/input_error.hpp"
#include "test/captured_stream.hpp"
#include "test/failing_calls/faults.hpp"
#include "test/random_level.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>

#include <unistd.h>

namespace hdmbench::failing_calls {
namespace {

constexpr int nothing_to_test = 77;         // exit status
constexpr unsigned seconds_until_hung = 60; // a run takes well below one

/// What is running, for the handler of a signal that ends the program.
std::array<char, 200> running{};

void say_what_ended(int signal) {
  const auto say = [](const char* words) { (void)!write(STDERR_FILENO, words, std::strlen(words)); };
  say("failing_calls: ");
  say(running.data());
  say(signal == SIGALRM ? ": the program hung\n" : ": the program crashed\n");
  _exit(1);
}

/// What a session is seen to have computed: two levels of different sizes and rules, and a pyramid whose last
/// level is large enough for every backend to leave tiles out.
struct Result {
  std::vector<VectorField> fields;
  std::vector<std::int64_t> counts;

  bool operator==(const Result& other) const {
    return counts == other.counts &&
           std::ranges::equal(fields, other.fields, [](const VectorField& a, const VectorField& b) {
             return compare(a, b).sites == 0;
           });
  }
};

Result compute(Session& session) {
  static const std::array problems{
      test::random_problem({3, 4}, test::Texture::dyadic, 1, {}, Rule::closed_form),
      test::random_problem({8, 8}, test::Texture::tie_rich, 2)};
  static const Level full = test::random_problem({128, 128}, test::Texture::tie_rich, 3).level;
  Result result;
  const auto look = [&] {
    result.counts.push_back(session.changed());
    session.read(result.fields.emplace_back());
  };
  for (const test::Problem& problem : problems) {
    session.load(problem.level);
    session.write(problem.start);
    (void)session.device_seconds();
    session.step(2);
    look();
    (void)session.device_seconds();
  }
  session.load(Pyramid{.full = &full,
                       .levels = {{.extent = {4, 4}, .sweeps = 2},   // by one work group
                                  {.extent = {40, 40}, .sweeps = 2}, // too large for that
                                  {.extent = full.extent, .sweeps = 2}}});
  session.solve();
  look();
  return result;
}

/// A backend of its own, which may keep its driver as long as it lives, and a session on it.
struct Opened {
  explicit Opened(std::string_view name)
      : registry(make_backends()), backend(&find_backend(registry, name)) {}

  std::vector<std::unique_ptr<Backend>> registry;
  const Backend* backend;
  std::unique_ptr<Session> session{}; ///< null: not open
};

/// Computes in the session, which is opened where there is none. Says what is wrong, in words; empty: the
/// bits are right. Throws DeviceError.
std::string compute_again(Opened& opened) {
  static const Result expected = compute(*make_scalar()->open({}));
  try {
    if (opened.session == nullptr) {
      opened.session = opened.backend->open({.device = {}, .work = Work::active});
    }
    return compute(*opened.session) == expected ? "" : "no error, and wrong bits";
  } catch (const DeviceError&) {
    throw;
  } catch (const std::exception& error) {
    return fmt::format("no DeviceError: {}", error.what());
  }
}

/// What is wrong with a session without a fault and with what it leaves; empty: nothing.
std::string wrong_with_next(std::string_view backend) {
  std::optional<Opened> opened(backend);
  try {
    const std::string wrong = compute_again(*opened);
    opened.reset();
    return wrong.empty() ? fmt::format("{}", fmt::join(faults().take_complaints(), "; "))
                         : fmt::format("the next session: {}", wrong);
  } catch (const DeviceError& error) {
    return fmt::format("the next session: {}", error.what());
  }
}

/// Whether a message says which call failed, and why. What cleans up is said by a later call, if at all.
bool explains(const std::string& message, const Kind& kind, const Call& call) {
  const auto has = [&](std::string_view word) { return message.find(word) != std::string::npos; };
  if (!has(kind.reason) || call.cleans_up || has(call.name)) {
    return has(kind.reason);
  }
  // What Vulkan-Hpp throws has the name of its method.
  static const std::map<std::string, std::string, std::less<>> methods{
      {"vkQueueSubmit", "Queue::submit"},
      {"vkGetQueryPoolResults", "QueryPool::getResult"},
      {"vkBindBufferMemory", "Buffer::bindMemory"},
      {"vkBeginCommandBuffer", "CommandBuffer::begin"},
      {"vkEndCommandBuffer", "CommandBuffer::end"}};
  const auto known = methods.find(call.name);
  std::string method = call.name.substr(2);
  method.front() = static_cast<char>(method.front() - 'A' + 'a');
  return kind.api == "Vulkan" && has(known != methods.end() ? known->second : "::" + method);
}

/// Adds to `row` one run, in which the `at`-th call fails; then the session goes on if it can, or the next
/// one has to.
void fail_once(nlohmann::json& row, std::string_view backend, const Kind& kind, std::size_t at,
               const std::set<std::string, std::less<>>& needed, test::CapturedStream& printed) {
  faults().arm(kind, at);
  std::optional<Opened> opened(backend);
  std::string wrong;
  std::string told;
  try {
    wrong = compute_again(*opened);
  } catch (const DeviceError& error) {
    told = error.what();
  }
  const bool over = !faults().struck; // what is left is to clean up
  const bool is_right = wrong.empty() && told.empty();
  if (told.empty()) {
    opened.reset();
  }
  if (!faults().struck) {
    throw std::logic_error(fmt::format("{} of {}: there is no such call", at, kind.name));
  }
  const Call call = *faults().struck;
  if (is_right && !over && !call.cleans_up && (kind.name != missing || needed.contains(call.name))) {
    wrong = "no error, although the call is needed";
  } else if (!told.empty() && !explains(told, kind, call)) {
    wrong = told;
  }
  bool went_on = false;
  if (opened && opened->session != nullptr && wrong.empty()) {
    try {
      wrong = compute_again(*opened);
      went_on = wrong.empty();
    } catch (const DeviceError&) { // it may say so again
    }
  }
  opened.reset();
  const std::string complaints = fmt::format("{}", fmt::join(faults().take_complaints(), "; "));
  wrong = wrong.empty() ? complaints : wrong;
  faults().disarm();
  wrong = wrong.empty() && !went_on ? wrong_with_next(backend) : wrong;
  const std::string said = printed.take();
  wrong = said.empty() ? wrong : said;
  const auto count = [&](const char* key, bool counts) { row[key] = row[key].get<int>() + (counts ? 1 : 0); };
  count("failed", true);
  count("clean", wrong.empty() && !is_right);
  count("succeeded", wrong.empty() && is_right);
  count("went_on", went_on);
  if (!wrong.empty()) {
    row["unclean"].push_back(fmt::format("{} {}: {}", at, call.name, wrong));
  }
}

/// The numbers, 1, 2, ..., of the first two and of the last call of each function.
std::vector<std::size_t> outermost_calls(const std::vector<std::string>& names) {
  std::map<std::string, std::vector<std::size_t>> calls;
  for (std::size_t i = 0; i < names.size(); ++i) {
    calls[names[i]].push_back(i + 1);
  }
  std::set<std::size_t> numbers;
  for (const auto& [name, all] : calls) {
    numbers.insert({all.front(), all[std::min<std::size_t>(1, all.size() - 1)], all.back()});
  }
  return {numbers.begin(), numbers.end()};
}

/// All runs of one kind on one backend: how many calls of a run can fail so; how many of them did, a run
/// each; after how many there was a DeviceError with the call's name and the driver's reason and nothing left
/// (clean), or the right bits all the same, as the work can be done without the call (succeeded); in how many
/// of the clean ones the same session computed the right bits afterwards (went_on); all others in words.
/// `quick`: of the kinds that let one call of this API fail, each takes its share of the outermost calls.
nlohmann::json row_of(std::string_view backend, const Kind& kind, bool quick) {
  test::CapturedStream printed(stdout); // by drivers and the validation layers of Vulkan
  faults().arm(kind, 0);
  if (const std::string wrong = wrong_with_next(backend); !wrong.empty()) {
    throw std::runtime_error(fmt::format("without any fault: {}", wrong));
  }
  const auto needed = faults().called;
  std::vector<std::size_t> numbers(faults().names.size()); // none: the backend does not go through this API
  std::iota(numbers.begin(), numbers.end(), 1);
  nlohmann::json row{{"backend", backend},      {"api", kind.api}, {"kind", kind.name},
                     {"calls", numbers.size()}, {"failed", 0},     {"clean", 0},
                     {"succeeded", 0},          {"went_on", 0},    {"unclean", nlohmann::json::array()}};
  if (quick && kind.name != missing) {
    const auto shares = [&](const Kind& other) { return other.api == kind.api && other.name != missing; };
    const auto turns = static_cast<std::size_t>(std::ranges::count_if(kinds(), shares));
    const std::vector<std::size_t> outermost = outermost_calls(faults().names);
    numbers.clear();
    for (auto i = static_cast<std::size_t>(std::count_if(kinds().data(), &kind, shares));
         i < outermost.size(); i += turns) {
      numbers.push_back(outermost[i]);
    }
  }
  for (const std::size_t at : numbers) {
    fmt::format_to_n(running.data(), running.size() - 1, "{}, {} {}, call {}{}", backend, kind.api, kind.name,
                     at, '\0');
    alarm(seconds_until_hung);
    fail_once(row, backend, kind, at, needed, printed);
  }
  alarm(0);
  return row;
}

int run(int argc, char** argv) {
  CLI::App program(
      "failing_calls: every call of a graphics driver fails once, in every way it can, while a backend "
      "works on two small levels and a pyramid.\nExit status 1 unless each time there was an error that "
      "names the call and the reason, nothing was left behind,\nand the same session went on to the right "
      "bits, or the next one did.");
  std::vector<std::string> wanted;
  std::filesystem::path file;
  bool quick = false;
  program.add_option("--backends", wanted, "Only these")->delimiter(',');
  program.add_flag("--quick", quick,
                   "Only the first two and the last call of each function fail, in one of the ways each");
  program.add_option("--json", file, "Write the results to this file");
  CLI11_PARSE(program, argc, argv);
  require_results_writable(file);
  for (const int signal : {SIGABRT, SIGALRM, SIGBUS, SIGFPE, SIGILL, SIGSEGV}) {
    std::signal(signal, say_what_ended);
  }
  nlohmann::json rows = nlohmann::json::array();
  bool is_clean = true;
  for (const auto& backend : make_backends()) {
    const bool is_wanted = wanted.empty() || std::ranges::find(wanted, backend->name()) != wanted.end();
    if (!is_wanted || backend->threads({}) > 0) { // a processor has no driver
      continue;
    }
    alarm(seconds_until_hung);
    try {
      (void)Opened(backend->name()).backend->devices();
    } catch (const DeviceError& error) {
      fmt::print("{} is not there: {}\n", backend->name(), error.what());
      continue;
    }
    Progress progress;
    const std::size_t before = rows.size();
    for (const Kind& kind : kinds()) {
      progress.describe(fmt::format("{}: {}", backend->name(), kind.name));
      if (nlohmann::json row = row_of(backend->name(), kind, quick); row["calls"] > 0) {
        rows.push_back(std::move(row));
      }
    }
    if (rows.size() == before) {
      throw std::runtime_error(fmt::format("{} makes no call that the stand-ins see", backend->name()));
    }
  }
  fmt::print("{}", table_text(rows, "backend|api:API|kind:what happens|calls|failed|clean:clean errors|"
                                    "succeeded:succeeded anyway|went_on:session went on"));
  for (const nlohmann::json& row : rows) {
    for (const std::string what : row["unclean"]) {
      const auto word = [&](const char* key) { return row[key].get<std::string>(); };
      fmt::print("  NOT CLEAN: {}, {} {}, call {}\n", word("backend"), word("api"), word("kind"), what);
      is_clean = false;
    }
  }
  write_results(file, "failing-calls", run_context(quick ? "failing_calls --quick" : "failing_calls", quick),
                rows);
  return rows.empty() ? nothing_to_test : is_clean ? 0 : 1;
}

} // namespace
} // namespace hdmbench::failing_calls

int main(int argc, char** argv) {
  try {
    return hdmbench::failing_calls::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "failing_calls: {}\n", error.what());
    return 2;
  }
}
