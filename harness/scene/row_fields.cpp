#include "harness/scene/row_fields.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace hdmbench {

JsonPlace JsonPlace::key(std::string_view name) const {
  return {file, fmt::format("{}{}{}", path, path.empty() ? "" : ".", name)};
}

JsonPlace JsonPlace::element(std::size_t index) const {
  return {file, fmt::format("{}[{}]", path, index)};
}

void JsonPlace::fail(std::string_view what) const {
  throw InputError(fmt::format("{}: {} {}", file.string(),
                               path.empty() ? "the document" : fmt::format("\"{}\"", path), what));
}

Fields::Fields(const nlohmann::json& object, JsonPlace place) : read_(&object), place_(std::move(place)) {
  if (!object.is_object()) {
    place_.fail(fmt::format("must be an object, but is {}", object.type_name()));
  }
}

const nlohmann::json& Fields::required(std::string_view key) const {
  const auto found = read_->find(key);
  if (found == read_->end()) {
    place_.key(key).fail("is missing");
  }
  return *found;
}

bool Fields::has(std::string_view key) const {
  const auto found = read_->find(key);
  return found != read_->end() && !found->is_null();
}

void require_samples(const std::vector<double>& seconds, const std::optional<double>& median) {
  refuse_if(seconds.empty() || !median, "valid", "is true although there are no seconds");
  const auto [low, high] = std::ranges::minmax(seconds);
  refuse_if(low <= 0.0, "seconds", "must be greater than 0");
  refuse_if(*median < low || *median > high, "seconds_median",
            "is not between the smallest and the largest of \"seconds\"");
}

namespace json_value {

std::size_t read_name(const nlohmann::json& found, const JsonPlace& place,
                      std::span<const std::string_view> names) {
  const auto name = std::ranges::find(names, found.is_string() ? found.get<std::string_view>() : "");
  if (name == names.end()) {
    place.fail(fmt::format("must be one of {}, but is {}", fmt::join(names, ", "), found.dump()));
  }
  return static_cast<std::size_t>(name - names.begin());
}

std::int64_t read_count(const nlohmann::json& found, const JsonPlace& place, std::int64_t most) {
  if (!found.is_number_integer() || found < 0 || found > most) {
    place.fail(fmt::format("must be an integer of 0 ... {}, but is {}", most, found.dump()));
  }
  return found.get<std::int64_t>();
}

void require_array(const nlohmann::json& found, const JsonPlace& place) {
  if (!found.is_array()) {
    place.fail(fmt::format("must be an array, but is {}", found.type_name()));
  }
}

} // namespace json_value

void to_json(nlohmann::json& written, const Placement& placement) {
  written = {{"origin", placement.origin}, {"direction", placement.axes}, {"thickness", placement.thickness}};
}

// As deep as our own documents, so recursion does.
// NOLINTNEXTLINE(misc-no-recursion)
nlohmann::json without_nulls(nlohmann::json value) {
  for (auto member = value.begin(); value.is_structured() && member != value.end();) {
    if (value.is_object() && member->is_null()) {
      member = value.erase(member);
    } else {
      *member = without_nulls(std::move(*member));
      ++member;
    }
  }
  return value;
}

} // namespace hdmbench
