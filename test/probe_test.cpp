// The probe's answers, on backends whose arithmetic is known.

#include "harness/check/probe.hpp"

#include "backends/registry.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/fused_real.hpp"
#include "kernels/specification/language.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <map>

// probe.inc with a scalar that fuses, as a compiler may that nobody asked not to.
namespace hdmbench::fused {

inline real operator+(Product a, Product b) {
  return std::fma(b.a, b.b, a.a * a.b);
}
inline real operator/(real a, real b) {
  return a.value / b.value;
}
inline real sqrt(real a) {
  return std::sqrt(a.value);
}
inline real exp(real a) {
  return std::exp(a.value);
}

#include "kernels/specification/probe.inc"

} // namespace hdmbench::fused

namespace hdmbench {
namespace {

float fused_program(float operation, float a, float b, float c, float d, float e) {
  return fused::probed(operation, a, b, c, d, e).value;
}

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
  for (const auto& backend : make_backends()) {
    try {
      const std::vector<ProbeRow> rows = probe(*backend, {});
      EXPECT_THAT(expected_tier(rows), testing::StartsWith("bitwise")) << backend->name();
    } catch (const DeviceError& error) {
      std::printf("%s is skipped: %s\n", std::string(backend->name()).c_str(), error.what());
    }
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

TEST(ProbeArithmetic, SaysFusedOfABuildThatFuses) {
  const auto found = differing([](const ArithmeticCase& one) {
    return fused_program(one[5], one[0], one[1], one[2], one[3], one[4]);
  });
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
