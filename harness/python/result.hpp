#pragma once

#include "harness/python/arrays.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/request.hpp"

#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

/// What a solution is in Python.
namespace hdmbench::python {

/// A displacement and where its pixels lie, as the files of `run` have them.
struct Field {
  VectorField displacement; ///< of the scene's pixels, their shortest sides
  double spacing = 1.0;     ///< of a pixel, millimetres
  Placement placement{};
  std::optional<FileGrid> oblong{}; ///< the file's own pixels, for which it is written
  Mapping mapping = Mapping::forward;
  Space space = Space::lps; ///< of whoever asked
  std::size_t axes = 3;     ///< of the array
  ScalarField tissue{};     ///< tissue_of() its scene

  /// Returns the vectors in millimetres, in LPS. Needs no GIL. Throws InputError.
  [[nodiscard]] images::Pixels physical() const;
  /// Writes them as `run` does: .nrrd, .mha, .nii.gz or .h5. Needs no GIL. Throws InputError.
  void save(const std::string& file) const;
};

/// A displacement that leads back: what is at y came from y + d(y).
struct Backward {
  Field field;
  std::size_t unmet = 0;   ///< pixels that it does not bring to within inverse_is_met of where they came from
  double farthest = 0.0;   ///< of these, pixels
  std::array<int, 3> at{}; ///< the farthest one
  py::array displacement{}; ///< millimetres, in the space of the field

  /// Returns the picture as the tissue moves it, as `hdmbench warp` does: an array of its shape, float32, or
  /// of labels of their own type. `affine` and `spacing` as of given_image(); where nothing says where the
  /// picture lies it has the pixels of the field. Throws InputError.
  [[nodiscard]] py::array warp(const py::object& picture, bool are_labels, const py::object& spacing,
                               const py::object& affine) const;
};

/// What a number of the displacement depends on (harness/applications/gradient.hpp), as arrays.
struct Derivatives {
  py::array moduli;  ///< per MPa, of the shape of the labels
  py::array targets; ///< per millimetre, of the shape of the displacement and in its space
  py::array forces;  ///< per newton on a voxel, of an image per newton per millimetre of thickness; likewise
  bool converged = true;
};

/// The scene of a result, and where it was solved.
struct Kept {
  Scene scene;
  std::string backend;
  SessionOptions session;
};

/// A scene that was solved.
struct Result {
  Field field;
  std::string scene;
  std::string energy;
  std::string method;
  std::string backend;
  std::string device;
  double largest = 0.0; ///< component of the displacement, millimetres
  std::optional<double> estimate{};
  std::optional<bool> met{};
  std::string outcome; ///< of a plan, in words
  Timings timings{};
  double seconds = 0.0; ///< of the whole call
  py::array displacement{};
  py::array affine{};
  py::object residuals{};
  py::object warnings{};
  std::shared_ptr<const Backward> backward{}; ///< null until somebody asks
  std::shared_ptr<const Kept> kept{};         ///< null but where Asked::differentiable

  /// Inverts the displacement, once. Throws InputError.
  const std::shared_ptr<const Backward>& inverse();
  /// `by_displacement`: the derivative of a number by `displacement`, of its shape, per millimetre. Throws
  /// InputError where the scene was not kept, or has no gradient; what Session throws, and what Python
  /// raises.
  [[nodiscard]] Derivatives gradient(const py::object& by_displacement) const;
};

/// What a caller asked for beside the scene itself.
struct Asked {
  ScheduleOverrides schedule{.takes_boxes = true};
  std::string accuracy{}; ///< in the words of the command line
  std::string within{};   ///< the same
  std::string backend = "openmp";
  SessionOptions session{};
  bool differentiable = false; ///< the scene is kept for Result::gradient()
};

/// Returns a result that has the displacement of a scene and where it lies; what computed it is yet to be
/// said. `space` and `axes` are those of whoever asks, see Field; no axes: the scene's. Called with the GIL.
[[nodiscard]] std::unique_ptr<Result> result_of(const Scene& scene, VectorField displacement, Space space,
                                                std::optional<std::size_t> axes);

/// Loads, solves and diagnoses a scene as `run` does. Ends where Python has a signal (Ctrl-C). Called with
/// the GIL, which it gives away meanwhile. Throws InputError, DeviceError, std::runtime_error where there is
/// no result, and what Python raises. `space` and `axes` as of result_of().
[[nodiscard]] std::unique_ptr<Result> solve(Asked asked, const std::function<Scene(ScheduleOverrides&)>& load,
                                            Space space, std::optional<std::size_t> axes);

/// Calls `work` without the GIL. What it reports to its progress lets Python handle signals: where one
/// raises, the work ends and so does this call. Throws that, and what `work` throws.
void work_interruptibly(const std::function<void(Progress&)>& work);

/// Returns rows of JSON as Python has them.
[[nodiscard]] py::object object_of(const nlohmann::json& rows);

} // namespace hdmbench::python
