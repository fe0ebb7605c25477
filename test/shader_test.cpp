// What running on a rasterizer that never contracts cannot show: the shaders as texts and as SPIR-V.

#include "backends/gl/compute.hpp"
#include "backends/gl/context.hpp"
#include "backends/gl/fragment.hpp"
#include "backends/gl/fragment_programs.hpp"
#include "backends/shared/tiles.hpp"
#include "kernels/shaders/law_steps.h"
#include "test/files.hpp"

#include <shaders/coarse_levels_vulkan.hpp>
#include <shaders/elastic_image_together_vulkan.hpp>
#include <shaders/elastic_image_vulkan.hpp>
#include <shaders/elastic_volume_together_vulkan.hpp>
#include <shaders/elastic_volume_vulkan.hpp>
#include <shaders/levels_volume_vulkan.hpp>
#include <shaders/levels_vulkan.hpp>
#include <shaders/passes_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sweep_volume_vulkan.hpp>
#include <shaders/sweep_vulkan.hpp>
#include <shaders/tiles_vertex.hpp>

namespace hdmbench {
namespace {

/// Status of glslangValidator, which is stricter than drivers are, over all texts, which it names; the stage
/// is the end of a text's name.
int lint(const std::vector<std::pair<const char*, std::string>>& texts) {
  const test::TemporaryFolder folder;
  std::string command = "glslangValidator";
  for (const auto& [name, text] : texts) {
    const auto number = std::to_string(command.size());
    std::string linted = text;
    linted.insert(linted.find('\n') + 1, "#define HDM_NO_PRECISE\n"); // kernels/shaders/precise.glsl
    command += " '" + folder.write(number + name, linted).string() + "'";
  }
  return std::system(command.c_str());
}

/// As backends/session/sweeps.cpp has it.
ProgramKind sweep_kind(const ShaderConstants& constants, std::size_t tile_class, std::size_t axes) {
  ProgramKind kind{.kernel = Kernel::sweep,
                   .constants = {{"RULE", constants.rule},
                                 {"COLOURS", constants.colours},
                                 {"STEP_COUNT", constants.step_count},
                                 {"CLASS", static_cast<int>(tile_class)},
                                 {"ACTIVE", axes == 2 && tile_class == 0 ? 1 : 0},
                                 {"TILE_WIDTH", 32},
                                 {"TILE_HEIGHT", 16},
                                 {"COLUMNS", 2},
                                 {"LANES", 16}},
                   .axes = axes};
  if (tile_class != general_class) {
    kind.steps = StepSet().padded();
  }
  return kind;
}

TEST(Shaders, AreStrictGlsl) {
  if (std::system("command -v glslangValidator >/dev/null") != 0) {
    GTEST_SKIP() << "glslangValidator is not installed";
  }
  std::vector<std::pair<const char*, std::string>> texts{
      {"quad.vert", std::string(sources::quad_vertex)},
      {"tiles.vert", gl::assemble(sources::tiles_vertex, "#define POINTS 16\n#define ACTIVE\n")}};
  for (const char* const pass : {"CELL 16", "CELLS 4", "COUNTS", "LOOP 0", "LOOP 1", "LOOP 2"}) {
    for (const char* const pairs : {"", "#define PAIRS\n"}) {
      texts.emplace_back("passes.frag", gl::assemble(sources::passes_fragment,
                                                     "#define " + std::string(pass) + "\n" + pairs));
    }
  }
  std::vector<ProgramKind> kinds{
      {.kernel = Kernel::coarse_levels,
       .constants = {{"INVOCATIONS", 64}, {"STEP_COUNT", 5}, {"STOPS_AT_REST", 1}}}};
  for (int number = 0; number < 3; ++number) {
    for (const std::size_t axes : {2, 3}) {
      kinds.push_back({.kernel = Kernel::levels, .constants = {{"PASS", number}}, .axes = axes});
    }
    kinds.push_back({.kernel = Kernel::loops, .constants = {{"LOOP", number}}});
  }
  for (const ShaderConstants constants : {ShaderConstants{0, 1, 5}, ShaderConstants{0, 2, 16},
                                          ShaderConstants{1, 2, 1}, ShaderConstants{3, 4, 5}}) {
    for (const std::size_t tile_class : {std::size_t{0}, general_class}) {
      texts.emplace_back("pairs.frag", gl::sweep_text(constants, tile_class, StepSet().padded()));
      for (const std::size_t axes : {2, 3}) {
        texts.emplace_back("sweep.frag", gl::sweep_text(constants, tile_class, {}, axes));
        texts.emplace_back("sweep.comp", gl::compute_text(sweep_kind(constants, tile_class, axes)));
      }
    }
  }
  for (int step = 0; step <= static_cast<int>(ElasticStep::squares); ++step) {
    for (const bool is_image : {false, true}) {
      const ElasticKernel kernel{.step = static_cast<ElasticStep>(step),
                                 .has_load = step % 2 == 0,
                                 .is_image = is_image,
                                 .has_masked = !is_image,
                                 .has_boxes = step % 2 == 0,
                                 .halved = step % 3 == 0 ? 3 : 7};
      for (const std::size_t axes : {2, 3}) {
        texts.emplace_back("elastic.frag", gl::elastic_fragment_text(kernel, axes));
        kinds.push_back({.kernel = Kernel::elastic,
                         .constants = {{"TOGETHER", step == static_cast<int>(ElasticStep::squares)},
                                       {"STEP", step},
                                       {"HAS_LOAD", step % 2},
                                       {"IS_IMAGE", is_image},
                                       {"BY_LIST", !is_image},
                                       {"LANES", 16},
                                       {"ROWS", 4},
                                       {"COLUMNS", 2},
                                       {"BOXES", step % 2 == 0},
                                       {"HALVED", step % 3 == 0 ? 3 : 7}},
                         .axes = axes});
      }
    }
  }
  for (const int step : {LAW_CELLS, LAW_SITES, LAW_LEAST}) {
    for (const std::size_t axes : {2, 3}) {
      kinds.push_back({.kernel = Kernel::laws,
                       .constants = {{"STEP", step}, {"FIBRES", 1}, {"LANES", 16}, {"COLUMNS", 1}},
                       .law = &laws::neo_hookean::law,
                       .axes = axes});
    }
  }
  for (const ProgramKind& kind : kinds) {
    texts.emplace_back("kernel.comp", gl::compute_text(kind));
  }
  EXPECT_EQ(lint(texts), 0);
  EXPECT_NE(lint({{"wrong.frag", "#version 120\nvoid main() { gl_FragColor = 1; }\n"}}), 0)
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
       {std::span<const std::uint32_t>(sweep_vulkan), std::span<const std::uint32_t>(sweep_volume_vulkan),
        std::span<const std::uint32_t>(levels_vulkan), std::span<const std::uint32_t>(levels_volume_vulkan),
        std::span<const std::uint32_t>(coarse_levels_vulkan),
        std::span<const std::uint32_t>(elastic_image_vulkan),
        std::span<const std::uint32_t>(elastic_volume_vulkan),
        std::span<const std::uint32_t>(elastic_image_together_vulkan),
        std::span<const std::uint32_t>(elastic_volume_together_vulkan),
        laws::neo_hookean::law.vulkan_of_images, laws::neo_hookean::law.vulkan_of_volumes}) {
    const Arithmetic found = count_arithmetic(shader);
    EXPECT_GT(found.operations, 8);
    EXPECT_EQ(found.contractible, 0);
  }
}

TEST(OpenGl, ACompilerErrorComesWithTheDriversLog) {
  std::unique_ptr<gl::Context> context;
  try {
    context = gl::make_egl_platform()->open(0, {2, 1});
  } catch (const DeviceError& error) {
    GTEST_SKIP() << "no OpenGL: " << error.what();
  }
  const gl::Context::Current current(*context);
  EXPECT_THAT(test::refusal<DeviceError>([&] {
                const gl::Program program(
                    context->api(),
                    {{GL_FRAGMENT_SHADER, "#version 120\nvoid main() { gl_FragColor = nonsense; }\n"}});
              }),
              HasSubstr("nonsense"));
}

} // namespace
} // namespace hdmbench
