#include "harness/report/portability.hpp"
#include "harness/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench::report {

namespace {

using State = PlatformTime::State;

std::string percent(double share) {
  return fmt::format("{:.{}f} %", share * 100.0, share < 0.1 ? 2 : 1);
}

std::string cell(const PlatformTime& time) {
  if (time.state == State::absent) {
    return "<td class=\"skipped\">not there</td>";
  }
  if (time.state == State::wrong) {
    return "<td class=\"disagree\">disagrees</td>";
  }
  std::string small = time.msites_per_second ? fmt::format("{:.4g} Msites/s, ", *time.msites_per_second) : "";
  small += fmt::format("{} of the fastest", percent(*time.application_efficiency));
  if (time.architectural_efficiency) {
    small += fmt::format(", {} of the ceiling", percent(*time.architectural_efficiency));
  }
  return fmt::format("<td class=\"number\">{} s<small>{}</small></td>", seconds_text(*time.seconds), small);
}

/// Headings are HTML and live as long as the table's.
std::string start(std::string_view css_class, const std::vector<std::string>& platforms,
                  std::initializer_list<std::string_view> more) {
  std::vector<std::string> escaped;
  for (const std::string& platform : platforms) {
    escaped.push_back(">" + escape(platform));
  }
  std::vector<std::string_view> headings{"Backend"};
  headings.insert(headings.end(), escaped.begin(), escaped.end());
  headings.insert(headings.end(), more);
  return table_start(css_class, headings);
}

std::string problem_table(const PortableProblem& problem) {
  std::string html = start("portability", problem.platforms, {">PP, fastest", ">PP, ceiling"});
  for (const ApplicationPortability& one : problem.applications) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escape(one.application));
    for (const PlatformTime& time : one.times) {
      html += cell(time);
    }
    html += fmt::format("<td class=\"number\">{}</td><td class=\"number\">{}</td></tr>\n",
                        percent(one.of_applications),
                        one.of_architecture ? percent(*one.of_architecture) : std::string("no ceiling"));
  }
  return html + std::string(table_end);
}

std::string tier_cell(const PlatformTier& tier) {
  return tier.disagrees ? "<td class=\"number disagree\">disagrees</td>"
                        : fmt::format("<td class=\"number agree\">{}<small>{}</small></td>",
                                      name_of(tier.tier), plural(tier.comparisons, "comparison"));
}

std::string tier_table(const std::vector<PlatformTier>& tiers) {
  std::vector<std::string> platforms;
  std::vector<std::string> applications;
  const auto add = [](std::vector<std::string>& names, const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) {
      names.push_back(name);
    }
  };
  for (const PlatformTier& tier : tiers) {
    add(platforms, tier.platform);
    add(applications, tier.application);
  }
  std::string html = start("portability", platforms, {});
  for (const std::string& application : applications) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escape(application));
    for (const std::string& platform : platforms) {
      const auto found = std::ranges::find_if(tiers, [&](const PlatformTier& tier) {
        return tier.application == application && tier.platform == platform;
      });
      html += found == tiers.end() ? "<td class=\"skipped\">not there</td>" : tier_cell(*found);
    }
    html += "</tr>\n";
  }
  return html + std::string(table_end);
}

} // namespace

std::string portability_section(const Results& results, Anchors& anchors) {
  std::string html = "<section>\n" + heading(2, anchors.unique("portability"), "Machines side by side");
  std::vector<PortableProblem> problems = portability(results);
  std::erase_if(problems, [](const PortableProblem& problem) { return problem.platforms.size() < 2; });
  if (problems.empty()) {
    return html + "<p class=\"empty\">No scene in these results was timed on two processors. <code>hdmbench "
                  "report A B C</code> with the result folders of several machines lays them side by side."
                  "</p>\n</section>\n";
  }
  html += "<p>PP is the performance portability of Pennycook, Sewall and Lee: the harmonic mean of a "
          "backend's efficiencies over the processors of a table, and 0 if it is not there on one of them or "
          "disagrees. The efficiency is, in the first column, the time of the fastest backend on that "
          "processor over the backend's own, in the second the share of the ceiling, of memory or "
          "arithmetic, that binds it. A driver that computes on the CPU counts for the CPU.</p>\n";
  const std::vector<PlatformTier> tiers = tiers_by_platform(results);
  if (!tiers.empty()) {
    html += heading(3, anchors.unique("portability tiers"), "Lowest tier") + tier_table(tiers);
  }
  for (const PortableProblem& problem : problems) {
    html += heading(3, anchors.unique("portability " + problem.name), problem.name) + problem_table(problem);
  }
  return html + "</section>\n";
}

} // namespace hdmbench::report
