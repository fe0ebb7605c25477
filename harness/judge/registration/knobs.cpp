#include "harness/judge/registration/knobs.hpp"

#include "harness/applications/iterated_registration.hpp"
#include "harness/applications/noise.hpp"
#include "harness/scene/row_fields.hpp"
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
  bool registers = true; ///< means something to Algorithm 6
  bool detects = true;
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

std::vector<Knob> knobs() {
  return {
      {"noise of pictures",
       {0.01, 0.03, 0.06, 0.1},
       [](Settings& s, double v) { s.pair.noise = v; },
       true,
       false},
      {"noise of the displacement",
       {0.003, 0.01, 0.03, 0.1},
       [](Settings& s, double v) { s.inclusion.noise = v; },
       false,
       true},
      {"largest displacement, px",
       {2.0, 5.0, 10.0, 15.0},
       [](Settings& s, double v) { s.pair.amplitude = s.inclusion.amplitude = v; }},
      {"region's radius over the image's width",
       {0.04, 0.07, 0.1, 0.13, 0.18},
       [](Settings& s, double v) { s.pair.region_share = s.inclusion.region_share = v; }},
      {"radius of the inclusion, px",
       {3.0, 5.0, 8.0, 12.0},
       [](Settings& s, double v) { s.inclusion.radius = v; },
       false,
       true},
      {"contrast of the inclusion",
       {0.33, 1.2, 1.5, 3.0, 10.0},
       [](Settings& s, double v) { s.inclusion.contrast = v; },
       false,
       true},
      {"Poisson's ratio told, truth 0.4",
       {0.2, 0.3, 0.4, 0.49},
       [](Settings& s, double v) { s.told.poisson = v; }},
      {"modulus told of label 4, over the true one",
       {0.5, 1.0, 2.0},
       [](Settings& s, double v) { scale_label(s.told, 4, v); }},
      {"share of tissue with a wrong label told",
       {0.0, 0.05, 0.2},
       [](Settings& s, double v) { mistake_labels(s.told, v); }},
  };
}

void register_cases(const Scene& scene, Settings settings, KnobRow& row, ElasticSession& session) {
  Progress silent(false);
  row.tissue = row.region = row.outliers = 0.0;
  row.not_converged = row.folded = 0;
  const auto count = static_cast<double>(row.cases);
  for (std::int64_t number = 0; number < row.cases; ++number) {
    settings.pair.seed = static_cast<std::uint32_t>(number + 1);
    const PlantedPair pair = plant(scene, settings.pair);
    const IteratedRegistration found =
        register_iteratively(pair.source, pair.target, settings.told, pair.region, {}, session, silent);
    const RegistrationError error = error_of(found.displacement, pair, scene.labels);
    *row.tissue += error.tissue / count;
    *row.region += error.region / count;
    *row.outliers += found.iterations.back().outliers / count;
    *row.not_converged += found.converged ? 0 : 1;
    *row.folded += error.folds > 0 ? 1 : 0;
    row.seconds += found.seconds / count;
  }
}

void detect_cases(const Scene& scene, Settings settings, KnobRow& row, ElasticSession& session) {
  Progress silent(false);
  std::vector<InclusionRow> found;
  std::vector<double> distances;
  row.found = row.mistaken = 0;
  for (std::int64_t number = 0; number < row.cases; ++number) {
    settings.inclusion.seed = static_cast<std::uint32_t>(number + 1);
    for (const double contrast : {settings.inclusion.contrast, 1.0}) {
      PlantedInclusion inclusion = settings.inclusion;
      inclusion.contrast = contrast;
      const InclusionRow one = look_for(scene, settings.told, inclusion, false, session, silent);
      (contrast == 1.0 ? *row.mistaken : *row.found) += one.score > one.by_chance ? 1 : 0;
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

void list_fields(Fields& fields, KnobRow& row) {
  fields("scene", row.scene);
  fields("width", row.width);
  fields("height", row.height);
  fields("algorithm", row.algorithm);
  fields("knob", row.knob);
  fields("value", row.value);
  fields("cases", row.cases);
  fields("seconds", NotNegative{row.seconds});
  fields.if_any("tissue", row.tissue);
  fields.if_any("region", row.region);
  fields.if_any("outliers", row.outliers);
  fields.if_any("not_converged", row.not_converged);
  fields.if_any("folded", row.folded);
  fields.if_any("area", row.area);
  fields.if_any("distance", row.distance);
  fields.if_any("found", row.found);
  fields.if_any("mistaken", row.mistaken);
}

std::vector<KnobRow> turn_knobs(const Scene& scene, int cases, ElasticSession& session, Progress& progress) {
  std::vector<KnobRow> rows;
  for (const Knob& knob : knobs()) {
    for (const bool detects : {false, true}) {
      if (!(detects ? knob.detects : knob.registers)) {
        continue;
      }
      for (const double value : knob.values) {
        progress.describe(fmt::format("rivals {}: {} {:g}", scene.name, knob.name, value));
        Settings settings{.told = scene};
        knob.turn(settings, value);
        KnobRow row{.scene = scene.name,
                    .width = scene.extent().width,
                    .height = scene.extent().height,
                    .algorithm = std::string(detects ? algorithm_7 : algorithm_6),
                    .knob = std::string(knob.name),
                    .value = value,
                    .cases = cases};
        (detects ? detect_cases : register_cases)(scene, settings, row, session);
        rows.push_back(row);
        progress.advance(1.0);
      }
    }
  }
  return rows;
}

} // namespace hdmbench
