#include "harness/judge/registration/rivals.hpp"

#include "harness/applications/conventional_registration.hpp"
#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/physical_registration.hpp"
#include "harness/applications/picture.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {

namespace {

/// What is turned, and back to usual for each value.
struct Settings {
  Scene told;
  PlantedOptions pair{.kind = Planted::resection};
  PlantedInclusion inclusion{};
};

struct Knob {
  std::string_view name;
  std::vector<double> values;
  std::function<void(Settings&, double)> turn;
  bool registers = true; ///< means something to Algorithms 5 and 6
  bool detects = true;   ///< to Algorithm 7
};

void scale_label(Scene& scene, int label, double factor) {
  for (std::size_t site = 0; site < scene.extent().sites(); ++site) {
    if (scene.labels.values[site] == label) {
      scene.full.modulus.values[site] *= static_cast<float>(factor);
    }
  }
  set_inverse_modulus(scene.full);
}

/// Discs of 4 pixels in which tissue is told to be as the tissue of another site.
void mistake_labels(Scene& scene, double share) {
  constexpr double radius = 4.0; // pixels
  GaussianNoise random(1);
  const Extent extent = scene.extent();
  const auto any_tissue = [&] {
    for (;;) {
      const auto site = static_cast<std::size_t>(random.uniform() * static_cast<double>(extent.sites()));
      if (scene.labels.values[site] > 0) {
        return site;
      }
    }
  };
  const auto tissue = std::ranges::count_if(scene.labels.values, [](int label) { return label > 0; });
  const double discs = share * static_cast<double>(tissue) / (M_PI * radius * radius);
  for (int disc = 0; disc < static_cast<int>(std::lround(discs)); ++disc) {
    const std::size_t centre = any_tissue();
    const std::size_t like = any_tissue();
    const int label = scene.labels.values[like];
    const float modulus = scene.full.modulus.values[like];
    const auto width = static_cast<std::size_t>(extent.width);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      if (scene.labels.values[site] > 0 && std::hypot(x - static_cast<double>(centre % width),
                                                      y - static_cast<double>(centre / width)) <= radius) {
        scene.labels.values[site] = label;
        scene.full.modulus.values[site] = modulus;
      }
    });
  }
  set_inverse_modulus(scene.full);
}

double mean_over_tissue(const VectorField& confidence, const LabelField& labels) {
  double sum = 0.0;
  for (std::size_t site = 0; site < labels.values.size(); ++site) {
    sum += labels.values[site] > 0 ? 0.5 * static_cast<double>(confidence.x[site] + confidence.y[site]) : 0.0;
  }
  return sum / static_cast<double>(std::ranges::count_if(labels.values, [](int label) { return label > 0; }));
}

std::vector<Knob> knobs() {
  constexpr bool no = false;
  return {
      {"noise of pictures", {0.01, 0.03, 0.06, 0.1}, [](auto& s, double v) { s.pair.noise = v; }, true, no},
      {"noise of the displacement",
       {0.003, 0.01, 0.03, 0.1},
       [](auto& s, double v) { s.inclusion.noise = v; },
       no},
      {"largest displacement, px",
       {2.0, 5.0, 10.0, 15.0},
       [](auto& s, double v) { s.pair.amplitude = s.inclusion.amplitude = v; }},
      {"region's radius over the image's width",
       {0.04, 0.07, 0.1, 0.13, 0.18},
       [](auto& s, double v) { s.pair.region_share = s.inclusion.region_share = v; }},
      {"radius of the inclusion, px",
       {3.0, 5.0, 8.0, 12.0},
       [](auto& s, double v) { s.inclusion.radius = v; },
       no},
      {"contrast of the inclusion",
       {0.33, 1.2, 1.5, 3.0, 10.0},
       [](auto& s, double v) { s.inclusion.contrast = v; },
       no},
      {"Poisson's ratio told, truth 0.4",
       {0.2, 0.3, 0.4, 0.49},
       [](auto& s, double v) { s.told.poisson = v; }},
      {"modulus told of label 4, over the true one",
       {0.5, 1.0, 2.0},
       [](auto& s, double v) { scale_label(s.told, 4, v); }},
      {"share of tissue with a wrong label told", {0.0, 0.05, 0.2}, [](auto& s, double v) {
         mistake_labels(s.told, v);
       }}};
}

/// Algorithm 6, or 5 after ITK's B-splines.
void register_cases(const Scene& scene, Settings settings, bool iterates, KnobRow& row,
                    const Backend& backend, const SessionOptions& options) {
  Progress silent(false);
  const auto session = backend.open_elastic(options);
  const Scene told = with_elastic_energy(settings.told);
  const auto count = static_cast<double>(row.cases);
  const auto add = [&](std::optional<double>& mean, double value) {
    mean = mean.value_or(0.0) + value / count;
  };
  row.folded = 0;
  for (std::int64_t number = 0; number < row.cases; ++number) {
    settings.pair.seed = static_cast<std::uint32_t>(number + 1);
    const PlantedPair pair = plant(scene, settings.pair);
    VectorField displacement;
    if (iterates) {
      IteratedRegistration found =
          register_iteratively(pair.source, pair.target, told, pair.region, {}, *session, silent);
      add(row.outliers, found.iterations.back().outliers);
      row.not_converged = row.not_converged.value_or(0) + (found.converged ? 0 : 1);
      row.seconds += found.seconds / count;
      displacement = std::move(found.displacement);
    } else {
      const ConventionalRegistration before =
          register_conventionally(pair.source, pair.target, pair.region, {}, silent);
      VectorField confidence;
      Solution solution = make_physical(pair.source, pair.target, before.displacement, pair.region, told,
                                        backend, options, confidence, silent);
      add(row.conventional, error_of(before.displacement, pair, scene.labels).region);
      add(row.believed, mean_over_tissue(confidence, told.labels));
      row.seconds += (before.seconds + solution.timings.total()) / count;
      displacement = std::move(solution.displacement);
    }
    const RegistrationError error = error_of(displacement, pair, scene.labels);
    add(row.tissue, error.tissue);
    add(row.region, error.region);
    *row.folded += error.folds > 0 ? 1 : 0;
  }
}

void detect_cases(const Scene& scene, Settings settings, KnobRow& row, ElasticSession& session) {
  Progress silent(false);
  std::vector<InclusionRow> found;
  std::vector<double> distances;
  row.found = row.mistaken = row.warned = row.mistaken_warned = 0;
  for (std::int64_t number = 0; number < row.cases; ++number) {
    settings.inclusion.seed = static_cast<std::uint32_t>(number + 1);
    for (const double contrast : {settings.inclusion.contrast, 1.0}) {
      PlantedInclusion inclusion = settings.inclusion;
      inclusion.contrast = contrast;
      const InclusionRow one = look_for(scene, settings.told, inclusion, false, session, silent);
      if (one.score > one.by_chance) {
        ++(contrast == 1.0 ? *row.mistaken : *row.found);
        (contrast == 1.0 ? *row.mistaken_warned : *row.warned) += one.doubted ? 1 : 0;
      }
      if (contrast != 1.0) {
        distances.push_back(one.distance);
      }
      row.seconds += one.seconds / (2.0 * static_cast<double>(row.cases));
      found.push_back(one);
    }
  }
  row.area = area_under_roc(found);
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::ranges::nth_element(distances, middle);
  row.distance = *middle;
}

} // namespace

std::vector<KnobRow> turn_knobs(const Scene& scene, int cases, bool slow, const Backend& backend,
                                const SessionOptions& options, Progress& progress) {
  const auto session = backend.open_elastic(options);
  std::vector<KnobRow> rows;
  for (const Knob& knob : knobs()) {
    for (const std::string_view algorithm : {algorithm_5, algorithm_6, algorithm_7}) {
      const bool detects = algorithm == algorithm_7;
      if (!(detects ? knob.detects : knob.registers) || (algorithm == algorithm_5 && !slow)) {
        continue;
      }
      for (const double value : knob.values) {
        progress.describe(fmt::format("rivals {}: {}, {} {:g}", scene.name, algorithm, knob.name, value));
        Settings settings{.told = scene};
        knob.turn(settings, value);
        KnobRow row;
        row.set_scene(scene);
        row.algorithm = std::string(algorithm);
        row.knob = std::string(knob.name);
        row.value = value;
        row.cases = cases;
        if (detects) {
          detect_cases(scene, settings, row, *session);
        } else {
          register_cases(scene, settings, algorithm == algorithm_6, row, backend, options);
        }
        rows.push_back(row);
        progress.advance(1.0);
      }
    }
  }
  return rows;
}

} // namespace hdmbench
