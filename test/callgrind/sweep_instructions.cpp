// Instructions per site and sweep, counted by valgrind: what a clock on a busy machine cannot tell. Counts of
// one compiler are the same on every run, so that 2 % more of them is a change of the code.
//   sweep_instructions --check FILE   compares with the committed counts   (--write FILE makes new ones)

#include "backends/cpu/cpu.hpp"
#include "backends/shared/energy_programs.hpp"
#include "backends/shared/subprocess.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/scene.hpp"
#include "kernels/data/input_error.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace hdmbench;

constexpr int size = 256; ///< sites a side
constexpr int sweeps = 8; ///< as many as openmp takes through a band together
constexpr double tolerance = 0.02;
constexpr int skipped = 77; ///< what ctest takes as skipped
const std::string planted_kernel = "planted";

/// The planted fault: the same field, but every 20th row is computed twice.
std::int64_t one_in_twenty_twice(const openmp::RowPart& part) {
  if (part.row % 20 == 0) {
    (void)programs_of(thesis_energy).rows[1](part);
  }
  return programs_of(thesis_energy).rows[1](part);
}

/// What runs under valgrind, which knows nothing of AVX-512.
void sweep(const std::string& kernel, const std::string& scene_name, int count) {
  const auto& rows = programs_of(thesis_energy).rows;
  const auto backend = kernel == "scalar"            ? make_scalar()
                       : kernel == "openmp-baseline" ? make_openmp_with("openmp", rows[0], "baseline")
                       : kernel == "openmp-avx2"     ? make_openmp_with("openmp", rows[1], "AVX2")
                                                 : make_openmp_with("openmp", one_in_twenty_twice, "slower");
  const Scene scene = load_scene(scene_name, {.size = Extent{size, size}});
  const auto session = backend->open({.device = "", .threads = 1});
  session->load(scene.full);
  session->write(scene.start_field());
  session->step(count);
}

/// Instructions of a whole run of sweep().
double count_instructions(const std::string& kernel, const std::string& scene, int count) {
  const TemporaryDirectory folder;
  const auto profile = folder.path() / "callgrind.out";
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  // Threads that wait for each other, where a scene is made, count as instructions, too.
  const ProcessEnd end = run_process({"env", "OMP_NUM_THREADS=1", "valgrind", "--tool=callgrind",
                                      "--callgrind-out-file=" + profile.string(), program, "--sweep", kernel,
                                      scene, std::to_string(count)},
                                     folder.path() / "output", folder.path() / "errors");
  if (!end.good()) {
    throw InputError(
        fmt::format("valgrind failed ({}): {}", end.text(), file_text(folder.path() / "errors")));
  }
  const std::string text = file_text(profile);
  const std::string key = "\nsummary: ";
  const std::size_t at = text.find(key);
  return at == text.npos ? throw InputError("valgrind wrote no summary")
                         : std::stod(text.substr(at + key.size()));
}

/// Of one sweep of one site: the difference of two runs, so that everything but the sweeps is gone. In
/// `random` every site is observed and every modulus another; in `square` hardly any is and few are.
nlohmann::json measure(const std::vector<std::string>& kernels) {
  nlohmann::json rows = nlohmann::json::array();
  for (const std::string& kernel : kernels) {
    for (const char* const scene : {"random", "square"}) {
      std::fprintf(stderr, "counting %s, %s\n", kernel.c_str(), scene);
      const double once = count_instructions(kernel, scene, sweeps);
      const double thrice = count_instructions(kernel, scene, 3 * sweeps);
      const double of_a_site = (thrice - once) / (2.0 * sweeps * size * size);
      rows.push_back({{"kernel", kernel},
                      {"scene", scene},
                      {"instructions_per_site", std::round(100.0 * of_a_site) / 100.0}});
    }
  }
  return rows;
}

const std::vector<std::string> all_kernels{"scalar", "openmp-baseline", "openmp-avx2"};

/// One sentence where the committed counts say nothing about this build.
std::optional<std::string> reason_to_skip(const nlohmann::json& committed) {
  const TemporaryDirectory folder;
  try {
    if (!run_process({"valgrind", "--version"}, folder.path() / "output", folder.path() / "errors").good()) {
      return "valgrind does not run";
    }
  } catch (const InputError& error) {
    return error.what();
  }
  const nlohmann::json here = run_context("", false);
  for (const char* const key : {"compiler", "flags", "architecture"}) {
    if (committed[key] != here[key]) {
      return fmt::format("the committed counts are of {} {}, this build is of {}", key,
                         committed[key].get<std::string>(), here[key].get<std::string>());
    }
  }
  return std::nullopt;
}

/// Whether all counts are as committed.
bool check(const nlohmann::json& committed, nlohmann::json rows) {
  bool good = true;
  for (nlohmann::json& row : rows) {
    double expected = 0.0;
    for (const nlohmann::json& other : committed) {
      const bool same = other["kernel"] == row["kernel"] ||
                        (row["kernel"] == planted_kernel && other["kernel"] == "openmp-avx2");
      expected =
          same && other["scene"] == row["scene"] ? other["instructions_per_site"].get<double>() : expected;
    }
    const double change = row["instructions_per_site"].get<double>() / expected - 1.0;
    const bool as_before = std::abs(change) <= tolerance; // false where nothing was committed
    good = good && as_before;
    row["committed"] = expected;
    row["change"] = fmt::format("{:+.1f} %{}", 100.0 * change, as_before ? "" : "  !");
  }
  fmt::print("Instructions per site and sweep\n{}",
             table_text(rows, "kernel|scene|committed|instructions_per_site:now|change"));
  return good;
}

int run_check(const std::filesystem::path& file, bool planted) {
  const nlohmann::json document = nlohmann::json::parse(std::ifstream(file));
  if (const auto reason = reason_to_skip(document["context"])) {
    fmt::print("skipped: {}\n", *reason);
    return skipped;
  }
  const bool good = check(document["results"], measure(planted ? std::vector{planted_kernel} : all_kernels));
  if (!good && !planted) {
    fmt::print("More than {:.0f} % off. If that is meant: sweep_instructions --write {}\n", 100.0 * tolerance,
               file.string());
  }
  return good != planted ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  CLI::App program("Instructions per site and sweep of the CPU backends, counted by valgrind.");
  std::string file;
  std::string new_file;
  std::vector<std::string> child;
  bool planted = false;
  auto* const checks =
      program.add_option("--check", file, "Compare with these counts")->check(CLI::ExistingFile);
  program.add_flag("--planted", planted, "See whether a kernel that computes every 20th row twice is found")
      ->needs(checks);
  program.add_option("--write", new_file, "Count anew and write this file")->excludes(checks);
  program.add_option("--sweep", child, "What is counted: KERNEL SCENE SWEEPS")->expected(3);
  CLI11_PARSE(program, argc, argv);
  try {
    if (!child.empty()) {
      sweep(child[0], child[1], std::stoi(child[2]));
    } else if (!new_file.empty()) {
      write_results(new_file, "sweep-instructions", run_context("--write", false), measure(all_kernels));
    } else if (!file.empty()) {
      return run_check(file, planted);
    } else {
      fmt::print("{}", program.help());
      return 2;
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "sweep_instructions: {}\n", error.what());
    return 2;
  }
  return 0;
}
