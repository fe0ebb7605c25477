#include "harness/tools/thesis_tools.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/names.hpp"
#include "harness/tools/field_lines.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <fstream>

namespace hdmbench {

namespace {

/// Also a text whose first line is damaged gets here, so that the error says what stands there.
bool is_text(const std::filesystem::path& file) {
  if (file.extension() == ".txt") {
    return true;
  }
  require_regular_file(file);
  std::array<char, 6> start{};
  std::ifstream(file, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == "Width=";
}

/// The number of a line such as "Width=300".
int read_side(FieldLines& lines, std::string_view key) {
  if (!lines.next()) {
    lines.fail_file(fmt::format("ends before the line {}=...", key));
  }
  const std::string_view text = lines.fields().front();
  const std::string start = fmt::format("{}=", key);
  if (lines.fields().size() == 1 && text.starts_with(start)) {
    if (const auto side = number_of<int>(text.substr(start.size())); side.value_or(0) >= 1) {
      return *side;
    }
  }
  lines.fail(fmt::format("{}=... with a whole number from 1 on is expected, not \"{}\"", key, text));
}

std::vector<float> read_component(FieldLines& lines, std::string_view axis, Extent extent) {
  if (!lines.next()) {
    lines.fail_file(fmt::format("ends before the line \"{} Trans ---\"", axis));
  }
  if (lines.fields().size() < 2 || lines.fields()[0] != axis || lines.fields()[1] != "Trans") {
    lines.fail(fmt::format("\"{} Trans ---\" is expected", axis));
  }
  std::vector<float> values;
  values.reserve(extent.sites());
  for (int row = 0; row < extent.height; ++row) {
    if (!lines.next()) {
      lines.fail_file(fmt::format("ends after {} of {} rows of {} Trans", row, extent.height, axis));
    }
    if (lines.fields().size() != static_cast<std::size_t>(extent.width)) {
      lines.fail(fmt::format("row {} of {} Trans has {} numbers, the image is {} pixels wide", row, axis,
                             lines.fields().size(), extent.width));
    }
    for (std::size_t column = 0; column < lines.fields().size(); ++column) {
      values.push_back(static_cast<float>(lines.number(column, "position")));
    }
  }
  return values;
}

VectorField read_text(const std::filesystem::path& file) {
  FieldLines lines(file);
  Extent extent;
  extent.width = read_side(lines, "Width");
  extent.height = read_side(lines, "Height");
  constexpr std::size_t least_bytes = 4; // a digit and a separator for x and for y
  if (extent.sites() > lines.size() / least_bytes + 1) {
    lines.fail_file(
        fmt::format("promises {} pixels, which its {} bytes cannot hold", extent.text(), lines.size()));
  }
  VectorField positions;
  positions.extent = extent;
  positions[0] = read_component(lines, "X", extent);
  positions[1] = read_component(lines, "Y", extent);
  if (lines.next()) {
    lines.fail("more rows than Height says");
  }
  return positions;
}

} // namespace

Image<VectorField> read_positions(const std::filesystem::path& file) {
  if (is_text(file)) {
    return {read_text(file), 1.0};
  }
  auto image = read_vector(file);
  try {
    validate(image.pixels, image.pixels.extent, "the position");
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  return image;
}

VectorField displacements_from_positions(const VectorField& positions) {
  VectorField displacement(positions.extent);
  for_each_site(positions.extent, [&](int x, int y) {
    const auto site = positions.extent.index(x, y);
    displacement[0][site] = static_cast<float>(double{positions[0][site]} - x);
    displacement[1][site] = static_cast<float>(double{positions[1][site]} - y);
  });
  return displacement;
}

} // namespace hdmbench
