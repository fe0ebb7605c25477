// The commands that write a page: of results, and for browsers.

#include "harness/cli/arguments.hpp"
#include "harness/report/report.hpp"

#ifdef HDMBENCH_WITH_BROWSER
#include "harness/check/cases.hpp"
#include "harness/web/browser_page.hpp"
#endif

namespace hdmbench::commands {

namespace {

const Option<std::vector<std::filesystem::path>> result_files("results",
                                                              "Files that --json wrote, or folders of them");
const Option<OutputFile> page_file("--output", "The page", "hdmbench-report.html");

int run_report(Call& call) {
  write_report(call[result_files], call[page_file]);
  fmt::print("{}\n{}\n", summary_text(call[result_files]), call[page_file].string());
  return success;
}

#ifdef HDMBENCH_WITH_BROWSER
/// Small scenes with the elastic energy, in which all of its kernels are: a page has all of their steps with
/// what these make.
std::vector<Scene> elastic_scenes() {
  std::vector<Case> cases = box_cases(2);
  cases.front().size = Extent{25, 23};
  cases.back().size = Extent{9, 10, 8};
  const std::string method(elastic_conjugate_gradients);
  cases.push_back({.scene = "random", .size = Extent{29, 27}, .method = method, .iterations = 2});
  cases.push_back({.scene = "ball", .size = Extent{10, 9, 11}, .method = method, .iterations = 2});
  std::vector<Scene> scenes;
  std::ranges::transform(cases, std::back_inserter(scenes), load_case);
  const RegisteredEnergy& energy = energy_of(find_method(method));
  for (const auto& [name, size] : {std::pair{"square", Extent{12, 11}}, {"cube", Extent{5, 6, 5}}}) {
    scenes.push_back(load_scene(name, {.size = size, .law = "neo-hookean", .energy = &energy}));
    use_energy(scenes.back(), energy);
  }
  return scenes;
}
#endif

int write_page([[maybe_unused]] Call& call) {
#ifdef HDMBENCH_WITH_BROWSER
  require_writable(call[page_file]);
  call.schedule.takes_boxes = true;
  const bool is_usual = call[option::scenes].empty() && call[option::sizes].empty() &&
                        call[option::methods].empty() && call[option::law].empty() &&
                        call.schedule.given.empty() && call.schedule.energy == nullptr;
  if (call[option::scenes].empty() && call[option::sizes].empty()) {
    call[option::sizes] = {"64"};
  }
  Progress progress;
  progress.describe("prepare the scenes");
  std::vector<Scene> scenes =
      load_scenes(call, {"exact-textures", "exact-pyramid", "tie-rich", "random", "square", "brain"});
  if (is_usual) {
    std::ranges::move(elastic_scenes(), std::back_inserter(scenes));
  }
  const std::string page = browser_page(scenes, run_context(call.line, false), progress);
  write_text(call[page_file], page);
  progress.clear();
  fmt::print("{} scenes, {:.1f} MB: open {} in a browser\n", scenes.size(),
             static_cast<double>(page.size()) / 1e6, call[page_file].string());
  return success;
#else
  throw InputError(
      "this build has no page for browsers: it needs clang++ and lld for WebAssembly, and OpenGL "
      "(Debian: clang lld wasi-libc libc++-14-dev-wasm32 libclang-rt-14-dev-wasm32)");
#endif
}

} // namespace

void add_report(CLI::App& program, Call& call) {
  add_command(program, call, "report", run_report,
              "Put results into one HTML page.\nIt needs no network and no other file.",
              {result_files, page_file}, {"results is required"});
}

void add_browser(CLI::App& program, Call& call) {
  add_command(
      program, call, "browser", write_page,
      "Write a page that tests a visitor's GPU.\n"
      "Write a page that tests the GPU of whoever opens it: the thesis's shader in WebGL 2 and a compute\n"
      "shader in WebGPU beside scalar in WebAssembly, every site after every sweep. Needs no network.\n"
      "Without scenes: those that show most, at 64 x 64, and small ones with the elastic energy, whose "
      "steps\n"
      "are compared with those that scalar made where the page was written.",
      {scenes_options(), option::law, Options(page_file, nullptr, "hdmbench-browser.html")},
      {"--methods excludes --method"});
}

} // namespace hdmbench::commands
