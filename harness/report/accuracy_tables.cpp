#include "harness/report/accuracy_tables.hpp"

#include "harness/report/html.hpp"
#include "harness/scene/joined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hdmbench::report {

namespace {

std::string number_cell(const std::string& text, const std::string& beneath = {}) {
  return fmt::format("<td class=\"number\">{}{}</td>", text,
                     beneath.empty() ? "" : "<small>" + beneath + "</small>");
}

const std::string no_cell = "<td class=\"number faint\">–</td>";

std::string distance_cell(const std::optional<double>& pixels) {
  return pixels ? number_cell(distance_text(*pixels)) : no_cell;
}

// All sites, the free ones beneath.
std::string rmsd_cell(const Rmsd& rmsd) {
  if (!rmsd.all) {
    return no_cell;
  }
  return number_cell(distance_text(*rmsd.all), rmsd.free ? "free " + distance_text(*rmsd.free) : "");
}

std::string energy_cell(const std::optional<double>& energy) {
  return energy ? number_cell(fmt::format("{:.4g}", *energy)) : no_cell;
}

std::string iterations_cell(const std::optional<std::int64_t>& iterations) {
  return iterations ? number_cell(count_text(*iterations)) : no_cell;
}

std::string seconds_cell(const AccuracyLine& line) {
  const AccuracyRow& fastest = **std::ranges::min_element(
      line.rows, {}, [](const AccuracyRow* row) { return row->seconds_median.value_or(HUGE_VAL); });
  if (!fastest.seconds_median) {
    return no_cell;
  }
  return number_cell(seconds_text(*fastest.seconds_median),
                     line.rows.size() > 1 ? escape(fastest.backend) : "");
}

std::string name_cell(const AccuracyLine& line) {
  std::vector<std::string> backends;
  for (const AccuracyRow* const row : line.rows) {
    if (!row->backend.empty()) {
      const bool timed = line.rows.size() > 1 && row->seconds_median;
      backends.push_back(timed ? fmt::format("{} {}\u00A0s", row->backend, seconds_text(*row->seconds_median))
                               : row->backend);
    }
  }
  std::string hint = method_hint(line.row());
  if (line.row().method == "fem-coarse") {
    hint += ", " + poisson_text(*line.row().poisson_used);
  }
  if (!line.row().note.empty() && line.row().variant.empty()) {
    hint += "; " + line.row().note;
  }
  const std::string by =
      backends.empty()
          ? ""
          : fmt::format("{}{}", backends.size() > 1 ? "same field by " : "by ", joined(backends, ", "));
  return fmt::format("<th scope=\"row\">{}<small>{}</small>{}</th>", escape(method_name(line.row())),
                     escape(hint), by.empty() ? "" : "<small>" + escape(by) + "</small>");
}

std::string failure_cell(const AccuracyRow& row, int columns) {
  return fmt::format("<td class=\"{}\" colspan=\"{}\"><b>{}</b><small>{}</small></td>",
                     row.skipped() ? "skipped" : "disagree", columns,
                     row.skipped() ? "– skipped" : "✗ failed", escape(row.failure()));
}

// Its finite elements have one Poisson ratio, which it does not print.
std::string thesis_rows(const AccuracyScene& scene, bool with_fem) {
  std::string html;
  for (const PublishedAccuracy& row : published_accuracy(scene)) {
    if (!with_fem && row.method == "FEM") {
      continue;
    }
    html +=
        fmt::format("<tr><th scope=\"row\">thesis, {}<small>Table {}</small></th>", row.method, row.table);
    html += row.mean_energy
                ? number_cell(fmt::format("{:.{}f}", *row.mean_energy, *row.mean_energy < 1.0 ? 5 : 4))
                : no_cell;
    html +=
        row.rmsd
            ? fmt::format("<td class=\"number middle\" colspan=\"2\">{:.6g}<small>ν not printed</small></td>",
                          *row.rmsd)
            : no_cell + no_cell;
    html += no_cell + (row.iterations ? number_cell(count_text(*row.iterations)) : no_cell);
    html += number_cell(fmt::format("{:.4g}", row.seconds)) + "</tr>\n";
  }
  return html.empty() ? html : "<tbody class=\"thesis\">\n" + html + "</tbody>\n";
}

std::string line_html(const AccuracyLine& line) {
  const AccuracyRow& row = line.row();
  if (row.failed()) {
    return "<tr>" + name_cell(line) + failure_cell(row, 6) + "</tr>\n";
  }
  return "<tr>" + name_cell(line) + energy_cell(row.mean_energy) + rmsd_cell(row.to_fem_nu0) +
         rmsd_cell(row.to_fem) + rmsd_cell(row.to_fixed_point) + iterations_cell(row.iterations) +
         seconds_cell(line) + "</tr>\n";
}

std::string methods_head(const AccuracyScene& scene, const char* first) {
  return table_start("accuracy", {first, ">Mean energy", ">RMSD to FEM,<br>ν\u00A0=\u00A00 [px]",
                                  fmt::format(">RMSD to FEM,<br>{} [px]", poisson_text(scene.poisson)),
                                  ">RMSD to the<br>fixed point [px]", ">Iterations", ">Seconds"});
}

// Squares of the parts on a common scale. A negative covariance takes its share back: hatched.
std::string bar_html(const Decomposition& parts, double scale) {
  const auto percent = [&](double squared_pixels) {
    return scale > 0.0 ? 100.0 * squared_pixels / scale : 0.0;
  };
  const double model = parts.model * parts.model;
  const double optimisation = parts.optimisation * parts.optimisation;
  const double covariance = 2.0 * parts.covariance;
  std::string html =
      fmt::format("<td><span class=\"bar error\" aria-hidden=\"true\"><i class=\"model\" "
                  "style=\"width:{:.2f}%\"></i><i class=\"optimisation\" style=\"width:{:.2f}%\"></i>",
                  percent(model), percent(optimisation));
  html += covariance >= 0.0
              ? fmt::format("<i class=\"covariance\" style=\"width:{:.2f}%\"></i>", percent(covariance))
              : fmt::format("<i class=\"minus\" style=\"left:{:.2f}%;width:{:.2f}%\"></i>",
                            percent(model + optimisation + covariance), percent(-covariance));
  return html + "</span></td>";
}

std::vector<AccuracyLine> iterated_lines(const AccuracyScene& scene) {
  std::vector<AccuracyLine> lines = scene.lines("sequential", false);
  std::ranges::copy(scene.lines("icm", false), std::back_inserter(lines));
  return lines;
}

} // namespace

std::string distance_text(double pixels) {
  if (pixels == 0.0) {
    return "0";
  }
  if (pixels < 1e-3) {
    return fmt::format("{:.1e}", pixels);
  }
  return fmt::format("{:.{}f}", pixels, pixels < 0.1 ? 4 : pixels < 10.0 ? 3 : 1);
}

std::string overview_table(std::span<const AccuracyScene> scenes) {
  std::string rows;
  for (const AccuracyScene& scene : scenes) {
    rows += fmt::format("<tr><th scope=\"row\">{}<small>{}, {}</small></th>", escape(scene.scene),
                        size_text(scene.width, scene.height), poisson_text(scene.poisson));
    for (const std::string_view method : {"CPU", "GPU"}) {
      const std::vector<PublishedAccuracy> published = published_accuracy(scene);
      const auto found = std::ranges::find(published, method, &PublishedAccuracy::method);
      rows += found == published.end() || !found->rmsd ? no_cell
                                                       : number_cell(fmt::format("{:.2f}", *found->rmsd));
    }
    // Not b-spline: far from any edge it has nothing to go by, see the table at the interfaces.
    for (const char* const method : {"sequential", "icm", "fixed-point", "interpolation"}) {
      const AccuracyRow* const row = scene.find(method);
      if (row != nullptr && row->to_fem_nu0.all) {
        rows += number_cell(distance_text(*row->to_fem_nu0.all),
                            row->to_fem.all ? distance_text(*row->to_fem.all) : "");
      } else {
        const bool failed = row == nullptr && !scene.lines(method, false).empty();
        rows += failed ? "<td class=\"number disagree\"><b>✗ failed</b></td>" : no_cell;
      }
    }
    rows += "</tr>\n";
  }
  return table_start("accuracy",
                     {"RMSD to FEM [px]", ">thesis,<br>CPU", ">thesis,<br>GPU", ">ICM,<br>in place",
                      ">ICM,<br>simultaneous", ">fixed<br>point", ">interpo-<br>lation"}) +
         rows + std::string(table_end);
}

std::string methods_table(const AccuracyScene& scene) {
  std::string html = methods_head(scene, "Method");
  for (const std::string& method : accuracy_methods()) {
    for (const AccuracyLine& line : scene.lines(method, false)) {
      html += line_html(line);
    }
  }
  return html + "</tbody>\n" + thesis_rows(scene, true) + "</table></div>\n";
}

std::string decomposition_table(const AccuracyScene& scene) {
  const std::vector<AccuracyLine> lines = iterated_lines(scene);
  double scale = 0.0;
  for (const AccuracyLine& line : lines) {
    for (const auto& [poisson, parts] : line.row().decompositions) {
      scale = std::max(scale, parts.model * parts.model + parts.optimisation * parts.optimisation +
                                  2.0 * std::max(parts.covariance, 0.0));
    }
  }
  std::string rows;
  for (const AccuracyLine& line : lines) {
    for (const auto& [poisson, parts] : line.row().decompositions) {
      rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td>", escape(method_name(line.row())),
                          poisson_text(poisson));
      rows += distance_cell(parts.total) + distance_cell(parts.model) + distance_cell(parts.optimisation) +
              number_cell(fmt::format("{}{}", parts.covariance < 0.0 ? "−" : "",
                                      distance_text(2.0 * std::abs(parts.covariance)))) +
              number_cell(fmt::format("{:.0e}", std::abs(parts.remainder()))) + bar_html(parts, scale) +
              "</tr>\n";
    }
  }
  if (rows.empty()) {
    return {};
  }
  const std::string_view squares =
      "Squares <span class=\"key\"><i class=\"model\"></i>model</span><span class=\"key\"><i "
      "class=\"optimisation\"></i>optimisation</span><span class=\"key\"><i "
      "class=\"covariance\"></i>covariance</span>";
  return table_start("breakdown", {"Field", "FEM with", ">Total [px]", ">Model [px]", ">Optimisation [px]",
                                   ">2 × covariance [px²]", ">Remainder [px²]", squares}) +
         rows + std::string(table_end);
}

std::string arithmetic_table(const AccuracyScene& scene) {
  std::string rows;
  for (const AccuracyRow* const row : scene.rows) {
    if (!row->arithmetic) {
      continue;
    }
    const Arithmetic::Iterations& data = row->arithmetic->resynchronised;
    rows += fmt::format("<tr><th scope=\"row\">{}<small>{}</small></th>", escape(row->backend),
                        escape(row->device));
    rows += number_cell(count_text(data.steps_compared), plural(data.iterations, "iteration"));
    rows += number_cell(count_text(data.steps_differing));
    rows += data.largest_gap_over_bound ? number_cell(fmt::format("{:.2g}", *data.largest_gap_over_bound))
                                        : no_cell;
    rows += data.beyond_bound > 0
                ? fmt::format("<td class=\"number disagree\"><b>✗ {}</b></td>", count_text(data.beyond_bound))
            : data.steps_compared == 0 ? "<td class=\"number mistrusted\"><b>? nothing compared</b></td>"
                                       : "<td class=\"number agree\"><b>✓ 0</b></td>";
    rows += distance_cell(data.rmsd) + distance_cell(row->arithmetic->run_rmsd) + "</tr>\n";
  }
  if (rows.empty()) {
    return {};
  }
  return table_start("breakdown", {"Backend", ">Steps compared", ">Other than<br>in double",
                                   ">Largest gap<br>over bound", ">Beyond<br>the bound",
                                   ">RMSD of one<br>iteration [px]", ">RMSD of the<br>whole run [px]"}) +
         rows + std::string(table_end);
}

std::string variants_table(const AccuracyScene& scene) {
  std::string rows;
  for (const std::string& method : accuracy_methods()) {
    const std::vector<AccuracyLine> variants = scene.lines(method, true);
    if (variants.empty()) {
      continue;
    }
    for (const AccuracyLine& line : scene.lines(method, false)) {
      rows += line.row().failed() ? "" : line_html(line);
    }
    for (const AccuracyLine& line : variants) {
      const AccuracyRow& row = line.row();
      rows += fmt::format("<tr class=\"variant\"><th scope=\"row\">{}<small>{}</small></th>",
                          escape(row.variant), escape(row.note));
      rows += row.failed()
                  ? failure_cell(row, 6)
                  : energy_cell(row.mean_energy) + rmsd_cell(row.to_fem_nu0) + rmsd_cell(row.to_fem) +
                        rmsd_cell(row.to_fixed_point) + iterations_cell(row.iterations) + seconds_cell(line);
      rows += "</tr>\n";
    }
  }
  if (rows.empty()) {
    return {};
  }
  return methods_head(scene, "Method and variant") + rows + "</tbody>\n" + thesis_rows(scene, false) +
         "</table></div>\n";
}

std::string interfaces_table(const AccuracyScene& scene) {
  std::string rows;
  const InterfaceRmsd* counts = nullptr;
  for (const std::string& method : accuracy_methods()) {
    for (const AccuracyLine& line : scene.lines(method, false)) {
      const AccuracyRow& row = line.row();
      // FEM with the scene's own ratio is the truth itself.
      if (row.failed() || !row.interface || (row.method == "fem" && row.poisson_used == scene.poisson)) {
        continue;
      }
      const InterfaceRmsd& rmsd = *row.interface;
      counts = &rmsd;
      rows += fmt::format("<tr><th scope=\"row\">{}</th>", escape(method_name(row)));
      rows += distance_cell(rmsd.near) + distance_cell(rmsd.elsewhere);
      rows += rmsd.near && rmsd.elsewhere && *rmsd.elsewhere > 0.0
                  ? number_cell(fmt::format("{:.2f}", *rmsd.near / *rmsd.elsewhere))
                  : no_cell;
      rows += "</tr>\n";
    }
  }
  if (counts == nullptr) {
    return {};
  }
  return table_start("breakdown", {"Method",
                                   fmt::format(">Within 5 px of an<br>interface [px]<small>{}</small>",
                                               plural(counts->near_sites, "site")),
                                   fmt::format(">Elsewhere [px]<small>{}</small>",
                                               plural(counts->elsewhere_sites, "site")),
                                   ">Ratio"}) +
         rows + std::string(table_end);
}

} // namespace hdmbench::report
