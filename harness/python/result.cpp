#include "harness/python/result.hpp"

#include "backends/registry.hpp"
#include "backends/shared/stopwatch.hpp"
#include "harness/applications/gradient.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"
#include "kernels/data/interruption.hpp"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>
#include <utility>

namespace hdmbench::python {

namespace {

/// Python has raised something, which its thread keeps.
struct Interrupted {};

/// Lets Python handle its signals, and not more often than a person notices.
class Signals {
public:
  void operator()() {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < 20ms) {
      return;
    }
    last_ = now;
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) {
      throw Interrupted{};
    }
  }

private:
  std::chrono::steady_clock::time_point last_{};
};

py::object residuals_of(const Scene& scene, const VectorField& displacement) {
  std::vector<double> misses;
  for (const KnownPoint& point : scene.points) {
    misses.push_back(residual_at(point, displacement) * scene.spacing);
  }
  return py::array_t<double>(static_cast<py::ssize_t>(misses.size()), misses.data());
}

/// Returns the components along the axes of the scene, per pixel, of a derivative by the displacement in
/// millimetres, in LPS.
VectorField along_axes(const images::Pixels& by_displacement, const Field& field) {
  VectorField result(field.displacement.extent);
  for (std::size_t axis = 0; axis < result.extent.axes(); ++axis) {
    const Placement::Vector& direction = field.placement.axes[axis];
    for (std::size_t site = 0; site < result.extent.sites(); ++site) {
      const float* const at = by_displacement.values.data() + 3 * site;
      const double sum = direction[0] * at[0] + direction[1] * at[1] + direction[2] * at[2];
      result[axis][site] = static_cast<float>(field.spacing * sum);
    }
  }
  return result;
}

/// Returns so many times the vectors, along the axes of the space in place of the scene's; LPS.
images::Pixels along_space(VectorField vectors, double times, const Field& field) {
  for (std::vector<float>& component : vectors.planes) {
    for (float& value : component) {
      value =
          static_cast<float>(times / field.spacing * value); // a displacement would be spacing times as much
    }
  }
  return physical_displacement("gradient", vectors, field.spacing, field.placement, {});
}

/// What is found out without the GIL.
struct Found {
  Scene scene;
  Answer answer;
  Warnings warnings;
  Device device;
};

Found find(Asked& asked, const std::function<Scene(ScheduleOverrides&)>& load, Progress& progress) {
  const bool is_asked = !asked.accuracy.empty() || !asked.within.empty();
  (void)parse_request(asked.accuracy, asked.within, 1.0);
  if (is_asked && asked.schedule.energy != nullptr) {
    require_near_finite_elements(*asked.schedule.energy,
                                 fmt::format("--energy {}", asked.schedule.energy->name));
  }
  Found found;
  found.scene = load_to_solve(asked.schedule, is_asked, [&] { return load(asked.schedule); });
  if (const std::string why = asked.differentiable ? why_no_gradient(found.scene) : ""; !why.empty()) {
    throw InputError("differentiable: " + why);
  }
  may_end_here();
  const Request request = parse_request(asked.accuracy, asked.within, found.scene.spacing);
  const auto registry = make_backends();
  const Backend& backend = choose_backend(registry, asked.backend, found.scene);
  found.device = backend.device(asked.session);
  found.answer = solve_request(found.scene, request, backend, asked.session, progress);
  const Solution& solution = found.answer.solution();
  may_end_here();
  if (const std::string absurd = why_absurd(found.scene, solution); !absurd.empty()) {
    throw std::runtime_error(no_result_text(found.scene, absurd));
  }
  may_end_here();
  found.warnings = diagnose(found.scene, solution, found.answer.plan);
  may_end_here();
  return found;
}

} // namespace

images::Pixels Field::physical() const {
  return physical_displacement("displacement", displacement, spacing, placement, oblong);
}

void Field::save(const std::string& file) const {
  require_displacement_name(file, displacement.extent);
  write_displacement(file, displacement, spacing, placement, oblong, mapping);
}

py::array Backward::warp(const py::object& picture, bool are_labels, const py::object& spacing,
                         const py::object& affine) const {
  if (!have_images()) {
    throw InputError("this hdmbench was built without image support, which moves pictures");
  }
  GivenImage given = given_image("image", picture, spacing, affine);
  images::Pixels transform = field.physical();
  if (given.geometry.stated == Stated::nothing) {
    if (given.geometry.size != transform.geometry.size) {
      throw InputError(
          fmt::format("image: has {} x {} x {} pixels, the displacement {} x {} x {}; say where it "
                      "lies: give its affine or its spacing",
                      given.geometry.size[0], given.geometry.size[1], given.geometry.size[2],
                      transform.geometry.size[0], transform.geometry.size[1], transform.geometry.size[2]));
    }
    given.geometry = transform.geometry;
    given.geometry.components = 1;
  }
  const auto axes = static_cast<std::size_t>(given.array.ndim());
  images::Pixels pixels = pixels_of(given);
  images::require_reasonable_number("image", pixels.geometry);
  {
    const py::gil_scoped_release release;
    images::resample(transform, are_labels, pixels);
  }
  const py::array moved = array_of(std::move(pixels), axes, Space::lps);
  return are_labels ? py::array(moved.attr("astype")(given.array.dtype())) : moved;
}

const std::shared_ptr<const Backward>& Result::inverse() {
  if (backward == nullptr) {
    auto made = std::make_shared<Backward>(Backward{.field = field});
    images::Pixels physical;
    {
      const py::gil_scoped_release release;
      Inverse inverse = invert(field.displacement, field.placement.aspect, field.tissue);
      made->field.displacement = std::move(inverse.displacement);
      made->field.mapping = Mapping::backward;
      made->unmet = inverse.unmet;
      made->farthest = inverse.farthest;
      made->at = inverse.at;
      physical = made->field.physical();
    }
    made->displacement = array_of(std::move(physical), field.axes, field.space);
    backward = std::move(made);
  }
  return backward;
}

Derivatives Result::gradient(const py::object& by_displacement) const {
  if (kept == nullptr) {
    throw InputError("the scene of this result is gone; solve it with differentiable=True, which keeps it");
  }
  const Scene& solved = kept->scene;
  const images::Pixels given = vectors_like(displacement, "by_displacement", by_displacement, field.space);
  images::Pixels moduli;
  images::Pixels targets;
  images::Pixels forces;
  bool converged = true;
  work_interruptibly([&](Progress& progress) {
    const auto registry = make_backends();
    Solver solver(choose_backend(registry, kept->backend, solved), kept->session);
    SceneGradient gradient =
        gradient_of(solved, field.displacement, along_axes(given, field), solver, progress);
    converged = gradient.converged;
    double voxel = 1.0; // volume of one, mm^3, of a pixel mm^2
    for (std::size_t axis = 0; axis < solved.extent().axes(); ++axis) {
      voxel *= solved.spacing * solved.full.sides[axis];
    }
    targets = along_space(std::move(gradient.target), 1.0 / solved.spacing, field);
    forces = along_space(std::move(gradient.force), solved.spacing / voxel, field); // MPa / side * voxel: N
    moduli = {targets.geometry, std::move(gradient.modulus.values)};
    moduli.geometry.components = 1;
  });
  return {array_of(std::move(moduli), field.axes, field.space),
          array_of(std::move(targets), field.axes, field.space),
          array_of(std::move(forces), field.axes, field.space), converged};
}

void work_interruptibly(const std::function<void(Progress&)>& work) {
  try {
    const py::gil_scoped_release release;
    const Interruptible interruptible{Signals()};
    Progress progress{std::function<void(double)>([](double) { may_end_here(); })};
    work(progress);
  } catch (const Interrupted&) {
    throw py::error_already_set();
  }
}

std::unique_ptr<Result> result_of(const Scene& scene, VectorField displacement, Space space,
                                  std::optional<std::size_t> axes) {
  auto result = std::make_unique<Result>();
  result->scene = scene.name;
  result->energy = scene.energy->name;
  result->largest = largest_component(displacement, tissue_of(scene)) * scene.spacing;
  result->residuals = residuals_of(scene, displacement);
  result->field = {.displacement = std::move(displacement),
                   .spacing = scene.spacing,
                   .placement = scene.placement,
                   .oblong = scene.oblong,
                   .space = space,
                   .axes = axes.value_or(scene.extent().axes()),
                   .tissue = tissue_of(scene)};
  images::Pixels physical;
  {
    const py::gil_scoped_release release;
    physical = result->field.physical();
  }
  result->affine = affine_of(physical.geometry, space);
  result->displacement = array_of(std::move(physical), result->field.axes, space);
  return result;
}

std::unique_ptr<Result> solve(Asked asked, const std::function<Scene(ScheduleOverrides&)>& load, Space space,
                              std::optional<std::size_t> axes) {
  const Clock clock;
  Found found;
  work_interruptibly([&](Progress& progress) { found = find(asked, load, progress); });
  const Solution& solution = found.answer.solution();
  std::unique_ptr<Result> result = result_of(found.scene, solution.displacement, space, axes);
  result->method = found.answer.plan ? "as needed" : method_name(found.scene);
  result->backend = asked.backend;
  result->device = found.device.name;
  result->estimate = solution.estimated_error;
  if (found.answer.plan) {
    result->met = found.answer.plan->met;
    result->outcome = found.answer.plan->outcome;
  }
  result->timings = solution.timings;
  result->warnings = object_of(nlohmann::json(found.warnings));
  if (asked.differentiable) {
    result->kept = std::make_shared<Kept>(std::move(found.scene), asked.backend, asked.session);
  }
  result->seconds = clock.seconds();
  return result;
}

py::object object_of(const nlohmann::json& rows) {
  return py::module_::import("json").attr("loads")(rows.dump());
}

} // namespace hdmbench::python
