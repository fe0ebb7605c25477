#pragma once

#include "harness/report/results.hpp"
#include "reference/published.hpp"

#include <string>
#include <vector>

namespace hdmbench::report {

/// Rows that describe one and the same field: one method, whose backends agree in every figure. A failed row
/// stands alone.
struct AccuracyLine {
  std::vector<const AccuracyRow*> rows; ///< at least one

  [[nodiscard]] const AccuracyRow& row() const { return *rows.front(); }
};

/// What one machine measured on one scene at one size with one Poisson ratio. Points into the Results.
struct AccuracyScene {
  std::string scene;
  std::string title;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double poisson = 0.0;
  std::vector<const AccuracyRow*> rows;
  const Results* results = nullptr;

  /// A file that a row names.
  [[nodiscard]] std::filesystem::path path_of(const AccuracyRow& row, const std::string& name) const {
    return results->path_of(row, name);
  }
  /// The first row that did not fail for which `condition(row)` holds; nullptr where there is none.
  template <typename Condition>
  [[nodiscard]] const AccuracyRow* first(Condition condition) const {
    for (const AccuracyRow* const row : rows) {
      if (!row->failed() && condition(*row)) {
        return row;
      }
    }
    return nullptr;
  }
  /// The first row of `method` as the scene says that did not fail; nullptr where there is none.
  [[nodiscard]] const AccuracyRow* find(const std::string& method) const;
  /// The same for finite elements with one Poisson ratio.
  [[nodiscard]] const AccuracyRow* find_fem(double poisson_used) const;
  /// All of `method`, folded; variants or what is as the scene says.
  [[nodiscard]] std::vector<AccuracyLine> lines(const std::string& method, bool variants) const;
};

/// In the order of the files.
[[nodiscard]] std::vector<AccuracyScene> accuracy_scenes(const Results& results, const std::string& machine);

/// In the order of tables: of the thesis's energy, finite elements, rivals, of the elastic energy.
[[nodiscard]] const std::vector<std::string>& accuracy_methods();

/// "ICM, in place", "FEM, ν = 0.3"; plain text.
[[nodiscard]] std::string method_name(const AccuracyRow& row);

/// What the method is, in a few plain words.
[[nodiscard]] std::string method_hint(const AccuracyRow& row);

/// The method's colour in every plot, "0067a8".
[[nodiscard]] std::string method_colour(const AccuracyRow& row);

/// "ν = 0.3" with no-break spaces.
[[nodiscard]] std::string poisson_text(double poisson);

/// Which figure of the thesis shows what of a scene; empty where it has none.
struct ThesisFigures {
  std::string_view scene;
  std::string_view convergence;
  std::string_view iterations;
  std::string_view differences;
  std::string_view profiles;
  std::string_view levels;
  std::string_view grids;
};
/// All empty for a scene that is not the thesis's.
[[nodiscard]] ThesisFigures thesis_figures(const std::string& scene);

/// What the thesis measured on this scene at this size; empty where it did not.
[[nodiscard]] std::vector<PublishedAccuracy> published_accuracy(const AccuracyScene& scene);

/// " Thesis: Fig. 5.4." or nothing.
[[nodiscard]] std::string thesis_reference(std::string_view figure);

} // namespace hdmbench::report
