#pragma once

#include "backends/backend.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"
#include "harness/solve/solve.hpp"

#include <memory>
#include <optional>
#include <string>

namespace hdmbench {

/// Why the backend cannot solve the scene, as a part of a sentence; empty: it can, or is not there at all.
[[nodiscard]] std::string why_not_solved(const Scene& scene, const Backend& backend);

/// Returns the scene with its moduli scaled by a power of two where float could not hold products of them:
/// its displacement is the same. None where they are usual, or scaled already.
[[nodiscard]] std::optional<Scene> with_safe_moduli(const Scene& scene);

/// Solves scenes by whatever method their schedule names, on one backend. Keeps its sessions open between
/// solutions, so that shaders are compiled once.
class Solver {
public:
  /// `backend` must outlive this object.
  Solver(const Backend& backend, const SessionOptions& options);

  /// Throws what Session throws; InputError where the backend cannot (why_not_solved), or no condition holds
  /// an elastic scene.
  [[nodiscard]] Solution solve(const Scene& scene, Progress& progress, const SolveOptions& options = {});

  /// The session that minimises the elastic energy, which is opened where there is none yet. Throws what open
  /// does; InputError where the backend does not compute that energy.
  [[nodiscard]] ElasticSession& elastic();

private:
  const Backend& backend_;
  SessionOptions options_;
  // Null until a scene wants them.
  std::unique_ptr<Session> session_;
  std::unique_ptr<ElasticSession> elastic_;
};

} // namespace hdmbench
