#pragma once

#include "harness/python/arrays.hpp"
#include "harness/scene/given_scene.hpp"
#include "harness/scene/schedule_overrides.hpp"

#include <functional>
#include <optional>

/// The arguments of solve() and verify() that say which scene.
namespace hdmbench::python {

/// What Python gives; None is what is not said.
struct SceneArguments {
  py::object labels, tissues, points, targets, confidence, modulus, spacing, affine, scene, size, conditions;
  py::object precision = py::none();
  py::object force = py::none();
  py::object fibre = py::none();
  py::object normals = py::none();
  py::object loads = py::none();
  py::object resect = py::none();
  py::object law = py::none();
};

/// What they come to. The scene is loaded later, without the GIL.
struct SceneToLoad {
  std::function<Scene(ScheduleOverrides&)> load; ///< throws InputError
  Space space = Space::lps;
  std::optional<std::size_t> axes{}; ///< of the array; none: there is none
};

/// Throws InputError for arguments that do not belong together or cannot be.
[[nodiscard]] SceneToLoad scene_to_load(const SceneArguments& given);

/// Returns what the caller says of the schedule: each None, or what the command line takes. Throws
/// InputError.
[[nodiscard]] ScheduleOverrides schedule_of(const py::object& energy, const py::object& method,
                                            const py::object& iterations, const py::object& poisson);

} // namespace hdmbench::python
