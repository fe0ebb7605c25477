// What running on a rasterizer that never contracts cannot show: the shaders as texts and as SPIR-V.

#include "backends/device/bindings.hpp"
#include "backends/gl/compute.hpp"
#include "backends/gl/context.hpp"
#include "backends/gl/elastic_fragment.hpp"
#include "backends/gl/fragment_programs.hpp"
#include "backends/registry.hpp"
#include "backends/shared/tiles.hpp"
#include "test/files.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <shaders/coarse_levels_compute.hpp>
#include <shaders/coarse_levels_vulkan.hpp>
#include <shaders/count_compute.hpp>
#include <shaders/count_fragment.hpp>
#include <shaders/elastic_coarse_compute.hpp>
#include <shaders/elastic_coarse_vulkan.hpp>
#include <shaders/elastic_compute.hpp>
#include <shaders/elastic_vulkan.hpp>
#include <shaders/project_compute.hpp>
#include <shaders/project_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sample_compute.hpp>
#include <shaders/sample_fragment.hpp>
#include <shaders/sweep_vulkan.hpp>
#include <shaders/tiles_vertex.hpp>

#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <span>

namespace hdmbench {
namespace {

/// Status of glslangValidator, which is stricter than drivers are.
int lint(const test::TemporaryFolder& folder, const char* file_name, std::string_view text) {
  const auto file = folder.write(file_name, text);
  return std::system(("glslangValidator '" + file.string() + "'").c_str());
}

/// As backends/session/sweeps.cpp has it.
ProgramKind sweep_kind(const ShaderConstants& constants, std::size_t tile_class, bool wakes) {
  ProgramKind kind{.kernel = Kernel::sweep,
                   .constants = {{"RULE", constants.rule},
                                 {"COLOURS", constants.colours},
                                 {"STEP_COUNT", constants.step_count},
                                 {"CLASS", static_cast<int>(tile_class)},
                                 {"WAKES", wakes ? 1 : 0},
                                 {"TILE_WIDTH", 32},
                                 {"TILE_HEIGHT", 16},
                                 {"COLUMNS", 4},
                                 {"LANES", 8}}};
  if (tile_class != general_class) {
    kind.steps = StepSet().padded();
  }
  return kind;
}

TEST(Shaders, AreStrictGlsl) {
  if (std::system("command -v glslangValidator >/dev/null") != 0) {
    GTEST_SKIP() << "glslangValidator is not installed";
  }
  const test::TemporaryFolder folder;
  for (const ShaderConstants constants : {ShaderConstants{0, 1, 5}, ShaderConstants{0, 2, 16},
                                          ShaderConstants{1, 2, 1}, ShaderConstants{3, 4, 5}}) {
    for (std::size_t tile_class = 0; tile_class < class_count; ++tile_class) {
      EXPECT_EQ(lint(folder, "sweep.frag", gl::sweep_text(constants, tile_class)), 0);
      EXPECT_EQ(lint(folder, "pairs.frag", gl::sweep_pairs_text(constants, StepSet().padded(), tile_class)),
                0);
    }
    for (const std::size_t tile_class : {std::size_t{0}, general_class}) {
      for (const bool active : {false, true}) {
        EXPECT_EQ(lint(folder, "sweep.comp", gl::compute_text(sweep_kind(constants, tile_class, active))), 0);
      }
    }
  }
  EXPECT_EQ(lint(folder, "sample.comp", gl::assemble(sources::sample_compute, "")), 0);
  EXPECT_EQ(lint(folder, "project.comp", gl::assemble(sources::project_compute, "")), 0);
  for (const char* const pairs : {"", "#define PAIRS\n"}) {
    EXPECT_EQ(lint(folder, "count.frag", gl::assemble(sources::count_fragment, pairs)), 0);
    EXPECT_EQ(lint(folder, "sample.frag", gl::assemble(sources::sample_fragment, pairs)), 0);
    EXPECT_EQ(lint(folder, "project.frag", gl::assemble(sources::project_fragment, pairs)), 0);
  }
  EXPECT_EQ(lint(folder, "coarse_levels.comp",
                 gl::assemble(sources::coarse_levels_compute, "#define INVOCATIONS 64\n#define STEP_COUNT 5\n"
                                                              "#define STOPS_AT_REST 1\n")),
            0);
  EXPECT_EQ(lint(folder, "quad.vert", sources::quad_vertex), 0);
  EXPECT_EQ(
      lint(folder, "tiles.vert", gl::assemble(sources::tiles_vertex, "#define POINTS 16\n#define ACTIVE\n")),
      0);
  EXPECT_EQ(lint(folder, "count.comp", gl::assemble(sources::count_compute, "")), 0);
  for (int step = 0; step <= static_cast<int>(ElasticStep::squares); ++step) {
    for (const auto masks : {ElasticMasks::none, ElasticMasks::anyhow, ElasticMasks::by_list}) {
      const ElasticKernel kernel{.step = static_cast<ElasticStep>(step),
                                 .has_load = step % 2 == 0,
                                 .is_image = masks == ElasticMasks::none,
                                 .masks = masks};
      EXPECT_EQ(lint(folder, "elastic.frag", gl::elastic_fragment_text(kernel)), 0);
      EXPECT_EQ(lint(folder, "elastic.comp",
                     gl::assemble(sources::elastic_compute,
                                  elastic_definitions(kernel) + "#define LANES 16\n#define ROWS 4\n")),
                0);
    }
  }
  EXPECT_EQ(lint(folder, "elastic_coarse.comp",
                 gl::assemble(sources::elastic_coarse_compute,
                              "#define LANES 16\n#define ROWS 4\n#define IN_SHARED 1\n")),
            0);
  EXPECT_NE(lint(folder, "wrong.frag", "#version 120\nvoid main() { gl_FragColor = 1; }\n"), 0)
      << "the lint is blind";
}

struct Arithmetic {
  int operations = 0; ///< float additions, subtractions and multiplications
  int contractible = 0;
};

/// SPIR-V: a header of five words, then instructions whose first word is length << 16 | opcode.
Arithmetic count_arithmetic(std::span<const std::uint32_t> words) {
  constexpr std::uint32_t decorate = 71;
  constexpr std::uint32_t no_contraction = 42;
  const std::set<std::uint32_t> arithmetic{129, 131, 133}; // OpFAdd, OpFSub, OpFMul
  std::set<std::uint32_t> protected_ids;
  Arithmetic found;
  for (std::size_t at = 5; at < words.size(); at += words[at] >> 16) {
    const std::uint32_t opcode = words[at] & 0xffffU;
    if (opcode == decorate && words[at + 2] == no_contraction) {
      protected_ids.insert(words[at + 1]);
    }
    if (arithmetic.contains(opcode)) {
      ++found.operations;
      found.contractible += protected_ids.contains(words[at + 2]) ? 0 : 1;
    }
  }
  return found;
}

TEST(Shaders, VulkanMayNotContractAnyFloatOperation) {
  for (const std::span<const std::uint32_t> shader :
       {std::span<const std::uint32_t>(sweep_vulkan), std::span<const std::uint32_t>(coarse_levels_vulkan),
        std::span<const std::uint32_t>(elastic_vulkan),
        std::span<const std::uint32_t>(elastic_coarse_vulkan)}) {
    const Arithmetic found = count_arithmetic(shader);
    EXPECT_GT(found.operations, 30);
    EXPECT_EQ(found.contractible, 0);
  }
}

/// Bytes of a site in the buffers and textures of a sweep, by their names in the shaders.
int bytes_of(const std::string& name) {
  const std::map<std::string, int> known{{"image", 8},     {"displacement", 8},     {"next_image", 8},
                                         {"improved", 8},  {"material", 8},         {"observation", 16},
                                         {"curvature", 8}, {"inverse_curvature", 8}};
  const auto found = known.find(name);
  if (found == known.end()) {
    ADD_FAILURE() << "an array that Backend::bytes_per_update() does not know: " << name;
    return 0;
  }
  return found->second;
}

/// The texel buffers, images and textures that a shader declares.
std::vector<std::string> arrays_in(const std::string& text) {
  static const std::regex declaration("(samplerBuffer|textureBuffer|imageBuffer|sampler2DRect) (\\w+);");
  std::vector<std::string> names;
  for (std::sregex_iterator at(text.begin(), text.end(), declaration), end; at != end; ++at) {
    names.push_back((*at)[2]);
  }
  return names;
}

constexpr std::array all_kinds{SiteKind::general, SiteKind::unobserved, SiteKind::uniform,
                               SiteKind::uniform_unobserved};

double declared_bytes(const char* backend, SiteKind kind) {
  const auto backends = make_backends();
  return find_backend(backends, backend).bytes_per_update(kind, 1);
}

/// SPIR-V of the sweep for a class of tiles and Rule::steps.
std::string compiled_sweep(const test::TemporaryFolder& folder, std::size_t tile_class) {
  const std::string shaders = HDMBENCH_SOURCE "/kernels/shaders";
  std::ifstream file(shaders + "/sweep.comp");
  std::string text(std::istreambuf_iterator<char>(file), {});
  text = std::regex_replace(text, std::regex("layout\\(constant_id = \\d+\\) const"), "const");
  text = std::regex_replace(text, std::regex("tile_class = 0u"), fmt::format("tile_class = {}u", tile_class));
  const auto input = folder.write("sweep.comp", text);
  const auto output = folder.write("sweep.spv", "");
  const std::string command =
      fmt::format("glslangValidator -V -Os --target-env vulkan1.1 -I{0} -I{0}/../specification "
                  "-I{0}/../specification/hdm -o {1} {2}",
                  shaders, output.string(), input.string());
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream binary(output, std::ios::binary);
  return {std::istreambuf_iterator<char>(binary), {}};
}

/// The numbers of a module's bindings.
std::set<std::uint32_t> bindings_in(const std::string& module) {
  constexpr std::uint32_t decorate = 71;
  constexpr std::uint32_t binding_decoration = 33;
  std::vector<std::uint32_t> words(module.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), module.data(), words.size() * sizeof(std::uint32_t));
  std::set<std::uint32_t> found;
  for (std::size_t at = 5; at < words.size(); at += words[at] >> 16) {
    if ((words[at] & 0xffffU) == decorate && words[at + 2] == binding_decoration) {
      found.insert(words[at + 3]);
    }
  }
  return found;
}

// The compiler drops the buffers that a class of tiles does not fetch from.
TEST(Bytes, OfVulkanAreThoseOfTheBuffersThatAreLeft) {
  const test::TemporaryFolder folder;
  for (const SiteKind kind : all_kinds) {
    const std::size_t tile_class = tile_class::class_in_use(classes_inside, class_of(kind));
    double bytes = 0.0;
    for (const std::uint32_t number : bindings_in(compiled_sweep(folder, tile_class))) {
      if (number != binding::tiles && number != binding::lengths && number != binding::appended_lengths) {
        bytes += number == binding::observation ? 16 : 8; // rgba32f, rg32f
      }
    }
    EXPECT_EQ(declared_bytes("vulkan-compute", kind), bytes) << "kind " << static_cast<int>(kind);
  }
}

/// With a current OpenGL 2.1 context.
class OpenGl : public testing::Test {
protected:
  void SetUp() override { SetUp({2, 1}); }

  void SetUp(gl::Version version) {
    try {
      context_ = gl::make_egl_platform()->open(0, version);
      current_.emplace(*context_);
    } catch (const DeviceError& error) {
      GTEST_SKIP() << "no OpenGL: " << error.what();
    }
  }

  [[nodiscard]] const gl::Api& api() const { return context_->api(); }

  /// Of the arrays that the driver has not dropped from the program, `stored` besides.
  static int bytes_left(const gl::Program& program, const std::string& text, int stored) {
    int bytes = stored;
    for (const std::string& name : arrays_in(text)) {
      bytes += program.uniform(name.c_str()) < 0 ? 0 : bytes_of(name);
    }
    return bytes;
  }

private:
  std::unique_ptr<gl::Context> context_;
  std::optional<gl::Context::Current> current_;
};

class OpenGlCompute : public OpenGl {
protected:
  void SetUp() override { OpenGl::SetUp({4, 3}); }
};

TEST_F(OpenGlCompute, BytesAreThoseOfTheBuffersThatAreLeft) {
  for (const SiteKind kind : all_kinds) {
    const std::string text = gl::compute_text(sweep_kind({0, 1, 5}, class_of(kind), false));
    const gl::Program program(api(), {{GL_COMPUTE_SHADER, text}});
    EXPECT_EQ(declared_bytes("gl-compute", kind), bytes_left(program, text, 0))
        << "kind " << static_cast<int>(kind);
  }
}

TEST_F(OpenGl, BytesAreThoseOfTheTexturesThatAreLeft) {
  for (const SiteKind kind : all_kinds) {
    const std::string text = gl::sweep_pairs_text({0, 1, 5}, StepSet().padded(), class_of(kind));
    const gl::Program program(
        api(), {{GL_VERTEX_SHADER, std::string(sources::quad_vertex)}, {GL_FRAGMENT_SHADER, text}});
    EXPECT_EQ(declared_bytes("gl-fragment", kind), bytes_left(program, text, 8))
        << "kind " << static_cast<int>(kind);
  }
}

TEST_F(OpenGl, ACompilerErrorComesWithTheDriversLog) {
  try {
    const gl::Program program(
        api(), {{GL_FRAGMENT_SHADER, "#version 120\nvoid main() { gl_FragColor = nonsense; }\n"}});
    FAIL() << "compiled";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos) << error.what();
  }
}

TEST_F(OpenGl, AnErrorNamesItsCall) {
  try {
    api().DrawArrays(GL_TRIANGLES, 0, -1);
    FAIL() << "accepted";
  } catch (const DeviceError& error) {
    EXPECT_STREQ(error.what(), "glDrawArrays: GL_INVALID_VALUE (0x0501)");
  }
}

} // namespace
} // namespace hdmbench
