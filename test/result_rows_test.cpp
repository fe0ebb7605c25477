// Rows of result files: what is read back is written again without losing a key, and what is wrong is refused
// by file, row and key.

#include "harness/check/verify.hpp"
#include "harness/measure/result_file.hpp"
#include "test/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

struct SampleRow {
  bool flag = false;
  int count = 0;
  float number = 0.0F;
  std::string text{};
  Tier tier = Tier::none;
  std::optional<double> maybe{};
  std::vector<double> gaps{};
  std::array<int, 2> pair{};
  std::vector<SampleRow> nested{};
  int newer = 7;
  std::string any{};
};

static void list_fields(Fields& fields, SampleRow& row) {
  fields("flag", row.flag);
  fields("count", row.count);
  fields("number", row.number);
  fields("text", row.text);
  fields("tier", row.tier);
  fields("maybe", row.maybe);
  fields("gaps", NullIsNan{row.gaps});
  fields("pair", row.pair);
  fields("nested", row.nested);
  fields.newer("newer", row.newer);
  fields.if_any("any", row.any);
}

static void require_consistent(const SampleRow& row) {
  if (row.text == "wrong") {
    throw Contradiction{"text", "is wrong"};
  }
}

namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Whether `after` has all that `before` has.
bool keeps(const json& after, const json& before) {
  json both = after;
  both.update(before, true);
  return both == after;
}

json sample() {
  return json::parse(R"({"flag": true, "count": 3, "number": 0.5, "text": "t", "tier": "exact", "maybe": null,
    "gaps": [1.0, null], "pair": [1, 2], "nested": []})");
}

std::string error_of(const json& row) {
  SampleRow read;
  return test::refusal([&] { read_json_row(row, {"a.json", "results[4]"}, read); });
}

std::string error_with(const char* key, json value) {
  json row = sample();
  row[key] = std::move(value);
  return error_of(row);
}

TEST(ResultRows, AreReadAsTheyAreWritten) {
  SampleRow read;
  read_json_row(sample(), {"a.json", ""}, read);
  EXPECT_EQ(read.tier, Tier::exact);
  EXPECT_TRUE(std::isnan(read.gaps.at(1)));
  EXPECT_EQ(read.newer, 7) << "a file of before keeps what it was";
  json again = to_json_row(read);
  EXPECT_FALSE(again.contains("any"));
  EXPECT_EQ(again["newer"], 7);
  EXPECT_TRUE(keeps(json::parse(again.dump()), sample()));
  EXPECT_FALSE(keeps(sample(), again));
}

TEST(ResultRows, WhatIsWrongIsRefusedByFileAndKey) {
  EXPECT_EQ(error_of(sample()), "accepted");
  const json complete = sample();
  for (const auto& [key, value] : complete.items()) {
    json missing = sample();
    missing.erase(key);
    EXPECT_EQ(error_of(missing), "a.json: \"results[4]." + key + "\" is missing");
    EXPECT_THAT(error_with(key.c_str(), json::object()),
                HasSubstr("a.json: \"results[4]." + key + "\" must be"));
  }
  EXPECT_THAT(error_of(json::array()), HasSubstr("\"results[4]\" must be an object, but is array"));
  EXPECT_THAT(error_with("count", -1), HasSubstr("must be an integer of 0 ... 2147483647, but is -1"));
  EXPECT_THAT(error_with("count", 1e3), HasSubstr("must be an integer of 0 ... 2147483647, but is 1000.0"));
  EXPECT_THAT(error_with("count", 3000000000),
              HasSubstr("must be an integer of 0 ... 2147483647, but is 3000000000"));
  EXPECT_THAT(error_with("tier", "strong"), HasSubstr("must be one of none, certified"));
  EXPECT_THAT(error_with("pair", {1, 2, 3}), HasSubstr("must have 2 values, but has 3"));
  EXPECT_THAT(error_with("newer", "soon"), HasSubstr("results[4].newer\" must be an integer"));
  EXPECT_THAT(error_with("text", "wrong"), HasSubstr("results[4].text\" is wrong"));
  json nested = sample();
  nested["text"] = "wrong";
  EXPECT_THAT(error_with("nested", {sample(), nested}), HasSubstr("results[4].nested[1].text\" is wrong"));
}

} // namespace
} // namespace hdmbench
