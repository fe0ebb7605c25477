#pragma once

#include "backends/shared/subprocess.hpp"
#include "test/files.hpp"

#include <exception>

namespace hdmbench::test {

/// Headless Chromium; a test is skipped where it does not start.
class Chromium : public testing::Test {
protected:
  void SetUp() override {
    try {
      if (!run_process({"chromium", "--version"}, output(), errors(), {.seconds = 60.0}).good()) {
        GTEST_SKIP() << "chromium does not start: " << file_text(errors());
      }
    } catch (const std::exception& error) {
      GTEST_SKIP() << error.what();
    }
  }

  /// The document at an address after `milliseconds` of the page's own time.
  std::string document(const std::string& address, int milliseconds, std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"chromium", "--headless", "--no-sandbox", "--window-size=1000,800"});
    options.insert(options.end(),
                   {"--virtual-time-budget=" + std::to_string(milliseconds),
                    "--user-data-dir=" + (folder() / "profile").string(), "--dump-dom", "file://" + address});
    const ProcessEnd end = run_process(options, output(), errors(),
                                       {.environment = {{"HOME", folder().string()}}, .seconds = 200.0});
    EXPECT_TRUE(end.good()) << end.text() << file_text(errors());
    return file_text(output());
  }

  [[nodiscard]] std::filesystem::path folder() const { return folder_.path(); }
  [[nodiscard]] std::filesystem::path page() const { return folder() / "page.html"; }

  TemporaryFolder folder_;

private:
  [[nodiscard]] std::filesystem::path output() const { return folder() / "output"; }
  [[nodiscard]] std::filesystem::path errors() const { return folder() / "errors"; }
};

} // namespace hdmbench::test
