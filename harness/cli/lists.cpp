// The commands that list what there is: devices and methods.

#include "harness/cli/arguments.hpp"
#include "harness/ranks/rank_backend.hpp"
#include "harness/scene/method.hpp"

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
  if (!call.json.empty()) {
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

struct Arguments {};

int run_devices(Arguments& /*none*/, Call& call) {
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

void list_methods() {
  const auto registry = make_backends();
  for (const RegisteredEnergy* const energy : energies()) {
    json rows = json::array();
    for (const Method& method : energy->methods) {
      rows.push_back({{"method", method.name},
                      {"effort", method.effort},
                      {"usual", method.usual_effort > 0 ? json(method.usual_effort) : json("the scene's")},
                      {"takes", option_names(method.options)},
                      {"backends", who_can(*energy, method, registry)},
                      {"what_it_does", method.summary}});
    }
    fmt::print("--energy {}\n{}\n", energy->name,
               table_text(rows, "method|effort:--iterations counts|usual|takes|backends|what_it_does"));
  }
}

} // namespace

void add_devices(CLI::App& program, Call& call) {
  const auto [command, own] = declare(program, call, "devices",
                                      "List every backend with its devices, or why it is not there.\n"
                                      "mpirun -n R hdmbench devices: which one each rank takes.",
                                      run_devices);
  add_json(command, call, "Write the list to this file");
}

void add_methods(CLI::App& program, Call& /*call*/) {
  program
      .add_subcommand("methods",
                      "List the ways to solve a scene (--method): what --iterations counts, how many are "
                      "usual,\nwhich other options each takes, and which backends can")
      ->callback(list_methods);
}

} // namespace hdmbench::commands
