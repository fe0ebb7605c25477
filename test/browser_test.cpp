// The page that tests a GPU, in a real browser: headless Chromium, whose WebGL and WebGPU run on SwiftShader
// here.

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
    // The page's own time passes while it waits for WebGPU, which takes none: its messages to itself hold the
    // time still.
    std::ofstream(page(), std::ios::app) << R"(<script>
const { port1, port2 } = new MessageChannel();
port1.onmessage = () => { if (!document.documentElement.dataset.done) { port2.postMessage(0); } };
port2.postMessage(0);
</script>)";
  }

  /// The document after all is done. `wishes` stand after # in the address.
  std::string document(const std::string& wishes) {
    return Chromium::document(page().string() + "#" + wishes, 600000,
                              {"--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                               "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"});
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
  ASSERT_EQ(found["results"].size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) { // two scenes by two backends in two modes
    const json& row = found["results"][i];
    EXPECT_EQ(row["backend"], i % 4 < 2 ? "webgl-fragment" : "webgpu-compute");
    EXPECT_EQ(row["verdict"], "agree") << row.dump();
    EXPECT_EQ(row["tier"], row["scene"] == "tie-rich" ? "bitwise" : "exact");
    EXPECT_EQ(row["sites_differing"], 0);
    EXPECT_GE(row["sites_compared"], 32 * 32 * row["sweeps"].get<int>() / row["levels"].get<int>());
  }
  for (const json& row : found["arithmetic"]) { // nothing is fused or reordered
    EXPECT_TRUE(row["answer"] == "as specified" ||
                row["question"].get<std::string>().starts_with("subnormal"))
        << row.dump();
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
  const std::string reported = file_text(folder() / "report.html");
  EXPECT_THAT(reported, HasSubstr("webgl-fragment"));
  EXPECT_THAT(reported, HasSubstr("webgpu-compute"));
  EXPECT_THAT(reported, HasSubstr("GLSL ES 3.00 fragment shader")) << "the passport has no table";
}

TEST_F(Browser, RunsEveryRuleByWebGpu) {
  write_page("random --methods annealing,coloured,closed-form --size 16 --iterations 4");
  const json found = results("missing=webgl2");
  ASSERT_EQ(found["results"].size(), 6U);
  for (const json& row : found["results"]) {
    EXPECT_EQ(row["backend"], "webgpu-compute");
    EXPECT_EQ(row["verdict"], "agree") << row.dump();
  }
}

TEST_F(Browser, FollowsTheStepsOfTheElasticEnergy) {
  for (const std::string scene :
       {"random --size 19x14 --iterations 2", "cube --size 5x6x5 --law neo-hookean"}) {
    const std::string what = scene + " --energy elastic";
    write_page(what);
    const json found = results();
    const auto verified = folder() / "verified.json";
    ASSERT_EQ(test::hdmbench("verify " + what + " --backends openmp --json " + verified.string()).status, 0);
    const json row_of_verify = json::parse(file_text(verified))["results"][0];
    ASSERT_EQ(found["results"].size(), 2U) << what;
    for (const json& row : found["results"]) {
      EXPECT_EQ(row["backend"], "webgpu-compute");
      EXPECT_EQ(row["verdict"], "agree") << row.dump();
      EXPECT_EQ(row["tier"], "bitwise");
      // The forces of laws on openmp are the host's own.
      const int more = row["sites_compared"].get<int>() - row_of_verify["sites_compared"].get<int>();
      EXPECT_EQ(more > 0, row["method"] == "laws of large strains") << more;
      EXPECT_GE(more, 0);
      EXPECT_EQ(row["levels"], row_of_verify["levels"]);
    }
  }
}

TEST_F(Browser, NamesTheStepOfTheElasticEnergyThatDiffers) {
  write_page("square --size 12x11 --energy elastic --law neo-hookean");
  for (const auto& [plant, step] : {std::pair{"sign", "sweep"}, {"stress", "forces of laws"}}) {
    const json found = results(std::string("plant=") + plant);
    ASSERT_EQ(found["results"].size(), 2U);
    for (const json& row : found["results"]) {
      EXPECT_EQ(row["verdict"], "disagree") << row.dump();
      EXPECT_EQ(row["first_difference"]["step"], step) << row.dump();
    }
    std::ofstream(folder() / "browser.json") << found;
  }
  test::expect_run(0,
                   "report " + (folder() / "browser.json").string() + " --output " +
                       (folder() / "report.html").string(),
                   HasSubstr("disagree with scalar: webgpu-compute on square"));
}

TEST_F(Browser, ComparesNothingWhereAllScenesNeedWebGpu) {
  write_page("random --size 9x8 --energy elastic --iterations 1");
  const std::string text = document("missing=webgpu");
  EXPECT_THAT(text, HasSubstr("class=\"verdict unsure\""));
  EXPECT_THAT(text, HasSubstr("Nothing was compared: these scenes need what this browser lacks."));
  EXPECT_THAT(text, HasSubstr("The elastic energy needs WebGPU: 1 of 1 scenes are not compared."));
}

TEST_F(Browser, HasNoPageOfMoreThanItShouldHave) {
  const std::string page = " --output " + (folder() / "page.html").string();
  test::expect_run(2, "browser ball --energy elastic" + page,
                   HasSubstr("more than 32 MB: take a smaller --size"));
  test::expect_run(2, "browser ball" + page, HasSubstr("ball is a volume"));
}

TEST_F(Browser, SeesAPlantedFault) {
  write_page("tie-rich --size 32");
  const json rows = results("plant=tie")["results"];
  ASSERT_EQ(rows.size(), 4U);
  for (const json& row : rows) {
    EXPECT_EQ(row["verdict"], "disagree") << row.dump();
    EXPECT_GT(row["sites_differing"], 0);
    EXPECT_TRUE(row["first_difference"].is_object());
  }
  EXPECT_THAT(document("plant=tie"), HasSubstr("class=\"verdict bad\""));
}

TEST_F(Browser, SeesAPlantedOrderOfASum) {
  write_page("tie-rich --size 8");
  const json rows = results("plant=order")["arithmetic"];
  ASSERT_EQ(rows.size(), 24U); // twelve questions to two programs
  for (const json& row : rows) {
    const std::string question = row["question"];
    EXPECT_GT(row["telling"], 0) << row.dump();
    if (question == "(a * b + c * d) + e") {
      EXPECT_EQ(row["answer"], "otherwise") << row.dump();
    } else if (!question.starts_with("subnormal")) { // SwiftShader flushes those
      EXPECT_EQ(row["answer"], "as specified") << row.dump();
    }
  }
}

TEST_F(Browser, NamesTheLineThatIsNoWgsl) {
  write_page("tie-rich --size 8");
  EXPECT_THAT(document("plant=word"),
              HasSubstr("Nothing can be compared: no WGSL is known for \"i\" in: loop (int i = 1;"));
}

TEST_F(Browser, SaysWhatABrowserLacks) {
  write_page("tie-rich --size 8");
  const std::string text = document("missing=EXT_color_buffer_float&missing=webgpu");
  EXPECT_THAT(text, HasSubstr("Nothing can be compared: this browser cannot draw into float textures"));
  EXPECT_THAT(text, HasSubstr("class=\"verdict unsure\""));
}

TEST_F(Browser, KeepsTheOtherPathWithoutWebGpu) {
  write_page("tie-rich --size 8");
  const std::string text = document("missing=webgpu");
  EXPECT_THAT(text, HasSubstr("Not compared: this browser has no WebGPU."));
  EXPECT_THAT(text, HasSubstr("The same bits: 2 of 2 comparisons"));
}

} // namespace
} // namespace hdmbench
