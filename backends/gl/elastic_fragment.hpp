#pragma once

#include "backends/gl/context.hpp"
#include "backends/shared/elastic_device.hpp"

#include <memory>
#include <string>

namespace hdmbench::gl {

/// kernels/shaders/elastic.frag on a context: OpenGL 2.1 as the fragment path needs it. Throws DeviceError.
[[nodiscard]] std::unique_ptr<ElasticDevice> make_elastic_fragment(std::unique_ptr<Context> context);

/// elastic.frag as the driver wants it.
[[nodiscard]] std::string elastic_fragment_text(const ElasticKernel& kernel);

} // namespace hdmbench::gl
