#include "harness/scene/images/intact.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace hdmbench::images {

namespace {

constexpr int most_axes = 10; // MetaIO has fixed arrays, and fixed buffers for a line and its key
constexpr std::size_t longest_line = 4000;
constexpr std::size_t longest_key = 200;
constexpr double largest = 1e10; // of a length or a coordinate; beyond, ITK's inverse is not finite

constexpr std::size_t longest_text = 250;

/// What a value consists of; the last four are numbers, so many for each axis or each pair of axes.
enum class Kind { text, type, whole, number, colour, sizes, lengths, per_axis, per_pair };

/// All that MetaIO gives a meaning in images. Other keys are the user's own.
const std::map<std::string_view, Kind> known_keys{{"AcquisitionDate", Kind::text},
                                                  {"AnatomicalOrientation", Kind::text},
                                                  {"BinaryData", Kind::text},
                                                  {"BinaryDataByteOrderMSB", Kind::text},
                                                  {"Comment", Kind::text},
                                                  {"CompressedData", Kind::text},
                                                  {"DistanceUnits", Kind::text},
                                                  {"ElementByteOrderMSB", Kind::text},
                                                  {"ElementDataFile", Kind::text},
                                                  {"Modality", Kind::text},
                                                  {"Name", Kind::text},
                                                  {"ObjectSubType", Kind::text},
                                                  {"ObjectType", Kind::text},
                                                  {"TransformType", Kind::text},
                                                  {"ElementType", Kind::type},
                                                  {"CompressedDataSize", Kind::whole},
                                                  {"CompressionLevel", Kind::whole},
                                                  {"ElementNBits", Kind::whole},
                                                  {"ElementNumberOfChannels", Kind::whole},
                                                  {"HeaderSize", Kind::whole},
                                                  {"ID", Kind::whole},
                                                  {"NDims", Kind::whole},
                                                  {"ParentID", Kind::whole},
                                                  {"ElementMax", Kind::number},
                                                  {"ElementMin", Kind::number},
                                                  {"ElementToIntensityFunctionOffset", Kind::number},
                                                  {"ElementToIntensityFunctionSlope", Kind::number},
                                                  {"Color", Kind::colour},
                                                  {"DimSize", Kind::sizes},
                                                  {"ElementSize", Kind::lengths},
                                                  {"ElementSpacing", Kind::lengths},
                                                  {"CenterOfRotation", Kind::per_axis},
                                                  {"ImagePosition", Kind::per_axis},
                                                  {"Offset", Kind::per_axis},
                                                  {"Origin", Kind::per_axis},
                                                  {"Position", Kind::per_axis},
                                                  {"SequenceID", Kind::per_axis},
                                                  {"Orientation", Kind::per_pair},
                                                  {"Rotation", Kind::per_pair},
                                                  {"TransformMatrix", Kind::per_pair}};

constexpr std::array<std::string_view, 12> types{
    "MET_CHAR", "MET_UCHAR", "MET_SHORT",     "MET_USHORT",     "MET_INT",   "MET_UINT",
    "MET_LONG", "MET_ULONG", "MET_LONG_LONG", "MET_ULONG_LONG", "MET_FLOAT", "MET_DOUBLE"};

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

template <typename Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() ? std::optional(value)
                                                                             : std::nullopt;
}

/// Whether `text` is `count` words, all of which fulfil `good`.
template <typename Good>
bool are_words(std::string_view text, int count, Good good) {
  int found = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(" \t"), text.size());
    if (!good(text.substr(0, end))) {
      return false;
    }
    text = trimmed(text.substr(end));
    ++found;
  }
  return found == count;
}

bool is_coordinate(std::string_view word) {
  const auto value = parse<double>(word);
  return value && std::abs(*value) <= largest;
}

bool is_length(std::string_view word) {
  const auto value = parse<double>(word);
  return value && *value >= 1.0 / largest && *value <= largest;
}

bool is_size(std::string_view word) {
  const auto value = parse<int>(word);
  return value && *value >= 1;
}

bool is_good(Kind kind, std::string_view value, int axes) {
  switch (kind) {
  case Kind::text:
    return value.size() <= longest_text;
  case Kind::whole:
    return parse<int>(value).has_value();
  case Kind::number:
    return is_coordinate(value);
  case Kind::colour:
    return are_words(value, 4, is_coordinate);
  case Kind::sizes:
    return are_words(value, axes, is_size);
  case Kind::per_axis:
    return are_words(value, axes, is_coordinate);
  case Kind::lengths:
    return are_words(value, axes, is_length);
  case Kind::per_pair:
    return are_words(value, axes * axes, is_coordinate);
  case Kind::type:
    return std::ranges::find(types, value) != types.end();
  }
  return false;
}

bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c >= ' ' || c == '\t'; });
}

class Header {
public:
  explicit Header(const std::filesystem::path& file) : file_(file) {}

  void read() {
    std::ifstream stream(file_, std::ios::binary);
    std::string line(longest_line + 1, '\0');
    while (stream.getline(line.data(), static_cast<std::streamsize>(line.size()))) {
      ++line_;
      // The end of the line counts as read, that of the file does not.
      const auto length = stream.gcount() - (stream.eof() ? 0 : 1);
      if (read_line(trimmed({line.data(), static_cast<std::size_t>(length)}))) {
        require("DimSize");
        require("ElementType");
        return;
      }
    }
    fail("the header ends without ElementDataFile, or a line is too long");
  }

private:
  /// Whether it was the last one.
  bool read_line(std::string_view line) {
    const auto equals = line.find('=');
    const std::string_view key = trimmed(line.substr(0, equals));
    if (equals == std::string_view::npos || key.empty() || !is_printable(line) ||
        key.find(':') != std::string_view::npos || key.size() > longest_key) {
      fail("it is not \"Key = Value\"");
    }
    const std::string_view value = trimmed(line.substr(equals + 1));
    if (!lines_.emplace(key, line_).second) {
      fail(fmt::format("{} is in line {} already", key, lines_.find(key)->second));
    }
    if (key == "NDims") {
      axes_ = parse<int>(value).value_or(0);
      if (axes_ < 1 || axes_ > most_axes) {
        fail(fmt::format("NDims must be 1 ... {}", most_axes));
      }
    }
    if (const auto known = known_keys.find(key); known != known_keys.end()) {
      if (known->second >= Kind::sizes) {
        require("NDims");
      }
      if (!is_good(known->second, value, axes_)) {
        fail(fmt::format("{} cannot be \"{}\"", key, value));
      }
    }
    return key == "ElementDataFile";
  }

  void require(std::string_view key) const {
    if (!lines_.contains(key)) {
      fail(fmt::format("{} must have come before", key));
    }
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw InputError(fmt::format("cannot read the image {}: line {} of its MetaImage header: {}",
                                 file_.string(), line_, what));
  }

  const std::filesystem::path& file_;
  std::map<std::string, int, std::less<>> lines_; ///< where a key was
  int line_ = 0;
  int axes_ = 0;
};

} // namespace

void require_sound_meta_header(const std::filesystem::path& file) {
  Header(file).read();
}

} // namespace hdmbench::images
