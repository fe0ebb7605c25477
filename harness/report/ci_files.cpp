#include "harness/report/ci_files.hpp"

#include "harness/report/html.hpp"
#include "harness/report/results.hpp"
#include "harness/scene/files.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace hdmbench::report {

/// "300x300"
static std::string short_size(const nlohmann::json& row) {
  std::string size = size_of(row);
  std::erase(size, ' ');
  return size;
}

namespace {

struct JunitCase {
  std::string class_name;
  std::string name;
  std::string skipped{}; ///< why; empty: it was not
  std::string failure{}; ///< likewise
  std::string details{}; ///< of a failure, line by line
  double seconds = 0.0;  ///< 0: not known
};

template <typename CaseOf>
void write_cases(const std::filesystem::path& file, std::string_view command, const nlohmann::json& rows,
                 const CaseOf& case_of) {
  if (file.empty()) {
    return;
  }
  std::string cases;
  int failures = 0;
  int skipped = 0;
  for (const nlohmann::json& row : rows) {
    const JunitCase one = case_of(row);
    cases +=
        fmt::format(R"(  <testcase classname="{}" name="{}"{}>)", escape(one.class_name), escape(one.name),
                    one.seconds > 0.0 ? fmt::format(" time=\"{:.3f}\"", one.seconds) : "");
    if (!one.skipped.empty()) {
      ++skipped;
      cases += fmt::format(R"(<skipped message="{}"/>)", escape(one.skipped));
    } else if (!one.failure.empty()) {
      ++failures;
      cases += fmt::format(R"(<failure message="{}">{}</failure>)", escape(one.failure), escape(one.details));
    }
    cases += "</testcase>\n";
  }
  write_text(file, fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n <testsuite "
                               "name=\"hdmbench {}\" tests=\"{}\" failures=\"{}\" "
                               "skipped=\"{}\">\n{} </testsuite>\n</testsuites>\n",
                               command, rows.size(), failures, skipped, cases));
}

} // namespace

/// Device, driver, first difference, why, where --dump wrote the step, and the command line that repeats it.
static std::string details_of_difference(const nlohmann::json& row) {
  std::string details =
      fmt::format("device: {}\ndriver: {}\n", text_of(row, "device"), text_of(row, "driver"));
  if (const auto first = row.find("first_difference"); first != row.end() && first->is_object()) {
    details += fmt::format("first: {}\n", text_of(*first, "text"));
  }
  if (const std::string why = text_of(row, "why"); !why.empty()) {
    details += fmt::format("why: {}\n", why);
  }
  if (const std::string dump = text_of(row, "dump"); !dump.empty()) {
    details += fmt::format("the step as a program: {}\n", dump);
  }
  return details + "repeat: " + text_of(row, "repeat");
}

void write_junit(const std::filesystem::path& file, const nlohmann::json& rows) {
  write_cases(file, "verify", rows, [](const nlohmann::json& row) {
    const std::string verdict = text_of(row, "verdict");
    const std::string reason = text_of(row, "reason");
    JunitCase one{.class_name =
                      fmt::format("{}.{}.{}", text_of(row, "scene"), short_size(row), text_of(row, "method")),
                  .name = fmt::format("{} {}", text_of(row, "backend"), text_of(row, "mode")),
                  .seconds = row.value("wall_seconds", 0.0)};
    if (verdict == "skipped") {
      one.skipped = reason.empty() ? verdict : reason;
    } else if (verdict != "agree" && verdict != "certified") {
      one.failure = fmt::format("{}: {} sites differ, {} counts are wrong. {}", verdict,
                                row.value("sites_differing", 0L), row.value("counts_differing", 0L), reason);
      one.details = details_of_difference(row);
    }
    return one;
  });
}

void write_junit_of_machine_code(const std::filesystem::path& file, const nlohmann::json& rows) {
  write_cases(file, "machine-code", rows, [](const nlohmann::json& row) {
    const std::string verdict = text_of(row, "verdict");
    JunitCase one{.class_name = fmt::format("{}.{}", text_of(row, "target"), text_of(row, "text")),
                  .name = fmt::format("{}, {} axes", text_of(row, "kernel"), row.value("axes", 0))};
    if (verdict == "not there") {
      one.skipped = text_of(row, "reason");
    } else if (verdict != "no fused operation") {
      one.failure = fmt::format("{}: {}", verdict, text_of(row, "reason"));
      for (const nlohmann::json& line : row["fused_lines"]) {
        one.failure += line.get<std::string>() + "; ";
      }
      one.details = fmt::format("hdmbench machine-code --targets {}", text_of(row, "target"));
    }
    return one;
  });
}

} // namespace hdmbench::report
