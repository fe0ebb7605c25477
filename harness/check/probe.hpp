#pragma once

#include "backends/backend.hpp"
#include "backends/shared/arithmetic.hpp"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the arithmetic of a device does: in the very programs that `verify` compares, one sweep on numbers
/// that tell the cases apart, because a device may treat each program otherwise; and, operation by operation,
/// in a small program of its own in the backend's language (kernels/specification/probe.inc).
namespace hdmbench {

/// How a device answered a question.
enum class ProbeAnswer {
  as_specified, ///< every telling component has scalar's value
  otherwise,    ///< every telling component has that of the other case
  mixed,        ///< some the one, some the other
  neither,      ///< some have neither
  untold        ///< no component could tell
};
inline constexpr std::array<std::string_view, 5> probe_answer_names{"as specified", "otherwise", "mixed",
                                                                    "neither", "untold"};
[[nodiscard]] constexpr const auto& names_of(ProbeAnswer) {
  return probe_answer_names;
}

/// One row of `probe`'s results.
struct ProbeRow {
  std::string backend{};
  std::string device{};
  std::string driver{};
  std::string program = "sweep"; ///< or the language of the small one
  std::string question;          ///< "a * b + c, candidates"
  std::string as_specified;      ///< the first answer in words: "rounded twice"
  std::string otherwise;         ///< the other one: "fused"
  ProbeAnswer answer = ProbeAnswer::untold;
  std::int64_t telling = 0;   ///< components whose value differs between the two answers: 0 proves nothing
  std::int64_t specified = 0; ///< of them, those with the first answer's
  std::int64_t other = 0;     ///< and with the second's
  /// Largest error against the correctly rounded number, in units of the last place, where the question is
  /// how an operation rounds: half of one at most is correct.
  std::optional<double> ulp{};
  bool agreement_needs_it = true; ///< whether scenes of verify would show it
};
void to_json(nlohmann::json& written, const ProbeRow& row);

/// Asks the device that `options` choose. Throws DeviceError.
[[nodiscard]] std::vector<ProbeRow> probe(const Backend& backend, const SessionOptions& options);

/// What the program of its own answers.
[[nodiscard]] std::vector<ProbeRow> probe_arithmetic(const ArithmeticProgram& program, std::size_t device);

/// A question with two answers; each has a number for each case.
struct OperationQuestion {
  std::string question, as_specified, otherwise; ///< as ProbeRow has them
  std::vector<ArithmeticCase> cases;
  std::vector<float> specified, other;
};
/// Returns what probe_arithmetic() asks where there are two answers, for a device that is asked elsewhere.
[[nodiscard]] std::vector<OperationQuestion> operation_questions();

/// The answer in words.
[[nodiscard]] std::string answer_text(const ProbeRow& row);

/// The answers that are not as specified, in one line: "sweep: a * b + c, candidates: fused; ..."; empty
/// where there are none.
[[nodiscard]] std::string findings(const std::vector<ProbeRow>& rows);

/// What the answers let one expect of `verify`, one sentence.
[[nodiscard]] std::string expected_tier(const std::vector<ProbeRow>& rows);

} // namespace hdmbench
