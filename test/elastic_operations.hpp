#pragma once

#include "backends/shared/elastic_session.hpp"
#include "test/elastic_problem.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <string>
#include <vector>

/// Every step of the elastic methods, for sessions that are compared.
namespace hdmbench::test {

inline constexpr std::array all_fields{ElasticField::displacement, ElasticField::correction,
                                       ElasticField::load, ElasticField::direction, ElasticField::image};

/// -0 equals 0.
inline std::size_t differing(const VectorField& a, const VectorField& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    count += a.x[i] == b.x[i] && a.y[i] == b.y[i] ? 0 : 1;
  }
  return count;
}

/// A step on any session, under a name.
struct Operation {
  std::string name;
  std::function<void(ElasticSession&)> call;
};

inline std::vector<Operation> operations_of(int levels) {
  using enum ElasticField;
  std::vector<Operation> all;
  const auto add = [&](std::string name, std::function<void(ElasticSession&)> call) {
    all.push_back({std::move(name), std::move(call)});
  };
  add("relax displacement", [](ElasticSession& s) { s.relax(0, displacement); });
  add("forces of displacement", [](ElasticSession& s) { s.forces(displacement, load); });
  add("forces of direction", [](ElasticSession& s) { s.forces(direction, image); });
  add("advance", [](ElasticSession& s) { s.advance(direction, correction, -0.37F, direction); });
  add("advance again", [](ElasticSession& s) { s.advance(displacement, displacement, 0.9F, direction); });
  for (int level = 0; level < levels; ++level) {
    add(fmt::format("relax correction of {}", level), [=](ElasticSession& s) { s.relax(level, correction); });
    add(fmt::format("relax {} from zero", level), [=](ElasticSession& s) { s.relax_from_zero(level); });
    if (level + 1 < levels) {
      add(fmt::format("restrict residual of {}", level),
          [=](ElasticSession& s) { s.restrict_residual(level, correction); });
      add(fmt::format("restrict load of {}", level), [=](ElasticSession& s) { s.restrict_load(level); });
      add(fmt::format("correct {}", level), [=](ElasticSession& s) { s.correct(level, correction); });
      add(fmt::format("interpolate to {}", level), [=](ElasticSession& s) { s.interpolate(level); });
    }
  }
  if (levels > 1) {
    add("restrict residual of displacement", [](ElasticSession& s) { s.restrict_residual(0, displacement); });
    add("correct displacement", [](ElasticSession& s) { s.correct(0, displacement); });
  }
  add("solve coarsest", [](ElasticSession& s) { s.solve_coarsest(); });
  return all;
}

/// All fields of all levels at random, the same on every session.
inline void fill(ElasticSession& session, const ElasticHierarchy& hierarchy) {
  std::uint64_t seed = 1;
  for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
    for (const ElasticField field : all_fields) {
      const bool everywhere = field == ElasticField::correction || field == ElasticField::load;
      if (level == 0 || everywhere) {
        session.write(static_cast<int>(level), field,
                      random_field(hierarchy.levels[level].grid.sites, ++seed));
      }
    }
  }
}

inline void expect_same(const ElasticSession& found, const ElasticSession& expected,
                        const ElasticHierarchy& hierarchy, const std::string& what) {
  for (std::size_t level = 0; level < hierarchy.levels.size(); ++level) {
    for (const ElasticField field : all_fields) {
      if (level == 0 || field == ElasticField::correction || field == ElasticField::load) {
        VectorField a;
        VectorField b;
        found.read(static_cast<int>(level), field, a);
        expected.read(static_cast<int>(level), field, b);
        ASSERT_EQ(differing(a, b), 0U)
            << what << ": field " << static_cast<int>(field) << " of level " << level;
      }
    }
  }
}

/// Both do all steps, one after the other, and have the same fields and dot products after each. Both have
/// loaded the hierarchy.
inline void expect_same_steps(ElasticSession& found, ElasticSession& expected,
                              const ElasticHierarchy& hierarchy, const std::string& what) {
  fill(expected, hierarchy);
  fill(found, hierarchy);
  for (const Operation& operation : operations_of(static_cast<int>(hierarchy.levels.size()))) {
    operation.call(expected);
    operation.call(found);
    const std::string where = fmt::format("{}, {}", what, operation.name);
    expect_same(found, expected, hierarchy, where);
    ASSERT_EQ(found.dot(ElasticField::correction, ElasticField::load),
              expected.dot(ElasticField::correction, ElasticField::load))
        << where;
    if (testing::Test::HasFatalFailure()) {
      return;
    }
  }
}

/// The same in an order of `seed`, some steps twice, with nothing read in between: what a device does
/// together.
inline void expect_same_in_one_go(ElasticSession& found, ElasticSession& expected,
                                  const ElasticHierarchy& hierarchy, std::uint64_t seed,
                                  const std::string& what) {
  fill(expected, hierarchy);
  fill(found, hierarchy);
  const std::vector<Operation> operations = operations_of(static_cast<int>(hierarchy.levels.size()));
  std::mt19937_64 engine(seed);
  for (std::size_t i = 0; i < 2 * operations.size(); ++i) {
    const Operation& operation = operations[engine() % operations.size()];
    operation.call(expected);
    operation.call(found);
  }
  expect_same(found, expected, hierarchy, fmt::format("{}, steps of seed {} in one go", what, seed));
}

} // namespace hdmbench::test
