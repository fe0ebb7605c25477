#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

namespace hdmbench::report {

namespace {

using Rows = std::vector<InstructionsRow>;

Rows of_group(const Rows& rows, std::string_view group) {
  Rows found;
  std::ranges::copy_if(rows, std::back_inserter(found), [&](const auto& row) { return row.group == group; });
  return found;
}

std::string number_html(std::optional<std::int64_t> number) {
  return fmt::format("<td class=\"number\">{}</td>", number ? count_text(*number) : "");
}

std::string fit_html(const InstructionsRow& row) {
  return row.instructions ? "<td class=\"yes\">yes</td>"
                          : fmt::format("<td class=\"disagree\"><b>no</b>: {}</td>", escape(row.refusal));
}

/// One row per shader of gl-fragment.
std::string sweeps_table(const Rows& rows, bool named) {
  std::vector<std::string_view> headings{">Candidates",  ">Instructions",      ">Of them texture",
                                         ">Temporaries", ">Scalar operations", "Fits"};
  headings.insert(headings.begin(), named ? "Method" : "Step set");
  std::string html = table_start("instructions", headings);
  for (const InstructionsRow& row : rows) {
    html += fmt::format("<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td>", escape(row.shader),
                        row.candidates > 0 ? count_text(row.candidates) : "none");
    html += number_html(row.instructions) + number_html(row.texture_instructions) +
            number_html(row.temporaries) + number_html(row.scalar_operations) + fit_html(row) + "</tr>\n";
  }
  return html + std::string(table_end);
}

/// "All 15 sets fit, the largest of 16 candidates with 260 of 512 instructions."
std::string candidates_sentence(const Rows& rows) {
  const InstructionsRow* largest = nullptr;
  std::int64_t fitting = 0;
  for (const InstructionsRow& row : rows) {
    if (row.instructions) {
      ++fitting;
      largest = largest == nullptr || row.candidates > largest->candidates ? &row : largest;
    }
  }
  const auto all = static_cast<std::int64_t>(rows.size());
  if (largest == nullptr) {
    return "<p>No set of candidates fits.</p>\n";
  }
  return fmt::format(
      "<p>{} of the {} sets fit; the largest of them has {} and takes {} of {} instructions.</p>\n",
      fitting == all ? "All" : count_text(fitting), count_text(all), plural(largest->candidates, "candidate"),
      count_text(*largest->instructions), count_text(largest->instructions_limit));
}

/// What becomes of the thesis's claim where the sets of 4 and of 6 step sizes were compiled.
std::string claim_html(const Rows& rows, const std::string& shader) {
  const auto fits = [&](std::int64_t step_sizes) -> std::optional<bool> {
    const auto row = std::ranges::find_if(rows, [&](const InstructionsRow& one) {
      return one.shader == shader && one.candidates == step_sizes;
    });
    return row == rows.end() ? std::nullopt : std::optional(row->instructions.has_value());
  };
  const auto four = fits(4);
  const auto six = fits(6);
  if (!four || !six) {
    return "<td class=\"faint\">not compiled</td>";
  }
  if (*four && !*six) {
    return "<td class=\"agree\">4 fit, 6 do not</td>";
  }
  return fmt::format("<td>{}</td>", *four ? "both fit" : *six ? "only 6 fit" : "neither fits");
}

/// One row per way of writing, one column per number of vectors.
std::string vectors_table(const Rows& rows) {
  std::set<std::int64_t> counts;
  std::vector<std::string> shaders;
  for (const InstructionsRow& row : rows) {
    counts.insert(row.energies);
    if (std::ranges::find(shaders, row.shader) == shaders.end()) {
      shaders.push_back(row.shader);
    }
  }
  std::vector<std::string> titles{"written as", "step sizes"};
  for (const std::int64_t count : counts) {
    titles.push_back(fmt::format(">{}", plural(count, "vector")));
  }
  std::string html = table_start("instructions", {titles.begin(), titles.end()});
  for (const std::string& shader : shaders) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>{}", escape(shader), claim_html(rows, shader));
    for (const std::int64_t count : counts) {
      const auto row = std::ranges::find_if(
          rows, [&](const InstructionsRow& one) { return one.shader == shader && one.energies == count; });
      if (row == rows.end()) {
        html += "<td></td>";
      } else if (row->instructions) {
        html += number_html(row->instructions);
      } else {
        html += fmt::format("<td class=\"number disagree\"><b>no</b><small>{}</small></td>",
                            escape(row->refusal));
      }
    }
    html += "</tr>\n";
  }
  return html + std::string(table_end);
}

constexpr std::string_view vectors_start = R"(<h4>The thesis's evaluation</h4>
<p>Its candidates are vectors: n step sizes for x and for y make n × n of them, each with the whole energy of the site.
It found that 4 step sizes fit and 6 do not. Its shader is not printed, so ours is written in several ways.</p>
)";

constexpr std::string_view vectors_end =
    R"(<p>On two-vectors a compiler does not see that half of the terms depend
on x alone, and computes them for every vector again; on scalars it shares them. gl-fragment has no vectors to try: x
and y do not depend on each other, so each takes its own best step, by the difference form.</p>
)";

constexpr std::string_view scalar_operations_note =
    R"(<p>Scalar operations are a second opinion, without a card: float
operations after glslang and spirv-opt, one per component. An instruction of the card is up to four of them.</p>
)";

std::string machine_html(const Rows& rows) {
  const InstructionsRow& any = rows.front();
  std::string html = fmt::format(
      R"(<p>Compiled for {} by {}. It has room for {} instructions, texture fetches included. A shader that
is too long fails there without an OpenGL error, so what reports no count does not fit.</p>
)",
      escape(any.device), escape(any.driver), count_text(any.instructions_limit));
  if (const Rows candidates = of_group(rows, "candidates"); !candidates.empty()) {
    html += "<h4>What gl-fragment sends, by the number of candidates</h4>\n" +
            candidates_sentence(candidates) + sweeps_table(candidates, false);
  }
  if (const Rows methods = of_group(rows, "methods"); !methods.empty()) {
    html += "<h4>What it sends for every method</h4>\n" + sweeps_table(methods, true);
  }
  if (const Rows vectors = of_group(rows, "vectors"); !vectors.empty()) {
    html += std::string(vectors_start) + vectors_table(vectors) + std::string(vectors_end);
  }
  return html + std::string(scalar_operations_note);
}

constexpr std::string_view introduction =
    R"(<p>The thesis's card ran fragment shaders of up to 512 operations. With 4
step sizes its shader came very close, 6 went past it (5.4, 6.2.4). Mesa has that card's compiler, which needs no card to
count.</p>
)";

constexpr std::string_view no_counts =
    R"(<p class="empty">No counts in these results; <code>instruction_count --json
FILE</code> in the build folder's test/ produces them.</p>
)";

} // namespace

std::string instructions_section(const Results& results, Anchors& anchors) {
  const SectionText text{"instructions", "Instruction counts on the thesis's graphics card",
                         std::string(introduction) + std::string(no_counts), introduction};
  return section(results, results.instructions, anchors, text,
                 [](const std::string&, const Rows& rows) { return machine_html(rows); });
}

} // namespace hdmbench::report
