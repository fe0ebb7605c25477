// The instruction budget of the thesis's card, Radeon X1300, as Mesa's compiler for it sees our shaders.

#include "backends/gl/fragment.hpp"
#include "backends/gl/objects.hpp"
#include "harness/scene/method.hpp"
#include "test/captured_stream.hpp"
#include "test/r300/instruction_rows.hpp"
#include "test/r300/scalar_operations.hpp"
#include "test/r300/vector_candidates.hpp"
#include "test/random_level.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <shaders/sweep_fragment.hpp>

namespace hdmbench::test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int budget = 512;

TEST(Judgement, ReadsTheLastFragmentShader) {
  const std::vector<std::string> messages{"VS shader: 1 inst, 0 vinst, 0 tex, 1 temps, 0 consts, 0 lits",
                                          "FS shader: 7 inst, 4 vinst, 2 sinst, 0 predicate, 0 flowcontrol, "
                                          "1 tex, 0 presub, 2 temps, 4 consts, 0 lits",
                                          "FS shader: 128 inst, 109 vinst, 66 sinst, 0 predicate, 3 "
                                          "flowcontrol, 11 tex, 18 presub, 17 temps, 11 consts, 0 "
                                          "lits"};
  const Compilation made = judge(messages, "");
  ASSERT_TRUE(made.resources);
  EXPECT_EQ(made.resources->instructions, 128);
  EXPECT_EQ(made.resources->texture_instructions, 11);
  EXPECT_EQ(made.resources->temporaries, 17);
  EXPECT_EQ(made.resources->flow_control, 3);
}

TEST(Judgement, ADummyIsARefusal) {
  const std::vector<std::string> messages{"FS shader: 1 inst, 0 tex, 1 temps, 0 consts"};
  const Compilation made =
      judge(messages, "r300 FP: Compiler Error:\n../src/a.c::emit(): Too many instructions\n"
                      "Using a dummy shader instead.\n");
  EXPECT_FALSE(made.resources);
  EXPECT_EQ(made.refusal, "Too many instructions");
}

TEST(Judgement, SilenceIsNoPass) {
  const std::vector<std::string> vertex_only{"VS shader: 1 inst, 0 tex, 1 temps, 0 consts"};
  EXPECT_THAT([&] { (void)judge(vertex_only, ""); }, ThrowsMessage<DeviceError>(HasSubstr("neither")));
  const std::vector<std::string> other_words{"FS shader: 128 instructions, 11 tex, 17 temps, 1 consts"};
  EXPECT_THAT([&] { (void)judge(other_words, ""); }, ThrowsMessage<DeviceError>(HasSubstr("\"inst\"")));
}

TEST(ScalarOperations, AreCountedPerComponent) {
  if (!scalar_operations("#version 120\nvoid main() { gl_FragColor = vec4(0.0); }\n")) {
    GTEST_SKIP() << "glslangValidator or spirv-opt is not installed";
  }
  const auto count = [](const std::string& expression) {
    return scalar_operations(
        "#version 120\nuniform vec4 v;\nuniform float s;\nvoid main() { gl_FragColor = " + expression +
        "; }\n");
  };
  EXPECT_EQ(count("v"), 0);
  EXPECT_EQ(count("v + v.wzyx"), 4);
  EXPECT_EQ(count("vec4(v.x / s)"), 1);
  EXPECT_EQ(count("vec4(dot(v, v.wzyx))"), 7);
  EXPECT_EQ(count("vec4(v.x < s ? 1.0 : 2.0)"), 2);
  EXPECT_EQ(count("abs(v) * s"), 8);
  EXPECT_EQ(count("vec4(dot(v.xy, v.zw))"), 3);
}

TEST(ScalarOperations, AreCountedInEveryRoundOfALoop) {
  const auto count = [](int rounds) {
    return scalar_operations(
        fmt::format("#version 120\nuniform float s[16];\nvoid main() {{ float sum = 0.5;\n"
                    "for (int i = 0; i < {}; ++i) {{ sum = sum * sum + s[i]; }}\n"
                    "gl_FragColor = vec4(sum); }}\n",
                    rounds));
  };
  if (!count(1)) {
    GTEST_SKIP() << "glslangValidator or spirv-opt is not installed";
  }
  EXPECT_EQ(*count(9) - *count(5), 4); // one multiply-add each
}

class Budget : public testing::Test {
protected:
  void SetUp() override {
    if (const std::string reason = why_missing(); !reason.empty()) {
      GTEST_SKIP() << reason;
    }
    compiler_.emplace();
  }

  /// A chain of dependent multiply-adds, which no compiler can shorten: about `length` instructions.
  Compilation compile_chain(int length) {
    std::string text = "#version 120\nuniform vec4 a;\nvoid main() {\n  vec4 v = a;\n";
    for (int i = 0; i < length; ++i) {
      text += "  v = v * v + a;\n";
    }
    return compiler_->compile(text + "  gl_FragColor = v;\n}\n");
  }

  std::optional<ShaderCompiler> compiler_;
};

TEST_F(Budget, IsThatOfTheThesis) {
  EXPECT_THAT(compiler_->device().name, HasSubstr("RV515"));
  EXPECT_EQ(compiler_->limits().instructions, budget);
}

// The limit is where the compiler gives up, not what we believe it to be; and nobody but the judge says so.
TEST_F(Budget, ATooLargeShaderIsSeen) {
  const Compilation fits = compile_chain(500);
  ASSERT_TRUE(fits.resources) << fits.refusal;
  EXPECT_THAT(fits.resources->instructions, testing::AllOf(testing::Ge(500), testing::Le(budget)));
  const Compilation too_large = compile_chain(520);
  EXPECT_FALSE(too_large.resources);
  EXPECT_THAT(too_large.refusal, HasSubstr("Too many instructions"));
}

TEST_F(Budget, EveryStepSetFits) {
  int before = 0;
  for (const InstructionRow& row : measure_candidates(*compiler_)) {
    ASSERT_TRUE(row.compilation.resources) << row.candidates << " candidates: " << row.compilation.refusal;
    EXPECT_LE(row.compilation.resources->instructions, budget) << row.candidates << " candidates";
    EXPECT_GT(row.compilation.resources->instructions, before)
        << "a candidate that costs nothing is not evaluated";
    before = row.compilation.resources->instructions;
    EXPECT_EQ(row.compilation.resources->flow_control, 0) << "a loop is counted once, whatever it costs";
  }
}

// Annealing, the longest of all, with as many candidates as there can be.
TEST_F(Budget, EveryMethodFits) {
  const auto rows = measure_methods(*compiler_);
  EXPECT_GT(rows.size(), methods().size() / 2);
  for (const InstructionRow& row : rows) {
    EXPECT_TRUE(row.compilation.resources)
        << row.shader << " with " << row.candidates << ": " << row.compilation.refusal;
  }
  EXPECT_EQ(std::ranges::max(rows, {}, &InstructionRow::candidates).candidates, StepSet::maximum_count - 1)
      << "annealing, without the 0";
}

// The two counts know nothing of each other: an instruction is a vector of three and a scalar operation at
// most.
TEST_F(Budget, IsNotFarFromTheScalarOperations) {
  const std::string source = gl::assemble(sources::sweep_fragment, {.step_count = 5});
  const std::optional<int> operations = scalar_operations(source);
  if (!operations) {
    GTEST_SKIP() << "glslangValidator or spirv-opt is not installed";
  }
  const Compilation made = compiler_->compile(source);
  ASSERT_TRUE(made.resources) << made.refusal;
  const int arithmetic = made.resources->instructions - made.resources->texture_instructions;
  EXPECT_GE(*operations, arithmetic);
  EXPECT_LE(*operations, 4 * arithmetic);
}

// The backend itself on the card: nothing else is compiled than what was counted.
TEST_F(Budget, IsOfWhatTheBackendSends) {
  std::vector<std::string> messages;
  const auto backend = gl::make_fragment("gl-fragment", "", make_card(messages));
  const auto session = backend->open({});
  for (const Rule rule : all_rules) {
    const Problem problem = random_problem({8, 5}, Texture::smooth, 1, StepSet(), rule, Update::coloured);
    messages.clear();
    CapturedStream errors(stderr);
    session->load(problem.level);
    session->write(problem.start);
    session->step(2);
    const Compilation sent = judge(messages, errors.take());
    const Compilation counted =
        compiler_->compile(gl::assemble(sources::sweep_fragment, shader_constants(problem.level)));
    ASSERT_TRUE(sent.resources && counted.resources) << sent.refusal << counted.refusal;
    EXPECT_EQ(sent.resources->instructions, counted.resources->instructions);
    EXPECT_EQ(sent.resources->temporaries, counted.resources->temporaries);
  }
}

// Thesis 5.4 and 6.2.4: with 4 step sizes the operations came very close to 512, 6 went past it. Another
// compiler may do better; this is what Mesa 22.3 makes of it.
TEST_F(Budget, FourStepSizesNearlyFillTheThesisShaderAndSixDoNotFit) {
  const auto compile = [&](std::span<const Candidate> vectors) {
    return compiler_->compile(vector_candidates_shader(Energy::as_printed, vectors));
  };
  const Compilation four = compile(product_set(uniform_steps(4)));
  ASSERT_TRUE(four.resources) << four.refusal;
  EXPECT_GT(four.resources->instructions, budget * 9 / 10);
  const std::vector<Candidate> six = product_set(uniform_steps(6));
  EXPECT_FALSE(compile(six).resources);
  EXPECT_THAT(compile(std::span(six).first(17)).refusal, HasSubstr("Too many instructions"));
}

} // namespace
} // namespace hdmbench::test
