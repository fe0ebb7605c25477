#include "kernels/data/step_set.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <vector>

namespace hdmbench {

namespace {

constexpr std::array<float, 4> thesis_steps{-1.0F, -0.1F, 1.0F, 0.1F};
constexpr std::array<float, 7> fine_steps{0.0F, -1.0F, -0.1F, -0.01F, 1.0F, 0.1F, 0.01F};

float parse_number(std::string_view word, std::string_view whole) {
  const auto first = word.find_first_not_of(" +");
  const auto last = word.find_last_not_of(' ');
  float value = 0.0F;
  if (first != std::string_view::npos) {
    const char* end = word.data() + last + 1;
    const auto result = std::from_chars(word.data() + first, end, value);
    if (result.ec == std::errc{} && result.ptr == end) {
      return value;
    }
  }
  throw InputError(
      fmt::format("step set \"{}\": \"{}\" is not a number; give \"default\", \"thesis\", \"fine\" or "
                  "numbers with commas between",
                  whole, word));
}

} // namespace

StepSet StepSet::parse(std::string_view text) {
  if (text == "default") {
    return StepSet{default_steps};
  }
  if (text == "thesis") {
    return StepSet{thesis_steps};
  }
  if (text == "fine") {
    return StepSet{fine_steps};
  }
  std::vector<float> values;
  std::string_view rest = text;
  while (!rest.empty()) {
    const auto comma = std::min(rest.find(','), rest.size());
    values.push_back(parse_number(rest.substr(0, comma), text));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return StepSet{values};
}

std::string StepSet::text() const {
  return fmt::format("{}", fmt::join(values(), ", "));
}

} // namespace hdmbench
