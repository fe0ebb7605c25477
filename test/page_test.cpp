// The page of results: its verdict, what it refuses, and what headless Chromium makes of it.

#include "harness/report/report.hpp"
#include "harness/report/verdict.hpp"
#include "harness/scene/images/images.hpp"
#include "test/chromium.hpp"
#include "test/program.hpp"

namespace hdmbench {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

/// page_rows.json: rows of each command, and what they come to.
const json& data() {
  static const json all = test::read_json(HDMBENCH_SOURCE "/test/page_rows.json");
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
    if (one.contains("not")) {
      EXPECT_THAT(all, Not(HasSubstr(one["not"].get<std::string>())));
    }
  }
  std::filesystem::remove(folder() / "verify.json");
  EXPECT_THAT(verdict().sentence, HasSubstr("there are no results of hdmbench verify"));
}

/// Once each, whatever the numbers of sites; a cause that rounding excuses is none for concern.
TEST_F(Page, SaysWhyBitsDiffer) {
  const auto fused = [](const char* backend, const char* verdict, const char* sites) {
    return verify_row(backend,
                      {{"verdict", verdict},
                       {"why", fmt::format("a product is fused in hdm/energy.inc, line 22: that makes "
                                           "all of {} sites that differ and 9 beside them",
                                           sites)}});
  };
  const auto all = [&] {
    std::string text = verdict().sentence;
    for (const report::Finding& note : verdict().notes) {
      text += '\n' + note.sentence;
    }
    return text;
  };
  const std::string cause = "Why bits differ: a product is fused in hdm/energy.inc, line 22 (";
  write("verify.json", "verify",
        json::array({fused("openmp", "certified", "7"), fused("opencl", "certified", "8")}));
  EXPECT_EQ(verdict().state, report::State::good);
  EXPECT_THAT(all(), AllOf(HasSubstr(cause), HasSubstr("openmp"), HasSubstr("opencl")));
  EXPECT_EQ(all().find(cause), all().rfind(cause));
  write("verify.json", "verify", json::array({fused("openmp", "disagree", "7")}));
  EXPECT_EQ(verdict().state, report::State::bad);
  EXPECT_THAT(all(), HasSubstr(cause));
}

/// A page of bench alone says what bench checked, and compares what does the same.
TEST_F(Page, BenchAloneIsAComparison) {
  json scalar = bench_row("scalar", 300, 1.0, 1.0);
  scalar["reference"] = "scalar";
  json dense = bench_row("openmp", 300, 0.1, 10.0);
  dense["reference"] = "scalar";
  json active = dense;
  active.update({{"work", "active"}, {"method", "icm-active"}, {"speed_up_over_scalar", 100.0}});
  write("bench.json", "bench", json::array({scalar, dense, active}));
  const report::Verdict found = verdict();
  EXPECT_EQ(found.state, report::State::good);
  EXPECT_THAT(found.sentence, HasSubstr("The fields of 2 timed solutions are scalar's to the last bit"));
  ASSERT_EQ(found.figures.size(), 2U);
  EXPECT_EQ(found.figures[0].value, "2");
  EXPECT_EQ(found.figures[1].value, "10 x") << "100 x is of a run that left out what rests";
  dense["valid"] = false;
  write("bench.json", "bench", json::array({scalar, dense}));
  EXPECT_EQ(verdict().state, report::State::bad);
  write("bench.json", "bench", json::array({scalar}));
  EXPECT_THAT(verdict().sentence, HasSubstr("Nothing was compared")) << "scalar with itself is none";
}

TEST_F(Page, SaysWhatWasCut) {
  (void)folder_.write("verify.json", json{{"schema", 1},
                                          {"command", "verify"},
                                          {"context", data()["context"]},
                                          {"cut", true},
                                          {"results", json::array({verify_row("openmp")})}}
                                         .dump());
  EXPECT_EQ(verdict().state, report::State::unsure);
  EXPECT_THAT(verdict().sentence, HasSubstr("ended before it had all rows: verify.json"));
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

TEST_F(Page, RefusesADocumentThatIsTooDeep) {
  (void)folder_.write("a.json", std::string(100000, '['));
  test::expect_run(2, "report " + folder().string(),
                   AllOf(HasSubstr("a.json"), HasSubstr("deep in each other")));
}

const Path committed = Path(HDMBENCH_SOURCE) / "reports/amd-epyc-llvmpipe";

TEST(Committed, AFolderIsOfOneMachineAndNamesNoFolderOfIt) {
  std::map<std::string, std::set<std::string>> machines;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(HDMBENCH_SOURCE "/reports")) {
    if (entry.path().extension() != ".json") {
      continue;
    }
    const json context = test::read_json(entry.path()).at("context");
    machines[entry.path().parent_path().string()].insert(context.at("machine"));
    EXPECT_THAT(context.at("arguments").get<std::string>(), Not(ContainsRegex("(^|[ =])[/~]")))
        << entry.path();
  }
  EXPECT_THAT(machines, AllOf(testing::SizeIs(testing::Ge(4U)),
                              testing::Each(testing::Pair(testing::_, testing::SizeIs(1U)))));
}

/// A page in a browser of 1000 x 800 pixels.
class PageInBrowser : public Page {
protected:
  void SetUp() override { Chromium::SetUp(); }

  std::string document(const Path& file) { return Chromium::document(file.string(), 5000); }

  /// Lets statements of JavaScript run in the page, which say by same(NAME, FOUND, WANTED) what must hold:
  /// WANTED is a value, a regular expression or a predicate. What does not is printed, and what was thrown.
  /// The policy of the page, which would forbid that, is taken out.
  void expect_page(const std::string& body) {
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
const unfold = (part) => { part.open = true; part.dispatchEvent(new Event("toggle")); };
const wrong = [];
const same = (name, found, wanted) => {
  const holds = wanted instanceof RegExp ? wanted.test(found) : typeof wanted === "function" ? wanted(found) : JSON.stringify(found) === JSON.stringify(wanted);
  if (!holds) wrong.push([name, found, "wanted", wanted instanceof RegExp || typeof wanted === "function" ? String(wanted) : wanted]);
};
const answer = document.createElement("pre");
answer.id = "answer";
(async () => { )" + body + R"( })().catch((error) => wrong.push("error: " + error)).then(() => {
const escaped = (character) => "\\u" + character.charCodeAt(0).toString(16).padStart(4, "0");
answer.textContent = "\u27e6" + JSON.stringify(wrong).replace(/[<>&\u007f-\uffff]/g, escaped) + "\u27e7";
document.body.append(answer); });
}
</script></body>)";
    text.replace(text.rfind("</body>"), 7, driver);
    const std::string dom = document(folder_.write("driven.html", text));
    const std::size_t first = dom.find("\u27e6", dom.find("id=\"answer\""));
    const std::size_t last = dom.find("\u27e7", std::min(first, dom.size()));
    ASSERT_NE(last, std::string::npos)
        << "no answer: " << dom.substr(dom.size() > 3000 ? dom.size() - 3000 : 0);
    EXPECT_EQ(json::parse(dom.substr(first + 3, last - first - 3)), json::array());
  }
};

TEST_F(PageInBrowser, ShowsWhatIsCommitted) {
  write_report(std::array{committed}, page());
  EXPECT_LT(std::filesystem::file_size(page()), 3'000'000U);
  EXPECT_THAT(document(page()), // under its own policy
              AllOf(HasSubstr("<h1>AMD EPYC, 2 cores</h1>"), HasSubstr("class=\"verdict good\""),
                    ContainsRegex("All 6 backends agree with scalar in [0-9,]+ of [0-9,]+ comparisons")));
  expect_page(R"(
    shown("details").forEach(unfold);
    const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    let overlapping = [];
    for (const svg of shown(".chart > svg")) {
      const labels = [...svg.querySelectorAll("text")].map((node) => [node.textContent, node.getBoundingClientRect()]);
      labels.forEach(([text, a], i) => labels.slice(i + 1).forEach(([other, b]) => { if (overlap(a, b)) overlapping.push(text + " over " + other); }));
    }
    same("titles", texts("h2"), ["Before and after", "Agreement", "Speed over sizes", "Speed against accuracy"]);
    same("folded", shown("details.part > summary").map((one) => one.firstChild.textContent),
         ["Accuracy", "From pixels to the continuum", "Where the methods fail", "Backends and devices", "Agreement on other drivers",
          "Arithmetic of the devices", "Planted faults", "Failing calls of drivers", "Golden hashes", "Several ranks", "Registration",
          "Hidden stiffness", "Does it fit the thesis's card?", "Reproduce"]);
    same("width", document.documentElement.scrollWidth, (width) => width <= 1000);
    same("labels over labels", overlapping, []);
    same("words", texts(".table td, .table th, .tip, .legend button, p, li").filter((text) => /undefined|\[object|Infinity|\bNaN (px|m?s)|^(NaN|false|null)$/.test(text)), []);
    same("empty tables", shown("tbody").filter((body) => body.children.length === 0).length, 0);
    same("tables that cannot be copied", shown(".table").filter((node) => !node.querySelector(".csv")).length, 0);
    same("loaded from elsewhere", shown("[src], link[href]").filter((node) => !(node.src || node.href).startsWith("data:")).length, 0);
    same("charts", shown(".chart > svg").length, (count) => count >= 6);
    same("pictures", shown(".slider img, .pictures img").filter((image) => image.src.startsWith("data:image/")).length, (count) => count >= 7);)");
}

TEST_F(PageInBrowser, SortsTablesAndCopiesThem) {
  write("bench.json", "bench",
        json::array({bench_row("openmp", 300, 0.02, 20.0), bench_row("a, \"b\"", 600, 0.0105, 5.0),
                     bench_row("scalar", 1200, 3.5, 1.0)}));
  make();
  expect_page(R"(
    choose(shown("select")[0] ?? { dispatchEvent() {} }, "square");
    const head = () => named("#speed-over-sizes thead button", "over dense scalar");
    const measured = () => column(2).filter((value) => !value.startsWith("thesis"));
    head().click(); same("up", measured(), ["scalar", 'a, "b"', "openmp"]);
    head().click(); same("down", measured(), ["openmp", 'a, "b"', "scalar"]);
    same("mark", head().parentNode.getAttribute("aria-sort"), "descending");
    named("#speed-over-sizes thead button", "backend").click(); same("words", measured(), ['a, "b"', "openmp", "scalar"]);
    let copied; navigator.clipboard.writeText = (text) => { copied = text; return Promise.resolve(); };
    shown("#speed-over-sizes .csv")[0].click();
    same("csv", copied.split("\n").slice(0, 2), ["scene,size,backend,method,seconds,over dense scalar", 'square,600,"a, ""b""",icm,0.0105,5']);)");
}

/// What was not timed has no row with 0 s, and is named.
TEST_F(PageInBrowser, NamesWhatWasNotTimed) {
  json absent = bench_row("cuda", 300, 0.0, 0.0);
  absent.update({{"valid", false},
                 {"seconds", json::array()},
                 {"speed_up_over_scalar", nullptr},
                 {"reason", "no driver"}});
  write("bench.json", "bench", json::array({bench_row("openmp", 300, 0.02, 20.0), absent}));
  make();
  expect_page(R"(
    same("timed", column(2).filter((value) => !value.startsWith("thesis")), ["openmp"]);
    same("named", texts("#speed-over-sizes p").join(" "), /Not timed: cuda \(no driver\)\./);)");
}

TEST_F(PageInBrowser, SwitchesSeriesScenesAndCells) {
  write("tradeoff.json", "tradeoff",
        json::array({point("icm", 0.001, 0.2), point("icm", 0.01, 0.1), point("multigrid", 0.002, 0.01),
                     point("fem", 0.5, 1e-6, {{"rival", true}, {"backend", ""}}),
                     point("icm", 0.1, 0.3, {{"scene", "circular"}})}));
  const json place{{"level", 2}, {"iteration", 3}, {"x", 4}, {"y", 5}};
  write("verify.json", "verify",
        json::array({verify_row("openmp"), verify_row("opencl", {{"verdict", "disagree"},
                                                                 {"sites_differing", 7},
                                                                 {"first_difference", place}})}));
  write("strange.json", "strange", json::array({{{"odd_key", 17}}}));
  std::filesystem::copy_file(committed / "brain-grid.png", folder() / "of-no-result.png");
  make();
  expect_page(R"(
    const more = shown("details.part > summary").find((one) => one.firstChild.textContent === "More pictures").parentNode;
    unfold(more);
    same("pictures of no result", more.querySelectorAll("img").length, 1);
    const dots = (name, wanted) => same("dots, " + name, shown(".chart .dot").length, wanted);
    dots("all", 4);
    same("steps: three points and the end", shown(".front")[0].getAttribute("d").match(/[MH]/g).length, 4);
    named(".legend button", "icm").click(); dots("without icm", 2);
    same("pressed", named(".legend button", "icm").getAttribute("aria-pressed"), "false");
    named(".legend button", "icm").click(); dots("again", 4);
    named(".legend button", "icm").dispatchEvent(new Event("dblclick")); dots("icm alone", 2);
    choose(shown("select")[0], "circular, 300\u00a0×\u00a0300"); dots("another scene", 1);
    choose(shown("select")[0], "square, 300\u00a0×\u00a0300");
    const svg = shown(".chart > svg")[0], box = svg.getBoundingClientRect();
    const place = shown(".chart .dot")[0].getAttribute("transform").match(/[\d.]+/g).map((value) => value * box.width / 760);
    svg.dispatchEvent(new MouseEvent("pointermove", { clientX: box.left + place[0] + 2, clientY: box.top + place[1] - 2 }));
    same("tip", texts(".tip")[0], (tip) => ["icm, openmp", "0.2", "hdmbench run"].every((part) => tip.includes(part)));
    shown("[data-cell='square opencl']")[0].click();
    same("picked", texts(".picked")[0], (row) => ["hdmbench verify square --size 300x300 --methods icm --backends opencl", "level 2, iteration 3, x = 4, y = 5"].every((part) => row.includes(part)));
    same("tones", shown("td.tier").map((cell) => cell.className), ["tier bitwise", "tier disagree"]);
    unfold(shown("#strange")[0]);
    same("strange", shown("#strange")[0].textContent, /odd key[^]*17|17[^]*odd key/);
    same("missing", texts("main p.soft").at(-1), (text) => text.includes('planted faults (hdmbench faults)') && !text.includes("tradeoff"));
  same("verdict", shown(".verdict")[0].className, "verdict bad");)");
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
  expect_page(R"(
    const canvases = shown("canvas"), sliders = shown(".slider input");
    for (let tries = 0; tries < 50 && !texts(".slider figcaption")[0]; ++tries) await new Promise((done) => setTimeout(done, 50));
    const gray = (view, x, y) => canvases[view].getContext("2d").getImageData(x, y, 1, 1).data[0];
    const corners = () => canvases.map((canvas, view) => [gray(view, 0, 0), gray(view, canvas.width - 1, canvas.height - 1)]);
    same("what was one slice before", corners(), [[121, 155], [175, 0], [164, 0]]);
    choose(named(".choice", "Deformation afterbefore").querySelector("select"), "before");
    same("across z = 4, y = 2, x = 3", corners(), [[161, 195], [215, 21], [204, 32]]);
    sliders.forEach((slider) => { slider.value = 1; slider.dispatchEvent(new Event("input")); });
    same("across 1", corners(), [[41, 75], [208, 14], [202, 30]]);
    same("caption", texts(".slider figcaption")[0], "slice across z: 2 of 6");)");
}

TEST_F(PageInBrowser, MachinesStandSideBySide) {
  write("a.json", "verify", json::array({verify_row("openmp")}));
  write("b.json", "verify", json::array({verify_row("openmp", {{"verdict", "disagree"}})}),
        {{"machine", "the other"}, {"date", "2026-11-22T00:00:00Z"}});
  make();
  expect_page(R"(
    same("first", [texts("h1")[0], shown(".verdict")[0].className], ["a machine", "verdict good"]);
    choose(shown("select")[0], "the other");
    same("second", [texts("h1")[0], shown(".verdict")[0].className], ["the other", "verdict bad"]);
    same("beside", shown("#machines tbody tr").length, 2);)");
}

TEST_F(PageInBrowser, NoNameIsTakenForMarkup) {
  const std::string evil = "</script><!--<script><img src=x onerror=\"document.title='owned'\">'&<b>{{1}}";
  const json where{{"machine", evil}, {"commit", evil}};
  write("verify.json", "verify",
        json::array(
            {verify_row(evil, {{"scene", evil}, {"method", evil}, {"reason", evil}, {"verdict", evil}})}),
        where);
  write("bench.json", "bench", json::array({bench_row(evil, 300, 0.1, 3.0)}), where);
  write("odd.json", evil, json::array({{{evil, evil}}}), where);
  const json warnings{{{"kind", evil}}};
  write(
      "run.json", "run",
      json::array({{{"scene", evil}, {"title", evil}, {"width", 9}, {"height", 9}, {"warnings", warnings}}}),
      where);
  make();
  EXPECT_THAT(document(page()), Not(HasSubstr("<img")));
  expect_page(R"(
    const evil = String.raw`<\/script><\!--<\script><img src=x onerror="document.title='owned'">'&<b>{{1}}`.replaceAll("\\", "");
    shown("details").forEach(unfold);
    shown("[data-cell]")[0].click();
    same("title", document.title, "hdmbench on " + evil);
    same("heading", texts("h1")[0], evil);
    same("images", shown("img").length, 0);
    same("bold", texts("b").filter((text) => text === "{{1}}").length, 0);
    same("scripts: the results, what the page shows, five of its own, the test's", shown("script").length, 8);
    same("cells", texts(".table tbody th, .table td").filter((text) => text.includes("<img src=x")).length, (count) => count >= 6);)");
}

} // namespace
} // namespace hdmbench
