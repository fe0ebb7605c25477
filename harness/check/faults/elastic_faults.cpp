#include "harness/check/faults/session_faults.hpp"

#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench::faults {

namespace {

/// A mistake in what load() uploads.
Fault in_hierarchy(std::string name, std::string what, std::function<void(ElasticHierarchy&)> spoil) {
  return {.name = std::move(name),
          .what = std::move(what),
          .method = std::string(elastic_conjugate_gradients),
          .in_hierarchy = std::move(spoil)};
}

/// `around` in place of every step of this name; all others are taken as they are.
Fault in_step(std::string name, std::string what, std::string_view step,
              std::function<void(const ElasticStep&, const AroundElasticStep&)> around) {
  return {.name = std::move(name),
          .what = std::move(what),
          .method = std::string(elastic_conjugate_gradients),
          .in_elastic_step = [step, around = std::move(around)](const ElasticStep& taken,
                                                                const AroundElasticStep& with) {
            if (taken.name == step) {
              around(taken, with);
            } else {
              taken.take(with.sound);
            }
          }};
}

/// Sums over the image in double precision, without the last rows.
Fault in_dot(std::string name, std::string what, int missing_rows) {
  return {.name = std::move(name),
          .what = std::move(what),
          .method = std::string(elastic_conjugate_gradients),
          .in_dot = [missing_rows](const VectorField& a, const VectorField& b) {
            double sum = 0.0;
            for (std::size_t i = 0; i < a.extent.index(0, a.extent.height - missing_rows); ++i) {
              sum += static_cast<double>(a.x[i]) * b.x[i] + static_cast<double>(a.y[i]) * b.y[i];
            }
            return static_cast<float>(sum);
          }};
}

/// The value that is in the middle of those that are not 0.
float& middle_of(std::vector<float>& values) {
  std::vector<std::size_t> set;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 0.0F) {
      set.push_back(i);
    }
  }
  return values.at(set.empty() ? 0 : set[set.size() / 2]);
}

ElasticLevel& first_coarse(ElasticHierarchy& hierarchy) {
  return hierarchy.levels.at(hierarchy.levels.size() > 1 ? 1 : 0);
}

} // namespace

std::vector<Fault> elastic_faults() {
  return {
      in_hierarchy("elastic-relaxation", "a sweep goes 0.62 of the way in place of 0.6",
                   [](ElasticHierarchy& hierarchy) {
                     for (ElasticLevel& level : hierarchy.levels) {
                       for (auto& values : level.response) {
                         std::ranges::transform(values, values.begin(),
                                                [](float value) { return value * (0.62F / 0.6F); });
                       }
                     }
                   }),
      in_hierarchy("elastic-response-one-ulp", "the response of one site is one unit in the last place off",
                   [](ElasticHierarchy& hierarchy) {
                     float& value = middle_of(hierarchy.levels.front().response[0]);
                     value = std::nextafter(value, std::numeric_limits<float>::infinity());
                   }),
      in_hierarchy(
          "elastic-parent-moment", "a moment of one coarse cell lacks a quarter: one of its children",
          [](ElasticHierarchy& hierarchy) { middle_of(first_coarse(hierarchy).moments[0]) *= 0.75F; }),
      in_hierarchy("elastic-moments-swapped", "the moments along x and y are swapped",
                   [](ElasticHierarchy& hierarchy) {
                     std::swap(hierarchy.levels.front().moments[1], hierarchy.levels.front().moments[2]);
                   }),
      in_hierarchy("elastic-masked-entry", "one entry of the matrix of one cut cell is 0",
                   [](ElasticHierarchy& hierarchy) {
                     for (MaskedCell& cell : first_coarse(hierarchy).masked.cells) {
                       const auto entry = std::ranges::find_if(
                           cell.stiffness, [](float value) { return std::abs(value) > 1e-3F; });
                       if (entry != cell.stiffness.end()) {
                         *entry = 0.0F;
                         return;
                       }
                     }
                   }),
      in_hierarchy("elastic-poisson-ratio", "Poisson's ratio 0.01 too high",
                   [](ElasticHierarchy& hierarchy) { hierarchy.ratio.nu += 0.01F; }),
      in_hierarchy("elastic-coarsest-column",
                   "the inverse of the coarsest level begins with its second column",
                   [](ElasticHierarchy& hierarchy) {
                     auto& inverse = hierarchy.coarsest_inverse;
                     const std::size_t size = 2 * hierarchy.levels.back().grid.sites.sites();
                     std::ranges::rotate(inverse, inverse.begin() + static_cast<std::ptrdiff_t>(size));
                   }),
      in_hierarchy("elastic-prescribed-freed", "a prescribed component may move",
                   [](ElasticHierarchy& hierarchy) {
                     ElasticLevel& image = hierarchy.levels.front();
                     const float some = middle_of(image.response[0]);
                     for_each_site(image.grid.sites, [&](int x, int y) {
                       float& value = image.response[0][image.grid.index(x, y)];
                       value = value == 0.0F ? some : value;
                     });
                   }),
      in_step("elastic-sweep-left-out", "no sweep on the first coarse level", sweep_step,
              [](const ElasticStep& step, const AroundElasticStep& around) {
                if (step.level != 1) {
                  step.take(around.sound);
                }
              }),
      in_step("elastic-from-zero", "a sweep that starts from 0 starts from the last correction",
              sweep_from_zero_step,
              [](const ElasticStep& step, const AroundElasticStep& around) {
                around.sound.relax(step.level, ElasticField::correction);
              }),
      in_step("elastic-stale-level", "the coarsest level keeps the load of before", restricted_load_step,
              [](const ElasticStep& step, const AroundElasticStep& around) {
                if (step.level + 1 < static_cast<int>(around.hierarchy.levels.size())) {
                  step.take(around.sound);
                }
              }),
      in_step("elastic-last-column", "the last column is never corrected", correction_step,
              [](const ElasticStep& step, const AroundElasticStep& around) {
                VectorField before;
                around.sound.read(step.level, step.field, before);
                step.take(around.sound);
                around.spoil(step.level, step.field, [&](VectorField& after) {
                  for (int y = 0; y < after.extent.height; ++y) {
                    const std::size_t site = after.extent.index(after.extent.width - 1, y);
                    after.x[site] = before.x[site];
                    after.y[site] = before.y[site];
                  }
                });
              }),
      in_step("elastic-advance-sign", "the load of conjugate gradients goes the wrong way", advance_step,
              [](const ElasticStep& step, const AroundElasticStep& around) {
                VectorField before;
                around.sound.read(step.level, step.field, before);
                step.take(around.sound);
                if (step.field == ElasticField::load) {
                  around.spoil(step.level, step.field, [&](VectorField& after) {
                    for (std::size_t site = 0; site < after.x.size(); ++site) {
                      after.x[site] = 2.0F * before.x[site] - after.x[site];
                      after.y[site] = 2.0F * before.y[site] - after.y[site];
                    }
                  });
                }
              }),
      // Seen at the end only: verify reads after every step that it follows.
      in_step("elastic-no-barrier", "a correction is lost where nobody waits for the step before",
              correction_step,
              [unread = 0](const ElasticStep& step, const AroundElasticStep& around) mutable {
                unread += around.is_waited_for ? 0 : 1;
                if (unread != 2) { // once, and only where nothing waits
                  step.take(around.sound);
                }
              }),
      in_dot("elastic-sum-without-last-row", "a sum over the image ends a row early", 1),
  };
}

Fault elastic_sums_in_double() {
  return in_dot("elastic-sums-in-double", "sums over the image in double precision", 0);
}

} // namespace hdmbench::faults
