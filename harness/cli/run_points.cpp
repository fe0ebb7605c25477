#include "harness/cli/run_points.hpp"

#include "backends/shared/stopwatch.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/points.hpp"
#include "kernels/data/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>

namespace hdmbench::commands {

namespace {

double root_mean_square(const json& rows, const char* key) {
  double squares = 0.0;
  int count = 0;
  for (const json& row : rows) {
    if (row[key].is_number()) {
      squares += std::pow(row[key].get<double>(), 2);
      ++count;
    }
  }
  return std::sqrt(squares / std::max(count, 1));
}

bool is_piece(const KnownPoint& point) {
  return point.share.has_value();
}

/// What the pieces of a surface come to, pixels.
struct Surface {
  std::size_t pieces = 0;
  double asked_squares = 0.0;
  double residual_squares = 0.0;
  double largest = 0.0;

  void add(double asked, double residual) {
    ++pieces;
    asked_squares += asked * asked;
    residual_squares += residual * residual;
    largest = std::max(largest, residual);
  }

  [[nodiscard]] json row(const std::string& name, double spacing) const {
    const auto count = static_cast<double>(pieces);
    return {{"surface", name},
            {"pieces", pieces},
            {"asked_mm", std::sqrt(asked_squares / count) * spacing},
            {"residual_mm", std::sqrt(residual_squares / count) * spacing},
            {"largest_mm", largest * spacing}};
  }
};

} // namespace

void require_points(const Call& call, const Scene& scene) {
  if (call[leave_one_out] && scene.points.empty()) {
    throw InputError(
        "--leave-one-out is for points, and the scene has none: give it --points, or [[points]]");
  }
  if (call[leave_one_out] && std::ranges::any_of(scene.points, is_piece)) {
    throw InputError("--leave-one-out is for points by themselves: pieces of a surface know where the one "
                     "between them went");
  }
}

std::vector<std::optional<double>> misses_left_out(Call& call, std::size_t points,
                                                   const std::function<VectorField(Scene& scene)>& solve,
                                                   json& phases) {
  if (!call[leave_one_out]) {
    return {};
  }
  const Clock clock;
  std::vector<std::optional<double>> misses(points);
  for (std::size_t point = 0; point < points; ++point) {
    call.idle_point = point;
    Scene scene = scene_of(call);
    scene.name += " without " + scene.points.at(point).name;
    try {
      misses[point] = residual_at(scene.points.at(point), solve(scene));
    } catch (const InputError&) { // no solution, and with the point there was one: it holds the body
    }
  }
  call.idle_point.reset();
  phases["left_out_seconds"] = clock.seconds();
  return misses;
}

void report_points(const Scene& scene, const VectorField& displacement,
                   const std::vector<std::optional<double>>& left_out, json& row) {
  if (scene.points.empty()) {
    return;
  }
  json rows = json::array();
  std::map<std::string, Surface> surfaces;
  double squares = 0.0;
  for (std::size_t number = 0; number < scene.points.size(); ++number) {
    const KnownPoint& point = scene.points[number];
    const double residual = residual_at(point, displacement);
    const double asked = std::hypot(point.target[0], point.target[1], point.target[2]);
    squares += residual * residual;
    if (is_piece(point)) {
      surfaces[point.name].add(asked, residual);
      continue;
    }
    rows.push_back(
        {{"point", point.name},
         {"asked_mm", asked * scene.spacing},
         {"residual_mm", residual * scene.spacing},
         {"deviations", point.deviation > 0.0 ? json(residual / point.deviation) : json()},
         {"left_out_mm",
          number < left_out.size() && left_out[number] ? json(*left_out[number] * scene.spacing) : json()}});
  }
  constexpr std::size_t most_shown = 20;
  const auto count = static_cast<double>(scene.points.size());
  fmt::print("  {} points: {:.3g} mm from where they went, RMS", scene.points.size(),
             std::sqrt(squares / count) * scene.spacing);
  const auto needed = std::ranges::count_if(left_out, [](const auto& miss) { return !miss; });
  if (needed < std::ssize(left_out)) {
    fmt::print("; each left out in turn, {:.3g} mm", root_mean_square(rows, "left_out_mm"));
  }
  fmt::print("\n");
  if (needed > 0) {
    fmt::print("  without {} of them, left out by itself, nothing holds the tissue\n", needed);
  }
  if (!rows.empty() && rows.size() <= most_shown) {
    fmt::print("{}", table_text(rows, "point|asked_mm:moved by mm|residual_mm:missed by mm|"
                                      "deviations:in its deviations|left_out_mm:missed by mm, left out"));
  }
  row["points"] = std::move(rows);
  for (const auto& [name, surface] : surfaces) {
    row["surfaces"].push_back(surface.row(name, scene.spacing));
  }
  if (row.contains("surfaces")) {
    fmt::print("{}", table_text(row["surfaces"],
                                "surface|pieces|asked_mm:moved by mm, RMS|residual_mm:missed by mm, "
                                "RMS|largest_mm:missed by mm, most"));
  }
}

} // namespace hdmbench::commands
