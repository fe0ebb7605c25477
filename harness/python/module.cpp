// What `import hdmbench` has: functions that call what the command line calls.

#include "harness/python/registration.hpp"

#include "backends/registry.hpp"
#include "harness/check/verify_rows.hpp"
#include "harness/measure/bench.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <build_information.hpp>

#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench::python {

namespace {

constexpr const char* solve_help =
    R"(How soft tissue moves where some of it is known to move: what `hdmbench run` computes, to the bit.

Give a scene of arrays, labels and tissues or modulus, or scene=.

labels      array of integers, or an image of nibabel's, or with a file of tissues the path of an image.
            Index 0 of every array is x (along a row of the file), index 1 y, index 2 z, as nibabel has them,
            in any memory order. Two axes are an image, three a volume.
tissues     {label: modulus in MPa, or a dictionary as [[tissue]] has it}, or the path of a file of these
points      where known points are before and after, millimetres: (before, after), arrays of a row x y z for
            each; or rows x y z dx dy dz [standard deviation]; or files as --points takes them
targets     known displacement of the pixels, millimetres: the shape of labels and 2 or 3 components;
            with confidence. Beside points of rows x y z alone: where these are after
confidence  of targets: 0 nothing is known, 1 certain; the shape of labels, or also for each component
modulus     in place of labels: Young's modulus of every pixel, MPa
spacing     millimetres from pixel to pixel: one number, or one for each axis
affine      4 x 4, from indices to millimetres in RAS, as nibabel has it; an image of nibabel's has its own
scene       the name of a shipped scene (scenes()), or the path of a TOML file
size        of a scene that has no size of its own
precision   of targets, in place of confidence: the inverse of each one's covariance, 1/mm^2, the shape of labels
            and a symmetric matrix; in a direction with 0 nothing is known
force       N/mm^3 on the tissue: the shape of labels and 2 or 3 components; moduli are absolute then
fibre       directions of fibres in tissues with a fibre_modulus, as force; 0: a pixel without
normals     directions across the walls that conditions with slide are, as force; 0: those of the labels
conditions  [{"where": "left", "dx": -5.0}, ...] as [[condition]] has them; None: the border is held
loads       [{"gravity": [0, 9.81, 0], "before": True}, {"pressure": 0.001, "from": 2, "on": 1}, ...] as [[load]] has
            them; gravity in LPS whatever the affine, so that this one pulls to the back; it needs a density in
            the dictionaries of all tissues but void. Moduli are absolute then
resect      a label or several that are taken out, as [[resect]]; a load with "before" acted when the image was made
law         "neo-hookean" or "linear", of all tissues that state none
energy, method, iterations, poisson, accuracy, within, backend, device, threads
            as the options of `hdmbench run`: accuracy=0.1 or "0.1px" is pixels, "0.1mm" millimetres
differentiable
            whether the result keeps the scene, for Result.gradient

Whoever gives an affine gives and gets positions and displacements in RAS, else they are along the axes of the
array, from its first pixel on; those of scene= are in LPS, as the files of `hdmbench run` have them.

Raises ValueError where the input cannot be computed on, RuntimeError where a device cannot do it or there is
no result. Ctrl-C ends it.)";

/// None is the empty text; a number is its own words.
std::string words_of(const py::object& value) {
  return value.is_none() ? "" : py::str(value).cast<std::string>();
}

std::unique_ptr<Result>
solve_scene(py::object labels, py::object tissues, py::object points, py::object targets,
            py::object confidence, py::object modulus, py::object spacing, py::object affine,
            py::object scene, py::object size, py::object conditions, py::object precision, py::object force,
            py::object fibre, py::object normals, py::object loads, py::object resect, py::object law,
            const py::object& energy, const py::object& method, const py::object& iterations,
            const py::object& poisson, const py::object& accuracy, const py::object& within,
            const std::string& backend, const std::string& device, int threads, bool differentiable) {
  const SceneToLoad to_load = scene_to_load(
      {std::move(labels), std::move(tissues), std::move(points), std::move(targets), std::move(confidence),
       std::move(modulus), std::move(spacing), std::move(affine), std::move(scene), std::move(size),
       std::move(conditions), std::move(precision), std::move(force), std::move(fibre), std::move(normals),
       std::move(loads), std::move(resect), std::move(law)});
  Asked asked{.schedule = schedule_of(energy, method, iterations, poisson),
              .accuracy = words_of(accuracy),
              .within = words_of(within),
              .backend = backend,
              .session = {.device = device, .threads = threads},
              .differentiable = differentiable};
  return solve(std::move(asked), to_load.load, to_load.space, to_load.axes);
}

constexpr const char* register_help =
    R"(How the tissue of one picture moved in another one, taken later: what `hdmbench register` computes, to the bit.

source, target  two arrays of one shape: gray values before and after; of three axes with iterate alone
labels, tissues the tissues of source, as of solve(); label 0 is not tissue
region          not 0 where the pictures are not to be believed: a growth, a resection. None: nowhere
iterate         thesis Algorithm 6, which needs no ITK; else Algorithm 5
spacing, affine as of solve(); the others as the options of `hdmbench register`

Result.met says whether Algorithm 6 converged. Raises as solve() does.)";

std::unique_ptr<Result> register_arrays(py::object source, py::object target, py::object labels,
                                        py::object tissues, py::object region, py::object spacing,
                                        py::object affine, bool iterate, const py::object& energy,
                                        const py::object& method, const py::object& iterations,
                                        const py::object& poisson, const std::string& backend,
                                        const std::string& device, int threads) {
  const py::none none;
  SceneToLoad scene =
      scene_to_load({std::move(labels), std::move(tissues), none, none, none, none, std::move(spacing),
                     std::move(affine), none, none, py::list()}); // pictures say what moves, no condition
  const Asked asked{.schedule = schedule_of(energy, method, iterations, poisson),
                    .backend = backend,
                    .session = {.device = device, .threads = threads}};
  return register_pictures({std::move(source), std::move(target), std::move(region)}, std::move(scene), asked,
                           iterate);
}

py::list list_backends() {
  nlohmann::json rows = nlohmann::json::array();
  {
    const py::gil_scoped_release release;
    for (const auto& backend : make_backends()) {
      nlohmann::json row{{"backend", backend->name()},
                         {"description", backend->description()},
                         {"available", true},
                         {"devices", nlohmann::json::array()},
                         {"reason", ""}};
      try {
        for (const Device& device : backend->devices()) {
          row["devices"].push_back(
              {{"device", device.name}, {"driver", device.driver}, {"software", device.is_software}});
        }
      } catch (const DeviceError& error) {
        row.update({{"available", false}, {"reason", error.what()}});
      }
      rows.push_back(std::move(row));
    }
  }
  return object_of(rows);
}

py::list list_scenes() {
  nlohmann::json rows = nlohmann::json::array();
  for (const SceneSummary& scene : scene_summaries()) {
    rows.push_back({{"scene", scene.name}, {"title", scene.title}, {"size", scene.size}});
  }
  return object_of(rows);
}

/// Returns the backends of these names; without names all but the first one, with which they are compared.
std::vector<const Backend*> beside_reference(const std::vector<std::unique_ptr<Backend>>& registry,
                                             const std::optional<std::vector<std::string>>& names) {
  std::vector<const Backend*> found;
  for (const auto& backend : registry) {
    if (!names && backend != registry.front()) {
      found.push_back(backend.get());
    }
  }
  for (const std::string& name : names.value_or(std::vector<std::string>{})) {
    found.push_back(&find_backend(registry, name));
  }
  return found;
}

py::list verify_scene(const std::string& scene, const std::optional<std::vector<std::string>>& backends,
                      py::object size, const py::object& energy, const py::object& method,
                      const py::object& iterations, const std::string& device, int threads) {
  const py::none none;
  const SceneToLoad to_load =
      scene_to_load({none, none, none, none, none, none, none, none, py::str(scene), std::move(size), none});
  ScheduleOverrides schedule = schedule_of(energy, method, iterations, none);
  nlohmann::json rows = nlohmann::json::array();
  work_interruptibly([&](Progress& progress) {
    const Scene loaded = to_load.load(schedule);
    const auto registry = make_backends();
    const std::vector<const Backend*> compared = beside_reference(registry, backends);
    const VerifyOptions options{.session = {.device = device, .threads = threads},
                                .iteration_limit = std::nullopt};
    progress.set_total(site_updates(loaded));
    for (const Comparison& comparison : verify(loaded, *registry.front(), compared, options, progress)) {
      rows.push_back(verify_row(loaded, comparison));
    }
  });
  return object_of(rows);
}

py::list bench_scene(const std::string& scene, const std::optional<std::vector<std::string>>& backends,
                     py::object size, const py::object& energy, const py::object& method,
                     const py::object& iterations, int repeat, const std::string& device, int threads) {
  if (repeat < 1) {
    throw InputError("repeat: is at least 1");
  }
  const py::none none;
  const SceneToLoad to_load =
      scene_to_load({none, none, none, none, none, none, none, none, py::str(scene), std::move(size), none});
  const ScheduleOverrides schedule_of_words = schedule_of(energy, method, iterations, none);
  nlohmann::json rows;
  work_interruptibly([&](Progress& progress) {
    const auto registry = make_backends();
    BenchOptions options{.backends = beside_reference(registry, backends),
                         .session = {.device = device, .threads = threads}};
    std::erase(options.backends, registry.front().get());
    options.backends.insert(options.backends.begin(), registry.front().get());
    Bench bench(progress);
    bench.add(
        [&] {
          ScheduleOverrides schedule = schedule_of_words;
          return std::optional(to_load.load(schedule));
        },
        [&](const Scene&) { return options; });
    std::ostringstream unread;
    rows = bench.run({fmt::format("--benchmark_repetitions={}", repeat), "--benchmark_min_time=0.02"}, unread,
                     {.show = [](const nlohmann::json&) {}, .keep = [](const nlohmann::json&) {}});
  });
  return object_of(rows);
}

py::dict timings_of(const Result& result) {
  const Timings& timings = result.timings;
  py::dict seconds;
  seconds["projection"] = timings.projection;
  seconds["upload"] = timings.upload;
  seconds["compute"] = timings.compute;
  seconds["readback"] = timings.readback;
  seconds["solution"] = timings.total();
  seconds["in_all"] = result.seconds;
  return seconds;
}

std::string text_of(const Result& result) {
  return fmt::format("<hdmbench.Result: {} {}, {} on {}, at most {:.4g} mm{}>", result.scene,
                     result.field.displacement.extent.text(), result.method, result.backend, result.largest,
                     result.estimate ? fmt::format(", estimated error {:.2g} px", *result.estimate) : "");
}

const char* name_of(Space space) {
  return space == Space::ras ? "RAS" : "LPS";
}

void save(const Field& field, const py::object& file) {
  const std::string path = path_of(file);
  const py::gil_scoped_release release;
  field.save(path);
}

void add_inverse(py::module_& module) {
  py::class_<Backward, std::shared_ptr<Backward>>(
      module, "Inverse", "The displacement that leads back, with which resamplers move pictures.")
      .def_property_readonly(
          "displacement", [](const Backward& self) { return self.displacement; },
          "Millimetres: what is at y came from y + displacement. An array as Result.displacement is.")
      .def_readonly("unmet", &Backward::unmet, "Pixels that no tissue meets: the image folds over there.")
      .def_readonly("farthest", &Backward::farthest, "The largest error at these, pixels.")
      .def_readonly("at", &Backward::at, "Where that is: x, y, z.")
      .def("warp", &Backward::warp, py::arg("image"), py::kw_only(), py::arg("labels") = false,
           py::arg("spacing") = py::none(), py::arg("affine") = py::none(), "As Result.warp does.")
      .def(
          "save", [](const Backward& self, const py::object& file) { save(self.field, file); },
          py::arg("file"),
          "Writes it as `hdmbench run --transform` does: .h5 (ITK), .nrrd, .mha or .nii.gz.");
}

void add_gradient(py::module_& module) {
  py::class_<Derivatives>(module, "Gradient",
                          "The derivatives of a number of a displacement by what the scene is made of.")
      .def_property_readonly(
          "moduli", [](const Derivatives& self) { return self.moduli; },
          "Per MPa, by the modulus of every voxel: of the shape of the labels. That of a tissue is the sum "
          "over\nits voxels. 0 in void.")
      .def_property_readonly(
          "targets", [](const Derivatives& self) { return self.targets; },
          "Per millimetre, by what every voxel is known to move, as targets= or conditions have it; 0 where\n"
          "nothing is known.")
      .def_property_readonly(
          "forces", [](const Derivatives& self) { return self.forces; },
          "Per newton, by a force on every voxel (of an image per newton per millimetre of thickness); 0 "
          "where\nit is held.")
      .def_readonly("converged", &Derivatives::converged,
                    "Whether the second solution, which these come from, lacks at most 1e-5 of itself.");
}

void add_result(py::module_& module) {
  py::class_<Result>(module, "Result", "A scene that was solved.")
      .def_property_readonly(
          "displacement", [](const Result& self) { return self.displacement; },
          "Millimetres: what is at index i is at affine @ (i, 1) and moves by displacement[i]. float32, the\n"
          "axes of the labels and one more with three components; the third is 0 of a flat image.")
      .def_property_readonly(
          "affine", [](const Result& self) { return self.affine; },
          "4 x 4, from indices to millimetres, in the space of the displacement.")
      .def_property_readonly(
          "space", [](const Result& self) { return name_of(self.field.space); },
          "RAS where an affine was given, else LPS.")
      .def_property_readonly(
          "residuals", [](const Result& self) { return self.residuals; },
          "How far every point is from where it went, millimetres.")
      .def_readonly("estimate", &Result::estimate,
                    "The estimated distance from finite elements, RMS, pixels (shortest sides); None where\n"
                    "the method has none.")
      .def_readonly("met", &Result::met, "Whether accuracy or within is met; None where neither was given.")
      .def_readonly("outcome", &Result::outcome, "How the plan for accuracy or within ended, in words.")
      .def_property_readonly(
          "warnings", [](const Result& self) { return self.warnings; },
          "What speaks against it: dictionaries with kind, message, advice and sites.")
      .def_property_readonly("timings", timings_of,
                             "Seconds: those of the solution as `hdmbench run --json` has them, and in_all.")
      .def_readonly("scene", &Result::scene)
      .def_readonly("energy", &Result::energy)
      .def_readonly("method", &Result::method)
      .def_readonly("backend", &Result::backend)
      .def_readonly("device", &Result::device)
      .def("inverse", &Result::inverse, "The displacement that leads back, computed once.")
      .def(
          "warp",
          [](Result& self, const py::object& image, bool labels, const py::object& spacing,
             const py::object& affine) { return self.inverse()->warp(image, labels, spacing, affine); },
          py::arg("image"), py::kw_only(), py::arg("labels") = false, py::arg("spacing") = py::none(),
          py::arg("affine") = py::none(),
          "The image as the tissue moves it, on its own pixels, as `hdmbench warp` does: linear, or of "
          "labels\n"
          "the nearest pixel; 0 where nothing comes from. An array without affine or spacing has the pixels "
          "of\n"
          "the displacement.")
      .def("gradient", &Result::gradient, py::arg("by_displacement"),
           "How a number depends on moduli, targets and forces, by one more solution: `by_displacement` is\n"
           "its derivative by the displacement, of its shape. Of a scene that was solved with "
           "differentiable=True.")
      .def(
          "save", [](const Result& self, const py::object& file) { save(self.field, file); }, py::arg("file"),
          "Writes the displacement as `hdmbench run` does: .nrrd, .mha, .nii.gz or .h5.")
      .def("__repr__", text_of);
}

} // namespace

// NOLINTNEXTLINE: pybind11's macro
PYBIND11_MODULE(_hdmbench, module) {
  module.doc() = "The compiled part of hdmbench.";
  module.attr("__version__") = std::string(build::version);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      std::rethrow_exception(std::move(thrown));
    } catch (const InputError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const DeviceError& error) {
      PyErr_SetString(PyExc_RuntimeError, error.what());
    }
  });
  add_inverse(module);
  add_gradient(module);
  add_result(module);
  const py::none none;
  module.def("solve", solve_scene, solve_help, py::arg("labels") = none, py::arg("tissues") = none,
             py::arg("points") = none, py::arg("targets") = none, py::arg("confidence") = none,
             py::arg("modulus") = none, py::arg("spacing") = none, py::arg("affine") = none, py::kw_only(),
             py::arg("scene") = none, py::arg("size") = none, py::arg("conditions") = none,
             py::arg("precision") = none, py::arg("force") = none, py::arg("fibre") = none,
             py::arg("normals") = none, py::arg("loads") = none, py::arg("resect") = none,
             py::arg("law") = none, py::arg("energy") = none, py::arg("method") = none,
             py::arg("iterations") = none, py::arg("poisson") = none, py::arg("accuracy") = none,
             py::arg("within") = none, py::arg("backend") = "openmp", py::arg("device") = "",
             py::arg("threads") = 0, py::arg("differentiable") = false);
  module.def(
      "backends", list_backends,
      "All backends, as `hdmbench devices` lists them: dictionaries with backend, description, available,\n"
      "devices (device, driver, software) and, of one that is absent, the reason.");
  module.def("scenes", list_scenes, "The shipped scenes: dictionaries with scene, title and size.");
  module.def("verify", verify_scene, py::arg("scene") = "square", py::arg("backends") = none, py::kw_only(),
             py::arg("size") = none, py::arg("energy") = none, py::arg("method") = none,
             py::arg("iterations") = none, py::arg("device") = "", py::arg("threads") = 0,
             "Compares backends (all) with `scalar`, bit for bit, at every iteration: the rows of `hdmbench\n"
             "verify --json`, one for each backend and mode, with verdict, tier and sites_differing.");
  module.def("register", register_arrays, register_help, py::arg("source"), py::arg("target"),
             py::arg("labels"), py::arg("tissues"), py::arg("region") = none, py::kw_only(),
             py::arg("spacing") = none, py::arg("affine") = none, py::arg("iterate") = false,
             py::arg("energy") = none, py::arg("method") = none, py::arg("iterations") = none,
             py::arg("poisson") = none, py::arg("backend") = "openmp", py::arg("device") = "",
             py::arg("threads") = 0);
  module.def("bench", bench_scene, py::arg("scene") = "square", py::arg("backends") = none, py::kw_only(),
             py::arg("size") = none, py::arg("energy") = none, py::arg("method") = none,
             py::arg("iterations") = none, py::arg("repeat") = 5, py::arg("device") = "",
             py::arg("threads") = 0,
             "Times whole solutions on backends (all) beside `scalar`, with whose bits each is compared: the "
             "rows of\n`hdmbench bench --json`, one for each backend, with seconds, valid and "
             "speed_up_over_scalar.");
}

} // namespace hdmbench::python
