#pragma once

#include "harness/report/report.hpp"
#include "kernels/data/input_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

/// Result files with invented figures for the tests of the report.
namespace hdmbench::report_samples {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Path = std::filesystem::path;

inline json context(const std::string& machine = "bench-1",
                    const std::string& date = "2026-11-21T01:02:03Z") {
  json result = json::parse(R"({"cpu": "Test CPU", "cores": 2, "operating_system": "Debian 12",
    "compiler": "GNU 12.2.0", "flags": "-O3", "commit": "abc1234", "version": "0.1.0",
    "arguments": "verify square --size 300", "quick": false})");
  result.update({{"machine", machine}, {"date", date}});
  return result;
}

inline json document(const std::string& command, json results, json where = context()) {
  return {
      {"schema", 1}, {"command", command}, {"context", std::move(where)}, {"results", std::move(results)}};
}

/// An array, also of one row, which braces alone would not make.
template <typename... Rows>
json rows(Rows... row) {
  json result = json::array();
  (result.push_back(std::move(row)), ...);
  return result;
}

inline json verify_row(const std::string& backend, const std::string& mode,
                       const std::string& scene = "square") {
  json row =
      json::parse(R"({"width": 300, "height": 300, "device": "llvmpipe", "levels": 10, "iterations": 500,
    "sites_compared": 1234567, "sites_differing": 0, "certified_ties": 0, "uncertified": 0,
    "max_abs_difference": 0.0, "first_difference": null, "tier": "bitwise", "verdict": "agree", "reason": ""})");
  row.update({{"backend", backend}, {"mode", mode}, {"scene", scene}});
  return row;
}

inline json disagreeing(json row) {
  row.update(
      json::parse(R"({"sites_differing": 7, "uncertified": 7, "max_abs_difference": 0.1, "tier": "none",
    "verdict": "disagree", "first_difference": {"level": 2, "iteration": 17, "x": 3, "y": 4}})"));
  return row;
}

inline json skipped(json row, const std::string& reason) {
  row.update(json::parse(R"({"device": "", "sites_compared": 0, "tier": "none", "verdict": "skipped"})"));
  row["reason"] = reason;
  return row;
}

inline json agreeing_rows() {
  return {verify_row("openmp", "resync"), verify_row("openmp", "free"), verify_row("gl-fragment", "resync"),
          verify_row("gl-fragment", "free")};
}

inline json bench_row(const std::string& backend, const std::string& scene, int size, double median,
                      double speed_up) {
  json row =
      json::parse(R"({"device": "llvmpipe", "method": "icm", "iterations": 500, "msites_per_second": 40.0,
    "setup_seconds": 0.1, "projection_seconds": 0.01, "upload_seconds": 0.01, "compute_seconds": 0.1,
    "readback_seconds": 0.01, "valid": true, "reason": ""})");
  row.update({{"backend", backend}, {"scene", scene}, {"width", size}, {"height", size}});
  row["seconds"] = {median * 0.9, median, median * 1.1};
  row["seconds_median"] = median;
  row["speed_up_over_scalar"] = speed_up;
  return row;
}

inline json device_row(const std::string& backend, bool available, const std::string& reason = "") {
  json row = json::parse(R"({"description": "a backend", "software": true, "updates": ["simultaneous"]})");
  row.update({{"backend", backend}, {"available", available}, {"reason", reason}});
  row["device"] = available ? "llvmpipe" : "";
  row["driver"] = available ? "Mesa 22.3.6" : "";
  return row;
}

inline json run_row() {
  return json::parse(R"({"scene": "square", "title": "Square", "width": 2, "height": 1, "backend": "openmp",
    "device": "llvmpipe", "method": "icm", "seconds": 0.5, "levels": 10, "iterations": 500, "mean_energy": 0.0035,
    "largest_displacement": 50.0, "spacing": 0.5, "field": "square.nrrd", "pictures": {}})");
}

/// A folder of its own for result files and the page.
class ReportFolder : public testing::Test {
protected:
  void SetUp() override {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = Path(testing::TempDir()) / ("hdmbench-report-" + std::to_string(getpid()) + "-" + test->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Path write(const std::string& name, const json& content) { return write_text(name, content.dump()); }
  Path write_text(const std::string& name, const std::string& content) {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  std::string render_files(const std::vector<Path>& results) {
    const Path page = folder_ / "page.html";
    write_report(results, page);
    std::ifstream stream(page, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::string render(const json& content) { return render_files({write("results.json", content)}); }

  std::string error_of_files(const std::vector<Path>& results) {
    try {
      write_report(results, folder_ / "page.html");
    } catch (const InputError& error) {
      EXPECT_FALSE(std::filesystem::exists(folder_ / "page.html"));
      return error.what();
    }
    return "no error";
  }
  std::string error_of(const json& content) { return error_of_files({write("results.json", content)}); }

  // The text of the box at the top of the page.
  static std::string verdict(const std::string& page) {
    const std::size_t start = page.find("<div class=\"verdict");
    return page.substr(start, page.find("</div>", start) - start);
  }

  Path folder_;
};

/// A value that is wrong in a good row, and what the refusal says.
struct Wrong {
  std::string where; ///< JSON pointer: "/points/0/failed"
  json value;
  std::string error;
};

/// The key is not there.
inline const json missing(json::value_t::discarded);

/// Of one command, with a row that is good.
class RowsReport : public ReportFolder {
protected:
  RowsReport(std::string command, json good) : command_(std::move(command)), good_(std::move(good)) {}

  std::string page_of(const json& results) {
    return render(document(command_, results.is_object() ? rows(results) : results));
  }

  void expect_refused(const std::vector<Wrong>& values) {
    for (const Wrong& wrong : values) {
      const json::json_pointer where(wrong.where);
      json row = good_;
      if (wrong.value.is_discarded()) {
        row.at(where.parent_pointer()).erase(where.back());
      } else {
        row[where] = wrong.value;
      }
      EXPECT_THAT(error_of(document(command_, rows(row))), HasSubstr(wrong.error)) << wrong.where;
    }
  }

private:
  std::string command_;
  json good_;
};

inline std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) {
    ++count;
  }
  return count;
}

} // namespace hdmbench::report_samples
