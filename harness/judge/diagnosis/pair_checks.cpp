#include "harness/applications/picture.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace hdmbench {

namespace {

constexpr double least_correlation = 0.1;
/// A registration makes pictures of noise a little more alike.
constexpr double of_chance = 2.0;
constexpr double least_information = 0.02; // bits
/// Of variances: how far the estimates of noise can be off.
constexpr double of_noise = 1.5;
constexpr double clear_gain = 0.5; // of the mean squared difference

/// The mean mutual information of pictures that have nothing to do with each other, bits: 2 N ln 2 times it
/// is distributed as chi squared with (bins - 1)^2 degrees of freedom.
double information_by_chance(std::size_t sites) {
  const double freedom = std::pow(static_cast<double>(Similarity::bins) - 1.0, 2);
  return freedom / (2.0 * std::numbers::ln2 * static_cast<double>(sites));
}

} // namespace

Warnings diagnose(const ScalarField& source, const ScalarField& target, const Similarity& before,
                  const Similarity& after) {
  const double by_chance = information_by_chance(source.values.size());
  if (std::abs(after.correlation) < least_correlation &&
      after.mutual_information < of_chance * by_chance + least_information) {
    return {{.kind = std::string(no_likeness),
             .message = fmt::format("The pictures have no likeness after the registration: their correlation "
                                    "is {:.2g}, their mutual "
                                    "information {:.2g} bits, where pictures of noise have {:.2g}.",
                                    after.correlation, after.mutual_information, by_chance),
             .advice = "Do not use this displacement; see that both files show the same person and slice."}};
  }
  const double noise = std::hypot(noise_of(source), noise_of(target));
  if (after.mean_squares >= clear_gain * before.mean_squares &&
      before.mean_squares <= of_noise * noise * noise) {
    return {
        {.kind = "nothing-gained",
         .message = fmt::format("There was nothing to gain: before the registration the pictures differed by "
                                "{:.2g} gray values of 255, and their noise is {:.2g}.",
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
