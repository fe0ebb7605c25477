// The commands that write a page: of results, and for browsers.

#include "harness/cli/arguments.hpp"
#include "harness/report/report.hpp"

#ifdef HDMBENCH_WITH_BROWSER
#include "harness/web/browser_page.hpp"
#endif

namespace hdmbench::commands {

namespace {

struct ReportArguments {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output = "hdmbench-report.html";
};

struct BrowserArguments {
  CommonArguments scenes;
  std::filesystem::path output = "hdmbench-browser.html";
};

int run_report(ReportArguments& arguments, Call& /*call*/) {
  write_report(arguments.results, arguments.output);
  fmt::print("{}\n{}\n", summary_text(arguments.results), arguments.output.string());
  return success;
}

int write_page([[maybe_unused]] BrowserArguments& arguments, [[maybe_unused]] Call& call) {
#ifdef HDMBENCH_WITH_BROWSER
  require_writable(arguments.output);
  if (arguments.scenes.sizes.empty()) {
    arguments.scenes.sizes = {"64"};
  }
  Progress progress;
  progress.describe("prepare the scenes");
  const std::vector<Scene> scenes = arguments.scenes.load_scenes(
      {"exact-textures", "exact-pyramid", "tie-rich", "random", "square", "brain"});
  const std::string page = browser_page(scenes, run_context(call.line, false), progress);
  write_text(arguments.output, page);
  progress.clear();
  fmt::print("{} scenes, {:.1f} MB: open {} in a browser\n", scenes.size(),
             static_cast<double>(page.size()) / 1e6, arguments.output.string());
  return success;
#else
  throw InputError(
      "this build has no page for browsers: it needs clang++ and lld for WebAssembly, and OpenGL "
      "(Debian: clang lld wasi-libc libc++-14-dev-wasm32 libclang-rt-14-dev-wasm32)");
#endif
}

} // namespace

void add_report(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "report",
              "Put results into one HTML page that needs no network and no other file.", run_report);
  add_option(command, "results", own.results, "Files that --json wrote, or folders of them")->required();
  add_output(command, "--output", own.output, "The page");
}

void add_browser(CLI::App& program, Call& call) {
  const auto [command, own] = declare(
      program, call, "browser",
      "Write a page that tests the GPU of whoever opens it: the thesis's shader in WebGL 2 beside scalar in\n"
      "WebAssembly, every site after every sweep. Needs no network.\n"
      "Without scenes: those that show most, at 64 x 64.",
      write_page);
  own.scenes.add_scenes_to(command);
  add_output(command, "--output", own.output, "The page");
}

} // namespace hdmbench::commands
