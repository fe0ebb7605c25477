#include "harness/judge/registration/rivals.hpp"

#include "backends/shared/elastic_session.hpp"
#include "harness/applications/picture.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hdmbench {

namespace {

using nlohmann::json;

constexpr std::string_view algorithm_7 = "Algorithm 7";

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

/// Of the cases that `algorithm` registered.
json registration_figures(const json& cases, std::string_view algorithm) {
  json figures;
  const auto of_method = [&](std::string_view method, const char* key) {
    double sum = 0.0;
    int count = 0;
    for (const json& row : cases) {
      if (row["method"] == method && row.contains(key)) {
        sum += row[key].get<double>();
        ++count;
      }
    }
    return count > 0 ? json(sum / count) : json();
  };
  for (const char* const key : {"tissue", "region", "seconds", "outliers", "believed"}) {
    figures[key] = of_method(algorithm, key);
  }
  const auto count = [&](const char* key, const auto& holds) {
    figures[key] = std::ranges::count_if(
        cases, [&](const json& row) { return row["method"] == algorithm && holds(row); });
  };
  count("folded", [](const json& row) { return row["folds"] > 0; });
  if (algorithm == algorithm_5) {
    figures["conventional"] = of_method(by_b_splines, "region");
  } else {
    count("not_converged", [](const json& row) { return row["converged"] == false; });
  }
  return without_nulls(figures);
}

} // namespace

json turn_knobs(const Scene& scene, int cases, bool slow, const Backend& backend,
                const SessionOptions& options, Progress& progress) {
  const auto session = backend.open_elastic(options);
  const auto wanted = [&](std::string_view way) {
    return way == algorithm_6 || (slow && (way == algorithm_5 || way == by_b_splines));
  };
  Progress silent(false);
  json rows = json::array();
  for (const Knob& knob : knobs()) {
    for (const double value : knob.values) {
      progress.describe(fmt::format("rivals {}: {} {:g}", scene.name, knob.name, value));
      Settings settings{.told = scene};
      knob.turn(settings, value);
      const auto add = [&](std::string_view algorithm, const json& figures) {
        json& row = rows.emplace_back(row_of(scene));
        row.update({{"algorithm", algorithm}, {"knob", knob.name}, {"value", value}, {"cases", cases}});
        row.update(figures);
      };
      if (knob.registers) {
        json registered = json::array();
        for (int number = 1; number <= cases; ++number) {
          settings.pair.seed = static_cast<std::uint32_t>(number);
          const json more =
              compare_rivals(wanted, scene, settings.told, settings.pair, backend, options, silent);
          registered.insert(registered.end(), more.begin(), more.end());
        }
        if (slow) {
          add(algorithm_5, registration_figures(registered, algorithm_5));
        }
        add(algorithm_6, registration_figures(registered, algorithm_6));
      }
      if (knob.detects) {
        const auto inclusion_of = [&](std::uint32_t number) {
          settings.inclusion.seed = number;
          return settings.inclusion;
        };
        const Search search{scene, settings.told, false, *session};
        add(algorithm_7, detection_figures(look_for_cases(cases, inclusion_of, search, silent)));
      }
      progress.advance(1.0);
    }
  }
  return rows;
}

} // namespace hdmbench
