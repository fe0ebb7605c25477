#pragma once

#include "backends/device/device.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>

namespace hdmbench {

/// The steps of the elastic energy as dispatches: kernels/shaders/elastic.comp and elastic_coarse.comp, or
/// elastic.cl where arrays are planes.
[[nodiscard]] std::unique_ptr<ElasticDevice> make_elastic_on_device(std::unique_ptr<ComputeDevice> device);

} // namespace hdmbench
