#pragma once

#include "harness/judge/registration/planted.hpp"
#include "harness/judge/registration/ways.hpp"

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace hdmbench {

/// What a displacement is worth where the true one is known. Pixels, root of the mean of |d - truth|^2.
struct RegistrationError {
  double tissue = 0.0;    ///< over sites of label > 0
  double tissue_95 = 0.0; ///< 95 % of them are nearer than this
  double region = 0.0;    ///< over the region of interest
  double dice = 0.0;      ///< of the labels, moved by it and by the truth, their mean
  std::int64_t folds = 0; ///< cells of tissue that are turned over
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RegistrationError, tissue, tissue_95, region, dice, folds)

[[nodiscard]] RegistrationError error_of(const VectorField& displacement, const PlantedPair& pair,
                                         const LabelField& labels);

inline constexpr std::string_view truth_outside = "the truth given outside the region";

/// Every way and truth_outside on a planted pair: rows as of register_every_way, with the RegistrationError
/// and {planted, amplitude, noise, seed}.
[[nodiscard]] nlohmann::json compare_rivals(const Scene& scene, const PlantedOptions& planted, bool slow,
                                            const Backend& backend, const SessionOptions& session,
                                            Progress& progress);

/// Returns one with a radius of 3 to 15 pixels and a contrast of 1.5 to 10, even on a logarithmic scale, by
/// the seed.
[[nodiscard]] PlantedInclusion any_inclusion(std::uint32_t seed);

/// How a planted inclusion is looked for.
struct Search {
  const Scene& scene;
  bool pictures =
      false; ///< the displacement is not given but found by Algorithm 6, in pictures with the noise
  ElasticSession& session;
};

/// Looks for one planted inclusion, which a contrast of 1 is not: {scene, width, height, radius, contrast,
/// noise (of the displacement: share of the largest one; of pictures: share of white), pictures, seed, score
/// (magnitude of the most significant disc, standard deviations), by_chance (the largest of its simulations
/// with nothing hidden), place_score (the score where the inclusion is: what there is to be found), distance
/// (of the disc that explains the displacement best from the inclusion's centre, pixels), found_contrast (of
/// that disc), seconds}.
[[nodiscard]] nlohmann::json look_for(const PlantedInclusion& inclusion, const Search& search);

/// Cases 1, 2, ... as `inclusion_of` their number, each with its inclusion and without.
[[nodiscard]] nlohmann::json
look_for_cases(std::int64_t cases, const std::function<PlantedInclusion(std::uint32_t number)>& inclusion_of,
               const Search& search, Progress& progress);

/// What such cases come to: {area, area_by_place: under the receiver operating characteristic by score and by
/// place_score, the probability that a case with an inclusion scores higher than one without; found,
/// mistaken: cases with and without one in which more than chance was found; distance, found_share: medians
/// of the error of the position, pixels, and of the contrast found over the true one}.
[[nodiscard]] nlohmann::json detection_figures(const nlohmann::json& cases);

} // namespace hdmbench
