#include "harness/choices.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

std::string describe(const Choice& choice) {
  std::string line = choice.what;
  for (const Choice::Option& option : choice.options) {
    line += fmt::format("{} {} {:.2f} ms", &option == &choice.options.front() ? ":" : ",", option.name,
                        std::ranges::min(option.seconds) * 1e3);
  }
  return fmt::format("{}: {}", line, choice.options[choice.chosen].name);
}

nlohmann::json to_json(const Choice& choice) {
  nlohmann::json options = nlohmann::json::array();
  for (const Choice::Option& option : choice.options) {
    options.push_back({{"name", option.name}, {"seconds", option.seconds}});
  }
  return {
      {"what", choice.what}, {"options", std::move(options)}, {"chosen", choice.options[choice.chosen].name}};
}

} // namespace hdmbench
