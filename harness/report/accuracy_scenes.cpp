#include "harness/report/accuracy_scenes.hpp"

#include "harness/report/plot_style.hpp"
#include "harness/scene/method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>

namespace hdmbench::report {

namespace {

bool same(const Rmsd& a, const Rmsd& b) {
  return a.all == b.all && a.free == b.free;
}

bool same_field(const AccuracyRow& a, const AccuracyRow& b) {
  return !a.failed() && !b.failed() && a.variant == b.variant && a.poisson_used == b.poisson_used &&
         a.mean_energy == b.mean_energy && a.iterations == b.iterations && same(a.to_fem, b.to_fem) &&
         same(a.to_fem_nu0, b.to_fem_nu0) && same(a.to_fixed_point, b.to_fixed_point);
}

struct MethodText {
  std::string_view method;
  std::string_view name;
  std::string_view hint;
  std::size_t colour;
};
constexpr std::array<MethodText, 10> method_texts{{
    {"sequential", "ICM, in place", "until nothing moves: the thesis's CPU program", 3},
    {"icm", "ICM, simultaneous", "a fixed number of iterations: the thesis's GPU program", 2},
    {"fixed-point", "fixed point", "every site at its own minimum: what ICM aims at", 1},
    {"fem", "FEM", "plane stress, nodes at the sites", 0},
    {"fem-coarse", "FEM, 60\u00A0×\u00A060", "as many elements as the thesis had", 5},
    {"interpolation", "interpolation", "between the conditions; knows no material", 4},
    {elastic_full_multigrid, "elastic, full multigrid", "finite elements' energy, a cycle on each level", 7},
    {elastic_conjugate_gradients, "elastic, conjugate gradients", "after that, its cycle as preconditioner",
     7},
    {elastic_sweeps, "elastic, sweeps", "on the full resolution alone", 7},
    {"b-spline", "B-spline registration", "of the pictures; knows no material", 6},
}};

const MethodText& text_of(const AccuracyRow& row) {
  return *std::ranges::find(method_texts, row.method, &MethodText::method);
}

constexpr std::array<ThesisFigures, 5> figures{{
    {"square", "Fig. 5.3a", "Fig. 5.3b", "Fig. 5.4", "Fig. 5.5", "Figs. 5.6 and 5.7", ""},
    {"square-modified", "Fig. 5.8a", "Fig. 5.8b", "Fig. 5.9", "Fig. 5.10", "", ""},
    {"square-single-level", "Fig. 5.11", "", "", "Fig. 5.12", "", ""},
    {"circular", "Fig. 5.14a", "Fig. 5.14b", "Fig. 5.15", "Fig. 5.16", "", "Fig. 5.17"},
    {"circular-radial", "Fig. 5.19a", "Fig. 5.19b", "Fig. 5.20", "Fig. 5.21", "", ""},
}};

} // namespace

const AccuracyRow* AccuracyScene::find(const std::string& method) const {
  return first([&](const AccuracyRow& row) { return row.method == method && row.variant.empty(); });
}

const AccuracyRow* AccuracyScene::find_fem(double poisson_used) const {
  return first([&](const AccuracyRow& row) {
    return row.method == "fem" && row.variant.empty() && row.poisson_used == poisson_used;
  });
}

std::vector<AccuracyLine> AccuracyScene::lines(const std::string& method, bool variants) const {
  std::vector<AccuracyLine> result;
  for (const AccuracyRow* const row : rows) {
    if (row->method != method || row->variant.empty() == variants) {
      continue;
    }
    const auto twin =
        std::ranges::find_if(result, [&](const AccuracyLine& line) { return same_field(line.row(), *row); });
    if (twin == result.end()) {
      result.push_back({{row}});
    } else {
      twin->rows.push_back(row);
    }
  }
  return result;
}

std::vector<AccuracyScene> accuracy_scenes(const Results& results, const std::string& machine) {
  std::vector<AccuracyScene> scenes;
  for (const AccuracyRow& row : results.accuracy) {
    if (results.machine_of(row) != machine) {
      continue;
    }
    const auto known = std::ranges::find_if(scenes, [&](const AccuracyScene& scene) {
      return scene.scene == row.scene && scene.width == row.width && scene.height == row.height &&
             scene.poisson == row.poisson;
    });
    AccuracyScene& scene = known != scenes.end()
                               ? *known
                               : scenes.emplace_back(AccuracyScene{
                                     row.scene, row.title, row.width, row.height, row.poisson, {}, &results});
    scene.rows.push_back(&row);
  }
  return scenes;
}

const std::vector<std::string>& accuracy_methods() {
  static const std::vector<std::string> methods = [] {
    std::vector<std::string> names;
    std::ranges::transform(method_texts, std::back_inserter(names),
                           [](const MethodText& text) { return std::string(text.method); });
    return names;
  }();
  return methods;
}

std::string method_name(const AccuracyRow& row) {
  const std::string name(text_of(row).name);
  return row.method == "fem" ? name + ", " + poisson_text(*row.poisson_used) : name;
}

std::string method_hint(const AccuracyRow& row) {
  return std::string(text_of(row).hint);
}

std::string method_colour(const AccuracyRow& row) {
  return plot_colours.at(text_of(row).colour);
}

std::string poisson_text(double poisson) {
  return fmt::format("ν\u00A0=\u00A0{:.4g}", poisson);
}

ThesisFigures thesis_figures(const std::string& scene) {
  const auto* const found = std::ranges::find(figures, scene, &ThesisFigures::scene);
  return found == figures.end() ? ThesisFigures{} : *found;
}

std::vector<PublishedAccuracy> published_accuracy(const AccuracyScene& scene) {
  constexpr std::int64_t size = 300; // N of its Tables 5.1, 5.3, 5.5, 5.7
  std::vector<PublishedAccuracy> rows;
  std::ranges::copy_if(hdmbench::published_accuracy(), std::back_inserter(rows),
                       [&](const PublishedAccuracy& row) {
                         return row.scene == scene.scene && scene.width == size && scene.height == size;
                       });
  return rows;
}

std::string thesis_reference(std::string_view figure) {
  return figure.empty() ? "" : fmt::format(" Thesis: {}.", figure);
}

} // namespace hdmbench::report
