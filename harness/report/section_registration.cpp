#include "harness/report/sections.hpp"

#include "harness/measure/median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>

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
             "<p>{} sites of the region, {} s. The labels' moduli leave {:.3g} px unexplained, those that "
             "were found {:.3g} px. Most significant: {:.1f} standard deviations; as much in {} of {} "
             "simulations with nothing hidden. Explained best by a disc at x = {:.1f}, y = {:.1f} (+- "
             "{:.1f}) "
             "of radius {:.1f} px and {:.2f} times the label's modulus.</p>\n",
             count_text(row.region_sites), seconds_text(row.seconds), row.unexplained_before, row.unexplained,
             row.largest, row.as_much_by_chance, row.simulations, row.x, row.y, row.position_deviation,
             row.radius, row.contrast) +
         (row.looks_like
              ? fmt::format("<p><b>The picture itself shows another tissue there: {:.0f} % of the disc "
                            "look like label {}. A wrong label?</b></p>\n",
                            100.0 * row.doubted.value_or(0.0), *row.looks_like)
              : std::string()) +
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

/// The curve, 240 units a side.
std::string roc_svg(const std::vector<RocPoint>& points) {
  constexpr double side = 240.0;
  std::string line;
  for (const RocPoint& point : points) {
    line += fmt::format("{:.1f},{:.1f} ", side * point.false_alarms, side * (1.0 - point.found));
  }
  return fmt::format(
      "<figure><svg viewBox=\"-34 -6 290 284\" width=\"290\" height=\"284\" role=\"img\" "
      "aria-label=\"receiver operating characteristic\">"
      "<rect width=\"{0}\" height=\"{0}\" fill=\"none\" stroke=\"#999\"/>"
      "<line x1=\"0\" y1=\"{0}\" x2=\"{0}\" y2=\"0\" stroke=\"#999\" stroke-dasharray=\"4 4\"/>"
      "<polyline points=\"{1}\" fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"2.5\"/>"
      "<text x=\"120\" y=\"260\" text-anchor=\"middle\" font-size=\"12\" fill=\"currentColor\">found where "
      "nothing is hidden</text>"
      "<text transform=\"translate(-12 120) rotate(-90)\" text-anchor=\"middle\" font-size=\"12\" "
      "fill=\"currentColor\">found where something is</text></svg>",
      side, line);
}

bool same_series(const hdmbench::InclusionRow& a, const hdmbench::InclusionRow& b) {
  return a.scene == b.scene && a.width == b.width && a.height == b.height && a.noise == b.noise &&
         a.pictures == b.pictures && a.spread == b.spread && (a.spread || a.radius == b.radius);
}

std::string roc_html(std::span<const hdmbench::InclusionRow> rows) {
  const auto hidden = [](const hdmbench::InclusionRow& row) { return row.contrast != 1.0; };
  const auto more_than_chance = [&](bool with) {
    return std::ranges::count_if(rows, [&](const hdmbench::InclusionRow& row) {
      return hidden(row) == with && row.score > row.by_chance;
    });
  };
  std::vector<double> distances;
  double contrast = 1.0;
  for (const hdmbench::InclusionRow& row : rows) {
    if (hidden(row)) {
      distances.push_back(row.distance);
      contrast = row.contrast;
    }
  }
  const hdmbench::InclusionRow& first = rows.front();
  const auto with = static_cast<std::ptrdiff_t>(distances.size());
  const auto area = area_under_roc(rows);
  const auto known = area_under_roc(rows, &hdmbench::InclusionRow::place_score);
  return roc_svg(roc_of(rows)) +
         fmt::format(
             "<figcaption>{} {}: {} of {}, {} without; noise {:g} % of {}. Area under the curve {}; {} "
             "had the place been known. More than chance: {} of {}, and {} of {} without. Error of the "
             "position {:.2f} px (median).</figcaption></figure>\n",
             escape(first.scene), size_text(first.width, first.height), plural(with, "inclusion"),
             first.spread ? "radius 3 to 15 px and contrast 1.5 to 10"
                          : fmt::format("radius {:g} px and contrast {:g}", first.radius, contrast),
             std::ssize(rows) - with, 100.0 * first.noise,
             first.pictures ? "white, in pictures" : "the largest displacement",
             area ? fmt::format("{:.3f}", *area) : "not known",
             known ? fmt::format("{:.3f}", *known) : "not known", more_than_chance(true), with,
             more_than_chance(false), std::ssize(rows) - with, median(distances));
}

std::string count_or_dash(const std::optional<std::int64_t>& count) {
  return count ? std::to_string(*count) : "&ndash;";
}

std::string knobs_html(const std::vector<KnobRow>& rows) {
  std::string physical;
  std::string iterated;
  std::string detected;
  for (const KnobRow& row : rows) {
    const std::string start =
        fmt::format("<tr><th scope=\"row\">{}</th><td>{:g}</td>", escape(row.knob), row.value);
    if (row.tissue) {
      std::string& table = row.conventional ? physical : iterated;
      table += start + fmt::format("<td>{:.3f}</td><td>{:.3f}</td>", *row.tissue, row.region.value_or(0.0));
      table += row.conventional
                   ? fmt::format("<td>{:.3f}</td><td>{:.1f} %</td>", *row.conventional,
                                 100.0 * row.believed.value_or(0.0))
                   : fmt::format("<td>{:.1f} %</td><td>{} of {}</td>", 100.0 * row.outliers.value_or(0.0),
                                 row.not_converged.value_or(0), row.cases);
      table += fmt::format("<td>{} of {}</td></tr>\n", row.folded.value_or(0), row.cases);
    } else {
      detected += start + fmt::format("<td>{}</td><td>{} of {}</td><td>{}</td><td>{} of {}</td><td>{}</td>"
                                      "<td>{:.2f}</td></tr>\n",
                                      row.area ? fmt::format("{:.3f}", *row.area) : "not known",
                                      row.found.value_or(0), row.cases, count_or_dash(row.warned),
                                      row.mistaken.value_or(0), row.cases, count_or_dash(row.mistaken_warned),
                                      row.distance.value_or(0.0));
    }
  }
  std::string html;
  const auto add = [&](const std::string& text, const std::vector<std::string_view>& columns,
                       const std::string& lines) {
    if (!lines.empty()) {
      html +=
          fmt::format("<p>{}</p>\n", text) + table_start("plain", columns) + lines + std::string(table_end);
    }
  };
  add("Algorithm 5 on a resection; beside it the error of ITK's B-splines in the region, and how much of "
      "them "
      "was believed.",
      {"knob", ">value", ">tissue, px", ">region, px", ">b-splines, px", ">believed", ">with folds"},
      physical);
  add("Algorithm 6 on a resection, and what warns: sites that do not match, no convergence, folds.",
      {"knob", ">value", ">tissue, px", ">region, px", ">outliers", ">not converged", ">with folds"},
      iterated);
  add("Algorithm 7 on displacements, and how often it finds something where nothing is. Warned: the picture "
      "shows another tissue there than the label says.",
      {"knob", ">value", ">area under the ROC", ">found", ">warned", ">where nothing is", ">warned",
       ">position, px"},
      detected);
  return html;
}

std::string people_html(const std::vector<PeopleRow>& rows) {
  std::string html;
  for (std::size_t first = 0; first < rows.size();) {
    const PeopleRow& row = rows[first];
    html += fmt::format("<p>{} to {}, {}: overlap of the labels (Dice)</p>\n", escape(row.scene),
                        escape(row.other), size_text(row.width, row.height));
    std::vector<std::string> labels;
    std::ranges::transform(row.overlaps, std::back_inserter(labels), [](const PeopleRow::Overlap& overlap) {
      return fmt::format(">label {}", overlap.label);
    });
    std::vector<std::string_view> columns{"method", ">mean"};
    columns.insert(columns.end(), labels.begin(), labels.end());
    columns.insert(columns.end(), {">correlation", ">folds", ">seconds"});
    html += table_start("plain", columns);
    for (; first < rows.size() && rows[first].scene == row.scene && rows[first].other == row.other &&
           rows[first].width == row.width && rows[first].height == row.height;
         ++first) {
      const PeopleRow& one = rows[first];
      html += fmt::format("<tr><th scope=\"row\">{}</th><td>{:.3f}</td>", escape(one.method), one.dice);
      for (const PeopleRow::Overlap& overlap : one.overlaps) {
        html += fmt::format("<td>{:.3f}</td>", overlap.dice);
      }
      html += fmt::format("<td>{:.3f}</td><td>{}</td><td>{}</td></tr>\n", one.correlation, one.folds,
                          seconds_text(one.seconds));
    }
    html += table_end;
  }
  return html;
}

} // namespace

std::string registration_section(const Results& results, Anchors& anchors) {
  std::string html =
      "<section>\n" + heading(2, anchors.unique("registration"), "Registration and hidden stiffness");
  if (results.registrations.empty() && results.rivals.empty() && results.inclusions.empty()) {
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
    if (const auto people = results.of(results.people, machine); !people.empty()) {
      html += heading(3, anchors.unique("people"), "From one person to another") + people_html(people);
    }
    std::vector<hdmbench::InclusionRow> inclusions;
    for (const auto& row : results.of(results.inclusions, machine)) {
      inclusions.push_back(row);
    }
    std::string curves;
    while (!inclusions.empty()) {
      const hdmbench::InclusionRow first = inclusions.front();
      const auto others = std::ranges::stable_partition(
          inclusions, [&](const hdmbench::InclusionRow& row) { return same_series(row, first); });
      curves += roc_html(std::span(inclusions.begin(), others.begin()));
      inclusions.erase(inclusions.begin(), others.begin());
    }
    if (!curves.empty()) {
      html += heading(3, anchors.unique("roc"), "Hidden inclusions, and cases without");
      html += "<div class=\"pictures\">\n" + curves + "</div>\n";
    }
    const std::vector<KnobRow> knobs = results.of(results.knobs, machine);
    if (!knobs.empty()) {
      html += heading(3, anchors.unique("knobs"), "Where it breaks") + knobs_html(knobs);
    }
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
