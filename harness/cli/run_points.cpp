#include "harness/cli/run_points.hpp"

#include "harness/report/table.hpp"
#include "harness/scene/points.hpp"
#include "kernels/data/input_error.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
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

} // namespace

void require_points(const Call& call, const Scene& scene) {
  if (call[leave_one_out] && scene.points.empty()) {
    throw InputError(
        "--leave-one-out is for points, and the scene has none: give it --points, or [[points]]");
  }
}

std::vector<std::optional<double>> misses_left_out(Call& call, std::size_t points,
                                                   const std::function<VectorField(Scene& scene)>& solve) {
  if (!call[leave_one_out]) {
    return {};
  }
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
  return misses;
}

void report_points(const Scene& scene, const VectorField& displacement,
                   const std::vector<std::optional<double>>& left_out, json& row) {
  if (scene.points.empty()) {
    return;
  }
  json rows = json::array();
  for (std::size_t number = 0; number < scene.points.size(); ++number) {
    const KnownPoint& point = scene.points[number];
    const double residual = residual_at(point, displacement);
    const double asked = std::hypot(point.target[0], point.target[1], point.target[2]);
    rows.push_back(
        {{"point", point.name},
         {"asked_mm", asked * scene.spacing},
         {"residual_mm", residual * scene.spacing},
         {"deviations", point.deviation > 0.0 ? json(residual / point.deviation) : json()},
         {"left_out_mm",
          number < left_out.size() && left_out[number] ? json(*left_out[number] * scene.spacing) : json()}});
  }
  constexpr std::size_t most_shown = 20;
  fmt::print("  {} points: {:.3g} mm from where they went, RMS", rows.size(),
             root_mean_square(rows, "residual_mm"));
  const auto needed = std::ranges::count_if(left_out, [](const auto& miss) { return !miss; });
  if (needed < std::ssize(left_out)) {
    fmt::print("; each left out in turn, {:.3g} mm", root_mean_square(rows, "left_out_mm"));
  }
  fmt::print("\n");
  if (needed > 0) {
    fmt::print("  without {} of them, left out by itself, nothing holds the tissue\n", needed);
  }
  if (rows.size() <= most_shown) {
    fmt::print("{}", table_text(rows, "point|asked_mm:moved by mm|residual_mm:missed by mm|"
                                      "deviations:in its deviations|left_out_mm:missed by mm, left out"));
  }
  row["points"] = std::move(rows);
}

} // namespace hdmbench::commands
