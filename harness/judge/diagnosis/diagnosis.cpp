#include "harness/judge/diagnosis/measures.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <warnings_text.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace hdmbench {

using namespace diagnosis;
using namespace fmt::literals;

namespace {

/// `first` and then the words of `text`, continued under it.
std::string paragraph(const std::string& first, const std::string& text, std::size_t indentation) {
  constexpr std::size_t most_columns = 110;
  std::string result;
  std::string line = fmt::format("{:<{}}", first, indentation - 1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (line.size() + 1 + word.size() > most_columns) {
      result += line + "\n";
      line = std::string(indentation - 1, ' ');
    }
    line += " " + word;
  }
  return result + line + "\n";
}

/// The mean mutual information of pictures that have nothing to do with each other, bits: 2 N ln 2 times it
/// is distributed as chi squared with (bins - 1)^2 degrees of freedom.
double information_by_chance(std::size_t sites) {
  const double freedom = std::pow(static_cast<double>(Similarity::bins) - 1.0, 2);
  return freedom / (2.0 * std::numbers::ln2 * static_cast<double>(sites));
}

} // namespace

Warning diagnosis::warning_of(std::string_view row, std::optional<std::size_t> sites,
                              fmt::format_args figures) {
  static const nlohmann::json table = nlohmann::json::parse(sources::warnings_text);
  const nlohmann::json& texts = table.at(std::string(row));
  const auto filled = [&](const char* text) {
    return fmt::vformat(texts.at(text).get<std::string>(), figures);
  };
  return {std::string(row.substr(0, row.find('/'))), filled("message"), filled("advice"), sites};
}

Warnings diagnosis::without_what_is_given(Warnings warnings, const Scene& scene) {
  const std::string method = "--method " + scene.schedule.method;
  const bool has_fine_steps = scene.full.steps.text() == StepSet::parse("fine").text();
  const auto is_given = [&](const std::string& part) {
    const bool names_method = part == method || part.starts_with(method + ",");
    return names_method || (has_fine_steps && part.starts_with("--steps fine"));
  };
  for (Warning& warning : warnings) {
    std::vector<std::string> parts;
    std::string rest = warning.advice;
    for (std::size_t at = 0; (at = rest.find("; ")) != std::string::npos; rest.erase(0, at + 2)) {
      parts.push_back(rest.substr(0, at));
    }
    parts.push_back(rest);
    if (std::erase_if(parts, is_given) > 0 && !parts.empty()) {
      warning.advice = fmt::format("{}", fmt::join(parts, "; "));
    }
  }
  return warnings;
}

std::string no_result_text(const Scene& scene, std::string_view why) {
  return fmt::format(
      "NO RESULT: {}; {}", why,
      has_laws(scene.full)
          ? "smaller displacements or loads, or a wider way for them to fade out, or the linear law, "
            "which does not see what is wrong with them"
          : "look for extreme moduli, targets or a huge --penalty, or take another --method");
}

std::string warnings_text(std::span<const Warning> warnings) {
  if (warnings.empty()) {
    return "  Checked before and after the run: nothing that speaks against this result was found.\n";
  }
  std::size_t width = 0;
  for (const Warning& warning : warnings) {
    width = std::max(width, warning.kind.size());
  }
  const std::size_t indentation = 2 + width + 2;
  std::string text = fmt::format("  Worth knowing ({}):\n", warnings.size());
  for (const Warning& warning : warnings) {
    text += paragraph("  " + warning.kind, warning.message, indentation);
    text += paragraph("", "-> " + warning.advice, indentation);
  }
  return text;
}

Warnings diagnose(const ScalarField& source, const ScalarField& target, const Similarity& before,
                  const Similarity& after) {
  constexpr double least_correlation = 0.1;
  constexpr double of_chance = 2.0;          // a registration makes pictures of noise a little more alike
  constexpr double least_information = 0.02; // bits
  constexpr double of_noise = 1.5;           // of variances: how far the estimates of noise can be off
  constexpr double clear_gain = 0.5;         // of the mean squared difference
  constexpr double least_gain = 1e-3;        // interpolation alone changes the measures by less
  Warnings warnings;
  const double by_chance = information_by_chance(source.values.size());
  if (std::abs(after.correlation) < least_correlation &&
      after.mutual_information < of_chance * by_chance + least_information) {
    warn(warnings, no_likeness, std::nullopt, "correlation"_a = after.correlation,
         "information"_a = after.mutual_information, "by_chance"_a = by_chance);
    return warnings;
  }
  const double noise = std::hypot(noise_of(source), noise_of(target));
  if (after.mean_squares >= clear_gain * before.mean_squares &&
      before.mean_squares <= of_noise * noise * noise) {
    warn(warnings, "nothing-gained", std::nullopt, "difference"_a = std::sqrt(before.mean_squares),
         "noise"_a = noise);
  } else if (after.mean_squares >= (1.0 - least_gain) * before.mean_squares &&
             after.correlation <= before.correlation + least_gain &&
             after.mutual_information <= before.mutual_information + least_gain) {
    warn(warnings, worse_than_nothing, std::nullopt);
  }
  return warnings;
}

} // namespace hdmbench
