// The commands that ask what there is and what it does: devices, methods, probe, implementations.

#include "harness/check/probe.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/measure/implementations.hpp"
#include "harness/ranks/rank_backend.hpp"

#include <fmt/ranges.h>

#include <map>

namespace hdmbench::commands {

namespace {

json updates(const Backend& backend) {
  json names = json::array();
  for (std::size_t i = 0; i < update_names.size(); ++i) {
    if (backend.supports(static_cast<Update>(i))) {
      names.push_back(update_names[i]);
    }
  }
  return names;
}

/// What each rank takes of each backend with --device by-rank. Of a backend without one, why.
int list_devices_of_ranks(const Call& call, Ranks& ranks) {
  if (!call[option::json].empty()) {
    throw InputError("devices --json tells of one process: leave out mpirun");
  }
  json own = json::array();
  for (const auto& backend : make_backends()) {
    json row{{"rank", ranks.rank()}, {"machine", machine_name()}, {"backend", backend->name()}};
    try {
      const SessionOptions options = options_of_rank({.device = "by-rank"}, *backend, ranks);
      const Device device = backend->device(options);
      row["device"] = fmt::format("{}, {}", device.name, device.driver);
      row["threads"] = backend->threads(options);
    } catch (const DeviceError& error) {
      row["device"] = fmt::format("not there: {}", error.what());
    }
    own.push_back(std::move(row));
  }
  fmt::print(
      "{}  --device by-rank: the ranks of a machine take its devices in turn, and share its processors out\n",
      table_text(gather_rows(own, ranks), "rank|machine|backend|threads|device:device and driver"));
  return success;
}

int run_devices(Call& call) {
  if (call.ranks != nullptr) {
    return list_devices_of_ranks(call, *call.ranks);
  }
  json rows = json::array();
  json present = json::array();
  std::string absent;
  for (const auto& backend : make_backends()) {
    json row{{"backend", backend->name()},
             {"description", backend->description()},
             {"updates", updates(*backend)},
             {"available", true},
             {"device", ""},
             {"driver", ""},
             {"software", false},
             {"reason", ""}};
    try {
      const std::vector<Device> devices = backend->devices();
      for (std::size_t i = 0; i < devices.size(); ++i) {
        row.update({{"device", devices[i].name},
                    {"driver", devices[i].driver},
                    {"software", devices[i].is_software}});
        rows.push_back(row);
        present.push_back(row);
        present.back()["number"] = i;
      }
    } catch (const DeviceError& error) {
      row.update({{"available", false}, {"reason", error.what()}});
      rows.push_back(row);
      absent += fmt::format("  {}: {}\n", backend->name(), error.what());
    }
  }
  fmt::print("{}{}{}", table_text(present, "backend|number:no.|device|driver"),
             absent.empty() ? "" : "\nNot there:\n", absent);
  call.write(std::move(rows));
  return success;
}

/// "all", or the names of those that can.
json who_can(const RegisteredEnergy& energy, const Method& method,
             const std::vector<std::unique_ptr<Backend>>& registry) {
  Schedule schedule;
  Level level;
  method.configure(schedule, level);
  json names = json::array();
  for (const auto& backend : registry) {
    if (energy.is_of_cells() ? backend->has_elastic() : backend->supports(level.update)) {
      names.push_back(backend->name());
    }
  }
  return names.size() == registry.size() ? json("all") : names;
}

int list_methods(Call& /*call*/) {
  const auto registry = make_backends();
  for (const RegisteredEnergy* const energy : registered_energies()) {
    json rows = json::array();
    for (const Method& method : energy->methods) {
      rows.push_back({{"method", method.name},
                      {"effort", method.effort},
                      {"usual", method.usual_effort > 0 ? json(method.usual_effort) : json("the scene's")},
                      {"takes", method.takes},
                      {"backends", who_can(*energy, method, registry)},
                      {"what_it_does", method.summary}});
    }
    fmt::print("--energy {}\n{}\n", energy->name,
               table_text(rows, "method|effort:--iterations counts|usual|takes|backends|what_it_does"));
  }
  return success;
}

int list_scenes(Call& /*call*/) {
  json rows = json::array();
  for (const SceneSummary& scene : scene_summaries()) {
    const bool is_volume = std::ranges::find(shipped_volumes, scene.name) != shipped_volumes.end();
    rows.push_back({{"scene", scene.name},
                    {"axes", is_volume ? "3-D" : "2-D"},
                    {"size", scene.size},
                    {"title", scene.title}});
  }
  fmt::print("{}\n  --size takes another size; a TOML file of your own is a scene, too.\n",
             table_text(rows, "scene|axes:|size|title:what it shows"));
  return success;
}

int run_probe(Call& call) {
  const Gates gates(call);
  const auto registry = make_backends();
  std::string expected;
  json results = json::array();
  std::string tables;
  Progress progress;
  for (const Backend* backend : choose_backends(call, registry)) {
    progress.describe(std::string(backend->name()));
    try {
      const std::vector<ProbeRow> rows = probe(*backend, call.session());
      json answers = json::array();
      for (const ProbeRow& row : rows) {
        results.push_back(row);
        answers.push_back(results.back());
        answers.back()["answer"] = answer_text(row);
      }
      tables += fmt::format("{}: {}\n{}\n", backend->name(), backend->device(call.session()).name,
                            table_text(answers, "program|question|answer"));
      expected += fmt::format("  {}: {}\n", backend->name(), expected_tier(rows));
    } catch (const DeviceError& error) {
      if (needs(call, backend->name())) {
        throw;
      }
      expected += fmt::format("  {}: skipped: {}\n", backend->name(), error.what());
    }
  }
  progress.clear();
  if (results.empty()) { // scalar is always there: it is the device that is not
    throw InputError(
        fmt::format("no backend has a device \"{}\"; hdmbench devices lists them", call[option::device]));
  }
  fmt::print("{}Expected of verify\n{}", tables, expected);
  call.write(std::move(results));
  return gates.judge(success, call);
}

const Option<double> limit_seconds("--limit-seconds", "That one implementation of one backend may take",
                                   180.0, CLI::Range(1.0, 1e6));
const Option<double> limit_memory("--limit-memory", "That it may take, in GB", 2.0, CLI::Range(0.1, 1e4));

/// What was given of the arguments that `verify` has too, for another process: scenes first.
std::vector<std::string> verify_words(const CLI::App& command, std::vector<std::string> words) {
  for (const CLI::Option* const option : command.get_options()) {
    const std::string name = option->get_name();
    const bool is_own = name == "--json" || name == "--backends" || name.starts_with("--limit");
    if (option->count() > 0 && !option->get_positional() && !is_own) {
      words.push_back(name);
      if (option->get_items_expected_max() > 0) {
        words.push_back(fmt::format("{}", fmt::join(option->results(), ",")));
      }
    }
  }
  return words;
}

int run_implementations(Call& call) {
  const auto registry = make_backends();
  for (const std::string& name : call[option::backends]) {
    (void)find_backend(registry, name);
  }
  Progress progress;
  json rows = verify_implementations(known_implementations(),
                                     {.program = std::filesystem::read_symlink("/proc/self/exe"),
                                      .verify = verify_words(*call.command, call[option::scenes]),
                                      .backends = call[option::backends],
                                      .seconds = call[limit_seconds],
                                      .resident_bytes = static_cast<std::int64_t>(call[limit_memory] * 1e9),
                                      .heard = [&](const json& some) { call.keep(some); }},
                                     progress);
  progress.clear();
  fmt::print("{}",
             table_text(rows, "backend|implementation|device|outcome|tier|scenes|comparisons|sites_compared|"
                              "sites_differing:differing|seconds|peak_bytes:bytes"));
  std::map<std::string, std::ptrdiff_t> count; // by outcome
  for (const json& row : rows) {
    ++count[row["outcome"]];
    if (row["reason"] != "") {
      fmt::print("{}{}", row_text("\n  {backend} on {implementation}: {reason}\n", row),
                 row["repeat"] == "" ? "" : row_text("    repeat: {repeat}\n", row));
    }
  }
  const auto passed = count["passed"];
  const auto failed = std::ssize(rows) - passed - count["absent"];
  fmt::print("\n{} pass, {} do not, {} are not there\n", passed, failed, count["absent"]);
  call.write(std::move(rows));
  return ended(call, failed == 0, passed > 0 ? "" : "no implementation was compared, so none has passed");
}

} // namespace

void add_devices(CLI::App& program, Call& call) {
  add_command(program, call, "devices", run_devices,
              "List every backend with its devices, or why not.\n"
              "mpirun -n R hdmbench devices: which one each rank takes.",
              {Options(option::json, "Write the list to this file")});
}

void add_methods(CLI::App& program, Call& call) {
  add_command(program, call, "methods", list_methods,
              "List the ways to solve a scene (--method).\n"
              "What --iterations counts, how many are usual,\n"
              "which other options each takes, and which backends can",
              {});
}

void add_scenes(CLI::App& program, Call& call) {
  add_command(program, call, "scenes", list_scenes, "List the scenes that come with the program.", {});
}

void add_probe(CLI::App& program, Call& call) {
  add_command(
      program, call, "probe", run_probe,
      "Ask what each device's arithmetic does.\n"
      "What does each device's arithmetic do? Are products fused into sums, are sums reordered,\n"
      "are subnormal numbers, -0, NaN and infinity kept, how are quotients and roots rounded, when does a\n"
      "loop end? One sweep in the very programs that verify compares, and a small program of its own per\n"
      "language, on numbers that tell the cases apart. \"telling\" in the JSON counts the answers that would "
      "have "
      "been\n"
      "others.",
      {backends_options(), gate_options(), Options(option::json, "Write the answers to this file")});
}

void add_implementations(CLI::App& program, Call& call) {
  add_command(
      program, call, "implementations", run_implementations,
      "verify on every driver of this machine.\n"
      "Run verify on every implementation of OpenGL and Vulkan that this machine has, each in a process of\n"
      "its own: as installed, Mesa's llvmpipe and softpipe, every Vulkan driver with a file, and zink on "
      "it.\n"
      "A driver that hangs, crashes or takes too much memory is a row of the table.\n"
      "Takes the arguments of verify. Exit status 1 if one does not pass.",
      {comparison_options().without({"--device", "--require", "--energy"}), limit_seconds, limit_memory},
      {"--methods excludes --method"});
}

} // namespace hdmbench::commands
