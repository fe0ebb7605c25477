#pragma once

#include "backends/registry.hpp"
#include "harness/check/compare.hpp"
#include "harness/solve/methods/elastic.hpp"
#include "harness/solve/methods/solver.hpp"
#include "harness/solve/solve.hpp"
#include "test/random_level.hpp"
#include "test/suite.hpp"

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

/// Why a backend is not there, in its driver's words; empty where it is.
inline std::string why_absent(const Backend& backend) {
  try {
    (void)backend.devices();
    return "";
  } catch (const DeviceError& error) {
    return fmt::format("{} is not there: {}", backend.name(), error.what());
  }
}

/// Those that are there; backends_test shows which are not.
inline std::vector<const Backend*> present_backends() {
  std::vector<const Backend*> present;
  for (const auto& backend : backends()) {
    if (why_absent(*backend).empty()) {
      present.push_back(backend.get());
    }
  }
  return present;
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
  return Solver(find(backend), {}).solve(scene, silent(), {.last_changed = true});
}

/// The elastic field of a level, by conjugate gradients on openmp until they end.
inline VectorField converged(const Level& level, const ElasticModel& model) {
  const auto session = find("openmp").open_elastic({.device = {}, .threads = 2});
  ElasticSolver solver(level, model, *session);
  solver.full_multigrid();
  for (int i = 0; i < 400 && !solver.conjugate_gradients().ended; ++i) {
  }
  return solver.displacement();
}

} // namespace hdmbench::test
