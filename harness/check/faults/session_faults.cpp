#include "harness/check/faults/session_faults.hpp"

#include "harness/scene/sites.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench::faults {

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

template <typename Change>
void change_all(VectorField& field, Change change) {
  for (auto* const values : {&field.x, &field.y}) {
    std::ranges::transform(*values, values->begin(), change);
  }
}

std::size_t middle(const VectorField& field) {
  return field.x.size() / 2;
}

float one_ulp_up(float value) {
  return std::nextafter(value, std::numeric_limits<float>::infinity());
}

/// 11 significant bits.
float as_half(float value) {
  int exponent = 0;
  const float significand = std::frexp(value, &exponent);
  return std::ldexp(std::nearbyint(std::ldexp(significand, 11)), exponent - 11);
}

/// Row y begins y elements late: a pitch that is one element too long.
void shift_rows(VectorField& field) {
  const VectorField sound = field;
  for_each_site(field.extent, [&](int x, int y) {
    const std::size_t from = (field.extent.index(x, y) + static_cast<std::size_t>(y)) % sound.x.size();
    field.x[field.extent.index(x, y)] = sound.x[from];
    field.y[field.extent.index(x, y)] = sound.y[from];
  });
}

void turn_upside_down(VectorField& field) {
  for (auto* const values : {&field.x, &field.y}) {
    for (int y = 0; y < field.extent.height / 2; ++y) {
      const auto row = [&](int at) {
        return values->begin() + static_cast<std::ptrdiff_t>(field.extent.index(0, at));
      };
      std::swap_ranges(row(y), row(y) + field.extent.width, row(field.extent.height - 1 - y));
    }
  }
}

/// The site of `coarser` that stands where (x, y) of `extent` is, pixel areas aligned.
std::size_t below(Extent coarser, Extent extent, int x, int y) {
  return coarser.index(x * coarser.width / extent.width, y * coarser.height / extent.height);
}

void take_nearest(VectorField& field, const VectorField& coarser) {
  for_each_site(field.extent, [&](int x, int y) {
    const std::size_t from = below(coarser.extent, field.extent, x, y);
    field.x[field.extent.index(x, y)] = coarser.x[from];
    field.y[field.extent.index(x, y)] = coarser.y[from];
  });
}

/// Conditions as the level before has them: two textures of four that were not uploaded again.
void keep_conditions(Level& level, const Level& before) {
  for_each_site(level.extent, [&](int x, int y) {
    const std::size_t to = level.extent.index(x, y);
    const std::size_t from = below(before.extent, level.extent, x, y);
    level.target.x[to] = before.target.x[from];
    level.target.y[to] = before.target.y[from];
    level.confidence.x[to] = before.confidence.x[from];
    level.confidence.y[to] = before.confidence.y[from];
  });
}

std::vector<Fault> reading_faults() {
  return {
      {.name = "one-site-one-ulp",
       .what = "one ulp at one site",
       .in_read =
           [](VectorField& field) {
             float& value = field.x[middle(field)];
             value = one_ulp_up(value);
           }},
      {.name = "last-corner",
       .what = "0.1 px too much at the last site",
       .in_read = [](VectorField& field) { field.y.back() += 0.1F; }},
      {.name = "drift",
       .what = "0.0001 px too much everywhere",
       .in_read = [](VectorField& field) { change_all(field, [](float value) { return value + 1e-4F; }); }},
      {.name = "nan-at-one-site",
       .what = "NaN at one site",
       .in_read = [](VectorField& field) { field.y[middle(field)] = not_a_number; }},
      {.name = "nan-everywhere",
       .what = "NaN everywhere",
       .in_read = [](VectorField& field) { change_all(field, [](float) { return not_a_number; }); }},
      {.name = "infinity-at-one-site",
       .what = "infinity at one site",
       .in_read = [](VectorField& field) { field.x.front() = std::numeric_limits<float>::infinity(); }},
      {.name = "components-swapped",
       .what = "x handed out as y",
       .in_read = [](VectorField& field) { std::swap(field.x, field.y); }},
      {.name = "row-pitch", .what = "rows read with a pitch one element too long", .in_read = shift_rows},
      {.name = "denormals-flushed",
       .what = "displacements below the smallest normal float become 0",
       .in_read =
           [](VectorField& field) {
             change_all(field,
                        [](float value) { return std::fpclassify(value) == FP_SUBNORMAL ? 0.0F : value; });
           }},
      {.name = "unwritten-zeros",
       .what = "a result nobody wrote: zeros",
       .in_read = [](VectorField& field) { field = VectorField(field.extent); }},
  };
}

std::vector<Fault> sweep_faults() {
  const auto keep = [](VectorField& field, const VectorField& before, int first_x, int first_y) {
    for (int y = first_y; y < field.extent.height; ++y) {
      for (int x = first_x; x < field.extent.width; ++x) {
        field.x[field.extent.index(x, y)] = before.x[field.extent.index(x, y)];
        field.y[field.extent.index(x, y)] = before.y[field.extent.index(x, y)];
      }
    }
  };
  return {
      {.name = "skipped-sweep", .what = "no sweep is done", .in_step = [](int) { return 0; }},
      {.name = "double-sweep", .what = "two sweeps for one", .in_step = [](int n) { return 2 * n; }},
      {.name = "swapped-buffers",
       .what = "the field before the last sweep is handed out",
       .in_output = [](VectorField& field, const VectorField& before) { field = before; }},
      {.name = "last-row-unwritten",
       .what = "the last row keeps what it had",
       .in_output = [keep](VectorField& field,
                           const VectorField& before) { keep(field, before, 0, field.extent.height - 1); }},
      {.name = "last-column-unwritten",
       .what = "the last column keeps what it had",
       .in_output = [keep](VectorField& field,
                           const VectorField& before) { keep(field, before, field.extent.width - 1, 0); }},
      {.name = "in-place",
       .what = "sites see what their neighbours have just become",
       .in_level = [](Level& level) { level.update = Update::sequential; }},
  };
}

std::vector<Fault> displacement_faults() {
  return {
      {.name = "stale-upload",
       .what = "the displacement uploaded is that of the upload before",
       .in_write =
           [before = VectorField()](VectorField& field) mutable {
             const VectorField now = field;
             if (before.extent == field.extent) {
               field = before;
             }
             before = now;
           }},
      {.name = "half-float-upload",
       .what = "the displacement uploaded has 11 significant bits",
       .in_write = [](VectorField& field) { change_all(field, as_half); }},
      {.name = "clamped-upload",
       .what = "the displacement uploaded is clamped to 0 ... 1, as fixed-point textures do",
       .in_write =
           [](VectorField& field) {
             change_all(field, [](float value) { return std::clamp(value, 0.0F, 1.0F); });
           }},
      {.name = "upside-down",
       .what = "row 0 at the bottom, as OpenGL has it, both ways",
       .in_write = turn_upside_down,
       .in_read = turn_upside_down},
      {.name = "nearest-prolongation",
       .what = "a level begins with its sites' nearest ones of the level above, not interpolated",
       .in_begin = take_nearest},
  };
}

std::vector<Fault> level_faults() {
  return {
      {.name = "stale-level",
       .what = "conditions of the level above",
       .in_level =
           [before = Level()](Level& level) mutable {
             const Level now = level;
             if (before.extent != Extent{}) {
               keep_conditions(level, before);
             }
             before = now;
           }},
      {.name = "wrong-alignment",
       .what = "levels sampled at pixel centres instead of corners, or the other way round",
       .in_pyramid =
           [](Level& level, const Scene& scene) {
             const bool corner = scene.schedule.alignment == Alignment::corner;
             const Level other =
                 sample_level(scene.full, level.extent, corner ? Alignment::center : Alignment::corner);
             level.target = other.target;
             level.confidence = other.confidence;
             level.modulus = other.modulus;
             level.inverse_modulus = other.inverse_modulus;
           }},
      {.name = "inverse-modulus-one-ulp",
       .what = "1 / m rounded up by one ulp",
       .in_level =
           [](Level& level) {
             auto& values = level.inverse_modulus.values;
             std::ranges::transform(values, values.begin(), one_ulp_up);
           }},
      {.name = "modulus-one-ulp",
       .what = "m rounded up by one ulp, 1 / m right",
       .in_level =
           [](Level& level) {
             std::ranges::transform(level.modulus.values, level.modulus.values.begin(), one_ulp_up);
           }},
      {.name = "target-rows-shifted",
       .what = "the targets of x one row up",
       .in_level =
           [](Level& level) {
             auto& values = level.target.x;
             const auto width = static_cast<std::size_t>(level.extent.width) % values.size();
             std::ranges::rotate(values, values.begin() + static_cast<std::ptrdiff_t>(width));
           }},
      {.name = "confidence-as-boolean",
       .what = "confidence of x is 0 or 1",
       .in_level =
           [](Level& level) {
             auto& values = level.confidence.x;
             std::ranges::transform(values, values.begin(), [](float c) { return c > 0.0F ? 1.0F : 0.0F; });
           }},
      {.name = "penalty-lost", .what = "K is 1", .in_level = [](Level& level) { level.penalty = 1.0F; }},
      {.name = "candidate-missing",
       .what = "the last candidate is left out",
       .in_level =
           [](Level& level) {
             level.steps = StepSet(level.steps.values().first(level.steps.values().size() - 1));
           }},
      {.name = "tie-order-reversed",
       .what = "the candidates in reverse order: among equals the last one wins",
       .in_level =
           [](Level& level) {
             std::vector<float> steps(level.steps.values().begin(), level.steps.values().end());
             std::ranges::reverse(steps);
             level.steps = StepSet(steps);
           }},
      {.name = "relaxation-lost",
       .what = "every sweep with relaxation 1",
       .method = "closed-form",
       .in_level = [](Level& level) { level.strengths = {1.0F}; }},
      {.name = "other-seed",
       .what = "the random numbers of another seed",
       .method = "annealing",
       .in_level = [](Level& level) { level.seed = (level.seed + 1) % 4093; }},
  };
}

std::vector<Fault> count_faults() {
  return {
      {.name = "count-stuck-at-zero",
       .what = "no site is ever counted as changed",
       .in_changed = [](std::int64_t) { return std::int64_t{0}; }},
      {.name = "count-off-by-one",
       .what = "one site too many is counted",
       .in_changed = [](std::int64_t changed) { return changed + 1; }},
      {.name = "count-of-the-sweep-before",
       .what = "the count comes one sweep late",
       .in_changed = [before = std::int64_t{0}](
                         std::int64_t changed) mutable { return std::exchange(before, changed); }},
  };
}

} // namespace

std::vector<Fault> session_faults() {
  std::vector<Fault> all;
  for (const auto& list :
       {reading_faults(), sweep_faults(), displacement_faults(), level_faults(), count_faults()}) {
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}

} // namespace hdmbench::faults
