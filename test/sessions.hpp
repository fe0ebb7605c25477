#pragma once

#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/solve/solve.hpp"
#include "test/random_level.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// The backends of the registry and what tests do with their sessions.
namespace hdmbench::test {

inline const std::vector<std::unique_ptr<Backend>>& backends() {
  static const auto registry = make_backends();
  return registry;
}

inline const Backend& scalar() {
  return *backends().front();
}

inline const Backend& find(std::string_view backend) {
  return find_backend(backends(), backend);
}

/// As parameters of a suite.
inline std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const auto& backend : backends()) {
    names.emplace_back(backend->name());
  }
  return names;
}

/// "gl_compute" of "gl-compute".
inline std::string test_name(std::string_view name) {
  std::string result(name);
  std::ranges::replace(result, '-', '_');
  return result;
}

/// Of a suite whose parameters are names.
inline constexpr auto parameter_name = [](const auto& information) { return test_name(information.param); };

inline Progress& silent() {
  static Progress progress(false);
  return progress;
}

inline VectorField read(Session& session) {
  VectorField field;
  session.read(field);
  return field;
}

inline void begin(Session& session, const Level& level, const VectorField& start) {
  session.load(level);
  session.write(start);
}

inline void begin(Session& session, const Problem& problem) {
  begin(session, problem.level, problem.start);
}

/// After sweeps on scalar.
inline VectorField swept(const Problem& problem, int sweeps) {
  static const auto session = scalar().open({});
  begin(*session, problem);
  session->step(sweeps);
  return read(*session);
}

inline Solution solved(const Scene& scene, std::string_view backend = "scalar") {
  return solve(scene, *find(backend).open({}), silent(), {.last_changed = true});
}

/// Every level, coarsest first, with `sweeps` on the full image and one more on each that is coarser.
inline Pyramid pyramid_of(const Level& full, Alignment alignment, int sweeps) {
  Pyramid pyramid{.full = &full, .alignment = alignment};
  for (const Extent extent : pyramid_extents(full.extent)) {
    pyramid.levels.insert(pyramid.levels.begin(),
                          {.extent = extent, .sweeps = sweeps++, .strengths = full.strengths});
  }
  return pyramid;
}

inline void expect_same_state(Session& expected, Session& found, const std::string& what) {
  const FieldDifference difference = compare(read(expected), read(found));
  ASSERT_EQ(difference.sites, 0) << what << ", first site index " << *difference.first;
  ASSERT_EQ(found.changed(), expected.changed()) << what;
}

/// Field and count of a pyramid in one piece, twice in the session that is tested.
inline void expect_same_solution(Session& expected, Session& found, const Pyramid& pyramid,
                                 const std::string& what) {
  expected.load(pyramid);
  expected.solve();
  found.load(pyramid);
  for (int time = 0; time < 2; ++time) {
    found.solve();
    ASSERT_NO_FATAL_FAILURE(expect_same_state(expected, found, fmt::format("{}, solution {}", what, time)));
  }
}

/// Field and count after each of `calls`, which are numbers of sweeps.
inline void expect_same_steps(Session& expected, Session& found, const Level& level, const VectorField& start,
                              const std::vector<int>& calls, const std::string& what) {
  begin(expected, level, start);
  begin(found, level, start);
  for (std::size_t call = 0; call < calls.size(); ++call) {
    expected.step(calls[call]);
    found.step(calls[call]);
    ASSERT_NO_FATAL_FAILURE(expect_same_state(expected, found, fmt::format("{}, call {}", what, call)));
  }
}

} // namespace hdmbench::test
