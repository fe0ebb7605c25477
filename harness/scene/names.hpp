#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// Whether a member of the range, or what `of` says of it, is `value`.
template <typename Range, typename Value, typename Of = std::identity>
[[nodiscard]] bool contains(const Range& range, const Value& value, Of of = {}) {
  return std::ranges::find(range, value, of) != std::ranges::end(range);
}

/// The whole of a text as a number, which may be NaN or infinite; none where it is none.
template <typename Number>
[[nodiscard]] std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// The texts of a range with `separator` between them. (fmt::join trips g++ 12's -Wstringop-overflow.)
template <typename Texts>
[[nodiscard]] std::string joined(const Texts& texts, std::string_view separator) {
  std::string result;
  bool first = true;
  for (const std::string& text : texts) {
    if (!first) {
      result += separator;
    }
    result += text;
    first = false;
  }
  return result;
}

/// How many letters must be put in, left out, replaced or exchanged with the next one to make `b` of `a`.
[[nodiscard]] inline std::size_t letters_between(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      cost[i][j] = std::min(
          {cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
      }
    }
  }
  return cost.back().back();
}

/// Returns how an error about an unknown name ends: "did you mean target?", or `otherwise` where no name of
/// `known` is near; at most a third of the letters may differ.
template <typename Names>
[[nodiscard]] std::string did_you_mean(std::string_view name, const Names& known,
                                       const std::string& otherwise) {
  std::string_view nearest;
  std::size_t least = std::max<std::size_t>(name.size() / 3, 1) + 1;
  for (const std::string_view candidate : known) {
    if (const std::size_t distance = letters_between(name, candidate); distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest.empty() ? otherwise : "did you mean " + std::string(nearest) + "?";
}

} // namespace hdmbench
