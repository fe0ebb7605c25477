#include "harness/judge/registration/rivals.hpp"

#include "harness/applications/detection.hpp"
#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/measure/median.hpp"
#include "harness/scene/sites.hpp"
#include "harness/solve/methods/solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace hdmbench {

namespace {

using nlohmann::json;

/// Where each label's sites are said to land, against where they do, to the nearest pixel: the mean of the
/// labels' Dice coefficients. Sites at which nothing lands in one of both say nothing.
double dice_of(const VectorField& displacement, const VectorField& truth, const LabelField& labels) {
  constexpr int no_label = std::numeric_limits<int>::min();
  const Extent extent = labels.extent;
  const auto moved = [&](const VectorField& by) {
    std::vector<int> landed(extent.sites(), no_label);
    for_each_site(extent, [&](int x, int y, int z) {
      std::array<int, 3> at{};
      bool is_inside = true;
      std::ranges::transform(end_of(by, x, y + z * extent.height), at.begin(),
                             [](float of) { return static_cast<int>(std::lround(of)); });
      for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
        is_inside = is_inside && at[axis] >= 0 && at[axis] < extent.sides()[axis];
      }
      if (is_inside) {
        landed[extent.index(at[0], at[1], at[2])] = labels.values[extent.index(x, y, z)];
      }
    });
    return landed;
  };
  const std::vector<int> said = moved(displacement);
  const std::vector<int> true_labels = moved(truth);
  std::map<int, std::array<double, 2>> counts; // sites that have the label in both, twice; in each, added up
  for (std::size_t site = 0; site < said.size(); ++site) {
    if (said[site] != no_label && true_labels[site] != no_label) {
      counts[said[site]][0] += said[site] == true_labels[site] ? 2.0 : 0.0;
      counts[said[site]][1] += 1.0;
      counts[true_labels[site]][1] += 1.0;
    }
  }
  counts.erase(0);
  double sum = 0.0;
  for (const auto& [label, count] : counts) {
    sum += count[0] / count[1];
  }
  return counts.empty() ? 0.0 : sum / static_cast<double>(counts.size());
}

/// Of finite elements inside the region, had the registration made no error outside.
VectorField given_outside(const Scene& scene, const PlantedPair& pair, bool looks_different,
                          const Backend& backend, const SessionOptions& session, Progress& progress) {
  Scene given = scene;
  given.start.reset();
  given.full.target = pair.truth;
  given.full.confidence = VectorField(scene.extent());
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    const float confidence = pair.region.values[site] == 0.0F ? 1.0F : 0.0F;
    given.full.confidence[0][site] = confidence;
    given.full.confidence[1][site] = confidence;
  }
  if (looks_different) {
    blend_moduli(given.full.modulus, pair.region, 0.05F); // as Algorithm 6 does
    set_inverse_modulus(given.full);
  }
  Solver solver(backend, session);
  return solver.solve(given, progress).displacement;
}

/// Cells of tissue (label > 0) that are turned over.
std::int64_t folds_of(const VectorField& displacement, const LabelField& labels) {
  const ScalarField areas = least_area_ratios(displacement);
  std::int64_t folds = 0;
  for_each_site(areas.extent, [&](int x, int y, int z) {
    folds += labels.values[labels.extent.index(x, y, z)] > 0 &&
             !(areas.values[areas.extent.index(x, y, z)] > 0.0F);
  });
  return folds;
}

} // namespace

RegistrationError error_of(const VectorField& displacement, const PlantedPair& pair,
                           const LabelField& labels) {
  const auto root_of_mean = [](const std::vector<double>& squares) {
    const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
    return squares.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(squares.size()));
  };
  std::vector<double> tissue;
  std::vector<double> region;
  for (std::size_t site = 0; site < labels.extent.sites(); ++site) {
    if (labels.values[site] > 0) {
      double& square = tissue.emplace_back(0.0);
      for (std::size_t axis = 0; axis < labels.extent.axes(); ++axis) {
        const double error = double{displacement[axis][site]} - double{pair.truth[axis][site]};
        square += error * error;
      }
      if (pair.region.values[site] != 0.0F) {
        region.push_back(tissue.back());
      }
    }
  }
  RegistrationError error{.tissue = root_of_mean(tissue),
                          .region = root_of_mean(region),
                          .dice = dice_of(displacement, pair.truth, labels)};
  if (!tissue.empty()) {
    const auto most =
        tissue.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(tissue.size() - 1));
    std::ranges::nth_element(tissue, most);
    error.tissue_95 = std::sqrt(*most);
  }
  error.folds = folds_of(displacement, labels);
  return error;
}

json compare_rivals(const Scene& scene, const PlantedOptions& planted, bool slow, const Backend& backend,
                    const SessionOptions& session, Progress& progress) {
  const Scene elastic = with_elastic_energy(scene);
  const auto what = planted_names[static_cast<std::size_t>(planted.kind)];
  const std::string caption = fmt::format("rivals {}: {}", scene.name, what);
  progress.describe(caption);
  const PlantedPair pair = plant(scene, planted);
  const bool looks_different = planted.kind != Planted::pressure;
  std::vector<RegisteredPair> all =
      register_every_way({pair.source, pair.target, pair.region, looks_different}, elastic, slow, backend,
                         session, caption, progress);
  if (scene.extent().axes() == 2) { // in which there is a region
    RegisteredPair& given = all.emplace_back(
        given_outside(elastic, pair, looks_different, backend, session, progress), row_of(scene));
    given.row.update({{"method", truth_outside}, {"knows_region", true}, {"seconds", 0.0}});
  }
  json rows = json::array();
  for (const RegisteredPair& registered : all) {
    json& row = rows.emplace_back(registered.row);
    row.update(json(error_of(registered.displacement, pair, scene.labels)));
    row.update({{"planted", what},
                {"amplitude", planted.amplitude},
                {"noise", planted.noise},
                {"seed", planted.seed}});
  }
  return rows;
}

PlantedInclusion any_inclusion(std::uint32_t seed) {
  GaussianNoise random(seed);
  const auto between = [&](double least, double most) {
    return least * std::pow(most / least, random.uniform());
  };
  PlantedInclusion inclusion{.radius = between(3.0, 15.0), .seed = seed};
  inclusion.contrast = between(1.5, 10.0);
  return inclusion;
}

json look_for(const PlantedInclusion& inclusion, const Search& search) {
  const auto& [scene, pictures, session] = search;
  PlantedInclusion planted = inclusion;
  planted.noise = pictures ? 0.0 : inclusion.noise;
  const PlantedField field = plant(scene, planted);
  Progress silent(false);
  Detection found;
  double seconds = 0.0;
  if (pictures) {
    const PlantedPair pair = pictures_of(scene, field, inclusion.noise, inclusion.seed);
    const IteratedRegistration registered =
        register_iteratively(pair.source, pair.target, scene, {}, {}, session, silent);
    seconds = registered.seconds;
    found = detect_modulus(pair.source, pair.target, registered.displacement, field.region, scene, {},
                           session, silent);
  } else {
    found = detect_modulus(field.observed, field.region, scene, {}, session, silent);
  }
  double place_score = 0.0;
  for_each_site(scene.extent(), [&](int x, int y) {
    if (std::hypot(x - field.x, y - field.y) < 1.0) {
      const auto significance = static_cast<double>(found.significance.values[scene.extent().index(x, y)]);
      place_score = std::max(place_score, std::abs(significance));
    }
  });
  json row = row_of(scene);
  row.update({{"radius", inclusion.radius},
              {"contrast", inclusion.contrast},
              {"noise", inclusion.noise},
              {"pictures", pictures},
              {"seed", inclusion.seed},
              {"score", std::abs(found.largest)},
              {"by_chance", std::ranges::max(found.by_chance)},
              {"place_score", place_score},
              {"distance", std::hypot(found.x - field.x, found.y - field.y)},
              {"found_contrast", found.contrast},
              {"seconds", seconds + found.seconds}});
  return row;
}

json look_for_cases(std::int64_t cases,
                    const std::function<PlantedInclusion(std::uint32_t number)>& inclusion_of,
                    const Search& search, Progress& progress) {
  json rows = json::array();
  for (std::int64_t number = 1; number <= cases; ++number) {
    PlantedInclusion inclusion = inclusion_of(static_cast<std::uint32_t>(number));
    for (const double contrast : {inclusion.contrast, 1.0}) {
      inclusion.contrast = contrast;
      rows.push_back(look_for(inclusion, search));
      progress.advance(1.0);
    }
  }
  return rows;
}

json detection_figures(const json& cases) {
  const auto is_hidden = [](const json& row) { return row["contrast"] != 1.0; };
  const auto area_by = [&](const char* score) {
    double higher = 0.0;
    double pairs = 0.0;
    for (const json& with : cases) {
      for (const json& without : cases) {
        if (is_hidden(with) && !is_hidden(without)) {
          higher += with[score] > without[score] ? 1.0 : with[score] == without[score] ? 0.5 : 0.0;
          pairs += 1.0;
        }
      }
    }
    return higher / pairs;
  };
  const auto found_in = [&](bool hidden) {
    return std::ranges::count_if(
        cases, [&](const json& row) { return is_hidden(row) == hidden && row["score"] > row["by_chance"]; });
  };
  std::vector<double> distances;
  std::vector<double> shares;
  for (const json& row : cases) {
    if (is_hidden(row)) {
      distances.push_back(row["distance"]);
      shares.push_back(row["found_contrast"].get<double>() / row["contrast"].get<double>());
    }
  }
  return {{"area", area_by("score")},      {"area_by_place", area_by("place_score")},
          {"found", found_in(true)},       {"mistaken", found_in(false)},
          {"distance", median(distances)}, {"found_share", median(shares)}};
}

} // namespace hdmbench
