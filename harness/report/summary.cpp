// What a run comes to on one screen: the numbers below the verdict, and the text for a terminal.

#include "backends/shared/stopwatch.hpp"
#include "harness/report/report.hpp"
#include "harness/report/results.hpp"
#include "harness/report/table.hpp"
#include "harness/report/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace hdmbench::report {

namespace {

using nlohmann::json;

Figure comparisons_figure(const Results& results, std::string_view machine) {
  const Rows rows = rows_where(rows_of(results, "verify", machine), was_compared);
  const auto compared = std::ssize(rows);
  const auto wrong = count_where(rows, disagrees);
  const auto agree = compared - count_where(rows, [](const json& row) {
                       return disagrees(row) || text_of(row, "verdict") == "mistrusted";
                     });
  const Rows timed = rows_of(results, "bench", machine);
  if (const auto checked = count_where(timed, is_checked); compared == 0 && checked > 0) {
    return {State::good, grouped(checked),
            "timed solutions are scalar's, the plain C++ program's, to the bit"};
  }
  if (compared == 0) {
    return {State::unsure, "none", "No backend was compared with scalar."};
  }
  return {wrong > 0          ? State::bad
          : agree < compared ? State::unsure
                             : State::good,
          fmt::format("{} of {}", grouped(agree), grouped(compared)),
          "comparisons with scalar, the plain C++ program, agree"};
}

/// Those of the scene and the size of the first.
Rows like_first(const Rows& rows) {
  return rows_where(rows, [&](const json& row) {
    return text_of(row, "scene") == text_of(*rows.front(), "scene") && size_of(row) == size_of(*rows.front());
  });
}

/// The rows of `square`, which the thesis begins with, or of the first scene, at the largest size that has
/// speed-ups.
Rows headline_rows(const Results& results, std::string_view machine) {
  Rows rows = rows_of(results, "bench", machine);
  std::ranges::stable_sort(rows, std::ranges::greater(), [](const json* row) {
    return std::tuple(number_of(*row, "speed_up_over_scalar").has_value(), text_of(*row, "scene") == "square",
                      number_of(*row, "width"));
  });
  rows = rows.empty() ? rows : like_first(rows);
  const bool has_speed_ups = !rows.empty() && number_of(*rows.front(), "speed_up_over_scalar");
  return has_speed_ups ? rows : Rows();
}

/// Returns the figure of the fastest backend that disagrees nowhere, by dense work, as scalar's is.
std::optional<Figure> fastest_figure(const Results& results, std::string_view machine) {
  std::set<std::string> wrong;
  for (const json* const row : rows_where(rows_of(results, "verify", machine), disagrees)) {
    wrong.insert(text_of(*row, "backend"));
  }
  const Rows rows = rows_where(headline_rows(results, machine), [&](const json& row) {
    return number_of(row, "speed_up_over_scalar") && flag_of(row, "valid") == true &&
           text_of(row, "work") == "dense" && !wrong.contains(text_of(row, "backend"));
  });
  if (rows.empty()) {
    return std::nullopt;
  }
  const auto speed_up = [](const json* row) { return *number_of(*row, "speed_up_over_scalar"); };
  const json& best = **std::ranges::max_element(rows, {}, speed_up);
  return Figure{State::good, fmt::format("{:.3g} x", speed_up(&best)),
                fmt::format("as fast as plain C++ on one thread, doing the same: {} by {} on {}, {}",
                            text_of(best, "method"), text_of(best, "backend"), text_of(best, "scene"),
                            size_of(best))};
}

/// The fastest that comes within 0.01 px of finite elements, else the nearest: on the brain, or the first
/// scene, with the scene's own Poisson's ratio where that was tried.
std::optional<Figure> nearest_figure(const Results& results, std::string_view machine) {
  constexpr double near = 0.01;
  constexpr double far = 0.5; // half a pixel is nothing to be proud of
  Rows rows = rows_where(rows_of(results, "tradeoff", machine), [](const json& row) {
    return flag_of(row, "rival") == false && flag_of(row, "valid") == true && own_error(row) &&
           number_of(row, "seconds_median");
  });
  if (rows.empty()) {
    return std::nullopt;
  }
  std::ranges::stable_sort(rows, {}, [](const json* row) {
    return std::pair(text_of(*row, "scene") != "brain", number_of(*row, "width"));
  });
  rows = like_first(rows);
  if (const Rows own = rows_where(rows,
                                  [](const json& row) {
                                    const auto used = number_of(row, "poisson_used");
                                    return used && used == number_of(row, "poisson");
                                  });
      !own.empty()) {
    rows = own;
  }
  const json& best = **std::ranges::min_element(rows, {}, [&](const json* row) {
    return std::pair(std::max(*own_error(*row), near), *number_of(*row, "seconds_median"));
  });
  const double error = *own_error(best);
  return Figure{error > far ? State::unsure : State::good, fmt::format("{:.2g} px", error),
                fmt::format("from finite elements with Poisson's ratio {:.3g} after {}: {} by {} on {}, {}",
                            number_of(best, "poisson_used").value_or(0.0),
                            duration_text(*number_of(best, "seconds_median")), text_of(best, "method"),
                            text_of(best, "backend"), text_of(best, "scene"), size_of(best))};
}

/// The headline's rows as a table.
std::string speed_text(const Rows& rows) {
  json list = json::array();
  for (const json* const row : rows) {
    if (number_of(*row, "seconds_median").value_or(0.0) > 0.0) {
      list.push_back(*row);
    }
  }
  return list.empty()
             ? ""
             : fmt::format(
                   "\n  {}, {}, a whole solution\n{}", text_of(*rows.front(), "scene"),
                   size_of(*rows.front()),
                   table_text(list,
                              "backend|method|seconds_median:seconds|speed_up_over_scalar:over dense scalar|"
                              "reason:not verified"));
}

} // namespace

std::vector<Figure> figures_of(const Results& results, std::string_view machine) {
  std::vector<Figure> figures{comparisons_figure(results, machine)};
  for (const auto& figure : {fastest_figure(results, machine), nearest_figure(results, machine)}) {
    if (figure) {
      figures.push_back(*figure);
    }
  }
  return figures;
}

} // namespace hdmbench::report

namespace hdmbench {

std::string summary_text(std::span<const std::filesystem::path> files) {
  using namespace report;
  constexpr std::size_t most_notes = 8;
  const Results results = load_results(files);
  std::string text;
  for (const std::string& machine : machines_of(results)) {
    const Verdict verdict = verdict_of(results, machine);
    text += fmt::format("{}\n  {}\n", machine, verdict.sentence);
    for (std::size_t i = 0; i < std::min(most_notes, verdict.notes.size()); ++i) {
      text += fmt::format("  {}\n", verdict.notes[i].sentence);
    }
    if (verdict.notes.size() > most_notes) {
      text += fmt::format("  The page has {} more.\n", verdict.notes.size() - most_notes);
    }
    for (const Figure& figure : verdict.figures) {
      text += fmt::format("  {:>12}  {}\n", figure.value, figure.text);
    }
    text += speed_text(headline_rows(results, machine));
  }
  return text;
}

} // namespace hdmbench
