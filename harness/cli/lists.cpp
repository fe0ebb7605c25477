// The commands that list what there is: devices and methods.

#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/cli/rank_rows.hpp"
#include "harness/judge/run_row.hpp"
#include "harness/measure/choices.hpp"
#include "harness/measure/median.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/ranks/rank_devices.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

struct Arguments {
  std::filesystem::path json;
  bool measures = false;
  SessionOptions session;
};

std::vector<std::string> updates(const Backend& backend) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < update_names.size(); ++i) {
    if (backend.supports(static_cast<Update>(i))) {
      names.emplace_back(update_names[i]);
    }
  }
  return names;
}

void add_choice(Table& table, const DeviceRow& row, const Choice& choice) {
  for (std::size_t i = 0; i < choice.options.size(); ++i) {
    const bool first = i == 0;
    const std::string mark = i != choice.chosen        ? ""
                             : choice.measured.empty() ? "taken"
                                                       : fmt::format("taken, measured {}", choice.measured);
    table.add({first ? row.backend : "", first ? row.device : "", first ? choice.what : "",
               choice.options[i].name, fmt::format("{:.3f} ms", median(choice.options[i].seconds) * 1e3),
               mark});
  }
}

/// What each rank takes of each backend with --device by-rank. Of a backend without one, why.
void list_devices_of_ranks(const Arguments& arguments, Ranks& ranks) {
  if (arguments.measures || !arguments.json.empty()) {
    throw InputError("devices --measure and --json tell of one process: leave out mpirun");
  }
  std::vector<RankRow> own;
  for (const auto& backend : make_backends()) {
    RankRow& row = own.emplace_back(
        RankRow{.machine = machine_name(), .backend = std::string(backend->name()), .device = {}});
    try {
      const SessionOptions options = options_of_rank({.device = "by-rank"}, *backend, ranks);
      const Device device = backend->device(options);
      row.device = fmt::format("{}, {}", device.name, device.driver);
      row.threads = backend->threads(options);
    } catch (const DeviceError& error) {
      row.device = fmt::format("not there: {}", error.what());
    }
  }
  const std::vector<RankRow> rows = gather_rows(own, ranks);
  Table table({"rank", "<machine", "<backend", "threads", "<device and driver"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    table.add({std::to_string(i / own.size()), rows[i].machine, rows[i].backend,
               rows[i].threads > 0 ? std::to_string(rows[i].threads) : "-", rows[i].device});
  }
  fmt::print(
      "{}  --device by-rank: the ranks of a machine take its devices in turn, and share its processors "
      "out\n",
      table.text());
}

void list_devices(const Arguments& arguments, const std::string& line) {
  require_results_writable(arguments.json);
  Table table({"<backend", "no.", "<device", "<driver"});
  nlohmann::json rows = nlohmann::json::array();
  std::string absent;
  Table chosen({"<backend", "<device", "<what", "<way", "median", "<"});
  bool any_chosen = false;
  for (const auto& backend : make_backends()) {
    DeviceRow row{.backend = std::string(backend->name()),
                  .description = std::string(backend->description()),
                  .updates = updates(*backend)};
    try {
      const std::vector<Device> devices = backend->devices();
      for (std::size_t i = 0; i < devices.size(); ++i) {
        table.add({i == 0 ? row.backend : "", std::to_string(i), devices[i].name, devices[i].driver});
        row.device = devices[i].name;
        row.driver = devices[i].driver;
        row.software = devices[i].is_software;
        if (arguments.measures) {
          SessionOptions session = arguments.session;
          session.device = std::to_string(i);
          row.choices = backend->choices(session);
          any_chosen = any_chosen || !row.choices.empty();
        }
        for (const Choice& choice : row.choices) {
          add_choice(chosen, row, choice);
        }
        rows.push_back(to_json_row(row));
      }
    } catch (const DeviceError& error) {
      row.available = false;
      row.reason = error.what();
      rows.push_back(to_json_row(row));
      absent += fmt::format("  {}: {}\n", row.backend, row.reason);
    }
  }
  fmt::print("{}", table.text());
  if (any_chosen) {
    fmt::print("\nChosen by measurement\n{}", chosen.text());
  }
  if (!absent.empty()) {
    fmt::print("\nNot there:\n{}", absent);
  }
  if (!arguments.json.empty()) {
    write_results(arguments.json, "devices", run_context(line, false), std::move(rows));
  }
}

/// "all", or the names of those that can.
std::string who_can(const Method& method, const std::vector<std::unique_ptr<Backend>>& registry) {
  Schedule schedule;
  Level level;
  method.configure(schedule, level);
  std::string names;
  std::size_t count = 0;
  for (const auto& backend : registry) {
    if (backend->supports(level.update)) {
      names += fmt::format("{}{}", count == 0 ? "" : ", ", backend->name());
      ++count;
    }
  }
  return count == registry.size() ? "all" : names;
}

void list_methods() {
  Table table({"<method", "<--iterations counts", "usual", "<takes", "<backends", "<what it does"});
  const auto registry = make_backends();
  for (const Method& method : methods()) {
    table.add({std::string(method.name), std::string(method.effort),
               method.usual_effort > 0 ? std::to_string(method.usual_effort) : "the scene's",
               method.options == no_options ? "-" : option_names(method.options), who_can(method, registry),
               std::string(method.summary)});
  }
  fmt::print("{}", table.text());
  Table elastic({"<with --energy elastic", "<--iterations counts", "usual", "<backends", "<what it does"});
  std::string names;
  for (const auto& backend : registry) {
    if (backend->has_elastic()) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", backend->name());
    }
  }
  for (const Method& method : elastic_methods()) {
    elastic.add({std::string(method.name), std::string(method.effort), std::to_string(method.usual_effort),
                 names, std::string(method.summary)});
  }
  fmt::print("\n{}", elastic.text());
}

} // namespace

void add_devices(const Command& program, const std::string& arguments, int& /*status*/, Ranks* ranks) {
  const Command command =
      program.add_subcommand("devices", "List every backend with its devices, or why it is not there.\n"
                                        "mpirun -n R hdmbench devices: which one each rank takes.");
  const auto own = std::make_shared<Arguments>();
  command.add_option("--json", own->json, "Write the list to this file");
  command.add_flag(
      "--measure", own->measures,
      "Measure, too, which way each device computes fastest: compiles shaders for it, takes seconds");
  add_choice_cache_to(command, own->session);
  command.callback([own, command, arguments, ranks] {
    refuse_idle(command,
                {{.here = !own->measures, .options = {"--no-cache"}, .why = "only --measure measures"}});
    ranks != nullptr ? list_devices_of_ranks(*own, *ranks) : list_devices(*own, arguments);
  });
}

void add_methods(const Command& program) {
  program
      .add_subcommand("methods",
                      "List the ways to solve a scene (--method): what --iterations counts, how many are "
                      "usual,\nwhich other options each takes, and which backends can")
      .callback(list_methods);
}

} // namespace hdmbench::commands
