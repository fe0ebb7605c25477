// The probe's answers, on backends whose arithmetic is known.

#include "harness/check/probe.hpp"

#include "backends/registry.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/faults/fused_backend.hpp"
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

TEST(Probe, ScalarRoundsEveryOperationAndKeepsEveryNumber) {
  for (const ProbeRow& row : probe(*make_backends().front(), {})) {
    if (!row.question.starts_with("exp")) { // whatever the C library does
      EXPECT_EQ(row.answer, ProbeAnswer::as_specified) << row.program << ": " << row.question;
    }
    EXPECT_GT(row.telling, 10) << row.program << ": " << row.question;
  }
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

TEST(Probe, SaysFlushedOfWhatFlushes) {
  const auto backends = make_backends();
  const auto flush = [](float& value) {
    value = std::fpclassify(value) == FP_SUBNORMAL ? std::copysign(0.0F, value) : value;
  };
  const faults::FaultyBackend flushing(*backends.front(),
                                       {.name = "flushing", .in_read = [&](VectorField& field) {
                                          std::ranges::for_each(field.x, flush);
                                          std::ranges::for_each(field.y, flush);
                                        }});
  const auto found = answers(flushing);
  EXPECT_EQ(found.at("subnormal + 0").answer, ProbeAnswer::otherwise);
  EXPECT_EQ(answer_text(found.at("subnormal result")), "flushed to 0");
  EXPECT_EQ(found.at("a * b + c, candidates").answer, ProbeAnswer::as_specified);
}

TEST(Probe, SaysNeitherOfWhatIsWrong) {
  const auto backends = make_backends();
  const faults::FaultyBackend wrong(
      *backends.front(), {.name = "wrong", .in_read = [](VectorField& field) { field.x[5] = 77.0F; }});
  EXPECT_EQ(answers(wrong).at("a * b + c, candidates").answer, ProbeAnswer::neither);
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

bool is(const ArithmeticCase& one, Operation operation) {
  return one[5] == static_cast<float>(operation);
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

TEST(ProbeArithmetic, SaysReorderedOfABuildThatReorders) {
  const auto found = differing([](const ArithmeticCase& one) {
    const auto [a, b, c, d, e, operation, unused, unread] = one;
    return is(one, Operation::sum_of_products) ? (a * b + e) + c * d : as_specified(one);
  });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(answer_text(found.at("(a * b + c * d) + e")), "(a * b + e) + c * d");
}

TEST(ProbeArithmetic, CountsUnitsInTheLastPlace) {
  const auto found = differing([](const ArithmeticCase& one) {
    const float result = as_specified(one);
    const bool off = is(one, Operation::divide) || is(one, Operation::square_root);
    return off ? std::nextafter(std::nextafter(result, 1e30F), 1e30F) : result;
  });
  ASSERT_EQ(found.size(), 2U);
  for (const auto& [question, row] : found) {
    EXPECT_GT(*row.ulp, 1.5) << question;
    EXPECT_LE(*row.ulp, 2.5) << question;
    EXPECT_EQ(row.specified, 0) << question;
    EXPECT_THAT(answer_text(row), testing::EndsWith("ulp off, 0 of 256 correct"));
  }
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
    return is(one, Operation::turns) ? std::min(result, 65'535.0F) : result;
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

/// Scalar's sweeps; its driver refuses the program.
class Refusing final : public Backend, public ArithmeticProgram {
public:
  [[nodiscard]] std::string_view name() const override { return "refusing"; }
  [[nodiscard]] std::string_view description() const override { return ""; }
  [[nodiscard]] std::vector<Device> devices() const override { return scalar_.front()->devices(); }
  [[nodiscard]] std::string_view language() const override { return "a small language"; }
  [[nodiscard]] std::vector<float> evaluate(std::size_t /*device*/,
                                            std::span<const ArithmeticCase> /*cases*/) const override {
    throw DeviceError("no loops here");
  }

private:
  [[nodiscard]] std::unique_ptr<Session> do_open(std::size_t /*index*/,
                                                 const SessionOptions& options) const override {
    return scalar_.front()->open(options);
  }

  std::vector<std::unique_ptr<Backend>> scalar_ = make_backends();
};

TEST(ProbeArithmetic, ADriverThatRefusesTheProgramStillHasItsSweep) {
  const std::vector<ProbeRow> rows = probe(Refusing(), {});
  EXPECT_GT(rows.size(), 3U);
  EXPECT_EQ(findings(rows), "a small language: a program of its own: no loops here");
  EXPECT_THAT(expected_tier(rows), testing::StartsWith("bitwise"));
}

TEST(ProbeArithmetic, EveryLanguageThatIsHereHasAProgram) {
  for (const auto& backend : make_backends()) {
    if (backend->name() == "openmp") {
      continue; // C++ too
    }
    try {
      const std::vector<ProbeRow> rows = probe(*backend, {});
      EXPECT_TRUE(std::ranges::any_of(rows, [](const ProbeRow& row) { return row.program != "sweep"; }))
          << backend->name();
      for (const ProbeRow& row : rows) {
        EXPECT_NE(row.answer, ProbeAnswer::untold) << backend->name() << ": " << row.question;
      }
    } catch (const DeviceError& error) {
      std::printf("%s is skipped: %s\n", std::string(backend->name()).c_str(), error.what());
    }
  }
}

} // namespace
} // namespace hdmbench
