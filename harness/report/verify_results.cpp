#include "harness/report/verify_results.hpp"

#include "harness/report/joined.hpp"
#include "harness/report/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

namespace hdmbench::report {

namespace {

Verdict read_verdict(const JsonReader& json) {
  const std::vector<std::string> names{"agree", "certified", "disagree", "mistrusted", "skipped"};
  const std::string name = json.text("verdict", names);
  return static_cast<Verdict>(std::ranges::find(names, name) - names.begin());
}

Tier read_tier(const JsonReader& json) {
  const std::vector<std::string> names(tier_names.begin(), tier_names.end());
  return static_cast<Tier>(std::ranges::find(names, json.text("tier", names)) - names.begin());
}

// 9 digits tell any two floats apart.
std::string plain(const nlohmann::json& value) {
  if (value.is_string()) {
    return value.get<std::string>();
  }
  if (value.is_null()) {
    return "not finite";
  }
  if (value.is_number_float()) {
    return fmt::format("{:.9g}", value.get<double>());
  }
  if (!value.is_array()) {
    return value.dump();
  }
  std::vector<std::string> parts;
  std::ranges::transform(value, std::back_inserter(parts), plain);
  return fmt::format("({})", joined(parts, ", "));
}

FirstDifference read_first_difference(const JsonReader& json) {
  FirstDifference first;
  first.level = json.count("level");
  first.iteration = json.count("iteration");
  first.x = json.count("x");
  first.y = json.count("y");
  for (const auto& [key, value] : json.json().items()) {
    if (key != "level" && key != "iteration" && key != "x" && key != "y") {
      std::string name = key;
      std::ranges::replace(name, '_', ' ');
      first.more += (first.more.empty() ? "" : ", ") + name + ' ' + plain(value);
    }
  }
  return first;
}

} // namespace

VerifyRow read_verify(const JsonReader& json) {
  VerifyRow row;
  row.scene = json.text("scene");
  row.width = json.count("width");
  row.height = json.count("height");
  row.backend = json.text("backend");
  row.device = json.text("device");
  row.method = json.has("method") ? json.text("method") : "";
  row.mode = json.text("mode", {"resync", "free", "active", "pyramid", "windows"});
  row.levels = json.count("levels");
  row.iterations = json.count("iterations");
  row.sites_compared = json.count("sites_compared");
  row.sites_differing = json.count("sites_differing");
  row.certified_ties = json.count("certified_ties");
  row.uncertified = json.count("uncertified");
  row.not_finite = json.has("not_finite") ? json.count("not_finite") : 0;
  row.counts_differing = json.has("counts_differing") ? json.count("counts_differing") : 0;
  row.max_abs_difference = json.number_or_null("max_abs_difference");
  if (const auto first = json.object_or_null("first_difference")) {
    row.first_difference = read_first_difference(*first);
  }
  row.tier = read_tier(json);
  row.verdict = read_verdict(json);
  row.reason = json.text("reason");

  const bool passes = row.verdict == Verdict::agree || row.verdict == Verdict::certified;
  if (passes && row.sites_compared == 0) {
    json.fail("verdict", "is a pass although no site was compared");
  }
  if (row.verdict == Verdict::agree && row.sites_differing > 0) {
    json.fail("verdict", fmt::format("is \"agree\" although {} sites differ", row.sites_differing));
  }
  if (passes && row.counts_differing > 0) {
    json.fail("verdict",
              fmt::format("is a pass although {} counts of changed sites differ", row.counts_differing));
  }
  if (passes && row.uncertified > 0) {
    json.fail("verdict",
              fmt::format("is a pass although {} differing sites are uncertified", row.uncertified));
  }
  if (passes != (row.tier != Tier::none) ||
      (row.verdict == Verdict::certified) != (row.tier == Tier::certified)) {
    json.fail("tier", fmt::format("is \"{}\", which the verdict contradicts",
                                  tier_names[static_cast<std::size_t>(row.tier)]));
  }
  return row;
}

} // namespace hdmbench::report
