#pragma once

#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/picture.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/judge/registration/ways.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hdmbench {

/// A picture that a command wrote, for the page.
struct NamedPicture {
  std::string caption;
  std::string file; ///< relative to the result file
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(NamedPicture, caption, file)

/// How `register` registers: thesis Algorithm 5 and 6.
inline constexpr std::array<std::string_view, 2> registration_algorithms{"region", "iterated"};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Similarity, mean_squares, correlation, mutual_information)

/// The row of `register`.
struct RegistrationRow : RegisteredScene {
  struct Iteration {
    int level = 0;
    std::int64_t width = 0;
    std::int64_t height = 0;
    double difference = 0.0; ///< gray values of 255
    double outliers = 0.0;   ///< share
    double step = 0.0;       ///< pixels
  };
  double spacing = 1.0;  ///< millimetres per pixel
  Placement placement{}; ///< of the field and its pictures in the patient
  std::string algorithm;
  std::string conventional{}; ///< of Algorithm 5
  std::string energy{};
  std::string backend{};
  std::string device{};
  double seconds = 0.0;
  std::optional<double> conventional_seconds{}; ///< part of seconds
  std::optional<bool> converged{};              ///< of Algorithm 6
  Similarity before{};
  Similarity after{};
  std::int64_t folds = 0;            ///< cells of four sites that are turned over
  double largest_displacement = 0.0; ///< pixels
  std::vector<Iteration> iterations{};
  std::string field{};
  std::vector<NamedPicture> pictures{};
  std::optional<Warnings> warnings{}; ///< none: there are none
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RegistrationRow::Iteration, level, width, height, difference, outliers,
                                   step)
inline void to_json(nlohmann::json& nlohmann_json_j, const RegistrationRow& nlohmann_json_t) {
  NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, scene, width, height, spacing, placement,
                                           algorithm, conventional, energy, backend, device, seconds,
                                           conventional_seconds, converged, before, after, folds,
                                           largest_displacement, iterations, field, pictures, warnings))
}

/// The row of `detect`.
struct DetectionRow : RegisteredScene {
  Placement placement{}; ///< of the images
  std::string backend;
  std::string device;
  double seconds = 0.0;              ///< in all
  double registration_seconds = 0.0; ///< part of them
  std::int64_t region_sites = 0;
  std::int64_t simulations = 0;       ///< pairs of pictures in which nothing is hidden
  std::int64_t as_much_by_chance = 0; ///< of them, in so many as much was found
  double largest_by_chance = 0.0;     ///< the most that was
  double noise = 0.0;                 ///< of the displacement, pixels
  double unexplained_before = 0.0;
  double unexplained = 0.0; ///< pixels, RMS
  double largest = 0.0;     ///< significance, standard deviations
  double x = 0.0;           ///< of the disc that explains it best, pixels
  double y = 0.0;
  double radius = 0.0;
  double contrast = 1.0;              ///< modulus over the label's
  double position_deviation = 0.0;    ///< standard deviation by noise, pixels
  double contrast_deviation = 0.0;    ///< of the logarithm
  bool contrast_at_limit = false;     ///< of the search: it may be more
  bool contrast_undetermined = false; ///< any that the search tries explains as much
  std::optional<int> looks_like{}; ///< the label of the tissue that the picture shows there, if not its own
  std::optional<double> doubted{}; ///< share of the disc where it does
  std::string modulus{};
  std::string deviation{};
  std::string detection{};
  std::vector<NamedPicture> pictures{};
};

inline void to_json(nlohmann::json& nlohmann_json_j, const DetectionRow& nlohmann_json_t) {
  NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(
      NLOHMANN_JSON_TO, scene, width, height, placement, backend, device, seconds, registration_seconds,
      region_sites, simulations, as_much_by_chance, largest_by_chance, noise, unexplained_before, unexplained,
      largest, x, y, radius, contrast, position_deviation, contrast_deviation, contrast_at_limit,
      contrast_undetermined, looks_like, doubted, modulus, deviation, detection, pictures))
}

} // namespace hdmbench
