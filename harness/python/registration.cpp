#include "harness/python/registration.hpp"

#include "backends/registry.hpp"
#include "backends/shared/stopwatch.hpp"
#include "harness/applications/picture.hpp"
#include "harness/applications/registration.hpp"
#include "harness/judge/diagnosis/diagnosis.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <iterator>
#include <utility>

namespace hdmbench::python {

namespace {

ScalarField picture_of(std::string name, const py::object& picture) {
  images::Pixels pixels = pixels_of(given_image(std::move(name), picture, py::none(), py::none()));
  const auto& size = pixels.geometry.size;
  ScalarField field(Extent{size[0], size[1], size[2]});
  field.values = std::move(pixels.values);
  return field;
}

/// Throws InputError where it is not of the scene's pixels.
void require_same(const char* name, const ScalarField& picture, const Scene& scene) {
  if (picture.extent != scene.extent()) {
    throw InputError(fmt::format("{}: has {} pixels, the labels have {}", name, picture.extent.text(),
                                 scene.extent().text()));
  }
}

/// What a registration comes to.
struct Registered {
  VectorField displacement;
  Timings timings{};
  std::optional<bool> converged{};
};

} // namespace

std::unique_ptr<Result> register_pictures(const PictureArguments& pictures, SceneToLoad to_load, Asked asked,
                                          bool is_iterated) {
  const Clock clock;
  ScalarField source = picture_of("source", pictures.source);
  ScalarField target = picture_of("target", pictures.target);
  ScalarField region = pictures.region.is_none() ? ScalarField() : picture_of("region", pictures.region);
  Scene scene;
  Device device;
  Registered found;
  Warnings warnings;
  work_interruptibly([&](Progress& progress) {
    scene = to_load.load(asked.schedule);
    require_labels(scene);
    require_same("source", source, scene);
    require_same("target", target, scene);
    prepare_pair(source, target);
    if (!region.values.empty()) {
      require_same("region", region, scene);
      require_region(region, "region");
    }
    const auto registry = make_backends();
    const Backend& backend = choose_backend(registry, asked.backend, scene);
    device = backend.device(asked.session);
    if (is_iterated) {
      const auto session = backend.open_elastic(asked.session);
      if (session == nullptr) {
        throw InputError(fmt::format("{} has no elastic energy, which iterate solves with", backend.name()));
      }
      IteratedRegistration of = register_iteratively(source, target, scene, region, {}, *session, progress);
      found = {.displacement = std::move(of.displacement), .converged = of.converged};
    } else {
      const VectorField first = register_conventionally(source, target, region, progress).displacement;
      VectorField confidence;
      Solution of =
          make_physical(source, target, first, region, scene, backend, asked.session, confidence, progress);
      found = {.displacement = std::move(of.displacement), .timings = of.timings};
    }
    warnings = diagnose(source, target, similarity(source, target),
                        similarity(source, pulled_back(target, found.displacement)));
    std::ranges::move(diagnose(found.displacement, tissue_of(scene)), std::back_inserter(warnings));
  });
  std::unique_ptr<Result> result =
      result_of(scene, std::move(found.displacement), to_load.space, to_load.axes);
  result->method = is_iterated ? "iterated" : "region";
  result->backend = asked.backend;
  result->device = device.name;
  result->timings = found.timings;
  result->met = found.converged;
  result->outcome = !found.converged   ? ""
                    : *found.converged ? "converged"
                                       : "not converged: the last step still moved the tissue";
  result->warnings = object_of(nlohmann::json(warnings));
  result->seconds = clock.seconds();
  return result;
}

} // namespace hdmbench::python
