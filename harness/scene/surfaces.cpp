#include "harness/scene/surfaces.hpp"

#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <sstream>
#include <utility>

namespace hdmbench {

namespace {

namespace fs = std::filesystem;

using Words = std::vector<std::string>;
using Triangle = std::array<std::size_t, 3>;

struct Surface {
  std::vector<Placement::Vector> vertices; ///< millimetres, in the space of the file
  std::vector<Triangle> triangles;
};

enum class Coding { text, little_endian, big_endian };

/// A file from its beginning to its end, as lines and as numbers.
class SurfaceFile {
public:
  explicit SurfaceFile(fs::path file) : file_(std::move(file)), bytes_(read_file(file_)) {}

  Coding coding = Coding::text; ///< of the numbers that follow

  [[nodiscard]] InputError wrong(std::string_view why) const {
    return InputError(fmt::format("{}: {}", file_.string(), why));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] bool is_at_end() const { return at_ >= bytes_.size(); }
  void go_to(std::size_t at) { at_ = at; }

  /// The words of the rest of the line; they are none at the end.
  Words words() {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::istringstream line(bytes_.substr(at_, end - at_));
    at_ = std::min(end + 1, bytes_.size());
    return {std::istream_iterator<std::string>(line), {}};
  }

  [[nodiscard]] double parsed(const std::string& word) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      throw wrong(fmt::format("\"{}\" is no number", word));
    }
    return value;
  }

  /// The next number, of a type as VTK and PLY name it where it is binary.
  double number(std::string_view type) {
    if (coding == Coding::text) {
      const std::string_view blanks = " \t\r\n";
      at_ = std::min(bytes_.find_first_not_of(blanks, at_), bytes_.size());
      const std::size_t end = std::min(bytes_.find_first_of(blanks, at_), bytes_.size());
      return parsed(bytes_.substr(std::exchange(at_, end), end - at_));
    }
    const auto is = [&](std::string_view one, std::string_view other) {
      return type == one || type == other;
    };
    return is("float", "float32")    ? binary<float>()
           : is("double", "float64") ? binary<double>()
           : is("int", "int32")      ? binary<std::int32_t>()
           : is("uint", "uint32")    ? binary<std::uint32_t>()
           : is("short", "int16")    ? binary<std::int16_t>()
           : is("ushort", "uint16")  ? binary<std::uint16_t>()
           : is("char", "int8")      ? binary<std::int8_t>()
           : is("uchar", "uint8")    ? binary<std::uint8_t>()
           : type == "vtktypeint64"
               ? binary<std::int64_t>()
               : throw wrong(fmt::format("\"{}\" is no type of numbers that is read", type));
  }

  Placement::Vector vector(std::string_view type) {
    Placement::Vector at{};
    std::ranges::generate(at, [&] { return number(type); });
    return at;
  }

private:
  template <typename Number>
  double binary() {
    std::array<char, sizeof(Number)> bytes{};
    if (bytes_.size() - at_ < bytes.size()) {
      throw wrong("ends before its numbers do");
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), bytes.size(), bytes.begin());
    at_ += bytes.size();
    if ((coding == Coding::big_endian) != (std::endian::native == std::endian::big)) {
      std::ranges::reverse(bytes);
    }
    const auto value = static_cast<double>(std::bit_cast<Number>(bytes));
    if (!std::isfinite(value)) {
      throw wrong("has a number that is not finite");
    }
    return value;
  }

  fs::path file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

/// Adds the triangles of a polygon, which meet in its first corner.
void add_polygon(const SurfaceFile& file, const std::vector<double>& corners, Surface& surface) {
  const auto index = [&](double corner) {
    if (!(corner >= 0.0 && corner < static_cast<double>(surface.vertices.size()))) {
      throw file.wrong(
          fmt::format("a polygon has the vertex {}, and there are {}", corner, surface.vertices.size()));
    }
    return static_cast<std::size_t>(corner);
  };
  for (std::size_t i = 2; i < corners.size(); ++i) {
    surface.triangles.push_back({index(corners[0]), index(corners[i - 1]), index(corners[i])});
  }
}

/// The cells of a section of VTK's, as it wrote them before version 5 and since.
std::vector<std::vector<double>> read_cells(SurfaceFile& file, const Words& head, bool has_offsets) {
  std::vector<std::vector<double>> cells;
  const double count = file.parsed(head.at(1));
  if (!has_offsets) {
    for (double i = 0.0; i < count; ++i) {
      auto& cell = cells.emplace_back();
      for (double left = file.number("int"); left > 0.0; --left) {
        cell.push_back(file.number("int"));
      }
    }
    return cells;
  }
  const auto read = [&](std::string_view key, double numbers) {
    Words words = file.words();
    while (words.empty() && !file.is_at_end()) {
      words = file.words();
    }
    if (words.size() != 2 || words[0] != key) {
      throw file.wrong(fmt::format("has no {} where they belong", key));
    }
    std::vector<double> values;
    for (double i = 0.0; i < numbers; ++i) {
      values.push_back(file.number(words[1]));
    }
    return values;
  };
  const std::vector<double> offsets = read("OFFSETS", count);
  const std::vector<double> corners = read("CONNECTIVITY", file.parsed(head.at(2)));
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    if (!(offsets[i - 1] >= 0.0 && offsets[i] >= offsets[i - 1] &&
          offsets[i] <= static_cast<double>(corners.size()))) {
      throw file.wrong("its OFFSETS are none of its CONNECTIVITY");
    }
    cells.emplace_back(corners.begin() + static_cast<std::ptrdiff_t>(offsets[i - 1]),
                       corners.begin() + static_cast<std::ptrdiff_t>(offsets[i]));
  }
  return cells;
}

Surface read_vtk(SurfaceFile& file) {
  const Words version = file.words();
  (void)file.words(); // a title
  const Words coding = file.words();
  if (version.size() != 5 || version[1] != "vtk" || file.words() != Words{"DATASET", "POLYDATA"}) {
    throw file.wrong("is no PolyData of VTK's legacy format");
  }
  const bool has_offsets = file.parsed(version[4]) >= 5.0;
  file.coding = coding == Words{"BINARY"} ? Coding::big_endian : Coding::text;
  Surface surface;
  while (!file.is_at_end()) {
    const Words words = file.words();
    if (words.empty()) {
      continue;
    }
    if (words[0] == "METADATA") {
      while (!file.words().empty()) {
      }
    } else if (words[0] == "POINTS" && words.size() == 3) {
      for (double left = file.parsed(words[1]); left > 0.0; --left) {
        surface.vertices.push_back(file.vector(words[2]));
      }
    } else if ((words[0] == "VERTICES" || words[0] == "LINES" || words[0] == "POLYGONS") &&
               words.size() == 3) {
      const std::vector<std::vector<double>> cells = read_cells(file, words, has_offsets);
      for (std::size_t i = 0; words[0] == "POLYGONS" && i < cells.size(); ++i) {
        add_polygon(file, cells[i], surface);
      }
    } else if (words[0] == "TRIANGLE_STRIPS") {
      throw file.wrong("has strips of triangles; write it with polygons");
    } else {
      break; // what belongs to vertices and cells
    }
  }
  return surface;
}

/// What a PLY file has many of, and the words of the lines that say what one has.
struct PlyElement {
  std::string name;
  double count = 0.0;
  std::vector<Words> properties;
};

std::vector<PlyElement> read_ply_header(SurfaceFile& file) {
  if (file.words() != Words{"ply"}) {
    throw file.wrong("is no PLY file");
  }
  std::vector<PlyElement> elements;
  Coding coding = Coding::text;
  for (Words words = file.words(); words != Words{"end_header"}; words = file.words()) {
    const std::string_view key = words.empty() ? "" : std::string_view(words[0]);
    if (key == "format" && words.size() == 3) {
      coding = words[1] == "ascii"                  ? Coding::text
               : words[1] == "binary_little_endian" ? Coding::little_endian
               : words[1] == "binary_big_endian"
                   ? Coding::big_endian
                   : throw file.wrong(fmt::format("\"{}\" is no format of PLY files", words[1]));
    } else if (key == "element" && words.size() == 3) {
      elements.push_back({.name = words[1], .count = file.parsed(words[2]), .properties = {}});
    } else if (key == "property" && words.size() >= 3 && !elements.empty() &&
               words.size() == (words[1] == "list" ? 5U : 3U)) {
      elements.back().properties.push_back(words);
    } else if (key != "comment" && key != "obj_info") {
      throw file.wrong("has a header that does not end, or is not understood");
    }
  }
  for (const PlyElement& element : elements) {
    if (element.properties.empty()) { // its many would be read from nothing, for ever
      throw file.wrong(fmt::format("its element {} has no property", element.name));
    }
  }
  file.coding = coding;
  return elements;
}

Surface read_ply(SurfaceFile& file) {
  Surface surface;
  for (const PlyElement& element : read_ply_header(file)) {
    for (double left = element.count; left > 0.0; --left) {
      Placement::Vector place{};
      for (const Words& property : element.properties) {
        const std::string& name = property.back();
        if (property[1] == "list") {
          std::vector<double> values;
          for (double more = file.number(property[2]); more > 0.0; --more) {
            values.push_back(file.number(property[3]));
          }
          if (element.name == "face" && name.starts_with("vertex_ind")) { // -ices, or -ex
            add_polygon(file, values, surface);
          }
        } else {
          const double value = file.number(property[1]);
          const std::size_t axis = std::string_view("xyz").find(name);
          if (name.size() == 1 && axis < place.size()) {
            place[axis] = value;
          }
        }
      }
      if (element.name == "vertex") {
        surface.vertices.push_back(place);
      }
    }
  }
  return surface;
}

Surface read_obj(SurfaceFile& file) {
  Surface surface;
  while (!file.is_at_end()) {
    const Words words = file.words();
    if (words.size() >= 4 && words[0] == "v") {
      surface.vertices.push_back({file.parsed(words[1]), file.parsed(words[2]), file.parsed(words[3])});
    } else if (words.size() >= 4 && words[0] == "f") {
      std::vector<double> corners;
      for (std::size_t i = 1; i < words.size(); ++i) {
        const double number = file.parsed(words[i].substr(0, words[i].find('/'))); // from 1, or from the end
        corners.push_back(number < 0.0 ? static_cast<double>(surface.vertices.size()) + number
                                       : number - 1.0);
      }
      add_polygon(file, corners, surface);
    }
  }
  return surface;
}

Surface read_stl(SurfaceFile& file) {
  Surface surface;
  constexpr std::size_t head = 80;
  constexpr std::size_t facet = 50; // a normal, three corners, two bytes
  const std::size_t rest = std::max(file.bytes().size(), head + 4) - head - 4;
  file.go_to(head);
  file.coding = Coding::little_endian;
  if (file.bytes().size() >= head + 4 && file.number("int") * double{facet} == static_cast<double>(rest)) {
    for (std::size_t at = head + 4; at < file.bytes().size(); at += facet) {
      file.go_to(at + 3 * sizeof(float));
      std::generate_n(std::back_inserter(surface.vertices), 3, [&] { return file.vector("float"); });
    }
  } else {
    file.go_to(0);
    while (!file.is_at_end()) {
      const Words words = file.words();
      if (words.size() == 4 && words[0] == "vertex") {
        surface.vertices.push_back({file.parsed(words[1]), file.parsed(words[2]), file.parsed(words[3])});
      }
    }
  }
  for (std::size_t i = 0; i + 2 < surface.vertices.size(); i += 3) {
    surface.triangles.push_back({i, i + 1, i + 2});
  }
  return surface;
}

constexpr std::array<std::pair<std::string_view, Surface (*)(SurfaceFile&)>, 4> formats{
    {{".vtk", read_vtk}, {".ply", read_ply}, {".obj", read_obj}, {".stl", read_stl}}};

const auto* format_of(const fs::path& file) {
  const std::string end = file.extension();
  return std::ranges::find(formats, end, [](const auto& format) { return format.first; });
}

/// The surface in LPS, with triangles or without.
Surface read_surface(const fs::path& path, std::string_view space) {
  SurfaceFile file(path);
  constexpr std::size_t header = 4096; // 3D Slicer says it in a title or a remark at the beginning
  const std::string_view begin = std::string_view(file.bytes()).substr(0, header);
  for (const std::string_view one : {"LPS", "RAS"}) {
    if (begin.find(fmt::format("SPACE={}", one)) != std::string_view::npos) {
      if (!space.empty() && space != one) {
        throw file.wrong(fmt::format("says that it is in {}, and not in {}", one, space));
      }
      space = one;
    }
  }
  if (space.empty()) {
    throw file.wrong("does not say where it lies: give [[points]] a space = \"LPS\" or \"RAS\"");
  }
  const auto* const format = format_of(path);
  Surface surface = format->second(file);
  if (surface.vertices.empty()) {
    throw file.wrong("has no vertices");
  }
  if (space == "RAS") {
    std::ranges::transform(surface.vertices, surface.vertices.begin(), Placement::turned);
  }
  return surface;
}

Placement::Vector combined(const std::array<Placement::Vector, 3>& corners, double u, double v) {
  Placement::Vector at{};
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = corners[0][i] + u * (corners[1][i] - corners[0][i]) + v * (corners[2][i] - corners[0][i]);
  }
  return at;
}

double distance(const Placement::Vector& from, const Placement::Vector& to) {
  return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

/// Cuts a triangle into n * n alike pieces, and adds one pair a piece.
void add_pieces(const std::array<Placement::Vector, 3>& from, const std::array<Placement::Vector, 3>& to,
                const std::string& name, std::vector<PointPair>& pairs) {
  const double a = distance(from[0], from[1]);
  const double b = distance(from[1], from[2]);
  const double c = distance(from[2], from[0]);
  const double half = 0.5 * (a + b + c);
  const double area =
      std::sqrt(std::max(0.0, half * (half - a) * (half - b) * (half - c))); // Heron's formula
  const double n = std::max(1.0, std::ceil(std::max({a, b, c}) / point_reach));
  constexpr double most = 1e7; // pieces: gigabytes
  if (static_cast<double>(pairs.size()) + n * n > most) {
    throw InputError(fmt::format("{}: has more than {} pieces of {} mm; are its vertices in millimetres?",
                                 name, most, point_reach));
  }
  const auto add = [&](double u, double v) {
    pairs.push_back({.name = name,
                     .before = combined(from, u / n, v / n),
                     .after = combined(to, u / n, v / n),
                     .area = area / (n * n)});
  };
  constexpr double third = 1.0 / 3.0;
  for (double i = 0.0; area > 0.0 && i < n; ++i) {
    for (double j = 0.0; i + j < n; ++j) {
      add(i + third, j + third);
      if (i + j + 1.0 < n) {
        add(i + 2.0 * third, j + 2.0 * third);
      }
    }
  }
}

} // namespace

bool is_surface(const fs::path& file) {
  return format_of(file) != formats.end();
}

std::vector<PointPair> read_surface_pairs(const fs::path& before, const fs::path& after,
                                          std::string_view space) {
  const Surface from = read_surface(before, space);
  const Surface to = read_surface(after, space);
  const auto refuse_other = [&](std::string_view what, std::size_t in_before, std::size_t in_after) {
    if (in_before != in_after) {
      throw InputError(fmt::format("{} has {} {}, {} has {}: a surface that moved has the same ones in the "
                                   "same order",
                                   before.string(), in_before, what, after.string(), in_after));
    }
  };
  refuse_other("vertices", from.vertices.size(), to.vertices.size());
  refuse_other("triangles", from.triangles.size(), to.triangles.size());
  std::vector<PointPair> pairs;
  const std::string name = before.filename();
  for (std::size_t i = 0; i < from.triangles.size(); ++i) {
    const Triangle& corners = from.triangles[i];
    if (corners != to.triangles[i]) {
      throw InputError(fmt::format("triangle {} has other corners in {} than in {}", i + 1, after.string(),
                                   before.string()));
    }
    add_pieces({from.vertices[corners[0]], from.vertices[corners[1]], from.vertices[corners[2]]},
               {to.vertices[corners[0]], to.vertices[corners[1]], to.vertices[corners[2]]}, name, pairs);
  }
  for (std::size_t i = 0; from.triangles.empty() && i < from.vertices.size(); ++i) {
    pairs.push_back({.name = std::to_string(i + 1), .before = from.vertices[i], .after = to.vertices[i]});
  }
  return pairs;
}

} // namespace hdmbench
