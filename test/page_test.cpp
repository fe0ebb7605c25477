// The page of results: its verdict, what it refuses, and what headless Chromium makes of it.

#include "harness/report/report.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/images/images.hpp"
#include "test/chromium.hpp"
#include "test/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace hdmbench {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Path = std::filesystem::path;

/// page_rows.json: rows of each command, and what they come to.
const json& data() {
  static const json all = test::read_json(HDMBENCH_PAGE_ROWS);
  return all;
}

/// The row of a command, with other values.
json row_of(const std::string& command, const json& changes) {
  json row = data()["rows"][command];
  row.update(changes);
  return row;
}

json verify_row(const std::string& backend, const json& changes = json::object()) {
  json row = row_of("verify", changes);
  row["backend"] = backend;
  return row;
}

json bench_row(const std::string& backend, int width, double seconds, double speed_up) {
  return row_of("bench", {{"backend", backend},
                          {"width", width},
                          {"height", width},
                          {"seconds_median", seconds},
                          {"seconds", {seconds}},
                          {"speed_up_over_scalar", speed_up}});
}

json point(const std::string& method, double seconds, double error, const json& changes = json::object()) {
  json row = row_of("point", changes);
  row.update({{"method", method}, {"seconds_median", seconds}, {"rmsd_to_fem_nu0", error}});
  return row;
}

/// Result files with invented figures, and the page of them.
class Page : public test::Chromium {
protected:
  void SetUp() override {} // only some need the browser

  Path write(const std::string& name, const std::string& command, const json& rows,
             const json& context = json::object()) {
    json where = data()["context"];
    where["arguments"] = command;
    where.update(context);
    return folder_.write(
        name, json{{"schema", 1}, {"command", command}, {"context", where}, {"results", rows}}.dump());
  }
  void make() { write_report(std::array{folder()}, page()); }
  [[nodiscard]] report::Verdict verdict() const {
    return report::verdict_of(report::load_results(std::array{folder()}), "");
  }
};

/// What the rows of a command come to beside a good row of verify.
TEST_F(Page, VerdictsAreTheWorstThatWasFound) {
  for (const json& one : data()["verdicts"]) {
    const std::string command = one["command"];
    SCOPED_TRACE(one.dump());
    write("verify.json", "verify", json::array({verify_row("openmp")}));
    write("more.json", command, json::array({row_of(command, one["row"])}));
    const report::Verdict found = verdict();
    EXPECT_EQ(json(found.state), one["state"]);
    std::string all = found.sentence;
    for (const report::Finding& note : found.notes) {
      all += '\n' + note.sentence;
    }
    EXPECT_THAT(found.state == report::State::good ? all : found.sentence,
                HasSubstr(one["says"].get<std::string>()));
  }
  std::filesystem::remove(folder() / "verify.json");
  EXPECT_THAT(verdict().sentence, HasSubstr("there are no results of hdmbench verify"));
}

TEST_F(Page, ANewerRowReplacesAnOlderOne) {
  const json agrees = json::array({verify_row("openmp")});
  const json disagrees = json::array({verify_row("openmp", {{"verdict", "disagree"}})});
  const json older = {{"date", "2026-11-22T00:00:00Z"}};
  write("a.json", "verify", agrees);
  write("b.json", "verify", disagrees, older);
  EXPECT_EQ(verdict().state, report::State::good);
  write("a.json", "verify", disagrees);
  write("b.json", "verify", agrees, older);
  EXPECT_EQ(verdict().state, report::State::bad);
}

TEST_F(Page, RefusesWhatIsNoResultFile) {
  const Path target = page();
  const auto refused = [&](const std::string& text, const std::string& says) {
    (void)folder_.write("a.json", text);
    test::expect_run(2, "report " + folder().string() + " --output " + target.string(),
                     AllOf(HasSubstr("a.json"), HasSubstr(says)));
    EXPECT_FALSE(std::filesystem::exists(target)) << "half a page";
  };
  refused("{\"schema\": 1", "is not JSON");
  refused("[]", "must be an object");
  refused(R"({"schema": 2})", "this program reads schema 1");
  refused(std::string(100000, '['), "deep in each other");
  write("a.json", "verify", json::array({1}));
  test::expect_run(2, "report " + folder().string() + " --output " + target.string(),
                   HasSubstr("results[0] must be an object"));
  std::filesystem::create_directory(folder() / "empty");
  test::expect_run(2, "report " + (folder() / "empty").string(), HasSubstr("the folder has no *.json file"));
  test::expect_run(2, "report " + (folder() / "gone").string(), HasSubstr("gone"));
}

const Path committed = Path(HDMBENCH_SOURCE) / "reports/amd-epyc-llvmpipe";

/// A page in a browser of 1000 x 800 pixels.
class PageInBrowser : public Page {
protected:
  void SetUp() override { Chromium::SetUp(); }

  std::string document(const Path& file) { return Chromium::document(file.string(), 5000); }

  /// What the body of a JavaScript function returns in the page; "error" and a text where it throws. The
  /// policy of the page, which would forbid that, is taken out.
  json ask(const std::string& body) {
    std::string text = file_text(page());
    const std::string policy = "script-src ";
    const std::size_t begin = text.find(policy) + policy.size();
    text.replace(begin, text.find('"', begin) - begin, "'unsafe-inline'");
    const std::string driver = R"(<script>
{
const shown = (selector) => [...document.querySelectorAll(selector)];
const texts = (selector) => shown(selector).map((node) => node.textContent);
const named = (selector, text) => shown(selector).find((node) => node.textContent === text);
const column = (index) => shown("#speed-over-sizes .table tbody tr").map((row) => row.children[index].textContent);
const choose = (select, value) => { select.value = value; select.dispatchEvent(new Event("change")); };
const answer = document.createElement("pre");
answer.id = "answer";
(async () => { )" + body +
                               R"( })().catch((error) => "error: " + error).then((result) => {
const escaped = (character) => "\\u" + character.charCodeAt(0).toString(16).padStart(4, "0");
answer.textContent = "\u27e6" + JSON.stringify(result).replace(/[<>&\u007f-\uffff]/g, escaped) + "\u27e7";
document.body.append(answer); });
}
</script></body>)";
    text.replace(text.rfind("</body>"), 7, driver);
    const std::string dom = document(folder_.write("driven.html", text));
    const std::size_t first = dom.find("\u27e6", dom.find("id=\"answer\""));
    const std::size_t last = dom.find("\u27e7", std::min(first, dom.size()));
    if (last == std::string::npos) {
      ADD_FAILURE() << "the page gave no answer: " << dom.substr(dom.size() > 3000 ? dom.size() - 3000 : 0);
      return {};
    }
    return json::parse(dom.substr(first + 3, last - first - 3));
  }
};

TEST_F(PageInBrowser, ShowsWhatIsCommitted) {
  write_report(std::array{committed}, page());
  EXPECT_LT(std::filesystem::file_size(page()), 3'000'000U);
  const std::string seen = document(page()); // under its own policy
  EXPECT_THAT(seen, AllOf(HasSubstr("<h1>AMD EPYC, 2 cores</h1>"), HasSubstr("class=\"verdict good\""),
                          testing::ContainsRegex(
                              "All 6 backends agree with scalar in [0-9,]+ of [0-9,]+ comparisons")));
  const json found = ask(R"(
    for (const part of shown("details")) { part.open = true; part.dispatchEvent(new Event("toggle")); }
    const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    let overlapping = [];
    for (const svg of shown(".chart > svg")) {
      const labels = [...svg.querySelectorAll("text")].map((node) => [node.textContent, node.getBoundingClientRect()]);
      labels.forEach(([text, a], i) => labels.slice(i + 1).forEach(([other, b]) => { if (overlap(a, b)) overlapping.push(text + " over " + other); }));
    }
    return {
      titles: texts("h2"), folded: shown("details.part > summary").map((one) => one.firstChild.textContent),
      width: document.documentElement.scrollWidth, overlapping, charts: shown(".chart > svg").length,
      bad: texts(".table td, .table th, .tip, .legend button, p, li").filter((text) => /undefined|\[object|Infinity|\bNaN (px|m?s)|^(NaN|false|null)$/.test(text)),
      empty: shown("tbody").filter((body) => body.children.length === 0).length,
      uncopied: shown(".table").filter((node) => !node.querySelector(".csv")).length,
      pictures: shown(".slider img, .pictures img").filter((image) => image.src.startsWith("data:image/")).length,
      loaded: shown("[src], link[href]").filter((node) => !(node.src || node.href).startsWith("data:")).length,
    };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_THAT(found["titles"],
              ElementsAre("Speed against accuracy", "Before and after", "Agreement", "Speed over sizes"));
  EXPECT_THAT(found["folded"],
              ElementsAre("Accuracy", "From pixels to the continuum", "Where the methods fail",
                          "Backends and devices", "Agreement on other drivers", "Arithmetic of the devices",
                          "Planted faults", "Failing calls of drivers", "Golden hashes", "Several ranks",
                          "Registration", "Hidden stiffness", "Does it fit the thesis's card?",
                          "More pictures", "Reproduce"));
  EXPECT_LE(found["width"], 1000);
  EXPECT_EQ(found["overlapping"], json::array());
  EXPECT_EQ(found["bad"], json::array());
  EXPECT_EQ(found["empty"], 0);
  EXPECT_EQ(found["uncopied"], 0);
  EXPECT_EQ(found["loaded"], 0);
  EXPECT_GE(found["charts"], 6);
  EXPECT_GE(found["pictures"], 7);
}

TEST_F(PageInBrowser, SortsTablesAndCopiesThem) {
  write("bench.json", "bench",
        json::array({bench_row("openmp", 300, 0.02, 20.0), bench_row("a, \"b\"", 600, 0.0105, 5.0),
                     bench_row("scalar", 1200, 3.5, 1.0)}));
  make();
  const json found = ask(R"(
    choose(shown("select")[0] ?? { dispatchEvent() {} }, "square");
    const head = () => named("#speed-over-sizes thead button", "over scalar");
    const thesis = (values) => values.filter((value) => !value.startsWith("thesis"));
    head().click(); const up = thesis(column(2));
    head().click(); const down = thesis(column(2)), mark = head().parentNode.getAttribute("aria-sort");
    named("#speed-over-sizes thead button", "backend").click(); const words = thesis(column(2));
    let copied; navigator.clipboard.writeText = (text) => { copied = text; return Promise.resolve(); };
    shown("#speed-over-sizes .csv")[0].click();
    return { up, down, words, mark, csv: copied.split("\n").slice(0, 2) };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_THAT(found["up"], ElementsAre("scalar", "a, \"b\"", "openmp"));
  EXPECT_THAT(found["down"], ElementsAre("openmp", "a, \"b\"", "scalar"));
  EXPECT_THAT(found["words"], ElementsAre("a, \"b\"", "openmp", "scalar"));
  EXPECT_EQ(found["mark"], "descending");
  EXPECT_THAT(found["csv"], ElementsAre("scene,size,backend,method,seconds,over scalar",
                                        "square,600,\"a, \"\"b\"\"\",icm,0.0105,5"));
}

TEST_F(PageInBrowser, SwitchesSeriesScenesAndCells) {
  write("tradeoff.json", "tradeoff",
        json::array({point("icm", 0.001, 0.2), point("icm", 0.01, 0.1), point("multigrid", 0.002, 0.01),
                     point("fem", 0.5, 1e-6, {{"rival", true}, {"backend", ""}}),
                     point("icm", 0.1, 0.3, {{"scene", "circular"}})}));
  write("verify.json", "verify",
        json::array({verify_row("openmp"),
                     verify_row("opencl", {{"verdict", "disagree"},
                                           {"sites_differing", 7},
                                           {"first_difference",
                                            {{"level", 2}, {"iteration", 3}, {"x", 4}, {"y", 5}}}})}));
  write("strange.json", "strange", json::array({{{"odd_key", 17}}}));
  make();
  const json found = ask(R"(
    const dots = () => shown(".chart .dot").length, front = () => shown(".front")[0].getAttribute("d").match(/[MH]/g).length;
    const all = dots(), steps = front();
    named(".legend button", "icm").click(); const fewer = dots(), pressed = named(".legend button", "icm").getAttribute("aria-pressed");
    named(".legend button", "icm").click(); const again = dots();
    named(".legend button", "icm").dispatchEvent(new Event("dblclick")); const alone = dots();
    choose(shown("select")[0], "circular"); const other = dots();
    choose(shown("select")[0], "square");
    const svg = shown(".chart > svg")[0], box = svg.getBoundingClientRect();
    const place = shown(".chart .dot")[0].getAttribute("transform").match(/[\d.]+/g).map((value) => value * box.width / 760);
    svg.dispatchEvent(new MouseEvent("pointermove", { clientX: box.left + place[0] + 2, clientY: box.top + place[1] - 2 }));
    const tip = texts(".tip")[0];
    shown("[data-cell='square opencl']")[0].click();
    const strange = shown("#strange")[0]; strange.open = true; strange.dispatchEvent(new Event("toggle"));
    return { all, steps, fewer, pressed, again, alone, other, tip, picked: texts(".picked")[0], tones: shown("td.tier").map((cell) => cell.className),
      strange: strange.textContent, missing: texts("main p.soft").at(-1), verdict: shown(".verdict")[0].className };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_EQ(found["all"], 4);
  EXPECT_EQ(found["steps"], 4) << "three points and the end";
  EXPECT_EQ(found["fewer"], 2);
  EXPECT_EQ(found["pressed"], "false");
  EXPECT_EQ(found["again"], 4);
  EXPECT_EQ(found["alone"], 2);
  EXPECT_EQ(found["other"], 1);
  EXPECT_THAT(found["tip"], AllOf(HasSubstr("icm, openmp"), HasSubstr("0.2"), HasSubstr("hdmbench run")));
  EXPECT_THAT(found["picked"],
              AllOf(HasSubstr("hdmbench verify square --size 300x300 --methods icm --backends opencl"),
                    HasSubstr("level 2, iteration 3, x = 4, y = 5")));
  EXPECT_THAT(found["tones"], ElementsAre("tier bitwise", "tier disagree"));
  EXPECT_THAT(found["strange"], AllOf(HasSubstr("odd key"), HasSubstr("17")));
  EXPECT_THAT(found["missing"],
              AllOf(HasSubstr("planted faults (hdmbench faults)"), Not(HasSubstr("tradeoff"))));
  EXPECT_EQ(found["verdict"], "verdict bad");
}

TEST_F(PageInBrowser, SlidersMoveTheSlicesOfAVolume) {
  if (!have_images()) {
    GTEST_SKIP() << "no pictures in this build";
  }
  ScalarField picture({7, 5, 6}); // each site has a gray value of its own, and moves by one along z
  for_each_site(picture.extent, [&](int x, int y, int z) {
    picture.values[picture.extent.index(x, y, z)] = static_cast<float>(40 * z + 7 * y + x + 1);
  });
  VectorField displacement(picture.extent);
  std::ranges::fill(displacement[2], 1.0F);
  const ContactSheet sheet = contact_sheet(picture, displacement);
  ASSERT_EQ(sheet.volume, picture.extent);
  write_png(folder() / "s.png", sheet.picture);
  write_png(folder() / "a.png", slice_of(picture, Plane{}));
  write("run.json", "run",
        json::array({{{"scene", "ball"},
                      {"width", 7},
                      {"height", 5},
                      {"depth", 6},
                      {"slices", {{"width", 7}, {"height", 5}, {"depth", 6}, {"at", {3, 2, 4}}}},
                      {"pictures", {{"after", "a.png"}, {"slices", "s.png"}}}}}));
  make();
  const json found = ask(R"(
    const canvases = shown("canvas"), sliders = shown(".slider input");
    for (let tries = 0; tries < 50 && !texts(".slider figcaption")[0]; ++tries) await new Promise((done) => setTimeout(done, 50));
    const gray = (view, x, y) => canvases[view].getContext("2d").getImageData(x, y, 1, 1).data[0];
    const corners = () => canvases.map((canvas, view) => [gray(view, 0, 0), gray(view, canvas.width - 1, canvas.height - 1)]);
    const after = corners();
    choose(named(".choice", "Deformation afterbefore").querySelector("select"), "before"); const before = corners();
    sliders.forEach((slider) => { slider.value = 1; slider.dispatchEvent(new Event("input")); });
    return { after, before, moved: corners(), captions: texts(".slider figcaption") };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_EQ(found["before"], json({{161, 195}, {15, 221}, {4, 232}})) << "across z = 4, y = 2, x = 3";
  EXPECT_EQ(found["after"], json({{121, 155}, {0, 181}, {0, 192}})) << "what was one slice before";
  EXPECT_EQ(found["moved"], json({{41, 75}, {8, 214}, {2, 230}})) << "across 1";
  EXPECT_EQ(found["captions"][0], "slice across z: 2 of 6");
}

TEST_F(PageInBrowser, MachinesStandSideBySide) {
  write("a.json", "verify", json::array({verify_row("openmp")}));
  write("b.json", "verify", json::array({verify_row("openmp", {{"verdict", "disagree"}})}),
        {{"machine", "the other"}, {"date", "2026-11-22T00:00:00Z"}});
  make();
  const json found = ask(R"(
    const first = [texts("h1")[0], shown(".verdict")[0].className];
    choose(shown("select")[0], "the other");
    return { first, second: [texts("h1")[0], shown(".verdict")[0].className], beside: texts("#machines tbody tr") };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_THAT(found["first"], ElementsAre("a machine", "verdict good"));
  EXPECT_THAT(found["second"], ElementsAre("the other", "verdict bad"));
  EXPECT_EQ(found["beside"].size(), 2U);
}

TEST_F(PageInBrowser, NoNameIsTakenForMarkup) {
  const std::string evil = "</script><!--<script><img src=x onerror=\"document.title='owned'\">'&<b>{{1}}";
  write("verify.json", "verify",
        json::array(
            {verify_row(evil, {{"scene", evil}, {"method", evil}, {"reason", evil}, {"verdict", evil}})}),
        {{"machine", evil}, {"commit", evil}});
  write("bench.json", "bench", json::array({bench_row(evil, 300, 0.1, 3.0)}), {{"machine", evil}});
  write("odd.json", evil, json::array({{{evil, evil}}}), {{"machine", evil}});
  write("run.json", "run",
        json::array({{{"scene", evil},
                      {"title", evil},
                      {"width", 9},
                      {"height", 9},
                      {"warnings", {{{"kind", evil}}}}}}),
        {{"machine", evil}});
  make();
  EXPECT_THAT(document(page()), Not(HasSubstr("<img")));
  const json found = ask(R"(
    for (const part of shown("details")) { part.open = true; part.dispatchEvent(new Event("toggle")); }
    shown("[data-cell]")[0].click();
    return { title: document.title, images: shown("img").length, bold: texts("b").filter((text) => text === "{{1}}").length, heading: texts("h1")[0],
      scripts: shown("script").length, cells: texts(".table tbody th, .table td").filter((text) => text.includes("<img src=x")).length };)");
  ASSERT_TRUE(found.is_object()) << found;
  EXPECT_EQ(found["title"], "hdmbench on " + evil);
  EXPECT_EQ(found["heading"], evil);
  EXPECT_EQ(found["images"], 0);
  EXPECT_EQ(found["bold"], 0);
  EXPECT_EQ(found["scripts"], 8) << "the results, what the page shows, five of its own, the test's";
  EXPECT_GE(found["cells"], 6);
}

} // namespace
} // namespace hdmbench
