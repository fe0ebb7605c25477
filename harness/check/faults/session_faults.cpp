#include "harness/check/faults/faulty_backend.hpp"

#include "harness/check/compare.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

namespace hdmbench::faults {

namespace {

void each_of(std::vector<float>& values, float (*change)(float)) {
  std::ranges::transform(values, values.begin(), change);
}

/// change() of every component of every site.
std::function<void(VectorField&)> each(float (*change)(float)) {
  return [change](VectorField& field) {
    for (std::vector<float>& plane : field.planes) {
      each_of(plane, change);
    }
  };
}

float one_ulp_up(float value) {
  return std::nextafter(value, std::numeric_limits<float>::infinity());
}

/// The last axis of the field.
std::vector<float>& last_plane(VectorField& field) {
  return field[field.extent.axes() - 1];
}

/// The sites that `chosen` returns true for keep what they had.
template <typename Chosen>
void keep(VectorField& after, const VectorField& before, const Chosen& chosen) {
  for (std::size_t site = 0; site < after[0].size(); ++site) {
    if (chosen(site)) {
      set_site(after, site, site_of(before, site));
    }
  }
}

/// Row 0 last, or in a volume slice 0.
void turn_round(VectorField& field) {
  const auto [width, height, depth] = field.extent.sides();
  const auto row = static_cast<std::ptrdiff_t>(width * (depth > 1 ? height : 1));
  for (std::vector<float>& plane : field.planes) {
    for (auto first = plane.begin(), last = plane.end(); last - first > row; first += row, last -= row) {
      std::swap_ranges(first, first + row, last - row);
    }
  }
}

/// Makes a fault of one hook: in_read("name", "what is wrong", what the hook does).
template <auto hook>
struct WithHook {
  std::string method = "icm";
  Way way = Way::every;
  std::size_t axes = 0;

  Fault operator()(std::string name, std::string what,
                   std::remove_reference_t<decltype(std::declval<Fault>().*hook)> spoil) const {
    Fault fault{.name = std::move(name), .what = std::move(what), .method = method, .axes = axes, .way = way};
    fault.*hook = std::move(spoil);
    return fault;
  }
};
const WithHook<&Fault::in_level> in_level;
const WithHook<&Fault::in_pyramid> in_pyramid;
const WithHook<&Fault::in_write> in_write;
const WithHook<&Fault::in_step> in_step;
const WithHook<&Fault::in_sweep> in_sweep;
const WithHook<&Fault::in_read> in_read;
const WithHook<&Fault::in_changed> in_changed;

const std::string elastic = std::string(elastic_conjugate_gradients);

/// Sums over the image in double precision, without the last rows of the last slice.
auto in_double(int missing_rows) {
  return [missing_rows](const VectorField& a, const VectorField& b) {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < a.extent.axes(); ++axis) {
      sum = std::inner_product(a[axis].begin(), a[axis].end() - missing_rows * a.extent.width,
                               b[axis].begin(), sum, std::plus<>(), std::multiplies<double>());
    }
    return static_cast<float>(sum);
  };
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

/// change(level) of every level of a hierarchy but the image.
template <typename Change>
std::function<void(ElasticHierarchy&)> on_coarse_levels(const Change& change) {
  return [change](ElasticHierarchy& hierarchy) {
    std::for_each(std::next(hierarchy.levels.begin()), hierarchy.levels.end(), change);
  };
}

} // namespace

std::vector<Fault> session_faults() {
  const WithHook<&Fault::in_level> in_closed_form{.method = "closed-form"};
  const WithHook<&Fault::in_sweep> in_volume{.axes = 3};
  const WithHook<&Fault::in_write> in_begin{.way = Way::one_piece};
  const WithHook<&Fault::in_changed> in_last_count{.way = Way::one_piece};
  const WithHook<&Fault::in_sweep> in_active_sweep{.way = Way::active};
  const WithHook<&Fault::in_changed> in_active_count{.way = Way::active};
  const WithHook<&Fault::in_hierarchy> in_hierarchy{.method = elastic};
  const WithHook<&Fault::in_elastic_step> in_elastic_step{.method = elastic};
  const WithHook<&Fault::in_dot> in_dot{.method = elastic};
  return {
      {.name = "sound", .what = "no mistake", .method = "", .is_control = true},
      {.name = "negative-zero",
       .what = "-0 where 0 belongs, which it equals",
       .method = "",
       .is_control = true,
       .in_read = each([](float value) { return value == 0.0F ? -0.0F : value; })},
      {.name = "elastic-sums-in-double",
       .what = "sums over the image in double precision",
       .method = elastic,
       .is_control = true,
       .in_dot = in_double(0)},
      in_read("one-site-one-ulp", "one ulp at one site",
              [](VectorField& field) {
                float& value = last_plane(field)[field[0].size() / 2];
                value = one_ulp_up(value);
              }),
      in_read("nan-at-one-site", "NaN at one site",
              [](VectorField& field) {
                last_plane(field)[field[0].size() / 2] = std::numeric_limits<float>::quiet_NaN();
              }),
      in_step("skipped-sweep", "no sweep is done", [](int) { return 0; }),
      in_sweep("swapped-buffers", "every other time the field before the sweep is handed out",
               [swapped = false](VectorField& after, const VectorField& before) mutable {
                 swapped = !swapped;
                 after = swapped ? before : after;
               }),
      in_sweep("last-row-unwritten", "the last row keeps what it had",
               [](VectorField& after, const VectorField& before) {
                 const std::size_t first =
                     after.extent.sites() - static_cast<std::size_t>(after.extent.width);
                 keep(after, before, [=](std::size_t site) { return site >= first; });
               }),
      in_sweep("last-component-unwritten", "the component along the last axis keeps what it had",
               [](VectorField& after, const VectorField& before) {
                 last_plane(after) = before[after.extent.axes() - 1];
               }),
      in_volume("last-slice-unwritten", "the last slice keeps what it had",
                [](VectorField& after, const VectorField& before) {
                  const std::size_t first = after.extent.index(0, 0, after.extent.depth - 1);
                  keep(after, before, [=](std::size_t site) { return site >= first; });
                }),
      in_volume("step-of-y-along-z", "z takes the candidate that y took",
                [](VectorField& after, const VectorField& before) {
                  for (std::size_t site = 0; site < after[2].size(); ++site) {
                    after[2][site] = before[2][site] + (after[1][site] - before[1][site]);
                  }
                }),
      in_level("in-place", "sites see what their neighbours have just become",
               [](Level& level) { level.update = Update::sequential; }),
      in_write("stale-upload", "the displacement uploaded is that of the upload before",
               [before = VectorField()](VectorField& field) mutable {
                 const VectorField now = field;
                 field = before.extent == field.extent ? before : field;
                 before = now;
               }),
      {.name = "upside-down",
       .what = "row 0 at the bottom, as OpenGL has it, both ways; of a volume slice 0 at the back",
       .in_write = turn_round,
       .in_read = turn_round},
      in_level("inverse-modulus-one-ulp", "1 / m rounded up by one ulp",
               [](Level& level) { each_of(level.inverse_modulus.values, one_ulp_up); }),
      in_level("modulus-one-ulp", "m rounded up by one ulp, 1 / m right",
               [](Level& level) { each_of(level.modulus.values, one_ulp_up); }),
      in_level("tie-order-reversed", "the candidates in reverse order: among equals the last one wins",
               [](Level& level) {
                 std::vector<float> steps(level.steps.values().begin(), level.steps.values().end());
                 std::ranges::reverse(steps);
                 level.steps = StepSet(steps);
               }),
      in_closed_form("relaxation-lost", "every sweep with relaxation 1",
                     [](Level& level) { level.strengths = {1.0F}; }),
      in_changed("count-off-by-one", "one site too many is counted",
                 [](std::int64_t changed) { return changed + 1; }),
      in_changed("count-of-the-sweep-before", "the count comes one sweep late",
                 [before = std::int64_t{0}](std::int64_t changed) mutable {
                   return std::exchange(before, changed);
                 }),
      in_pyramid("wrong-alignment", "in one piece: levels sampled at pixel centres, not at corners",
                 [](Pyramid& pyramid) { pyramid.alignment = Alignment::center; }),
      in_pyramid("pyramid-one-sweep-short", "in one piece: the last level gets one sweep less",
                 [](Pyramid& pyramid) {
                   pyramid.levels.back().sweeps = std::max(0, pyramid.levels.back().sweeps - 1);
                 }),
      in_begin("pyramid-begins-with-the-last",
               "in one piece: a second solution does not begin with the null field, but with what the first "
               "one had on its last level",
               [last = VectorField()](VectorField& begin) mutable {
                 if (last.extent.sites() > begin.extent.sites()) {
                   begin = sample_field(last, begin.extent, Alignment::corner);
                 }
                 last = begin;
               }),
      in_last_count("pyramid-count-off-by-one", "in one piece: one site too many is counted",
                    [](std::int64_t changed) { return changed + 1; }),
      in_active_sweep("tile-never-wakes", "active: a tile that did not change is never looked at again",
                      [older = VectorField()](VectorField& after, const VectorField& before) mutable {
                        keep(after, before, [&](std::size_t site) {
                          return older.extent == before.extent && !differs(older, before, site);
                        });
                        older = before;
                      }),
      in_active_sweep("sleeping-tile-from-the-older-buffer",
                      "active: a tile that did not change is not written, and its buffer has something older",
                      [older = VectorField()](VectorField& after, const VectorField& before) mutable {
                        keep(after, older, [&](std::size_t site) {
                          return older.extent == after.extent && !differs(before, after, site);
                        });
                        older = before;
                      }),
      in_active_count("count-kept-when-all-sleep",
                      "active: when nothing is left to do the count stays that of the last sweep that did "
                      "something",
                      [last = std::int64_t{0}](std::int64_t changed) mutable {
                        return changed == 0 ? last : last = changed;
                      }),
      in_hierarchy("elastic-response-one-ulp", "the response of one site is one unit in the last place off",
                   [](ElasticHierarchy& hierarchy) {
                     float& value = middle_of(hierarchy.levels.front().response[0]);
                     value = one_ulp_up(value);
                   }),
      in_hierarchy("elastic-relaxation", "omega 1 % too large on coarse levels",
                   on_coarse_levels([](ElasticLevel& level) {
                     for (std::vector<float>& response : level.response) {
                       each_of(response, [](float value) { return 1.01F * value; });
                     }
                   })),
      in_hierarchy(
          "elastic-moments-swapped", "cells have x's first moment for y's",
          on_coarse_levels([](ElasticLevel& level) { std::swap(level.moments[1], level.moments[2]); })),
      in_hierarchy("elastic-moment-sign",
                   "a sign in the sum over the children that makes the first moment along the last axis",
                   on_coarse_levels([](ElasticLevel& level) {
                     each_of(level.moments[level.grid.axes()], [](float value) { return -value; });
                   })),
      in_hierarchy("elastic-cut-cell", "a cell that conditions cut loses an entry of its matrix",
                   on_coarse_levels([](ElasticLevel& level) {
                     if (!level.masked.empty()) {
                       middle_of(level.masked.stiffness) = 0.0F;
                     }
                   })),
      in_hierarchy("elastic-poisson-ratio", "Poisson's ratio 0.01 too high",
                   [](ElasticHierarchy& hierarchy) {
                     for (ElasticLevel& level : hierarchy.levels) {
                       level.ratio.nu += 0.01F;
                       level.ratio.lame += 0.05F;
                     }
                   }),
      in_hierarchy("elastic-slope-factor", "slopes along y are 1 % too steep",
                   [](ElasticHierarchy& hierarchy) { hierarchy.levels.front().ratio.y *= 1.01F; }),
      in_hierarchy("elastic-slopes-of-the-image", "cells of all levels are as long as those of the image",
                   [](ElasticHierarchy& hierarchy) {
                     for (ElasticLevel& level : hierarchy.levels) {
                       level.ratio = hierarchy.levels.front().ratio;
                     }
                   }),
      in_hierarchy("elastic-integration", "of a volume's divergence the mean over a cell counts alone",
                   [](ElasticHierarchy& hierarchy) { hierarchy.levels.front().bend = 0.0F; }),
      in_hierarchy("elastic-coarsest-column",
                   "the inverse of the coarsest level begins with its second column",
                   [](ElasticHierarchy& hierarchy) {
                     auto& inverse = hierarchy.coarsest_inverse;
                     const Extent sites = hierarchy.levels.back().grid.sites;
                     const std::size_t size = sites.axes() * sites.sites();
                     std::ranges::rotate(inverse, inverse.begin() + static_cast<std::ptrdiff_t>(size));
                   }),
      in_elastic_step("elastic-sweep-left-out", "no sweep on the first coarse level",
                      [](const MethodStep& step, bool) {
                        return step.kind != MethodStep::Kind::relax || step.level != 1;
                      }),
      // Seen at the end only: verify reads after every step that it follows.
      in_elastic_step("elastic-no-barrier", "a correction is lost where nobody waits for the step before",
                      [unread = 0](const MethodStep& step, bool is_waited_for) mutable {
                        const bool corrects = step.kind == MethodStep::Kind::correct;
                        unread += corrects && !is_waited_for ? 1 : 0;
                        return !corrects || unread != 2; // once, where nothing waits
                      }),
      in_dot("elastic-sum-without-last-row", "a sum over the image ends a row early", in_double(1)),
  };
}

} // namespace hdmbench::faults
