#include "harness/scene/method.hpp"

#include "backends/registry.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/cli/commands.hpp"
#include "harness/report/table.hpp"

#include <fmt/format.h>

namespace hdmbench::commands {

namespace {

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
  Table elastic({{"with --energy elastic", Table::Align::left},
                 {"--iterations counts", Table::Align::left},
                 {"usual", Table::Align::right},
                 {"backends", Table::Align::left},
                 {"what it does", Table::Align::left}});
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

void add_methods(const Command& program) {
  program
      .add_subcommand("methods",
                      "List the ways to solve a scene (--method): what --iterations counts, how many are "
                      "usual,\nwhich other options each takes, and which backends can")
      .callback(list_methods);
}

} // namespace hdmbench::commands
