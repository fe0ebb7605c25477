// The instruction budget of the thesis's card, Radeon X1300, as Mesa's compiler for it sees our shaders.

#include "kernels/data/level.hpp"
#include "test/files.hpp"
#include "test/program.hpp"
#include "test/r300/shader_compiler.hpp"

namespace hdmbench::test {
namespace {

using testing::ThrowsMessage;

constexpr int budget = 512;

TEST(Judgement, SilenceIsNoPass) {
  const std::vector<std::string> vertex_only{"VS shader: 1 inst, 0 tex, 1 temps, 0 consts"};
  EXPECT_THAT([&] { (void)judge(vertex_only, ""); }, ThrowsMessage<DeviceError>(HasSubstr("neither")));
  const std::vector<std::string> other_words{"FS shader: 128 instructions, 11 tex, 17 temps, 1 consts"};
  EXPECT_THAT([&] { (void)judge(other_words, ""); }, ThrowsMessage<DeviceError>(HasSubstr("in other words")));
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

/// By the program: what gl-fragment sends, and the thesis's own way (5.4, 6.2.4): with 4 step sizes the
/// operations came very close to 512, 6 went past it. Another compiler may do better than Mesa 22.3.
TEST_F(Budget, WhatGlFragmentSendsFitsAndSixStepSizesOfTheThesisDoNot) {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "rows.json").string();
  expect_run(0, "--json " + file, HasSubstr("RV515"));
  const nlohmann::json rows = read_json(file)["results"];
  int before = 0;
  int most = 0;
  for (const nlohmann::json& row : rows) {
    SCOPED_TRACE(row.dump());
    const bool fits = !row["instructions"].is_null();
    const int instructions = fits ? row["instructions"].get<int>() : budget + 1;
    if (row["group"] == "vectors") {
      EXPECT_EQ(fits, row["energies"] <= 16);
      EXPECT_EQ(instructions > budget * 9 / 10, row["energies"] >= 16);
      if (row["energies"] == 17) { // one vector more than 4 x 4
        EXPECT_THAT(row["refusal"].get<std::string>(), HasSubstr("Too many instructions"));
      }
      continue;
    }
    EXPECT_LE(instructions, budget);
    most = std::max(most, row["candidates"].get<int>());
    if (row["group"] == "candidates") {
      EXPECT_GT(instructions, before) << "a candidate that costs nothing is not evaluated";
      EXPECT_EQ(row["flow_control"], 0) << "a loop is counted once, whatever it costs";
      before = instructions;
    }
  }
  EXPECT_EQ(most, StepSet::maximum_count);
}

} // namespace
} // namespace hdmbench::test
