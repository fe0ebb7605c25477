#pragma once

#include "backends/backend.hpp"
#include "backends/gl/context.hpp"
#include "backends/session/elastic_steps.hpp"

#include <memory>
#include <string>
#include <string_view>

namespace hdmbench::gl {

/// The thesis's own design on the contexts of one platform: GLSL 1.20, two framebuffer objects that are
/// swapped. The image is drawn as points as large as its tiles (fragment_level.hpp), and over them its
/// border. Candidates are swept in texels of two sites where vertex shaders can fetch, which devices of the
/// thesis's time cannot; other rules, and candidates there, in its texels of one. Needs OpenGL 2.1 with
/// points of 64 pixels, EXT_framebuffer_object, ARB_texture_rectangle and ARB_texture_float; vertex shaders
/// that fetch for Work::active, which is dense without them.
[[nodiscard]] std::unique_ptr<Backend> make_fragment(std::string_view name, std::string_view description,
                                                     std::unique_ptr<Platform> platform);

/// The elastic energy there: kernels/shaders/elastic.frag. `name`: of the backend, for errors.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_fragment(std::string name,
                                                                    std::unique_ptr<Context> context);
/// elastic.frag as the driver wants it, of images or of volumes.
[[nodiscard]] std::string elastic_fragment_text(const ElasticKernel& kernel, std::size_t axes = 2);

} // namespace hdmbench::gl
