// The page that tests a GPU, in a real browser: headless Chromium, whose WebGL runs on SwiftShader here.

#include "test/chromium.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

using nlohmann::json;

/// A page, and the browser's answers to it.
class Browser : public test::Chromium {
protected:
  void write_page(const std::string& arguments) {
    test::expect_run(0, "browser " + arguments + " --output " + page().string());
  }

  /// The document after all is done. `wishes` stand after # in the address.
  std::string document(const std::string& wishes) {
    return Chromium::document(page().string() + "#" + wishes, 600000,
                              {"--use-angle=swiftshader", "--enable-unsafe-swiftshader"});
  }

  /// What the page would save.
  json results(const std::string& wishes = "") {
    const std::string text = document(wishes);
    const std::string mark = "id=\"results\">";
    const auto begin = text.find(mark);
    const auto end = text.find("</script>", begin);
    EXPECT_NE(end, std::string::npos) << text.substr(0, 2000);
    return json::parse(text.substr(begin + mark.size(), end - begin - mark.size()));
  }
};

TEST_F(Browser, HasScalarsBitsAfterEverySweep) {
  write_page("exact-textures tie-rich --size 32");
  const json found = results();
  ASSERT_EQ(found["results"].size(), 4U);
  for (const json& row : found["results"]) {
    EXPECT_EQ(row["verdict"], "agree") << row.dump();
    EXPECT_EQ(row["tier"], row["scene"] == "tie-rich" ? "bitwise" : "exact");
    EXPECT_EQ(row["sites_differing"], 0);
    EXPECT_GE(row["sites_compared"], 32 * 32 * row["sweeps"].get<int>() / row["levels"].get<int>());
  }
  // As many sweeps as verify does, and a report that takes the page's results for what they are.
  const auto verified = folder() / "verified.json";
  ASSERT_EQ(test::hdmbench("verify tie-rich --size 32 --backends openmp --json " + verified.string()).status,
            0);
  const json rows = json::parse(file_text(verified))["results"];
  EXPECT_EQ(found["results"].back()["sites_compared"], rows[0]["sites_compared"]);
  std::ofstream(folder() / "browser.json") << found;
  const test::Outcome report = test::hdmbench("report " + (folder() / "browser.json").string() +
                                              " --output " + (folder() / "report.html").string());
  EXPECT_EQ(report.status, 0) << report.output;
  EXPECT_THAT(file_text(folder() / "report.html"), HasSubstr("webgl-fragment"));
}

TEST_F(Browser, SeesAPlantedFault) {
  write_page("tie-rich --size 32");
  const json row = results("plant=tie")["results"][0];
  EXPECT_EQ(row["verdict"], "disagree");
  EXPECT_GT(row["sites_differing"], 0);
  EXPECT_TRUE(row["first_difference"].is_object());
  EXPECT_THAT(document("plant=tie"), HasSubstr("class=\"verdict bad\""));
}

TEST_F(Browser, SaysWhatABrowserLacks) {
  write_page("tie-rich --size 8");
  const std::string text = document("missing=EXT_color_buffer_float");
  EXPECT_THAT(text, HasSubstr("Nothing can be compared: this browser cannot draw into float textures"));
  EXPECT_THAT(text, HasSubstr("class=\"verdict unsure\""));
}

} // namespace
} // namespace hdmbench
