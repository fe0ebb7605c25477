#include "harness/scene/images/images.hpp"
#include "harness/scene/images/pixels.hpp"

#include "backends/shared/subprocess.hpp"
#include "harness/scene/files.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>
#include <type_traits>

// ITK's readers crash, run for ever or take all memory on damaged files, or report on standard error alone
// that pixels are missing. So a file is read by the program itself, started again, which hands back the
// pixels.

namespace hdmbench {

namespace {

using images::Geometry;
using images::Pixels;

constexpr std::string_view question = "--read-image";
// Exit statuses of the process that reads: what a library ends it with is another one.
constexpr int has_read = 78;    // its standard output is the geometry and the values
constexpr int has_refused = 79; // its standard output is the sentence of an InputError
constexpr int has_no_room = 80; // its standard output took no more

std::atomic<bool>& reads_apart() {
  static std::atomic<bool> apart = false;
  return apart;
}

/// Copied from one process to the other as it is.
static_assert(std::is_trivially_copyable_v<Geometry>);

/// How long reading this file may keep a processor busy. The time that others take on the machine does not
/// count.
rlim_t processor_seconds(const std::filesystem::path& file) {
  constexpr std::uintmax_t bytes_per_second = 100'000; // compressed a thousandfold, on a slow machine
  std::error_code ignored;
  return 5 + std::filesystem::file_size(file, ignored) / bytes_per_second;
}

/// The process that was started to read `file`.
[[noreturn]] void answer(const std::filesystem::path& file) {
  std::FILE* const output = fdopen(dup(STDOUT_FILENO), "wb");
  dup2(STDERR_FILENO, STDOUT_FILENO); // what libraries print
  if (output == nullptr || ftruncate(STDERR_FILENO, 0) != 0 || lseek(STDERR_FILENO, 0, SEEK_SET) != 0) {
    std::_Exit(EXIT_FAILURE); // what was printed before this is not about the file
  }
  const rlim_t seconds = processor_seconds(file);
  const rlimit limit{seconds, seconds + 1};
  setrlimit(RLIMIT_CPU, &limit);
  int status = has_read;
  try {
    const Pixels pixels = images::read_pixels_here(file);
    std::fwrite(&pixels.geometry, sizeof pixels.geometry, 1, output);
    std::fwrite(pixels.values.data(), sizeof(float), pixels.values.size(), output);
  } catch (const std::exception& error) {
    std::fputs(error.what(), output);
    status = has_refused;
  }
  std::_Exit(std::ferror(output) == 0 && std::fclose(output) == 0 ? status : has_no_room);
}

/// What libraries printed about a file.
struct Printed {
  std::string complaint;            ///< the beginning of it, as one line of printable characters
  std::vector<std::string> remarks; ///< what is no reason to doubt its pixels
};

/// A warning of libpng about what is beside the pixels: colour profiles, times.
bool is_harmless(const std::string& line) {
  return line.starts_with("libpng warning: ") && line.find("IDAT") == std::string::npos &&
         line.find("image data") == std::string::npos && line.find("compressed") == std::string::npos;
}

/// libtiff also warns of what other programs may write into a file.
Printed printed_in(const std::string& text) {
  constexpr std::size_t most = 200;
  Printed printed;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    std::ranges::replace_if(
        line, [](char c) { return (c < ' ' || c > '~') && c != '\t'; }, '?');
    if (line.starts_with(images::remark_begin) || is_harmless(line)) {
      if (std::ranges::find(printed.remarks, line) == printed.remarks.end()) {
        printed.remarks.push_back(line);
      }
      continue;
    }
    std::istringstream words(line.find(": Warning, ") == std::string::npos ? line : "");
    for (std::string word; words >> word;) {
      printed.complaint += (printed.complaint.empty() ? "" : " ") + word;
    }
  }
  printed.complaint = printed.complaint.substr(0, most);
  return printed;
}

Pixels read_apart(const std::filesystem::path& file) {
  const MemoryFile output;
  const MemoryFile errors;
  // The bytes are enough for the most values as the file has them, as float, and once more.
  const ProcessOptions options{.seconds = 60.0 + 10.0 * static_cast<double>(processor_seconds(file)),
                               .resident_bytes = std::int64_t{20'000'000'000}};
  ProcessEnd end;
  try {
    end = ask_own_program(question, file.string(), output.path(), errors.path(), options);
  } catch (const InputError&) { // no process can be started here, which says nothing about the file
    return images::read_pixels_here(file);
  }
  if (end.exit_status == has_no_room) { // says nothing about the file
    rlimit allowed{};
    getrlimit(RLIMIT_FSIZE, &allowed);
    throw images::unreadable(
        file, allowed.rlim_cur == RLIM_INFINITY
                  ? "there is no memory for its pixels"
                  : fmt::format("files of {} bytes are allowed (ulimit -f), and its pixels need a larger one",
                                allowed.rlim_cur));
  }
  const auto [complaint, remarks] = printed_in(file_text(errors.path()));
  if (end.exit_status == has_refused) {
    throw InputError(file_text(output.path()) + (complaint.empty() ? "" : ": " + complaint));
  }
  if (end.exit_status == has_read && complaint.empty()) {
    std::ifstream stream(output.path(), std::ios::binary);
    Pixels pixels;
    stream.read(reinterpret_cast<char*>(&pixels.geometry), sizeof pixels.geometry);
    pixels.values.resize(pixels.geometry.values());
    stream.read(reinterpret_cast<char*>(pixels.values.data()),
                static_cast<std::streamsize>(pixels.values.size() * sizeof(float)));
    for (const std::string& remark : remarks) {
      fmt::print(stderr, "{}{}\n", remark,
                 remark.starts_with(images::remark_begin) ? "" : " (" + file.string() + ")");
    }
    return pixels;
  }
  const std::string happened =
      end.exit_status == has_read ? "" : fmt::format("its reader {}", end.sentence(options));
  throw images::unreadable(file, fmt::format("it is damaged or cut short: {}{}{}", happened,
                                             happened.empty() || complaint.empty() ? "" : "; ", complaint));
}

} // namespace

bool have_images() {
  return true;
}

void read_images_apart(int argc, const char* const* argv) {
  if (const auto file = asked_subject(argc, argv, question)) {
    answer(*file);
  }
  images::make_factories();
  reads_apart() = std::getenv("HDMBENCH_ASK_IN_PROCESS") == nullptr;
}

Pixels images::read_pixels(const std::filesystem::path& file) {
  require_regular_file(file); // ITK reports a folder and a missing file as an unknown format
  return reads_apart() ? read_apart(file) : read_pixels_here(file);
}

} // namespace hdmbench
