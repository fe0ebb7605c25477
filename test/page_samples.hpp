#pragma once

#include "harness/report/report.hpp"
#include "harness/report/verdict.hpp"
#include "test/files.hpp"
#include "test/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <string>

/// Result files with invented figures, and the page of them.
namespace hdmbench::page_samples {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Path = std::filesystem::path;

inline json verify_row(const std::string& backend, const json& changes = json::object()) {
  json row = {{"scene", "square"}, {"width", 300},          {"height", 300},        {"backend", backend},
              {"device", "cpu"},   {"mode", "resync"},      {"method", "icm"},      {"verdict", "agree"},
              {"tier", "bitwise"}, {"sites_compared", 100}, {"sites_differing", 0}, {"reason", ""}};
  row.update(changes);
  return row;
}

inline json bench_row(const std::string& backend, int width, double seconds, double speed_up) {
  return {{"scene", "square"}, {"width", width},  {"height", width},      {"backend", backend},
          {"device", ""},      {"method", "icm"}, {"valid", true},        {"seconds_median", seconds},
          {"reason", ""},      {"work", "dense"}, {"seconds", {seconds}}, {"speed_up_over_scalar", speed_up}};
}

inline json point(const std::string& method, double seconds, double error,
                  const json& changes = json::object()) {
  json row = {{"kind", "point"},
              {"scene", "square"},
              {"width", 300},
              {"height", 300},
              {"method", method},
              {"backend", "openmp"},
              {"effort", "usual"},
              {"rival", false},
              {"status", "ok"},
              {"valid", true},
              {"reason", ""},
              {"seconds_median", seconds},
              {"poisson_used", 0.0},
              {"rmsd_to_fem_nu0", error},
              {"command", "hdmbench run"}};
  row.update(changes);
  return row;
}

class Page : public testing::Test {
protected:
  Path write(const std::string& name, const std::string& command, const json& rows,
             const json& context = json::object()) {
    json where = {{"machine", "a machine"},
                  {"cpu", "cpu"},
                  {"cores", 2},
                  {"architecture", "x86_64"},
                  {"operating_system", "Debian"},
                  {"compiler", "GNU"},
                  {"flags", "-O3"},
                  {"commit", "abc"},
                  {"version", "0.1.0"},
                  {"date", "2026-11-23T01:02:03Z"},
                  {"arguments", command},
                  {"quick", false}};
    where.update(context);
    return folder_.write(
        name, json{{"schema", 1}, {"command", command}, {"context", where}, {"results", rows}}.dump());
  }
  [[nodiscard]] Path folder() const { return folder_.path(); }
  [[nodiscard]] Path page() const { return folder() / "page.html"; }
  void make() { write_report(std::array{folder()}, page()); }
  [[nodiscard]] report::Verdict verdict() const {
    return report::verdict_of(report::load_results(std::array{folder()}), "");
  }

  test::TemporaryFolder folder_;
};

} // namespace hdmbench::page_samples
