#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

namespace hdmbench::report {

namespace {

std::string cell(const Distance& distance) {
  return fmt::format("<td class=\"number\">{:.2g}<small>{:.2g}</small></td>", distance.rmsd,
                     distance.largest);
}

/// The largest image of each contrast.
std::vector<ContinuumRow> finest(const std::vector<ContinuumRow>& rows) {
  std::map<double, ContinuumRow> best;
  for (const ContinuumRow& row : rows) {
    const auto known = best.find(row.contrast);
    if (known == best.end() || known->second.width < row.width) {
      best[row.contrast] = row;
    }
  }
  std::vector<ContinuumRow> result;
  std::ranges::transform(best, std::back_inserter(result), [](const auto& entry) { return entry.second; });
  return result;
}

std::string table(const std::vector<ContinuumRow>& rows) {
  std::string html = table_start("continuum", {">contrast", ">size", ">discretisation [px]", ">order",
                                               ">algebraic [px]", ">float32 [px]", ">our field in all [px]"});
  for (const ContinuumRow& row : rows) {
    html += fmt::format("<tr><th scope=\"row\" class=\"number\">{:.6g}</th><td class=\"number\">{}</td>{}<td "
                        "class=\"number\">{}</td>{}{}{}</tr>\n",
                        row.contrast, size_text(row.width, row.height), cell(row.discretisation),
                        row.order ? fmt::format("{:.2f}", *row.order) : "", cell(row.algebraic),
                        cell(row.rounding), cell(row.total));
  }
  return html + std::string(table_end);
}

} // namespace

std::string continuum_section(const Results& results, Anchors& anchors) {
  const SectionText text{
      "continuum", "From pixels to the continuum", no_data("distances from the continuum", "continuum"),
      R"(<p>Finite elements on pixels are a truth with an error of their own: a round interface becomes stairs. A sheet
with a round inclusion, stretched by 50 px, has a displacement in closed form. RMSD over all sites, the largest distance of
a site beneath. <b>Discretisation</b>: from finite elements on the pixels (direct, double) to the closed form; its order is
that in the image's side, since the first size. <b>Algebraic</b>: from our field, at the usual effort of its method, to
these finite elements. <b>float32</b>: the same when no step changes our field any more. An algebraic error below that of
discretisation buys nothing.</p>
)"};
  return section(results, results.continuum, anchors, text,
                 [](const std::string&, const std::vector<ContinuumRow>& rows) {
                   return table(finest(rows)) + folded("All sizes", table(rows));
                 });
}

} // namespace hdmbench::report
