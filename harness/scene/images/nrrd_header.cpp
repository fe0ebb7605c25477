#include "harness/scene/images/pixels.hpp"

#include <cctype>
#include <fstream>

namespace hdmbench::images {

namespace {

std::string in_small_letters(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The texts between quotation marks that are not empty, and not NRRD's "???".
std::vector<std::string> quoted(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; (begin = text.find('"', begin)) != std::string::npos;) {
    const std::size_t end = std::min(text.find('"', begin + 1), text.size());
    std::string part = in_small_letters(text.substr(begin + 1, end - begin - 1));
    if (!part.empty() && part != "???") {
      parts.push_back(std::move(part));
    }
    begin = std::min(end + 1, text.size());
  }
  return parts;
}

double millimetres_of(const std::filesystem::path& file, const std::vector<std::string>& units) {
  static const std::map<std::string, double, std::less<>> known{
      {"mm", 1.0},          {"millimeter", 1.0},   {"millimeters", 1.0}, {"millimetre", 1.0},
      {"millimetres", 1.0}, {"um", 1e-3},          {"\xc2\xb5m", 1e-3},  {"\xce\xbcm", 1e-3},
      {"micron", 1e-3},     {"microns", 1e-3},     {"micrometer", 1e-3}, {"micrometers", 1e-3},
      {"micrometre", 1e-3}, {"micrometres", 1e-3}, {"nm", 1e-6},         {"nanometer", 1e-6},
      {"nanometers", 1e-6}, {"cm", 10.0},          {"centimeter", 10.0}, {"centimeters", 10.0},
      {"centimetre", 10.0}, {"centimetres", 10.0}, {"m", 1000.0},        {"meter", 1000.0},
      {"meters", 1000.0},   {"metre", 1000.0},     {"metres", 1000.0}};
  double unit = 1.0;
  for (const std::string& name : units) {
    const auto found = known.find(name);
    if (found == known.end() || (&name != &units.front() && found->second != unit)) {
      throw unreadable(
          file, fmt::format("its unit of length \"{}\" is not known, or axes have several; give mm", name));
    }
    unit = found->second;
  }
  return unit;
}

} // namespace

NrrdFields nrrd_fields(const std::filesystem::path& file) {
  NrrdFields fields;
  std::ifstream stream(file, std::ios::binary);
  constexpr std::size_t longest_line = std::size_t{1} << 16U;
  std::string line;
  const auto read_line = [&] {
    line.clear();
    for (int c = stream.get(); c != EOF && c != '\n' && line.size() < longest_line; c = stream.get()) {
      line += static_cast<char>(c);
    }
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    return !line.empty();
  };
  if (!read_line() || !line.starts_with("NRRD")) {
    return fields;
  }
  while (read_line()) {
    if (const std::size_t colon = line.find(": "); line.front() != '#' && colon != std::string::npos) {
      fields.emplace(in_small_letters(line.substr(0, colon)), line.substr(colon + 2));
    }
  }
  return fields;
}

void correct_nrrd_place(const std::filesystem::path& file, const NrrdFields& fields, Geometry& geometry) {
  const auto field = [&](std::string_view name) {
    const auto found = fields.find(name);
    std::string text = found == fields.end() ? "" : found->second;
    text.erase(std::min(text.find_last_not_of(" \t") + 1, text.size()));
    return text;
  };
  const std::string space = in_small_letters(field("space"));
  const bool is_las = space == "left-anterior-superior" || space == "las";
  if (!space.empty() && !is_las && space != "left-posterior-superior" && space != "lps" &&
      space != "right-anterior-superior" && space != "ras") {
    throw unreadable(
        file, fmt::format("its space is {}, which does not say where the patient's left, back and head "
                          "are, or has a time; give left-posterior-superior, "
                          "right-anterior-superior or left-anterior-superior",
                          space));
  }
  // ITK turns the first axis of this space, which leads to the left already, and not the second.
  for (std::size_t row = 0; is_las && row < 2; ++row) {
    geometry.origin[row] = 0.0 - geometry.origin[row];
    for (Placement::Vector& axis : geometry.axes) {
      axis[row] = 0.0 - axis[row];
    }
  }
  const bool has_directions = fields.contains("space directions");
  const double unit = millimetres_of(file, quoted(field(has_directions ? "space units" : "units")));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    geometry.spacing[axis] *= unit;
    geometry.origin[axis] *= unit;
  }
  geometry.stated = has_directions || fields.contains("space origin") ? Stated::place
                    : fields.contains("spacings")                     ? Stated::sides
                                                                      : Stated::nothing;
}

} // namespace hdmbench::images
