// The probe's answers, on backends whose arithmetic is known.

#include "harness/check/probe.hpp"

#include "harness/check/faults/faulty_backend.hpp"
#include "test/sessions.hpp"

#include <bit>

namespace hdmbench {
namespace {

std::map<std::string, ProbeRow> answers(const Backend& backend) {
  std::map<std::string, ProbeRow> found;
  for (ProbeRow& row : probe(backend, {})) {
    if (row.program == "sweep") {
      found.emplace(row.question, row);
    }
  }
  return found;
}

TEST(Probe, EveryBackendThatIsHereRoundsEveryOperation) {
  for (const Backend* const backend : test::present_backends()) {
    EXPECT_THAT(expected_tier(probe(*backend, {})), testing::StartsWith("bitwise")) << backend->name();
  }
}

TEST(Probe, SaysFusedOfWhatFuses) {
  const auto fused = faults::make_fused();
  const auto found = answers(*fused);
  for (const char* rule : {"candidates", "closed form"}) {
    const ProbeRow& row = found.at(std::string("a * b + c, ") + rule);
    EXPECT_EQ(row.answer, ProbeAnswer::otherwise) << rule;
    EXPECT_EQ(answer_text(row), "fused");
  }
  EXPECT_THAT(expected_tier(probe(*fused, {})),
              testing::StartsWith("certified: a * b + c, candidates: fused"));
}

/// A program that is built otherwise.
class Control final : public ArithmeticProgram {
public:
  using Program = std::function<float(const ArithmeticCase&)>;
  explicit Control(Program program) : program_(std::move(program)) {}

  [[nodiscard]] std::string_view language() const override { return "C++, built otherwise"; }
  [[nodiscard]] std::vector<float> evaluate(std::size_t /*device*/,
                                            std::span<const ArithmeticCase> cases) const override {
    std::vector<float> results;
    std::ranges::transform(cases, std::back_inserter(results), program_);
    return results;
  }

private:
  Program program_;
};

/// The rows that are not as specified, by question.
std::map<std::string, ProbeRow> differing(const Control::Program& program) {
  std::map<std::string, ProbeRow> found;
  for (const ProbeRow& row : probe_arithmetic(Control(program), 0)) {
    if (row.answer != ProbeAnswer::as_specified && !row.question.starts_with("exp")) {
      found.emplace(row.question, row);
    }
  }
  return found;
}

float as_specified(const ArithmeticCase& one) {
  return evaluate_in_cpp(std::span(&one, 1)).front();
}

/// As a compiler may have it that nobody asked not to.
float fused(const ArithmeticCase& one) {
  const auto [a, b, c, d, e, operation, unused, unread] = one;
  switch (static_cast<Operation>(static_cast<int>(operation))) {
  case Operation::multiply_add:
  case Operation::precise_chain:
    return std::fma(a, b, c);
  case Operation::sum_of_products:
  case Operation::precise_sum:
    return std::fma(c, d, a * b) + e;
  default:
    return as_specified(one);
  }
}

TEST(ProbeArithmetic, SaysFusedOfABuildThatFuses) {
  const auto found = differing(fused);
  ASSERT_TRUE(found.contains("a * b + c"));
  EXPECT_EQ(answer_text(found.at("a * b + c")), "fused");
  EXPECT_EQ(answer_text(found.at("a * b + c, precise")), "fused");
  EXPECT_EQ(found.at("a * b + c, precise").telling, 256);
  std::vector<ProbeRow> rows;
  for (const auto& [question, row] : found) {
    rows.push_back(row);
  }
  EXPECT_THAT(findings(rows), testing::StartsWith("C++, built otherwise: a * b + c: fused; "));
  EXPECT_THAT(expected_tier(rows), testing::StartsWith("certified: a * b + c, precise: fused"));
}

TEST(ProbeArithmetic, SeesLostNumbersAndLostTurns) {
  const auto found = differing([](const ArithmeticCase& one) {
    float result = as_specified(one);
    result = std::fpclassify(result) == FP_SUBNORMAL ? 0.0F : result;
    if (std::bit_cast<std::uint32_t>(result) == 0x80000000U) {
      result = 0.0F;
    }
    result = std::isnan(result) ? (std::isnan(one[0]) ? one[1] : 0.0F) : result;
    result = std::isinf(result) ? std::numeric_limits<float>::max() : result;
    return one[5] == static_cast<float>(Operation::turns) ? std::min(result, 65'535.0F) : result;
  });
  EXPECT_EQ(answer_text(found.at("subnormal result")), "flushed to 0");
  EXPECT_EQ(answer_text(found.at("subnormal handed on")), "flushed to 0");
  EXPECT_EQ(answer_text(found.at("-0 * a")), "+0");
  EXPECT_EQ(answer_text(found.at("NaN + a")), "a");
  EXPECT_EQ(answer_text(found.at("infinity - infinity")), "0");
  EXPECT_EQ(answer_text(found.at("infinity + a")), "the largest number");
  EXPECT_EQ(answer_text(found.at("a loop of 100,000 turns")), "left after 65,535");
  EXPECT_EQ(found.size(), 7U);
}

} // namespace
} // namespace hdmbench
