#pragma once

#include "backends/gl/context.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>

namespace hdmbench::gl {

/// kernels/shaders/elastic.comp and elastic_coarse.comp on a context of OpenGL 4.3. Throws DeviceError.
[[nodiscard]] std::unique_ptr<ElasticDevice> make_elastic_compute(std::unique_ptr<Context> context,
                                                                  bool is_software);

} // namespace hdmbench::gl
