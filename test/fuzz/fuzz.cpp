// Programs that read what may come from anywhere: scene files, result files, lists of the thesis's tools, as
// HDMBENCH_FUZZ_READS says. libFuzzer looks for inputs that are answered by anything but a refusal or a
// result; without it (no HDMBENCH_FUZZ) the program reads every file of the folders given once: what was
// found stays mended.

#include "backends/backend.hpp"
#include "harness/report/results.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/scene.hpp"
#include "harness/tools/thesis_tools.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace {

using namespace hdmbench;
namespace fs = std::filesystem;

/// The path of a file of this process's own with these bytes. The folder goes with the process.
fs::path file_with(std::string_view name, std::string_view bytes) {
  static const TemporaryDirectory folder;
  auto file = folder.path() / name;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!(stream << bytes << std::flush)) {
    fmt::print(stderr, "{} cannot be written\n", file.string());
    std::abort();
  }
  return file;
}

/// With images of 3 x 2 pixels beside it.
void read_scene(std::string_view text) {
  constexpr std::string_view image = "NRRD0004\nencoding: ascii\n";
  (void)file_with("labels.nrrd",
                  fmt::format("{}type: short\ndimension: 2\nsizes: 3 2\n\n0 1 0\n1 1 0\n", image));
  (void)file_with("modulus.nrrd",
                  fmt::format("{}type: float\ndimension: 2\nsizes: 3 2\n\n5 1.5 3\n1 1 9\n", image));
  (void)file_with("vector.nrrd",
                  fmt::format("{}type: float\ndimension: 3\nsizes: 2 3 2\nkinds: vector domain "
                              "domain\n\n0 1 0.5 0 0 1\n1 1 1 0 0 0.25\n",
                              image));
  // Whatever size the file asks for: read, and replaced.
  (void)load_scene(file_with("scene.toml", text).string(), {.size = Extent{9, 7}});
}

void read_result_file(std::string_view text) {
  const fs::path file = file_with("results.json", text);
  (void)report::load_results({&file, 1});
}

/// bUnwarpJ's raw transformations, or nodes and elements with a line of = between the two.
void read_list(std::string_view text) {
  constexpr std::string_view border = "\n=\n";
  const auto end = text.find(border);
  if (text.starts_with("Width=")) {
    (void)displacements_from_positions(read_positions(file_with("raw.txt", text)).pixels);
  } else if (end == text.npos) {
    const Mesh mesh = read_mesh(file_with("nodes.csv", text), std::nullopt);
    (void)nearest_node_image(mesh, grid_over(mesh, {8, 6}), 1.0);
  } else {
    const Mesh mesh = read_mesh(file_with("nodes.csv", text.substr(0, end)),
                                file_with("elements.csv", text.substr(end + border.size())));
    (void)element_image(mesh, grid_over(mesh, {8, 6}));
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::map<std::string_view, void (*)(std::string_view)> readers{
      {"scene", read_scene}, {"results", read_result_file}, {"lists", read_list}};
  try {
    readers.at(HDMBENCH_FUZZ_READS)({reinterpret_cast<const char*>(data), size});
  } catch (const InputError&) {
  } catch (const DeviceError&) {
  } catch (const std::exception& error) {
    fmt::print(stderr, "neither InputError nor DeviceError: {}\n", error.what());
    std::abort();
  }
  return 0;
}

#ifndef HDMBENCH_FUZZ
int main(int count, char** folders) {
  std::set<fs::path> files;
  for (int i = 1; i < count; ++i) {
    files.insert(fs::directory_iterator(folders[i]), fs::directory_iterator());
  }
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    fmt::print("{}\n", file.string());
    std::fflush(stdout); // before a crash
    alarm(5);            // whose signal ends the program
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  fmt::print("{} inputs answered\n", files.size());
  return files.empty() ? 1 : 0;
}
#endif
