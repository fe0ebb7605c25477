// The probe's answers, on backends whose arithmetic is known.

#include "harness/check/probe.hpp"

#include "backends/registry.hpp"
#include "harness/check/faults/faulty_backend.hpp"
#include "harness/check/faults/fused_backend.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hdmbench {
namespace {

std::map<std::string, ProbeRow> answers(const Backend& backend) {
  std::map<std::string, ProbeRow> found;
  for (ProbeRow& row : probe(backend, {})) {
    found.emplace(row.question, row);
  }
  return found;
}

TEST(Probe, ScalarRoundsEveryOperationAndKeepsEveryNumber) {
  for (const auto& [question, row] : answers(*make_backends().front())) {
    EXPECT_EQ(row.answer, ProbeAnswer::as_specified) << question;
    EXPECT_GT(row.telling, 10) << question;
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

} // namespace
} // namespace hdmbench
