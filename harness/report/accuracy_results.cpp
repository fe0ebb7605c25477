#include "harness/report/accuracy_results.hpp"

#include "harness/report/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::report {

namespace {

// A writer may leave a key out or put null where it does not apply.
std::string text_if_any(const JsonReader& json, const std::string& key) {
  return json.holds(key) ? json.text(key) : "";
}

std::optional<double> number_if_any(const JsonReader& json, const std::string& key) {
  return json.holds(key) ? json.number_or_null(key) : std::nullopt;
}

std::vector<JsonReader> objects_if_any(const JsonReader& json, const std::string& key) {
  return json.holds(key) ? json.objects(key) : std::vector<JsonReader>{};
}

void require_not_negative(const JsonReader& json, const std::string& key, double value) {
  if (!(value >= 0.0)) {
    json.fail(key, fmt::format("is {}, but must not be negative", value));
  }
}

std::optional<double> distance_if_any(const JsonReader& json, const std::string& key) {
  const std::optional<double> value = number_if_any(json, key);
  if (value) {
    require_not_negative(json, key, *value);
  }
  return value;
}

double distance(const JsonReader& json, const std::string& key) {
  const double value = json.number(key);
  require_not_negative(json, key, value);
  return value;
}

Rmsd read_rmsd(const JsonReader& json, const std::string& truth) {
  return {distance_if_any(json, "rmsd_to_" + truth), distance_if_any(json, "rmsd_free_to_" + truth)};
}

void require_length(const JsonReader& json, const std::string& key, std::size_t found, std::int64_t wanted,
                    const std::string& of_what) {
  if (static_cast<std::int64_t>(found) != wanted) {
    json.fail(key, fmt::format("has {} values, but {} is {}", found, of_what, wanted));
  }
}

std::optional<InterfaceRmsd> read_interface(const JsonReader& json) {
  if (!json.holds("rmsd_interface_to_fem") && !json.holds("rmsd_elsewhere_to_fem")) {
    return std::nullopt;
  }
  InterfaceRmsd result;
  result.near = distance_if_any(json, "rmsd_interface_to_fem");
  result.elsewhere = distance_if_any(json, "rmsd_elsewhere_to_fem");
  result.near_sites = json.count("interface_sites");
  result.elsewhere_sites = json.count("elsewhere_sites");
  return result;
}

Decomposition read_decomposition(const JsonReader& json) {
  Decomposition result;
  result.poisson = json.number("poisson");
  result.total = distance(json, "total");
  result.model = distance(json, "model");
  result.optimisation = distance(json, "optimisation");
  result.covariance = json.number("covariance");
  result.remainder = json.number("remainder");
  // The one that is written must be small, and be what the others leave.
  const double total = result.total * result.total;
  const double left = total - (result.model * result.model + result.optimisation * result.optimisation +
                               2.0 * result.covariance);
  for (const double remainder : {result.remainder, left}) {
    if (!(std::abs(remainder) <= 1e-9 * (total + 1.0))) {
      json.fail("remainder",
                fmt::format("is {:.3g} px^2: model^2 + optimisation^2 + 2 covariance is not total^2 = {:.6g}",
                            remainder, total));
    }
  }
  return result;
}

Arithmetic read_arithmetic(const JsonReader& json) {
  Arithmetic result;
  result.run_rmsd = distance_if_any(json, "double_rmsd");
  const JsonReader steps = json.object("resynchronised");
  result.iterations = steps.count("iterations");
  result.steps_compared = steps.count("steps_compared");
  result.steps_differing = steps.count("steps_differing");
  result.largest_gap_over_bound = distance_if_any(steps, "largest_gap_over_bound");
  result.iteration_rmsd = distance_if_any(steps, "rmsd");
  result.beyond_bound = steps.count("beyond_bound");
  if (result.steps_differing > result.steps_compared) {
    steps.fail("steps_differing", fmt::format("is {}, but only {} were compared", result.steps_differing,
                                              result.steps_compared));
  }
  if (result.beyond_bound > result.steps_differing) {
    steps.fail("beyond_bound",
               fmt::format("is {}, but only {} steps differ", result.beyond_bound, result.steps_differing));
  }
  if (result.beyond_bound == 0 && result.largest_gap_over_bound.value_or(0.0) > 1.0) {
    steps.fail("largest_gap_over_bound",
               fmt::format("is {}, but \"beyond_bound\" is 0", *result.largest_gap_over_bound));
  }
  return result;
}

Convergence read_convergence(const JsonReader& json) {
  Convergence result;
  result.iterations_per_level = json.numbers("iterations_per_level");
  const std::vector<double>& iterations = result.iterations_per_level;
  if (iterations.empty() || iterations.front() < 1.0 ||
      std::ranges::adjacent_find(iterations, std::greater_equal<>()) != iterations.end()) {
    json.fail("iterations_per_level", "must rise from at least 1");
  }
  const auto read = [&](const std::string& key) {
    std::vector<double> values = json.numbers_or_gaps(key);
    require_length(json, key, values.size(), std::ssize(iterations),
                   "the length of \"iterations_per_level\"");
    return values;
  };
  result.rmsd_to_fem = read("rmsd_to_fem");
  result.rmsd_to_fixed_point = read("rmsd_to_fixed_point");
  result.mean_energy = read("mean_energy");
  for (const auto& [key, values] : {std::pair("rmsd_to_fem", &result.rmsd_to_fem),
                                    std::pair("rmsd_to_fixed_point", &result.rmsd_to_fixed_point)}) {
    const auto negative = std::ranges::find_if(*values, [](double value) { return value < 0.0; });
    if (negative != values->end()) {
      json.fail(key, fmt::format("has {}, but must not be negative", *negative));
    }
  }
  return result;
}

Profiles read_profiles(const JsonReader& json, const AccuracyRow& row) {
  Profiles result{json.numbers_or_gaps("horizontal"), json.numbers_or_gaps("vertical"),
                  json.numbers_or_gaps("falling"), json.numbers_or_gaps("rising")};
  require_length(json, "horizontal", result.horizontal.size(), row.width, "the width of the image");
  require_length(json, "vertical", result.vertical.size(), row.height, "the height of the image");
  require_length(json, "rising", result.rising.size(), std::ssize(result.falling),
                 "the length of \"falling\"");
  return result;
}

LevelProfiles read_level_profiles(const JsonReader& json) {
  LevelProfiles result;
  result.level = json.count("level");
  result.width = json.count("width");
  result.height = json.count("height");
  const auto read = [&](const std::string& key, std::int64_t length, const std::string& of_what) {
    const JsonReader line = json.object(key);
    LevelProfiles::Components components{line.numbers_or_gaps("x"), line.numbers_or_gaps("y")};
    require_length(line, "x", components.x.size(), length, of_what);
    require_length(line, "y", components.y.size(), length, of_what);
    return components;
  };
  result.horizontal = read("horizontal", result.width, "the width of the level");
  result.vertical = read("vertical", result.height, "the height of the level");
  return result;
}

Differences read_differences(const JsonReader& json) {
  const JsonReader pictures = json.object("pictures");
  const std::filesystem::path folder = json.file().parent_path();
  Differences result{folder / pictures.text("magnitude"), folder / pictures.text("x"),
                     folder / pictures.text("y"), json.number("limit"), json.text("against")};
  if (!(result.limit > 0.0)) {
    json.fail("limit", fmt::format("is {}, but must be greater than 0", result.limit));
  }
  return result;
}

std::vector<Polyline> read_polylines(const JsonReader& json, const std::string& key) {
  std::vector<Polyline> lines = json.lists_of_numbers(key);
  for (const Polyline& line : lines) {
    if (line.size() < 4 || line.size() % 2 != 0) {
      json.fail(key, fmt::format("has a line of {} numbers, but x and y of at least two points are needed",
                                 line.size()));
    }
  }
  return lines;
}

void read_iterations(const JsonReader& json, AccuracyRow& row) {
  if (json.holds("iterations")) {
    row.iterations = json.count("iterations");
  }
  std::int64_t sum = 0;
  for (const JsonReader& level : objects_if_any(json, "levels")) {
    row.levels.push_back(
        {level.count("level"), level.count("width"), level.count("height"), level.count("iterations")});
    sum += row.levels.back().iterations;
  }
  if (!row.levels.empty() && row.iterations != sum) {
    json.fail("levels", fmt::format("come to {} iterations, but \"iterations\" is {}", sum,
                                    row.iterations ? fmt::format("{}", *row.iterations) : "missing"));
  }
}

void read_figures(const JsonReader& json, AccuracyRow& row) {
  if (json.holds("convergence")) {
    row.convergence = read_convergence(json.object("convergence"));
  }
  if (json.holds("profiles")) {
    row.profiles = read_profiles(json.object("profiles"), row);
  }
  for (const JsonReader& level : objects_if_any(json, "level_profiles")) {
    row.level_profiles.push_back(read_level_profiles(level));
  }
  if (json.holds("differences")) {
    row.differences = read_differences(json.object("differences"));
  }
  if (json.holds("grid")) {
    const JsonReader grid = json.object("grid");
    row.grid_spacing = grid.number("spacing");
    row.grid = read_polylines(grid, "lines");
  }
  if (json.holds("interfaces")) {
    row.interfaces = read_polylines(json, "interfaces");
  }
}

} // namespace

std::string AccuracyRow::failure() const {
  return status != "ok" ? status : "not finite, or not the bits of scalar";
}

AccuracyRow read_accuracy(const JsonReader& json) {
  AccuracyRow row;
  row.scene = json.text("scene");
  row.title = json.text("title");
  row.width = json.count("width");
  row.height = json.count("height");
  row.poisson = json.number("poisson");
  row.method = json.text(
      "method", {"icm", "sequential", "fixed-point", "fem", "fem-coarse", "interpolation", "b-spline"});
  row.variant = text_if_any(json, "variant");
  row.note = text_if_any(json, "note");
  row.poisson_used = row.method.starts_with("fem") ? std::optional(json.number("poisson_used"))
                                                   : number_if_any(json, "poisson_used");
  row.backend = text_if_any(json, "backend");
  row.device = text_if_any(json, "device");
  row.status = json.text("status");
  row.valid = json.flag("valid");
  row.seconds = json.holds("seconds") ? json.numbers("seconds") : std::vector<double>{};
  row.seconds_median = number_if_any(json, "seconds_median");
  if (!row.failed()) {
    require_samples(json, row.seconds, row.seconds_median);
  }
  read_iterations(json, row);
  row.mean_energy = number_if_any(json, "mean_energy");
  row.to_fem = read_rmsd(json, "fem");
  row.to_fem_nu0 = read_rmsd(json, "fem_nu0");
  row.to_fixed_point = read_rmsd(json, "fixed_point");
  row.interface = read_interface(json);
  if (json.holds("arithmetic")) {
    row.arithmetic = read_arithmetic(json.object("arithmetic"));
  }
  if (row.failed()) {
    return row; // a broken field may have null anywhere
  }
  for (const JsonReader& decomposition : objects_if_any(json, "decompositions")) {
    row.decompositions.push_back(read_decomposition(decomposition));
  }
  read_figures(json, row);
  return row;
}

} // namespace hdmbench::report
