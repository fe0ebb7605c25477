#include "harness/scene/points.hpp"

#include "harness/scene/files.hpp"
#include "harness/scene/surfaces.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string_view>
#include <utility>

namespace hdmbench {

namespace {

namespace fs = std::filesystem;

struct NamedPoint {
  std::string name;
  Placement::Vector at{};
};

InputError wrong(const fs::path& file, int line, std::string_view why) {
  return InputError(fmt::format("{}:{}: {}", file.string(), line, why));
}

/// What stands between commas, or where there is none between blanks.
std::vector<std::string> words_of(const std::string& line) {
  const bool has_commas = line.find(',') != std::string::npos;
  std::vector<std::string> words;
  std::string word;
  const auto end_word = [&] {
    words.push_back(word);
    word.clear();
  };
  for (const char letter : line) {
    const bool is_blank = letter == ' ' || letter == '\t' || letter == '\r';
    if (has_commas ? letter == ',' : is_blank) {
      if (has_commas || !word.empty()) {
        end_word();
      }
    } else if (!is_blank) {
      word += letter;
    }
  }
  if (has_commas || !word.empty()) {
    end_word();
  }
  return words;
}

std::optional<double> number_of(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

/// Throws InputError where they are no finite numbers.
std::vector<double> numbers_of(const std::vector<std::string>& words, const fs::path& file, int line) {
  std::vector<double> values;
  for (const std::string& word : words) {
    const std::optional<double> value = number_of(word);
    if (!value || !std::isfinite(*value)) {
      throw wrong(file, line, fmt::format("\"{}\" is no number", word));
    }
    values.push_back(*value);
  }
  return values;
}

/// From Slicer's name of a space: LPS, or RAS, whose first two axes point the other way.
Placement::Vector in_lps(Placement::Vector at, std::string_view space, const fs::path& file, int line) {
  if (space == "RAS" || space == "0") {
    return Placement::turned(at);
  }
  if (space != "LPS" && space != "1") {
    throw wrong(file, line, fmt::format("the coordinate system \"{}\" is neither LPS nor RAS", space));
  }
  return at;
}

std::vector<NamedPoint> read_fcsv(const fs::path& file) {
  std::istringstream text(read_file(file));
  std::string space;
  std::vector<NamedPoint> points;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line.starts_with('#')) {
      constexpr std::string_view key = "CoordinateSystem";
      if (const std::size_t found = line.find(key); found != std::string::npos) {
        const std::vector<std::string> words = words_of(line.substr(found + key.size()));
        space = words.empty() ? "" : words.back();
      }
      continue;
    }
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) {
      continue;
    }
    if (words.size() < 4) {
      throw wrong(file, number, "a point is id,x,y,z,...");
    }
    const std::vector<double> at = numbers_of({words.begin() + 1, words.begin() + 4}, file, number);
    constexpr std::size_t label = 11;
    points.push_back(
        {words.size() > label ? words[label] : words[0], in_lps({at[0], at[1], at[2]}, space, file, number)});
  }
  return points;
}

std::vector<NamedPoint> read_markups(const fs::path& file) {
  try {
    const nlohmann::json markups = nlohmann::json::parse(read_file(file)).at("markups").at(0);
    std::vector<NamedPoint> points;
    for (const nlohmann::json& point : markups.at("controlPoints")) {
      const auto at = point.at("position").get<Placement::Vector>();
      points.push_back(
          {point.value("label", ""), in_lps(at, markups.value("coordinateSystem", ""), file, 1)});
    }
    return points;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(
        fmt::format("{}: is no file of points as 3D Slicer writes it: {}", file.string(), error.what()));
  }
}

std::vector<NamedPoint> read_points(const fs::path& file) {
  const std::string name = file.filename();
  std::vector<NamedPoint> points;
  if (name.ends_with(".fcsv")) {
    points = read_fcsv(file);
  } else if (name.ends_with(".json")) {
    points = read_markups(file);
  } else {
    throw InputError(
        fmt::format("{}: points before and after are in files of 3D Slicer's, .fcsv or .mrk.json, "
                    "or both on surfaces, .vtk, .ply, .obj or .stl; one file with lines of x y z dx dy dz "
                    "needs no second one",
                    file.string()));
  }
  if (points.empty()) {
    throw InputError(fmt::format("{}: has no points", file.string()));
  }
  return points;
}

} // namespace

std::vector<PointPair> read_point_pairs(const fs::path& before, const fs::path& after) {
  const std::vector<NamedPoint> from = read_points(before);
  const std::vector<NamedPoint> to = read_points(after);
  if (from.size() != to.size()) {
    throw InputError(fmt::format("{} has {} points, {} has {}: each needs its other one", before.string(),
                                 from.size(), after.string(), to.size()));
  }
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto same = std::ranges::find(from, to[i].name, &NamedPoint::name);
    if (same != from.end() && from[i].name != to[i].name) {
      throw InputError(
          fmt::format("point {} is \"{}\" in {} and \"{}\" in {}: give both files the same order", i + 1,
                      from[i].name, before.string(), to[i].name, after.string()));
    }
    pairs.push_back({from[i].name, from[i].at, to[i].at});
  }
  return pairs;
}

PointPair point_pair(std::span<const double> numbers, std::string name) {
  if (numbers.size() != 6 && numbers.size() != 7) {
    throw InputError(fmt::format("has {} numbers; a point is x y z dx dy dz, and perhaps its deviation (mm)",
                                 numbers.size()));
  }
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); })) {
    throw InputError(fmt::format("point {} has a number that is not finite", name));
  }
  PointPair pair{.name = std::move(name)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    pair.before[axis] = numbers[axis];
    pair.after[axis] = numbers[axis] + numbers[axis + 3];
  }
  if (numbers.size() == 7) {
    if (numbers[6] < 0.0) {
      throw InputError(fmt::format("a deviation of {} mm is below 0", numbers[6]));
    }
    pair.deviation = numbers[6];
  }
  return pair;
}

std::vector<PointPair> read_point_pairs(const fs::path& file) {
  if (file.extension() == ".fcsv" || file.extension() == ".json" || is_surface(file)) {
    throw InputError(
        fmt::format("{}: has points at one time; give those of before and those of after", file.string()));
  }
  std::istringstream text(read_file(file));
  std::vector<PointPair> pairs;
  int number = 0;
  bool may_be_title = true;
  for (std::string line; std::getline(text, line);) {
    ++number;
    const std::vector<std::string> words = words_of(line.substr(0, line.find('#')));
    if (words.empty()) {
      continue;
    }
    if (std::exchange(may_be_title, false) && !number_of(words[0])) {
      continue;
    }
    const std::vector<double> values = numbers_of(words, file, number);
    try {
      pairs.push_back(point_pair(values, std::to_string(pairs.size() + 1)));
    } catch (const InputError& error) {
      throw wrong(file, number, error.what());
    }
  }
  if (pairs.empty()) {
    throw InputError(fmt::format("{}: has no points", file.string()));
  }
  return pairs;
}

} // namespace hdmbench
