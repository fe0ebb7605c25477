#include "harness/check/faults/session_faults.hpp"

#include "harness/check/compare.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench::faults {

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

void each_of(std::vector<float>& values, float (*change)(float)) {
  std::ranges::transform(values, values.begin(), change);
}

/// change() of every component of every site.
std::function<void(VectorField&)> each(float (*change)(float)) {
  return [change](VectorField& field) {
    each_of(field.x, change);
    each_of(field.y, change);
  };
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

void copy_site(const VectorField& from, std::size_t site, VectorField& to) {
  to.x[site] = from.x[site];
  to.y[site] = from.y[site];
}

bool differs(const VectorField& a, const VectorField& b, std::size_t site) {
  return a.x[site] != b.x[site] || a.y[site] != b.y[site];
}

/// Sites from (x, y) on, to the right and below, keep what they had.
void keep(VectorField& after, const VectorField& before, int x, int y) {
  for_each_site(after.extent, [&](int i, int j) {
    if (i >= x && j >= y) {
      copy_site(before, after.extent.index(i, j), after);
    }
  });
}

/// Row y begins y elements late: a pitch that is one element too long.
void shift_rows(VectorField& field) {
  const VectorField sound = field;
  for_each_site(field.extent, [&](int x, int y) {
    const std::size_t to = field.extent.index(x, y);
    const std::size_t from = (to + static_cast<std::size_t>(y)) % sound.x.size();
    field.x[to] = sound.x[from];
    field.y[to] = sound.y[from];
  });
}

void turn_upside_down(VectorField& field) {
  const VectorField upright = field;
  for_each_site(field.extent, [&](int x, int y) {
    const std::size_t from = field.extent.index(x, field.extent.height - 1 - y);
    field.x[field.extent.index(x, y)] = upright.x[from];
    field.y[field.extent.index(x, y)] = upright.y[from];
  });
}

/// Conditions as the level before has them: two textures of four that were not uploaded again.
class StaleConditions {
public:
  void operator()(Level& level) {
    const Level now = level;
    if (before_.extent != Extent{}) {
      level.target = sample_field(before_.target, level.extent, Alignment::center);
      level.confidence = sample_field(before_.confidence, level.extent, Alignment::center);
    }
    before_ = now;
  }

private:
  Level before_;
};

/// Sites that should be awake and are asleep keep what they had.
class SleepySites {
public:
  /// What a site that changed wakes for the next sweep: sites up to `reach` to the right of it and below, and
  /// none to the left of it and above.
  explicit SleepySites(int reach) : reach_(reach) {}

  void operator()(VectorField& after, const VectorField& before) {
    const Extent extent = after.extent;
    if (last_.extent != extent || compare(last_, before).sites > 0) { // another level, another field
      awake_.assign(extent.sites(), 1);
    }
    std::vector<char> awake(extent.sites(), 0);
    for_each_site(extent, [&](int x, int y) {
      const std::size_t site = extent.index(x, y);
      if (awake_[site] == 0) {
        copy_site(before, site, after);
      } else if (differs(before, after, site)) {
        for (int j = y; j <= std::min(y + reach_, extent.height - 1); ++j) {
          for (int i = x; i <= std::min(x + reach_, extent.width - 1); ++i) {
            awake[extent.index(i, j)] = 1;
          }
        }
      }
    });
    awake_ = std::move(awake);
    last_ = after;
  }

private:
  int reach_;
  std::vector<char> awake_;
  VectorField last_; ///< what the sweep before ended with
};

/// Of two buffers in turn, sites that did not change are written to neither: every other sweep shows what
/// they were before they last changed.
class OlderSites {
public:
  void operator()(VectorField& after, const VectorField& before) {
    if (older_.extent == after.extent) {
      for (std::size_t site = 0; site < after.x.size(); ++site) {
        if (!differs(before, after, site)) {
          copy_site(older_, site, after);
        }
      }
    }
    older_ = before;
  }

private:
  VectorField older_;
};

/// A count that is made of the fields before and after every sweep.
Fault counted(std::string name, std::string what, Way way,
              std::function<std::int64_t(const VectorField& after, const VectorField& before)> count) {
  const auto counted = std::make_shared<std::int64_t>(0);
  return {.name = std::move(name),
          .what = std::move(what),
          .way = way,
          .in_sweep = [counted, count = std::move(count)](
                          VectorField& after, const VectorField& before) { *counted = count(after, before); },
          .in_changed = [counted](std::int64_t) { return *counted; }};
}

/// The sites that touch one that changed: what a backend that leaves out work visits.
std::int64_t visited_sites(const VectorField& after, const VectorField& before) {
  const Extent extent = after.extent;
  std::int64_t visited = 0;
  for_each_site(extent, [&](int x, int y) {
    bool near = false;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, extent.height - 1); ++j) {
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, extent.width - 1); ++i) {
        near = near || differs(after, before, extent.index(i, j));
      }
    }
    visited += near ? 1 : 0;
  });
  return visited;
}

/// Makes a fault of one hook: in_read("name", "what is wrong", what the hook does).
template <auto hook>
struct WithHook {
  Fault operator()(std::string name, std::string what,
                   std::remove_reference_t<decltype(std::declval<Fault>().*hook)> spoil, Way way = Way::every,
                   std::string method = "icm") const {
    Fault fault{.name = std::move(name), .what = std::move(what), .method = std::move(method), .way = way};
    fault.*hook = std::move(spoil);
    return fault;
  }
};
constexpr WithHook<&Fault::in_level> in_level;
constexpr WithHook<&Fault::in_pyramid> in_pyramid;
constexpr WithHook<&Fault::in_write> in_write;
constexpr WithHook<&Fault::in_begin> in_begin;
constexpr WithHook<&Fault::in_step> in_step;
constexpr WithHook<&Fault::in_sweep> in_sweep;
constexpr WithHook<&Fault::in_read> in_read;
constexpr WithHook<&Fault::in_changed> in_changed;

} // namespace

std::vector<Fault> session_faults() {
  return {
      in_read("one-site-one-ulp", "one ulp at one site",
              [](VectorField& field) {
                float& value = field.x[field.x.size() / 2];
                value = one_ulp_up(value);
              }),
      in_read("last-corner", "0.1 px too much at the last site",
              [](VectorField& field) { field.y.back() += 0.1F; }),
      in_read("drift", "0.0001 px too much everywhere", each([](float value) { return value + 1e-4F; })),
      in_read("nan-at-one-site", "NaN at one site",
              [](VectorField& field) { field.y[field.y.size() / 2] = not_a_number; }),
      in_read("nan-everywhere", "NaN everywhere", each([](float) { return not_a_number; })),
      in_read("infinity-at-one-site", "infinity at one site",
              [](VectorField& field) { field.x.front() = std::numeric_limits<float>::infinity(); }),
      in_read("components-swapped", "x handed out as y",
              [](VectorField& field) { std::swap(field.x, field.y); }),
      in_read("row-pitch", "rows read with a pitch one element too long", shift_rows),
      in_read("denormals-flushed", "displacements below the smallest normal float become 0",
              each([](float value) { return std::fpclassify(value) == FP_SUBNORMAL ? 0.0F : value; })),
      in_read("unwritten-zeros", "a result nobody wrote: zeros",
              [](VectorField& field) { field = VectorField(field.extent); }),
      in_step("skipped-sweep", "no sweep is done", [](int) { return 0; }),
      in_step("double-sweep", "two sweeps for one", [](int n) { return 2 * n; }),
      in_sweep("swapped-buffers", "every other time the field before the sweep is handed out",
               [swapped = false](VectorField& after, const VectorField& before) mutable {
                 swapped = !swapped;
                 after = swapped ? before : after;
               }),
      in_sweep("last-row-unwritten", "the last row keeps what it had",
               [](VectorField& after, const VectorField& before) {
                 keep(after, before, 0, after.extent.height - 1);
               }),
      in_sweep("last-column-unwritten", "the last column keeps what it had",
               [](VectorField& after, const VectorField& before) {
                 keep(after, before, after.extent.width - 1, 0);
               }),
      in_level("in-place", "sites see what their neighbours have just become",
               [](Level& level) { level.update = Update::sequential; }),
      in_write("stale-upload", "the displacement uploaded is that of the upload before",
               [before = VectorField()](VectorField& field) mutable {
                 const VectorField now = field;
                 field = before.extent == field.extent ? before : field;
                 before = now;
               }),
      in_write("half-float-upload", "the displacement uploaded has 11 significant bits", each(as_half)),
      in_write("clamped-upload",
               "the displacement uploaded is clamped to 0 ... 1, as fixed-point textures do",
               each([](float value) { return std::clamp(value, 0.0F, 1.0F); })),
      {.name = "upside-down",
       .what = "row 0 at the bottom, as OpenGL has it, both ways",
       .in_write = turn_upside_down,
       .in_read = turn_upside_down},
      in_begin("nearest-prolongation",
               "a level begins with its sites' nearest ones of the level above, not interpolated",
               [](VectorField& first, const VectorField& coarser) {
                 first = sample_field(coarser, first.extent, Alignment::center);
               }),
      in_level("stale-level", "conditions of the level above", StaleConditions()),
      in_level("inverse-modulus-one-ulp", "1 / m rounded up by one ulp",
               [](Level& level) { each_of(level.inverse_modulus.values, one_ulp_up); }),
      in_level("modulus-one-ulp", "m rounded up by one ulp, 1 / m right",
               [](Level& level) { each_of(level.modulus.values, one_ulp_up); }),
      in_level("target-rows-shifted", "the targets of x one row up",
               [](Level& level) {
                 auto& values = level.target.x;
                 const auto width = static_cast<std::size_t>(level.extent.width) % values.size();
                 std::ranges::rotate(values, values.begin() + static_cast<std::ptrdiff_t>(width));
               }),
      in_level(
          "confidence-as-boolean", "confidence of x is 0 or 1",
          [](Level& level) { each_of(level.confidence.x, [](float c) { return c > 0.0F ? 1.0F : 0.0F; }); }),
      in_level("penalty-lost", "K is 1", [](Level& level) { level.penalty = 1.0F; }),
      in_level("candidate-missing", "the last candidate is left out",
               [](Level& level) {
                 level.steps = StepSet(level.steps.values().first(level.steps.values().size() - 1));
               }),
      in_level("tie-order-reversed", "the candidates in reverse order: among equals the last one wins",
               [](Level& level) {
                 std::vector<float> steps(level.steps.values().begin(), level.steps.values().end());
                 std::ranges::reverse(steps);
                 level.steps = StepSet(steps);
               }),
      in_level(
          "relaxation-lost", "every sweep with relaxation 1", [](Level& level) { level.strengths = {1.0F}; },
          Way::every, "closed-form"),
      in_level(
          "other-seed", "the random numbers of another seed",
          [](Level& level) { level.seed = (level.seed + 1) % 4093; }, Way::every, "annealing"),
      in_changed("count-stuck-at-zero", "no site is ever counted as changed",
                 [](std::int64_t) { return std::int64_t{0}; }),
      in_changed("count-off-by-one", "one site too many is counted",
                 [](std::int64_t changed) { return changed + 1; }),
      in_changed("count-of-the-sweep-before", "the count comes one sweep late",
                 [before = std::int64_t{0}](std::int64_t changed) mutable {
                   return std::exchange(before, changed);
                 }),
  };
}

std::vector<Fault> one_piece_faults() {
  return {
      in_begin(
          "projection-alignment", "in one piece: between levels pixel areas are aligned, not corners",
          [](VectorField& first, const VectorField& coarser) {
            first = coarser.extent.sites() < first.extent.sites()
                        ? prolongate(coarser, first.extent, Alignment::center)
                        : first;
          },
          Way::one_piece),
      in_pyramid("wrong-alignment", "in one piece: levels sampled at pixel centres, not at corners",
                 [](Pyramid& pyramid) { pyramid.alignment = Alignment::center; }),
      in_pyramid("pyramid-last-level-not-swept", "in one piece: the last level is projected and left at that",
                 [](Pyramid& pyramid) { pyramid.levels.back().sweeps = 0; }),
      in_pyramid("pyramid-level-skipped", "in one piece: the last level but one is left out",
                 [](Pyramid& pyramid) {
                   if (pyramid.levels.size() > 1) {
                     pyramid.levels.erase(pyramid.levels.end() - 2);
                   }
                 }),
      in_pyramid("pyramid-one-sweep-short", "in one piece: the last level gets one sweep less",
                 [](Pyramid& pyramid) {
                   pyramid.levels.back().sweeps = std::max(0, pyramid.levels.back().sweeps - 1);
                 }),
      in_begin(
          "pyramid-begins-with-its-end",
          "in one piece: a second solution begins with the first one's field, not with the null field",
          [](VectorField& first, const VectorField& last_read) {
            first = last_read.extent.sites() >= first.extent.sites()
                        ? sample_field(last_read, first.extent, Alignment::corner)
                        : first;
          },
          Way::one_piece),
      counted("pyramid-count-of-the-first-level",
              "in one piece: the count of changed sites is the first level's", Way::one_piece,
              [count = std::int64_t{0}, first = std::size_t{0},
               last = std::size_t{0}](const VectorField& after, const VectorField& before) mutable {
                const std::size_t sites = after.extent.sites();
                first = first == 0 || sites < last ? sites : first; // every solution begins with the smallest
                count = sites == first ? compare(before, after).sites : count;
                last = sites;
                return count;
              }),
  };
}

std::vector<Fault> active_faults() {
  return {
      in_sweep("tile-never-wakes", "active: a tile that did not change is never looked at again",
               SleepySites(0), Way::active),
      in_sweep("rim-not-passed-on",
               "active: a change at a tile's rim does not wake the tiles to the left and above",
               SleepySites(1), Way::active),
      in_sweep("sleeping-tile-from-the-older-buffer",
               "active: a tile that did not change is not written, and its buffer has something older",
               OlderSites(), Way::active),
      counted("count-of-visited-sites", "active: all sites next to one that changed are counted", Way::active,
              visited_sites),
      in_changed(
          "count-kept-when-all-sleep",
          "active: when nothing is left to do the count stays that of the last sweep that did something",
          [last = std::int64_t{0}](std::int64_t changed) mutable {
            return changed == 0 ? last : last = changed;
          },
          Way::active),
  };
}

std::vector<Fault> session_controls() {
  return {{.name = "sound", .what = "no mistake", .method = ""},
          {.name = "negative-zero",
           .what = "-0 where 0 belongs, which it equals",
           .method = "",
           .in_read = each([](float value) { return value == 0.0F ? -0.0F : value; })},
          elastic_sums_in_double()};
}

} // namespace hdmbench::faults
