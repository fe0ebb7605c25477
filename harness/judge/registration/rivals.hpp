#pragma once

#include "backends/backend.hpp"
#include "harness/judge/registration/planted.hpp"
#include "harness/judge/registration/ways.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/progress.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
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

[[nodiscard]] RegistrationError error_of(const VectorField& displacement, const PlantedPair& pair,
                                         const LabelField& labels);

/// Cells of tissue (label > 0) that are turned over.
[[nodiscard]] std::int64_t folds_of(const VectorField& displacement, const LabelField& labels);

/// A row of `rivals`: one way to register one planted pair.
struct RivalRow : RegisteredScene, RegistrationError {
  std::string planted; ///< of planted_names
  double amplitude = 0.0;
  double noise = 0.0;
  std::int64_t seed = 0;
  std::string method;
  bool knows_region = false; ///< was told where the region of interest is
  double seconds = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RivalRow, scene, width, height, planted, amplitude, noise, seed, method,
                                   knows_region, seconds, tissue, tissue_95, region, dice, folds)

inline constexpr std::string_view truth_outside = "the truth given outside the region";

/// Every way on a planted pair (register_every_way).
[[nodiscard]] std::vector<RivalRow> compare_rivals(const Scene& scene, const PlantedOptions& planted,
                                                   bool slow, const Backend& backend,
                                                   const SessionOptions& session, Progress& progress);

/// A row of `rivals --other`: one way to register the picture of one person to that of another. Nobody knows
/// the true displacement; what can be said is whether one label lies on the same label.
struct PeopleRow : RegisteredScene {
  /// How much the two have in common of one label.
  struct Overlap {
    int label = 0;
    double dice = 0.0; ///< 0 ... 1
  };
  std::string other; ///< the target; the source is `scene`
  std::string method;
  double dice = 0.0;             ///< mean over the labels above 0 that both have
  std::vector<Overlap> overlaps; ///< of each of them
  double correlation = 0.0;      ///< of the pictures afterwards
  std::int64_t folds = 0;        ///< cells of tissue that are turned over
  double seconds = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PeopleRow::Overlap, label, dice)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PeopleRow, scene, width, height, other, method, dice, overlaps,
                                   correlation, folds, seconds)

/// Of each label above 0 that both have: twice the sites where `source` at x and `target` at x + d(x), to the
/// nearest site, are of that label, over those of either.
[[nodiscard]] std::vector<PeopleRow::Overlap> overlaps_of(const LabelField& source, const LabelField& target,
                                                          const VectorField& displacement);

/// Every way of register_every_way, from the picture of `scene` to that of `other`. A label must be the same
/// tissue in both. Throws InputError where they have not the same size, or one has no picture or labels.
[[nodiscard]] std::vector<PeopleRow> compare_people(const Scene& scene, const Scene& other, bool slow,
                                                    const Backend& backend, const SessionOptions& session,
                                                    Progress& progress);

/// A row of `roc`: one planted inclusion, or none.
struct InclusionRow : RegisteredScene {
  double radius = 0.0;
  double contrast = 1.0; ///< 1: nothing was hidden
  double noise = 0.0;    ///< of the displacement, share of the largest one; of pictures, share of white
  bool pictures = false; ///< the displacement was not given but found by Algorithm 6
  bool spread = false;   ///< of a series in which radius and contrast differ from case to case
  std::int64_t seed = 0;
  double score = 0.0;       ///< magnitude of the most significant disc, standard deviations
  double by_chance = 0.0;   ///< the largest of its simulations with nothing hidden
  double place_score = 0.0; ///< what there is to be found: the score where the inclusion is
  double distance =
      0.0; ///< of the disc that explains the displacement best from the inclusion's centre, pixels
  double found_contrast = 1.0; ///< of that disc
  bool doubted = false;        ///< the picture shows another tissue there than the label says
  double seconds = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InclusionRow, scene, width, height, radius, contrast, noise, pictures,
                                   spread, seed, score, by_chance, place_score, distance, found_contrast,
                                   doubted, seconds)

/// Of a radius of 3 to 15 pixels and a contrast of 1.5 to 10, even on a logarithmic scale, by the seed.
[[nodiscard]] PlantedInclusion any_inclusion(std::uint32_t seed);

/// In the displacement, or with `pictures` in pictures that have its noise. `told` is the scene as the search
/// knows it.
[[nodiscard]] InclusionRow look_for(const Scene& scene, const Scene& told, const PlantedInclusion& inclusion,
                                    bool pictures, ElasticSession& session, Progress& progress);

/// The area under the receiver operating characteristic by `score` or another measure of a row: the
/// probability that a case with an inclusion scores higher than one without. None where either is missing.
[[nodiscard]] std::optional<double> area_under_roc(std::span<const InclusionRow> rows,
                                                   double InclusionRow::*score = &InclusionRow::score);

/// A row of `rivals --knobs`: one thing is turned, all others are as usual. "told" is what the algorithm is
/// told of the tissue, which is not what the truth was made with.
struct KnobRow : RegisteredScene {
  /// algorithm_5 and algorithm_6 register a resection, algorithm_7 looks for inclusions.
  std::string algorithm;
  std::string knob;
  double value = 0.0;
  std::int64_t cases = 0;
  double seconds = 0.0; ///< of a case, mean
  // Algorithms 5 and 6, means over the cases
  std::optional<double> tissue{};       ///< error, pixels
  std::optional<double> region{};       ///< error, pixels
  std::optional<double> conventional{}; ///< of 5: error in the region of the registration before it, pixels
  std::optional<double> believed{};     ///< of 5: mean confidence in that registration over tissue
  std::optional<double> outliers{}; ///< share of the sites that do not match, as the last iteration saw them
  std::optional<std::int64_t> not_converged{}; ///< cases
  std::optional<std::int64_t> folded{};        ///< cases with folds
  // Algorithm 7
  std::optional<double> area{};           ///< under the ROC
  std::optional<double> distance{};       ///< error of the position, median, pixels
  std::optional<std::int64_t> found{};    ///< of the cases with an inclusion, more than chance
  std::optional<std::int64_t> mistaken{}; ///< of as many without
  std::optional<std::int64_t> warned{}; ///< of `found`: the picture shows another tissue than the label says
  std::optional<std::int64_t> mistaken_warned{}; ///< of `mistaken`
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KnobRow, scene, width, height, algorithm, knob, value, cases, seconds,
                                   tissue, region, conventional, believed, outliers, not_converged, folded,
                                   area, distance, found, mistaken, warned, mistaken_warned)

/// Turns noise, size, contrast and what is told of Poisson's ratio, of moduli and of labels. Each row is that
/// of `cases` seeds. Without `slow` Algorithm 5 is left out.
[[nodiscard]] std::vector<KnobRow> turn_knobs(const Scene& scene, int cases, bool slow,
                                              const Backend& backend, const SessionOptions& session,
                                              Progress& progress);

} // namespace hdmbench
