#include "test/elastic_cases.hpp"

#include "backends/cpu/cpu.hpp"
#include "harness/check/cases.hpp"
#include "harness/check/compare.hpp"
#include "test/random_level.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <random>

namespace hdmbench::test {
namespace {

/// The name of a step, and the step on any session.
using Operation = std::pair<std::string, std::function<void(ElasticSession&)>>;

std::vector<Operation> operations_of(int levels) {
  using enum ElasticField;
  std::vector<Operation> all{
      {"relax displacement", [](ElasticSession& s) { s.relax(0, displacement); }},
      {"forces of displacement", [](ElasticSession& s) { s.forces(displacement, load); }},
      {"forces of direction", [](ElasticSession& s) { s.forces(direction, image); }},
      {"advance", [](ElasticSession& s) { s.advance(direction, correction, -0.37F, direction); }},
      {"advance in place", [](ElasticSession& s) { s.advance(displacement, displacement, 0.9F, direction); }},
      {"solve coarsest", [](ElasticSession& s) { s.solve_coarsest(); }}};
  for (int level = 0; level < levels; ++level) {
    const auto add = [&](const char* name, std::function<void(ElasticSession&)> call) {
      all.push_back({fmt::format("{} {}", name, level), std::move(call)});
    };
    add("relax correction of", [=](ElasticSession& s) { s.relax(level, correction); });
    add("relax from zero", [=](ElasticSession& s) { s.relax_from_zero(level); });
    if (level + 1 < levels) {
      const ElasticField finest = level == 0 ? displacement : correction;
      add("restrict residual of", [=](ElasticSession& s) { s.restrict_residual(level, correction); });
      add("restrict residual of field of", [=](ElasticSession& s) { s.restrict_residual(level, finest); });
      add("restrict load of", [=](ElasticSession& s) { s.restrict_load(level); });
      add("correct", [=](ElasticSession& s) { s.correct(level, correction); });
      add("correct field of", [=](ElasticSession& s) { s.correct(level, finest); });
      add("interpolate to", [=](ElasticSession& s) { s.interpolate(level); });
    }
  }
  return all;
}

/// Calls visit(level, field) for every field that a session keeps.
template <typename Visit>
void for_each_field(const ElasticHierarchy& hierarchy, Visit visit) {
  for (int level = 0; level < std::ssize(hierarchy.levels); ++level) {
    for (std::size_t field = 0; field < elastic_fields; ++field) {
      if (has_field(level, static_cast<ElasticField>(field))) {
        visit(level, static_cast<ElasticField>(field));
      }
    }
  }
}

/// Which field of which level is another one; empty where none is.
std::string other_field(const ElasticSession& found, const ElasticSession& expected,
                        const ElasticHierarchy& hierarchy) {
  std::string text;
  for_each_field(hierarchy, [&](int level, ElasticField field) {
    VectorField found_values;
    VectorField expected_values;
    found.read(level, field, found_values);
    expected.read(level, field, expected_values);
    if (compare(expected_values, found_values).sites > 0) {
      text = fmt::format("field {} of level {}", static_cast<int>(field), level);
    }
  });
  const auto dot = [](const ElasticSession& session) {
    return session.dot(ElasticField::correction, ElasticField::load);
  };
  return dot(found) == dot(expected) ? text : "the dot product";
}

ElasticCase elastic_case(Extent extent, Tissue tissue, Held held, double contrast, double poisson,
                         std::uint64_t seed) {
  const ElasticModel model{poisson, seed % 2 == 0 ? Integration::full : Integration::selective_reduced};
  Level level = elastic_level(extent, tissue, held, contrast, seed);
  if (seed % 3 == 0) { // rectangles or boxes, whose levels are halved along all axes or along some
    constexpr std::array<std::array<double, 3>, 6> sides{{{1.5, 1.0, 1.0},
                                                          {1.0, 4.0, 3.5},
                                                          {1.0, 1.0, 5.0},
                                                          {5.0, 1.0, 1.2},
                                                          {3.0, 6.0, 1.0},
                                                          {1.0, 2.5, 1.0}}};
    level.sides = sides[seed / 3 % sides.size()];
    level.sides[2] = extent.axes() == 3 ? level.sides[2] : 1.0;
  }
  return {fmt::format("elastic_level({{{}, {}, {}}}, Tissue({}), Held({}), {}, {}), {{{}, Integration({})}}, "
                      "sides {}",
                      extent.width, extent.height, extent.depth, static_cast<int>(tissue),
                      static_cast<int>(held), contrast, seed, poisson, seed % 2,
                      fmt::join(level.sides, " x ")),
          std::move(level), model};
}

/// Springs that hold one direction more than another, as a registration has them at every site.
ElasticCase case_of_springs(Extent extent, std::uint64_t seed) {
  const VectorField along = random_field(extent, seed);
  const std::size_t axes = extent.axes();
  SiteSprings springs(extent);
  for (std::size_t site = 0; site < extent.sites(); ++site) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      for (std::size_t other = axis; other < axes; ++other) {
        springs.entries[symmetric_entry(axes, axis, other)][site] =
            30.0F * along[axis][site] * along[other][site];
      }
    }
  }
  return {fmt::format("springs along random_field({{{}}}, {})", extent.text(", "), seed),
          elastic_level(extent, Tissue::noise, Held::scattered, 100.0, seed), 0.3, std::move(springs)};
}

} // namespace

std::vector<ElasticCase> elastic_cases() {
  std::vector<ElasticCase> cases;
  std::uint64_t seed = 0;
  for (const Extent extent : {Extent{1, 1},
                              {2, 2},
                              {1, 19},
                              {19, 1},
                              {2, 37},
                              {37, 2},
                              {50, 3},
                              {9, 7},
                              {16, 16},
                              {17, 33},
                              {40, 23},
                              {64, 31},
                              {66, 35},
                              {131, 70}}) {
    for (const std::size_t other : {0, 2}) { // of five: what is held in two ways here is in others next
      ++seed;
      const Held held = all_held[(seed + other) % all_held.size()];
      cases.push_back(elastic_case(extent, all_tissues[seed % 4], held, 100.0, 0.3, seed));
    }
    cases.push_back(case_of_springs(extent, ++seed));
  }
  for (const Extent extent : odd_volumes()) {
    for (const Held held : {Held::border, Held::regions, Held::springs}) {
      ++seed;
      cases.push_back(elastic_case(extent, all_tissues[seed % 4], held, 100.0, 0.3, seed));
    }
    cases.push_back(case_of_springs(extent, ++seed));
  }
  return cases;
}

ElasticCase random_elastic_case(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](int end) { return static_cast<int>(engine() % static_cast<std::uint64_t>(end)); };
  Extent extent{1 + below(30), 1 + below(30)};
  const Tissue tissue = all_tissues.at(static_cast<std::size_t>(below(4)));
  const Held held = all_held.at(static_cast<std::size_t>(below(5)));
  const double contrast = std::pow(10.0, below(4));
  const double poisson = 0.07 * below(8);
  if (below(8) == 0) { // a volume
    extent = {2 + below(9), 2 + below(9), 2 + below(9)};
  }
  return elastic_case(extent, tissue, held, contrast, poisson, seed);
}

std::string elastic_difference(ElasticSession& session, const ElasticCase& one, Order order) {
  const ElasticHierarchy outline = outline_of(one.level.extent, one.level.sides);
  const auto scalar = make_scalar()->open_elastic({});
  const auto both = [&](const auto& call) {
    call(*scalar);
    call(session);
  };
  both([&](ElasticSession& each) {
    each.load(one.body());
    std::uint64_t seed = 1;
    for_each_field(outline, [&](int level, ElasticField field) {
      const Extent sites = outline.levels[static_cast<std::size_t>(level)].grid.sites;
      each.write(level, field, random_field(sites, ++seed));
    });
  });
  const auto operations = operations_of(static_cast<int>(outline.levels.size()));
  std::mt19937_64 engine(7);
  const std::size_t count = order == Order::one_by_one ? operations.size() : 2 * operations.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [name, call] = operations[order == Order::one_by_one ? i : engine() % operations.size()];
    both(call);
    const bool looks = order == Order::one_by_one || i + 1 == count;
    if (const std::string other = looks ? other_field(session, *scalar, outline) : ""; !other.empty()) {
      return fmt::format("{}: {} differs after {}", one.name, other, name);
    }
  }
  return "";
}

} // namespace hdmbench::test
