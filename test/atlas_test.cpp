#include "harness/judge/atlas/atlas.hpp"
#include "test/sessions.hpp"

#include <toml++/toml.h>

namespace hdmbench::atlas {
namespace {

using test::scalar;

EntryResult run_quickly(const Entry& entry) {
  return run_entry(entry, scalar(), true, test::silent());
}

/// Each entry is run once for all tests.
const EntryResult& result_of(std::string_view name) {
  static std::map<std::string_view, EntryResult> results;
  if (!results.contains(name)) {
    results.emplace(name, run_quickly(find_entry(name)));
  }
  return results.at(name);
}

/// Between which of the quick knobs a series begins to fail, as atlas_pins.toml says.
struct Pinned {
  std::string entry;
  std::string series;
  double good;
  double failed;
  double healthy_error; ///< at most, at the first knob
  double harmful_error; ///< at least, at the last one
};

/// What of it does not hold, empty if all does.
std::string mismatch(const Pinned& pinned, const EntryResult& result) {
  const auto series = std::ranges::find(result.series, pinned.series, &SeriesResult::name);
  if (series == result.series.end() || series->points.empty()) {
    return "there is no such series";
  }
  const auto same = [](double wanted, const std::optional<double>& found) {
    return std::isnan(wanted) ? !found : found == wanted;
  };
  const double last_error = series->points.back().error.value_or(HUGE_VAL);
  if (!same(pinned.failed, series->first_failed) ||
      (!std::isnan(pinned.failed) && !same(pinned.good, series->last_good))) {
    return fmt::format("fails at {} and not at {}", series->first_failed.value_or(NAN),
                       series->last_good.value_or(NAN));
  }
  if (!(series->points.front().error.value_or(HUGE_VAL) <= pinned.healthy_error)) {
    return fmt::format("error {} at the healthy end", series->points.front().error.value_or(NAN));
  }
  return last_error >= pinned.harmful_error ? "" : fmt::format("error {} at the harmful end", last_error);
}

std::vector<Pinned> read_pins() {
  std::vector<Pinned> pins;
  static const toml::table file = toml::parse_file(HDMBENCH_SOURCE "/test/atlas_pins.toml");
  for (const auto& row : *file["pins"].as_array()) {
    const toml::array& one = *row.as_array();
    const auto number = [&](std::size_t i) { return one[i].value<double>().value(); };
    pins.push_back({one[0].value<std::string>().value(), one[1].value<std::string>().value(), number(2),
                    number(3), number(4), number(5)});
  }
  return pins;
}
const std::vector<Pinned> pins = read_pins();

TEST(Atlas, EveryEntryIsPinned) {
  for (const Entry& entry : entries()) {
    EXPECT_TRUE(std::ranges::any_of(pins, [&](const Pinned& pinned) { return pinned.entry == entry.name; }) ||
                entry.name == "undetermined")
        << entry.name;
  }
}

/// The last value of the knob has no answer, and no method gives one.
TEST(Atlas, WhatNothingHoldsIsRefusedByEveryElasticMethod) {
  for (const auto& [entry, refusal] :
       {std::pair{"elastic-supports",
                  "at 1: the conditions leave the elastic sheet free to move: all 96 x 96 "
                  "sites can turn about"},
        std::pair{"elastic-free-body",
                  "at 1e-08: no condition holds a part of the tissue, 1089 pixels at x = "
                  "32 ... 64, y = 32 ... 64"}}) {
    const EntryResult& result = result_of(entry);
    for (const SeriesResult& series : result.series) {
      EXPECT_EQ(series.points.size() + 1, result.entry->quick_knobs.size()) << entry << ", " << series.name;
      EXPECT_TRUE(series.absence.starts_with(refusal))
          << entry << ", " << series.name << ": " << series.absence;
    }
  }
}

TEST(Atlas, WithoutAnyConditionTheStartComesOut) {
  for (const SeriesResult& series : result_of("undetermined").series) {
    if (series.absence.empty()) {
      EXPECT_LE(*series.points.front().error, 0.5) << series.name;
      EXPECT_FLOAT_EQ(static_cast<float>(*series.points.back().error), 10.0F) << series.name;
    }
  }
}

// What is beyond the target range is computed again; a little growth is not.
TEST(Atlas, OverRelaxationWithoutColoursIsNeverBetterThanBelowOne) {
  const SeriesResult& all_at_once = result_of("oscillation").series.front();
  ASSERT_EQ(all_at_once.name, "all at once");
  EXPECT_TRUE(all_at_once.points[1].failed) << "factor 1.02";
  EXPECT_GT(all_at_once.points[2].error.value_or(HUGE_VAL), *all_at_once.points[0].error) << "factor 1.1";
}

/// One test, as every test is a process of its own and the entries take seconds.
TEST(Atlas, EveryEntryFailsWhereItIsPinnedAndWarnedOf) {
  for (const Pinned& pinned : pins) {
    EXPECT_EQ(mismatch(pinned, result_of(pinned.entry)), "") << pinned.entry << ", " << pinned.series;
  }
  for (const Entry& entry : entries()) {
    const auto is_its_own = [&](std::string_view kind) {
      return std::ranges::find(entry.warnings, kind) != entry.warnings.end();
    };
    for (const SeriesResult& series : result_of(entry.name).series) {
      const bool is_truth = series.name == fixed_point_method || series.name == finite_elements_method;
      for (const Point& point : series.points) {
        EXPECT_TRUE(std::ranges::any_of(point.warnings, is_its_own) || !point.failed || is_truth ||
                    entry.warnings.empty())
            << entry.name << ", " << series.name << " at " << point.knob;
      }
      if (series.points.empty() || series.points.front().failed) {
        continue;
      }
      for (const std::string& kind : series.points.front().warnings) {
        // Both state how far the field may still be from the fixed point, from a tenth of a pixel on, which
        // icm leaves at the healthy end too.
        const bool is_estimate = kind == "stalled" || kind == "still-moving";
        EXPECT_TRUE(is_estimate || !is_its_own(kind)) << entry.name << ", " << series.name << ": " << kind;
      }
    }
  }
}

TEST(Atlas, AMethodThatIgnoresTheKnobIsNoticed) {
  for (const std::string_view name : {"start-level-late", "two-cycles", "step-quantum"}) {
    Entry faulty = find_entry(name);
    std::erase_if(faulty.series, [](const Series& series) { return series.name != "icm"; });
    faulty.series.front().adjust.clear();
    if (name == "two-cycles") {
      faulty.problem = {"fixed point", "rough start of 2 px"};
    }
    const EntryResult result = run_quickly(faulty);
    for (const Pinned& pinned : pins) {
      if (pinned.entry == name && pinned.series == "icm") {
        EXPECT_NE(mismatch(pinned, result), "") << name;
      }
    }
  }
}

} // namespace
} // namespace hdmbench::atlas
