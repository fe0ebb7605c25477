// What a user sees where a driver fails, and what a caller of a session may do then.

#include "backends/cpu/cpu.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/random_level.hpp"

namespace hdmbench {
namespace {

using test::Outcome;

/// Runs the program with the stand-ins, which are for one thread; `fault` is API/kind/call.
Outcome with_fault(const std::string& fault, const std::string& arguments) {
  return test::hdmbench(
      arguments,
      fmt::format("LP_NUM_THREADS=1 OMP_NUM_THREADS=1 LD_LIBRARY_PATH='{}' HDMBENCH_FAILING_CALL='{}'",
                  HDMBENCH_STAND_INS, fault));
}

/// One that is there and disagrees is there.
bool has(const std::string& backend) {
  return test::hdmbench("verify square --size 5 --quick --backends " + backend).status != 2;
}

/// The kernels of a batch are compiled on all threads, where an error must not get lost.
TEST(FailingCalls, OfOneKernelAmongManyIsNamed) {
  if (!has("vulkan-compute")) {
    GTEST_SKIP() << "no Vulkan";
  }
  const Outcome outcome = with_fault("Vulkan/OUT_OF_HOST_MEMORY/vkCreateComputePipelines",
                                     "verify cube --energy elastic --sizes 9x8x7 --backends vulkan-compute");
  EXPECT_EQ(outcome.status, 2) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("vkCreateComputePipelines: ErrorOutOfHostMemory"));
}

TEST(FailingCalls, EndTheCommandWithTheCallOfOpenGl) {
  if (!has("gl-fragment")) {
    GTEST_SKIP() << "there is no gl-fragment";
  }
  const Outcome outcome = with_fault("OpenGL/GL_OUT_OF_MEMORY/glReadPixels",
                                     "verify square --size 5 --quick --backends gl-fragment");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.output, HasSubstr("hdmbench: gl-fragment: glReadPixels: GL_OUT_OF_MEMORY (0x0505)"));
}

TEST(FailingCalls, LibrariesWithoutFunctionsAreNotThere) {
  const Outcome outcome = test::hdmbench("devices", "LD_LIBRARY_PATH='" HDMBENCH_EMPTY_LIBRARIES "'");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.output, HasSubstr("gl-fragment: libEGL.so.1 has no eglBindAPI"));
  EXPECT_THAT(outcome.output,
              HasSubstr("gl-fragment-osmesa: libOSMesa.so.8 has no OSMesaCreateContextAttribs"));
  EXPECT_THAT(outcome.output,
              HasSubstr("vulkan-compute: the Vulkan loader libvulkan.so.1 has no vkGetInstanceProcAddr"));
  EXPECT_THAT(outcome.output, testing::AnyOf(HasSubstr("opencl: libOpenCL.so.1 has no clBuildProgram"),
                                             HasSubstr("opencl: this build was configured without")));
}

TEST(FailingCalls, AStepThatFailedLeavesNothingToRead) {
  const test::Problem problem = test::random_problem({4, 3}, test::Texture::dyadic, 1);
  bool fails = true;
  const auto scalar = make_scalar();
  const faults::FaultyBackend backend(*scalar, {.name = "fails", .in_step = [&](int sweeps) {
                                                  return fails ? throw DeviceError("planted") : sweeps;
                                                }});
  const auto session = backend.open({});
  VectorField field;
  session->load(problem.level);
  session->write(problem.start);
  EXPECT_THROW(session->step(1), DeviceError);
  EXPECT_THROW(session->read(field), std::logic_error);
  EXPECT_THROW(session->step(1), std::logic_error);
  fails = false;
  session->load(problem.level);
  session->write(problem.start);
  session->step(1);
  EXPECT_NO_THROW(session->read(field));
}

} // namespace
} // namespace hdmbench
