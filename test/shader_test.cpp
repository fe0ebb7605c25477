// What running on a rasterizer that never contracts cannot show: the shaders as texts and as SPIR-V.

#include "backends/gl/context.hpp"
#include "backends/gl/fragment_programs.hpp"
#include "backends/gl/tile_sweeps.hpp"
#include "test/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <shaders/coarse_levels_compute.hpp>
#include <shaders/coarse_levels_vulkan.hpp>
#include <shaders/count_compute.hpp>
#include <shaders/count_fragment.hpp>
#include <shaders/project_compute.hpp>
#include <shaders/project_fragment.hpp>
#include <shaders/quad_vertex.hpp>
#include <shaders/sample_compute.hpp>
#include <shaders/sample_fragment.hpp>
#include <shaders/sweep_vulkan.hpp>
#include <shaders/tiles_vertex.hpp>

#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <span>

namespace hdmbench {
namespace {

/// Status of glslangValidator, which is stricter than drivers are.
int lint(const test::TemporaryFolder& folder, const char* file_name, std::string_view text) {
  const auto file = folder.write(file_name, text);
  return std::system(("glslangValidator '" + file.string() + "'").c_str());
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
        gl::TileProgramKind kind{.constants = constants, .tile_class = tile_class, .active = active};
        if (tile_class != general_class) {
          kind.steps = StepSet().padded();
        }
        EXPECT_EQ(lint(folder, "sweep.comp", gl::assemble(kind)), 0);
      }
    }
  }
  EXPECT_EQ(lint(folder, "sample.comp", sources::sample_compute), 0);
  EXPECT_EQ(lint(folder, "project.comp", gl::assemble(sources::project_compute, "")), 0);
  for (const char* const pairs : {"", "#define PAIRS\n"}) {
    EXPECT_EQ(lint(folder, "count.frag", gl::assemble(sources::count_fragment, pairs)), 0);
    EXPECT_EQ(lint(folder, "sample.frag", gl::assemble(sources::sample_fragment, pairs)), 0);
    EXPECT_EQ(lint(folder, "project.frag", gl::assemble(sources::project_fragment, pairs)), 0);
  }
  EXPECT_EQ(lint(folder, "coarse_levels.comp",
                 gl::assemble(sources::coarse_levels_compute, "#define INVOCATIONS 64\n#define STEP_COUNT 5\n"
                                                              "#define STOPS_AT_REST true\n")),
            0);
  EXPECT_EQ(lint(folder, "quad.vert", sources::quad_vertex), 0);
  EXPECT_EQ(
      lint(folder, "tiles.vert", gl::assemble(sources::tiles_vertex, "#define POINTS 16\n#define ACTIVE\n")),
      0);
  EXPECT_EQ(lint(folder, "count.comp", sources::count_compute), 0);
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
       {std::span<const std::uint32_t>(sweep_vulkan), std::span<const std::uint32_t>(coarse_levels_vulkan)}) {
    const Arithmetic found = count_arithmetic(shader);
    EXPECT_GT(found.operations, 30);
    EXPECT_EQ(found.contractible, 0);
  }
}

/// With a current OpenGL 2.1 context.
class OpenGl : public testing::Test {
protected:
  void SetUp() override {
    try {
      context_ = gl::make_egl_platform()->open(0, {2, 1});
      current_.emplace(*context_);
    } catch (const DeviceError& error) {
      GTEST_SKIP() << "no OpenGL: " << error.what();
    }
  }

  [[nodiscard]] const gl::Api& api() const { return context_->api(); }

private:
  std::unique_ptr<gl::Context> context_;
  std::optional<gl::Context::Current> current_;
};

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
