#include "harness/judge/registration/ways.hpp"

#include "backends/shared/subprocess.hpp"
#include "harness/applications/picture.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/temporary_directory.hpp"
#include "harness/solve/stopwatch.hpp"
#include "kernels/data/input_error.hpp"

#include <elastix_text.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iterator>
#include <ranges>
#include <string>
#include <vector>

#include <unistd.h>

namespace hdmbench {

namespace {

namespace fs = std::filesystem;

/// Two axes, which is what elastix takes for a picture; pixels have sides of 1. `type`: MET_FLOAT, MET_UCHAR.
template <typename Value>
void write_picture(const fs::path& file, Extent extent, std::string_view type,
                   const std::vector<Value>& values) {
  std::string text = fmt::format("ObjectType = Image\nNDims = 2\nDimSize = {} {}\nElementSpacing = 1 1\n"
                                 "Offset = 0 0\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                                 "ElementType = {}\nElementDataFile = LOCAL\n",
                                 extent.width, extent.height, type);
  text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
  write_text(file, text);
}

void run(const std::vector<std::string>& words, const fs::path& folder) {
  const fs::path output = folder / "output.txt";
  const ProcessEnd end =
      run_process(words, output, folder / "errors.txt", {.advice = "Install Debian's package elastix"});
  if (!end.good()) {
    std::string said = file_text(folder / "errors.txt") + file_text(output);
    said.erase(
        std::find_if_not(said.rbegin(), said.rend(), [](char c) { return std::isspace(c) != 0; }).base(),
        said.end());
    throw InputError(fmt::format("{} ended with {}: {}", words.front(), end.text(),
                                 said.substr(said.find_last_of('\n') + 1)));
  }
}

} // namespace

bool is_installed(std::string_view program) {
  const char* const path = std::getenv("PATH");
  return path != nullptr &&
         std::ranges::any_of(std::string_view(path) | std::views::split(':'), [&](const auto& folder) {
           const fs::path file = fs::path(folder.begin(), folder.end()) / program;
           return fs::is_regular_file(file) && access(file.c_str(), X_OK) == 0;
         });
}

ElastixRegistration register_with_elastix(const ScalarField& source, const ScalarField& target,
                                          const ScalarField& unseen) {
  require_pair(source, target);
  const TemporaryDirectory folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  const Clock clock;
  write_picture(file("source.mha"), source.extent, "MET_FLOAT", source.values);
  write_picture(file("target.mha"), target.extent, "MET_FLOAT", target.values);
  write_text(file("parameters.txt"), sources::elastix_text);
  const std::string output = folder.path().string();
  std::vector<std::string> words{"elastix", "-threads",        "1", "-f", file("source.mha"),
                                 "-m",      file("target.mha")};
  words.insert(words.end(), {"-p", file("parameters.txt"), "-out", output});
  if (!unseen.values.empty()) {
    std::vector<unsigned char> seen;
    std::ranges::transform(unseen.values, std::back_inserter(seen),
                           [](float value) { return static_cast<unsigned char>(value == 0.0F); });
    write_picture(file("mask.mha"), unseen.extent, "MET_UCHAR", seen);
    words.insert(words.end(), {"-fMask", file("mask.mha")});
  }
  run(words, folder.path());
  // Its transform takes points of the fixed picture, the source, to points of the moving one: as ours.
  run({"transformix", "-def", "all", "-tp", file("TransformParameters.0.txt"), "-out", output, "-threads",
       "1"},
      folder.path());
  ElastixRegistration result;
  result.displacement = read_vector(file("deformationField.mha")).pixels;
  result.seconds = clock.seconds();
  if (result.displacement.extent != source.extent) {
    throw InputError(fmt::format("transformix wrote a field of {} x {}", result.displacement.extent.width,
                                 result.displacement.extent.height));
  }
  return result;
}

} // namespace hdmbench
