#include "test/report_samples.hpp"

#include <array>
#include <cstdlib>
#include <string>
#include <utility>

namespace hdmbench {
namespace {

using namespace report_samples;

class ReportInput : public ReportFolder {};

// Sets PATH for as long as it lives.
class PathVariable {
public:
  explicit PathVariable(const Path& value) {
    const char* const before = std::getenv("PATH");
    before_ = before == nullptr ? "" : before;
    setenv("PATH", value.c_str(), 1);
  }
  PathVariable(const PathVariable&) = delete;
  PathVariable& operator=(const PathVariable&) = delete;
  ~PathVariable() { setenv("PATH", before_.c_str(), 1); }

private:
  std::string before_;
};

TEST_F(ReportInput, EveryKeyIsRequired) {
  const std::array<std::pair<const char*, json>, 4> samples{
      {{"verify", verify_row("openmp", "free")},
       {"bench", bench_row("openmp", "square", 300, 1.0, 2.0)},
       {"run", run_row()},
       {"devices", device_row("openmp", true)}}};
  for (const auto& [command, row] : samples) {
    for (const auto& [key, value] : row.items()) {
      json mistyped = row;
      mistyped[key] = json::array({json::object()}); // the type of no key
      const std::string type_error = error_of(document(command, rows(row, mistyped)));
      EXPECT_THAT(type_error, HasSubstr("results.json: \"results[1]." + key + "\" must be"));
      if (key == "field" || key == "pictures") {
        continue; // a build without images writes none
      }
      json missing = row;
      missing.erase(key);
      const std::string error = error_of(document(command, rows(row, missing)));
      EXPECT_THAT(error, HasSubstr("results.json: \"results[1]." + key + "\" is missing"));
    }
  }
  const json complete = context();
  for (const auto& [key, value] : complete.items()) {
    json missing = complete;
    missing.erase(key);
    const std::string error = error_of(document("verify", json::array(), missing));
    EXPECT_THAT(error, HasSubstr("\"context." + key + "\" is missing"));
  }
}

TEST_F(ReportInput, RefusesWhatIsNotAResultFile) {
  EXPECT_THAT(error_of_files({folder_ / "gone.json"}), HasSubstr("gone.json: there is no such file"));
  EXPECT_THAT(error_of_files({write_text("a.json", "{\"schema\": 1")}), HasSubstr("a.json: is not JSON"));
  EXPECT_THAT(error_of(json::array()), HasSubstr("results.json: the document must be an object"));
  json other = document("verify", agreeing_rows());
  other["schema"] = 2;
  EXPECT_THAT(error_of(other), HasSubstr("is 2, but this program reads schema 1"));
  constexpr std::size_t depth = 100000; // enough to end the stack of whoever walks through it by recursion
  const Path deep =
      write_text("deep.json", "{\"results\": " + std::string(depth, '[') + std::string(depth, ']') + "}");
  EXPECT_THAT(error_of_files({deep}), HasSubstr("deep in each other"));
  EXPECT_THAT(error_of_files({}), HasSubstr("no result files"));
  std::filesystem::create_directory(folder_ / "empty");
  EXPECT_THAT(error_of_files({folder_ / "empty"}), HasSubstr("has no *.json file"));
}

TEST_F(ReportInput, RefusesRowsThatContradictThemselves) {
  json row = verify_row("openmp", "free");
  row["sites_differing"] = 1;
  EXPECT_THAT(error_of(document("verify", rows(row))), HasSubstr("\"agree\" although 1 sites differ"));
  row = verify_row("openmp", "free");
  row["sites_compared"] = 0;
  EXPECT_THAT(error_of(document("verify", rows(row))), HasSubstr("although no site was compared"));
  row.update({{"sites_compared", 9}, {"verdict", "certified"}, {"uncertified", 1}});
  EXPECT_THAT(error_of(document("verify", rows(row))), HasSubstr("1 differing sites are uncertified"));
  row = verify_row("openmp", "free");
  row["counts_differing"] = 2;
  EXPECT_THAT(error_of(document("verify", rows(row))), HasSubstr("2 counts of changed sites differ"));
  row = verify_row("openmp", "free");
  row["tier"] = "none";
  EXPECT_THAT(error_of(document("verify", rows(row))), HasSubstr("which the verdict contradicts"));
  json bench = bench_row("openmp", "square", 300, 1.0, 2.0);
  bench["seconds_median"] = 5.0;
  EXPECT_THAT(error_of(document("bench", rows(bench))), HasSubstr("seconds_median"));
  bench["seconds"] = json::array();
  EXPECT_THAT(error_of(document("bench", rows(bench))), HasSubstr("there are no seconds"));
}

TEST_F(ReportInput, SaysThatGnuplotIsMissing) {
  const Path results = write("b.json", document("bench", rows(bench_row("openmp", "square", 300, 1.0, 2.0))));
  const PathVariable nowhere(folder_ / "empty");
  const std::string error = error_of_files({results});
  EXPECT_THAT(error, HasSubstr("gnuplot"));
  EXPECT_THAT(error, HasSubstr("gnuplot-nox"));
}

TEST_F(ReportInput, PassesOnWhatGnuplotSays) {
  const Path results = write("b.json", document("bench", rows(bench_row("openmp", "square", 300, 1.0, 2.0))));
  const Path fake = write_text("gnuplot", "#!/bin/sh\necho '<svg></svg>'\necho 'out of ink' >&2\nexit 3\n");
  std::filesystem::permissions(fake, std::filesystem::perms::owner_all);
  const PathVariable only(folder_);
  const std::string error = error_of_files({results});
  EXPECT_THAT(error, HasSubstr("exit status 3"));
  EXPECT_THAT(error, HasSubstr("out of ink"));
}

TEST_F(ReportInput, NoNameReachesGnuplotAsACommand) {
  const Path mark = folder_ / "executed";
  const std::string evil = "x'\nsystem('touch " + mark.string() + "')\n`touch " + mark.string() + "`";
  json row = bench_row(evil, evil, 300, 1.0, 2.0);
  row["device"] = evil;
  EXPECT_THAT(render(document("bench", rows(row))), HasSubstr("<svg"));
  EXPECT_FALSE(std::filesystem::exists(mark));
}

} // namespace
} // namespace hdmbench
