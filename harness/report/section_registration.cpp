#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

template <typename Row>
std::string pictures_html(const Results& results, const Row& row) {
  std::string html;
  for (const NamedPicture& picture : row.pictures) {
    const EmbeddedPng png = embed_png(results.path_of(row, picture.file));
    html += fmt::format(
        "<figure><img src=\"{}\" width=\"{}\" height=\"{}\" style=\"max-width:min(100%,{}px)\" "
        "alt=\"{}\"><figcaption>{}</figcaption></figure>\n",
        png.uri, png.width, png.height, png.width, escape(picture.caption), escape(picture.caption));
  }
  return html.empty() ? html : "<div class=\"pictures\">\n" + html + "</div>\n";
}

std::string iterations_html(const RegistrationRow& row) {
  if (row.iterations.empty()) {
    return {};
  }
  std::string html = table_start("plain", {"pictures", ">difference, gray values", ">outliers", ">step, px"});
  for (const auto& iteration : row.iterations) {
    html += fmt::format("<tr><th scope=\"row\">{}</th><td>{:.3g}</td><td>{:.1f} %</td><td>{:.3g}</td></tr>\n",
                        size_text(iteration.width, iteration.height), iteration.difference,
                        100.0 * iteration.outliers, iteration.step);
  }
  return folded(fmt::format("{}; {}", plural(std::ssize(row.iterations), "iteration"),
                            row.converged.value_or(false) ? "converged" : "<b>not converged</b>"),
                html + std::string(table_end));
}

std::string registration_html(const Results& results, const RegistrationRow& row, Anchors& anchors) {
  const bool iterated = row.algorithm == registration_algorithms[1];
  std::string html = heading(
      3, anchors.unique("register " + row.scene + " " + row.algorithm),
      fmt::format("{}: {}", row.scene, iterated ? "iterated (Algorithm 6)" : "made physical (Algorithm 5)"));
  html += fmt::format("<p>{} by {} energy on {}{}, {} s. Correlation {:.3f} before, {:.3f} after; mutual "
                      "information {:.3f} and "
                      "{:.3f} bits. Largest displacement {:.3g} px, {}.</p>\n",
                      size_text(row.width, row.height), escape(row.energy), escape(row.backend),
                      row.conventional.empty() ? "" : ", after ITK's " + escape(row.conventional),
                      seconds_text(row.seconds), row.before.correlation, row.after.correlation,
                      row.before.mutual_information, row.after.mutual_information, row.largest_displacement,
                      plural(row.folds, "folded cell"));
  return html + pictures_html(results, row) + iterations_html(row);
}

std::string detection_html(const Results& results, const DetectionRow& row, Anchors& anchors) {
  return heading(3, anchors.unique("detect " + row.scene), fmt::format("{}: hidden stiffness", row.scene)) +
         fmt::format(
             "<p>{} sites of the region, {} solutions, {} s. The labels' moduli leave {:.3g} px "
             "unexplained, those that were found {:.3g} px. Most significant: {:.1f} standard deviations "
             "at x = {}, y = {}.</p>\n",
             count_text(row.region_sites), count_text(row.solutions), seconds_text(row.seconds),
             row.unexplained_before, row.unexplained, row.largest, row.x, row.y) +
         pictures_html(results, row);
}

std::string rivals_html(const std::vector<RivalRow>& rows) {
  std::string html;
  const auto same_case = [](const RivalRow& a, const RivalRow& b) {
    return a.scene == b.scene && a.width == b.width && a.height == b.height && a.planted == b.planted &&
           a.amplitude == b.amplitude && a.noise == b.noise && a.other_gray == b.other_gray &&
           a.seed == b.seed;
  };
  for (std::size_t first = 0; first < rows.size();) {
    const RivalRow& row = rows[first];
    html += fmt::format("<p>{} {}: {} of {:g} px, noise {:g} %{}, seed {}</p>\n", escape(row.scene),
                        size_text(row.width, row.height), escape(row.planted), row.amplitude,
                        100.0 * row.noise, row.other_gray ? ", other gray values" : "", row.seed);
    html += table_start(
        "plain", {"method", ">tissue, px", ">95 %", ">region", ">interfaces", ">Dice", ">folds", ">seconds"});
    for (; first < rows.size() && same_case(rows[first], row); ++first) {
      const RivalRow& one = rows[first];
      html += fmt::format(
          "<tr><th scope=\"row\">{}</th><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td>"
          "<td>{:.3f}</td><td>{}</td><td>{}</td></tr>\n",
          escape(one.method), one.tissue, one.tissue_95, one.region, one.interfaces, one.dice, one.folds,
          seconds_text(one.seconds));
    }
    html += table_end;
  }
  return html;
}

std::string roc_html(const std::vector<InclusionRow>& rows) {
  const std::vector<hdmbench::InclusionRow> plain(rows.begin(), rows.end());
  const auto area = area_under_roc(plain);
  const auto with = std::ranges::count_if(rows, [](const auto& row) { return row.contrast != 1.0; });
  return fmt::format("<p>{} with an inclusion, {} without: area under the ROC {}.</p>\n",
                     plural(with, "case"), std::ssize(rows) - with,
                     area ? fmt::format("{:.3f}", *area) : "not known");
}

} // namespace

std::string registration_section(const Results& results, Anchors& anchors) {
  std::string html =
      "<section>\n" + heading(2, anchors.unique("registration"), "Registration and hidden stiffness");
  if (results.registrations.empty() && results.rivals.empty()) {
    html += no_data("registrations", "register SOURCE TARGET --scene S");
  }
  for (const RegistrationRow& row : results.registrations) {
    html += registration_html(results, row, anchors);
  }
  for (const DetectionRow& row : results.detections) {
    html += detection_html(results, row, anchors);
  }
  if (!results.rivals.empty()) {
    html += heading(3, anchors.unique("rivals"), "Against planted truth");
    html +=
        "<p>Finite elements on another mesh and with another Poisson ratio deform a slice; every method has "
        "to find out how. Root mean square distance from the truth in pixels.</p>\n";
  }
  for (const std::string& machine : results.machines) {
    html += rivals_html(results.of(results.rivals, machine));
    const std::vector<InclusionRow> inclusions = results.of(results.inclusions, machine);
    html += inclusions.empty() ? "" : roc_html(inclusions);
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
