#pragma once

#include "backends/session/shapes.hpp"
#include "backends/shared/elastic_session.hpp"

#include <memory>
#include <optional>
#include <string>

namespace hdmbench {

/// As Backend and ArithmeticProgram give it.
struct DeviceBackendName {
  std::string name;
  std::string description;
  std::string language;
};

/// The backend that computes on the devices of an API.
[[nodiscard]] std::unique_ptr<Backend> make_device_backend(DeviceBackendName name,
                                                           std::unique_ptr<ComputeApi> api);

/// A session whose levels, sweeps and pyramids are on a device, by shapes_for(*device) where no others are
/// given.
[[nodiscard]] std::unique_ptr<Session> make_device_session(std::unique_ptr<ComputeDevice> device, Work work,
                                                           std::optional<Shapes> shapes = {});

/// The steps of the elastic energy as dispatches: kernels/shaders/elastic.comp and elastic_coarse.comp, or
/// elastic.cl where arrays are planes. `name`: of the backend, for errors.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_session(std::string name,
                                                                   std::unique_ptr<ComputeDevice> device);

} // namespace hdmbench
