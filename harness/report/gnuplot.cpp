#include "harness/report/gnuplot.hpp"

#include "harness/report/html.hpp"
#include "kernels/input_error.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hdmbench::report {

namespace {

std::string error_text(int code) {
  return std::generic_category().message(code);
}

class TemporaryDirectory {
public:
  TemporaryDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "hdmbench-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw InputError(fmt::format("{}: no temporary directory: {}", name, error_text(errno)));
    }
    path_ = name;
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

class FileActions {
public:
  FileActions() { check(posix_spawn_file_actions_init(&actions_)); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  void redirect(int descriptor, const std::string& file, int flags) {
    check(posix_spawn_file_actions_addopen(&actions_, descriptor, file.c_str(), flags, 0600));
  }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

private:
  static void check(int code) {
    if (code != 0) {
      throw InputError(fmt::format("gnuplot cannot be prepared: {}", error_text(code)));
    }
  }

  posix_spawn_file_actions_t actions_{};
};

std::string file_text(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Exit status as waitpid gives it.
int run_gnuplot(const std::string& script, const std::string& output, const std::string& errors) {
  FileActions actions;
  actions.redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
  actions.redirect(STDOUT_FILENO, output, O_WRONLY | O_CREAT | O_TRUNC);
  actions.redirect(STDERR_FILENO, errors, O_WRONLY | O_CREAT | O_TRUNC);

  std::string program = "gnuplot";
  std::string options = "--default-settings"; // not the user's own start-up file
  std::string file = script;
  char* const arguments[] = {program.data(), options.data(), file.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), actions.get(), nullptr, arguments, environ);
  if (failed != 0) {
    throw InputError(fmt::format("gnuplot, which draws the plots, cannot be started: {}. Install it "
                                 "(Debian: gnuplot-nox) or put it on PATH.",
                                 error_text(failed)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) {
      throw InputError(fmt::format("gnuplot cannot be waited for: {}", error_text(errno)));
    }
  }
  return status;
}

// A third of what gnuplot writes says nothing: empty groups, defaults, hundredths of a unit, space.
std::string compact(std::string svg) {
  static const std::regex defaults(
      R"( stroke-linecap="butt"| stroke-linejoin="miter"| class="gridline"|<tspan font-family="sans-serif" >|</tspan>)");
  static const std::regex hundredths(R"((\d\.\d)\d(?=[ ,"')]))");
  static const std::regex space(R"(\s*\n\s*)");
  static const std::regex empty_groups(R"(<g [^>]*>\s*</g>)");
  svg = std::regex_replace(svg, defaults, "");
  svg = std::regex_replace(svg, hundredths, "$1");
  svg = std::regex_replace(svg, space, "\n");
  return std::regex_replace(svg, empty_groups, "");
}

} // namespace

std::string gnuplot_text(std::string_view text) {
  std::string result = "'";
  for (const char letter : text) {
    if (letter == '\'') {
      result += "''";
    } else {
      result += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
    }
  }
  return result + '\'';
}

std::string gnuplot_svg_file(const std::string& script) {
  const TemporaryDirectory directory;
  const std::filesystem::path script_file = directory.path() / "plot.gnuplot";
  const std::filesystem::path output = directory.path() / "plot.svg";
  const std::filesystem::path errors = directory.path() / "errors.txt";
  std::ofstream stream(script_file, std::ios::binary);
  stream << script;
  stream.close();
  if (!stream) {
    throw InputError(fmt::format("{}: cannot be written", script_file.string()));
  }

  const int status = run_gnuplot(script_file.string(), output.string(), errors.string());
  std::string svg = file_text(output);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || svg.find("<svg") == std::string::npos ||
      svg.find("</svg>") == std::string::npos) {
    throw InputError(fmt::format("gnuplot failed ({}): {}",
                                 WIFSIGNALED(status) ? fmt::format("signal {}", WTERMSIG(status))
                                                     : fmt::format("exit status {}", WEXITSTATUS(status)),
                                 file_text(errors)));
  }
  return svg;
}

std::string gnuplot_svg(const std::string& script, const std::string& prefix, const std::string& label) {
  std::string svg = gnuplot_svg_file(script);
  svg.erase(0, svg.find("<svg"));

  static const std::regex tool_tips("<(title|desc)>[^<]*</(title|desc)>\\s*");
  static const std::regex namespaces("\\sxmlns(:xlink)?=\"[^\"]*\""); // HTML knows them
  static const std::regex ids("(\\sid=['\"])");
  static const std::regex references("((?:href=['\"]|url\\(\\s*['\"]?)#)");
  svg = std::regex_replace(svg, tool_tips, "");
  svg = std::regex_replace(svg, namespaces, "");
  svg = std::regex_replace(svg, ids, "$1" + prefix);
  svg = std::regex_replace(svg, references, "$1" + prefix);
  svg = compact(std::move(svg));
  svg.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", escape(label)));
  return svg;
}

} // namespace hdmbench::report
