#include "harness/measure/device_row.hpp"

#include "harness/measure/median.hpp"
#include "harness/scene/row_fields.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

std::string describe(const Choice& choice) {
  std::string line = choice.what;
  for (const Choice::Option& option : choice.options) {
    line += fmt::format("{} {} {:.2f} ms", &option == &choice.options.front() ? ":" : ",", option.name,
                        median(option.seconds) * 1e3);
  }
  const std::string when =
      choice.measured.empty() ? "" : fmt::format(" (kept, measured {})", choice.measured);
  return fmt::format("{}: {}{}", line, choice.options[choice.chosen].name, when);
}

static void list_fields(Fields& fields, Choice::Option& option) {
  fields("name", option.name);
  fields("seconds", option.seconds);
}

static void require_consistent(const Choice::Option& option) {
  refuse_if(option.seconds.empty(), "seconds", "is empty");
}

void list_fields(Fields& fields, Choice& choice) {
  fields("what", choice.what);
  fields("options", choice.options);
  std::string chosen = fields.reading() ? "" : choice.options[choice.chosen].name;
  fields("chosen", chosen);
  const auto found = std::ranges::find(choice.options, chosen, &Choice::Option::name);
  refuse_if(found == choice.options.end(), "chosen", "is none of the options");
  fields.if_any("measured", choice.measured);
  choice.chosen = static_cast<std::size_t>(found - choice.options.begin());
}

void list_fields(Fields& fields, DeviceRow& row) {
  fields("backend", row.backend);
  fields("description", row.description);
  fields("updates", row.updates);
  fields("available", row.available);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("software", row.software);
  fields("reason", row.reason);
  fields.newer("choices", row.choices);
}

} // namespace hdmbench
