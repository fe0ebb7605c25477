#include "harness/judge/diagnosis/diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace hdmbench {

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
  const double by_chance = information_by_chance(source.values.size());
  if (std::abs(after.correlation) < least_correlation &&
      after.mutual_information < of_chance * by_chance + least_information) {
    return {
        {.kind = std::string(no_likeness),
         .message = fmt::format("The pictures have no likeness after the registration: correlation {:.2g}, "
                                "mutual information {:.2g} bits, where noise has {:.2g}.",
                                after.correlation, after.mutual_information, by_chance),
         .advice = "Do not use this displacement; see that both files show the same person and slice."}};
  }
  const double noise = std::hypot(noise_of(source), noise_of(target));
  if (after.mean_squares >= clear_gain * before.mean_squares &&
      before.mean_squares <= of_noise * noise * noise) {
    return {
        {.kind = "nothing-gained",
         .message = fmt::format("There was nothing to gain: before the registration the pictures differed "
                                "by {:.2g} gray values of 255, and their noise is {:.2g}.",
                                std::sqrt(before.mean_squares), noise),
         .advice = "Take the displacement for 0: what it says is the error of the registration."}};
  }
  if (after.mean_squares >= before.mean_squares && after.correlation <= before.correlation &&
      after.mutual_information <= before.mutual_information) {
    return {
        {.kind = "nothing-gained",
         .message = "Nothing was gained: by every measure the pictures are no more alike than before.",
         .advice = "Take the displacement for 0, or register otherwise: --iterate, --conventional demons."}};
  }
  return {};
}

} // namespace hdmbench
