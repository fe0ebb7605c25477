#include "harness/check/probe.hpp"

#include "harness/check/certificate.hpp"
#include "harness/check/rewritten_real.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace hdmbench {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr Extent extent{32, 32}; // of sweeps

/// What a component, or a case of an operation, can come to.
struct Answers {
  float specified;
  float other;             ///< of questions with two answers
  long double exact = 0.0; ///< of those about rounding
};

struct Question {
  ProbeRow row{}; ///< the question, and both answers in words
  bool about_rounding = false;
  bool zero_has_sign = true;
  std::vector<ArithmeticCase> cases{}; ///< of an operation
  std::vector<Answers> answers{};
};

/// Numbers with drawn significands, seeded, the same everywhere.
class Numbers {
public:
  /// 1 <= x < 2, every bit drawn.
  float significand() {
    return std::bit_cast<float>(0x3f800000U | static_cast<std::uint32_t>(engine_() >> 41));
  }
  /// The same times a power of two.
  float of_any_size() {
    constexpr int exponents = 20;
    const auto exponent = static_cast<int>(engine_() % (2 * exponents + 1)) - exponents;
    return std::ldexp(significand(), exponent);
  }

private:
  std::mt19937_64 engine_{3};
};

constexpr int many = 256; // cases

/// What is asked of an operation: its name, both answers in words, and a function that draws a case of it and
/// what it can come to.
Question of_operation(std::string text, std::string as_specified, std::string otherwise, int cases,
                      const std::function<std::pair<ArithmeticCase, Answers>(Numbers&)>& draw) {
  Question question{.row = {.question = std::move(text),
                            .as_specified = std::move(as_specified),
                            .otherwise = std::move(otherwise),
                            .agreement_needs_it = false}};
  Numbers numbers;
  for (int i = 0; i < cases; ++i) {
    const auto [one, its] = draw(numbers);
    question.cases.push_back(one);
    question.answers.push_back(its);
  }
  return question;
}

/// What is subtracted is the rounded product: 0, or what rounding took away from it.
Question fusing(std::string text, Operation operation) {
  return of_operation(std::move(text), "rounded twice", "fused", many, [=](Numbers& draw) {
    const float a = draw.significand();
    const float b = draw.significand();
    const float product = a * b;
    return std::pair{arithmetic_case(operation, a, b, -product), Answers{0.0F, std::fma(a, b, -product)}};
  });
}

Question reordering(std::string text, Operation operation) {
  return of_operation(std::move(text), "in this order", "(a * b + e) + c * d", many, [=](Numbers& draw) {
    const float a = draw.significand();
    const float b = draw.significand();
    const float c = 0.01F * draw.significand();
    const float d = draw.significand();
    const float first = a * b;
    const float second = c * d;
    const float sum = first + second;
    return std::pair{arithmetic_case(operation, a, b, c, d, -first), Answers{sum - first, second}};
  });
}

/// `exact` is the result as near as a long double has it; of two numbers of any size, or of one up to `most`.
Question rounding(std::string text, Operation operation, long double (*exact)(long double, long double),
                  float most = 0.0F) {
  Question question =
      of_operation(std::move(text), "correctly rounded", "rounded otherwise", many, [=](Numbers& draw) {
        const float a = most > 0.0F ? 2.0F * most * (draw.significand() - 1.5F) : draw.of_any_size();
        const float b = most > 0.0F ? 0.0F : draw.of_any_size();
        const long double result = exact(a, b);
        const auto rounded = static_cast<float>(result);
        return std::pair{arithmetic_case(operation, a, b), Answers{rounded, rounded, result}};
      });
  question.about_rounding = true;
  return question;
}

/// A number of a kind, sixteen times with other significands where it has one: given the significand, a and b
/// of the operation, and both answers.
Question special(std::string text, std::string as_specified, std::string otherwise, Operation operation,
                 std::array<float, 4> (*make)(float significand)) {
  return of_operation(std::move(text), std::move(as_specified), std::move(otherwise), 16, [=](Numbers& draw) {
    const auto [a, b, specified, other] = make(draw.significand());
    return std::pair{arithmetic_case(operation, a, b), Answers{specified, other}};
  });
}

std::vector<Question> questions_of_operations() {
  using Numbers4 = std::array<float, 4>;
  std::vector<Question> questions{
      fusing("a * b + c", Operation::multiply_add),
      fusing("a * b + c, precise", Operation::precise_chain),
      reordering("(a * b + c * d) + e", Operation::sum_of_products),
      reordering("(a * b + c * d) + e, precise", Operation::precise_sum),
      rounding("a / b", Operation::divide, [](long double a, long double b) { return a / b; }),
      rounding("1 / a", Operation::reciprocal, [](long double a, long double) { return 1.0L / a; }),
      rounding("sqrt(a)", Operation::square_root, [](long double a, long double) { return std::sqrt(a); }),
      rounding(
          "exp(a), -8 ... 8", Operation::exponential, [](long double a, long double) { return std::exp(a); },
          8.0F),
      special("subnormal operand", "kept", "taken for 0", Operation::multiply,
              [](float x) {
                return Numbers4{x * 0x1p-130F, 0x1p+30F, x * 0x1p-130F * 0x1p+30F, 0.0F};
              }),
      special("subnormal result", "kept", "flushed to 0", Operation::multiply,
              [](float x) {
                return Numbers4{x * 0x1p-100F, 0x1p-30F, x * 0x1p-100F * 0x1p-30F, 0.0F};
              }),
      special("subnormal handed on", "kept", "flushed to 0", Operation::hand_on,
              [](float x) {
                return Numbers4{x * 0x1p-130F, 0.0F, x * 0x1p-130F, 0.0F};
              }),
      special("-0 * a", "-0", "+0", Operation::multiply,
              [](float x) {
                return Numbers4{-0.0F, x, -0.0F, 0.0F};
              }),
      special("infinity + a", "infinity", "the largest number", Operation::add,
              [](float x) {
                return Numbers4{infinity, x, infinity, std::numeric_limits<float>::max()};
              }),
      special("NaN + a", "NaN", "a", Operation::add,
              [](float x) {
                return Numbers4{nan, x, nan, x};
              }),
      special("infinity - infinity", "NaN", "0", Operation::add,
              [](float) {
                return Numbers4{infinity, -infinity, nan, 0.0F};
              }),
      special("a loop of 100,000 turns", "all of them", "left after 65,535", Operation::turns, [](float) {
        return Numbers4{100'000.0F, 1.0F, 100'000.0F, 65'535.0F};
      })};
  questions[1].row.agreement_needs_it = true; // the specification's chains are such
  return questions;
}

/// Any NaN is like another. -0 is 0 in a sweep, as everywhere else, but not where an operation is asked for:
/// there only bits are compared, because this program is built without signed zeros.
bool same(float a, float b, bool zero_has_sign) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (!zero_has_sign && a == b) ||
         (std::isnan(a) && std::isnan(b));
}

/// Units in the last place of the correctly rounded number.
double error_of(const Answers& its, float found) {
  if (!std::isfinite(found)) {
    return std::numeric_limits<double>::infinity();
  }
  const long double unit = std::ldexp(1.0L, std::ilogb(its.specified) - 23);
  return static_cast<double>(std::abs(static_cast<long double>(found) - its.exact) / unit);
}

ProbeRow judged(const Question& question, std::span<const float> found) {
  ProbeRow row = question.row;
  const bool about_rounding = question.about_rounding;
  const bool signs = question.zero_has_sign;
  std::int64_t strange = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < question.answers.size(); ++i) {
    const Answers& its = question.answers[i];
    const bool right = same(found[i], its.specified, signs);
    const bool other = about_rounding ? !right : same(found[i], its.other, signs);
    strange += right || other ? 0 : 1;
    if (about_rounding || !same(its.specified, its.other, signs)) {
      ++row.telling;
      row.specified += right ? 1 : 0;
      row.other += other ? 1 : 0;
      worst = about_rounding ? std::max(worst, error_of(its, found[i])) : worst;
    }
  }
  if (about_rounding && std::isfinite(worst)) {
    row.ulp = worst;
  }
  row.answer = row.telling == 0                              ? ProbeAnswer::untold
               : strange > 0 || !std::isfinite(worst)        ? ProbeAnswer::neither
               : row.specified == row.telling                ? ProbeAnswer::as_specified
               : row.other == row.telling && !about_rounding ? ProbeAnswer::otherwise
                                                             : ProbeAnswer::mixed;
  return row;
}

/// One sweep by this rule, with a tenth of the components observed. What a candidate comes to shows only
/// where two nearly tie: everything on a grid of 0.1 with one modulus. A minimiser shows every rounding.
ProbeRow fused_in_sweep(std::string text, Rule rule, Session& session) {
  const bool ties = rule != Rule::closed_form;
  const double grid = ties ? 0.1 : 0.001;
  const double reach = ties ? 0.5 : 10.0; // pixels
  std::mt19937_64 engine(1);
  const auto on_grid = [&] {
    const double uniform = static_cast<double>(engine() >> 11) * 0x1p-53; // the same everywhere
    return static_cast<float>(grid * std::round(reach * (2.0 * uniform - 1.0) / grid));
  };
  Level level;
  level.extent = extent;
  VectorField before = level.target = level.confidence = VectorField(extent);
  level.modulus = ScalarField(extent, 1.0F);
  level.rule = rule;
  level.strengths = ties ? std::vector<float>{} : std::vector<float>{0.9F};
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    before[0][i] = on_grid();
    before[1][i] = on_grid();
    level.modulus.values[i] = ties ? 1.0F : 0.5F + static_cast<float>(engine() % 1000) / 700.0F;
    level.target[0][i] = static_cast<float>(grid * static_cast<double>(engine() % 10));
    level.confidence[0][i] = engine() % 10 == 0 ? 0.7F : 0.0F;
  }
  set_inverse_modulus(level);
  if (needs_inverse_curvature(rule)) {
    set_inverse_curvature(level);
  }
  VectorField swept;
  session.load(level);
  session.write(before);
  session.step(1);
  session.read(swept);
  Question question{
      .row = {.question = std::move(text), .as_specified = "rounded twice", .otherwise = "fused"},
      .zero_has_sign = false};
  std::vector<float> found;
  for_each_site(extent, [&](int x, int y) {
    const SiteAnswer specified = proofs_of(level).specified_answer(level, before, 0, x, y, 0);
    const rewritten::Replay replay(rewritten::all_fused);
    const SiteAnswer fused = proofs_of(level).replayed_answer(level, before, 0, x, y, 0);
    for (std::size_t axis = 0; axis < extent.axes(); ++axis) {
      question.answers.push_back({specified[axis], fused[axis]});
      found.push_back(swept[axis][extent.index(x, y)]);
    }
  });
  return judged(question, found);
}

/// A driver that refuses the program has still answered by its sweep.
std::vector<ProbeRow> arithmetic_rows(const ArithmeticProgram& program, const Device& device,
                                      const std::vector<Device>& all) {
  try {
    const auto index = std::ranges::find_if(
        all, [&](const Device& one) { return one.name == device.name && one.driver == device.driver; });
    return probe_arithmetic(program, static_cast<std::size_t>(index - all.begin()));
  } catch (const DeviceError& error) {
    return {{.program = std::string(program.language()),
             .question = "a program of its own",
             .as_specified = "runs",
             .otherwise = error.what(),
             .answer = ProbeAnswer::otherwise,
             .telling = 1,
             .other = 1,
             .agreement_needs_it = false}};
  }
}

} // namespace

void to_json(nlohmann::json& written, const ProbeRow& row) {
  written = {{"backend", row.backend},
             {"device", row.device},
             {"driver", row.driver},
             {"program", row.program},
             {"question", row.question},
             {"as_specified", row.as_specified},
             {"otherwise", row.otherwise},
             {"answer", probe_answer_names.at(static_cast<std::size_t>(row.answer))},
             {"telling", row.telling},
             {"specified", row.specified},
             {"other", row.other},
             {"ulp", row.ulp},
             {"agreement_needs_it", row.agreement_needs_it}};
}

std::vector<ProbeRow> probe_arithmetic(const ArithmeticProgram& program, std::size_t device) {
  const std::vector<Question> all = questions_of_operations();
  std::vector<ArithmeticCase> cases;
  for (const Question& question : all) {
    cases.insert(cases.end(), question.cases.begin(), question.cases.end());
  }
  cases.resize((cases.size() + cases_at_once - 1) / cases_at_once * cases_at_once,
               arithmetic_case(Operation::hand_on, 0.0F));
  const std::vector<float> found = program.evaluate(device, cases);
  std::vector<ProbeRow> rows;
  std::size_t begin = 0;
  for (const Question& question : all) {
    rows.push_back(judged(question, std::span(found).subspan(begin, question.cases.size())));
    rows.back().program = program.language();
    begin += question.cases.size();
  }
  return rows;
}

std::vector<OperationQuestion> operation_questions() {
  std::vector<OperationQuestion> asked;
  for (const Question& question : questions_of_operations()) {
    if (!question.about_rounding) {
      const ProbeRow& row = question.row;
      OperationQuestion& one = asked.emplace_back(
          OperationQuestion{row.question, row.as_specified, row.otherwise, question.cases, {}, {}});
      for (const Answers& its : question.answers) {
        one.specified.push_back(its.specified);
        one.other.push_back(its.other);
      }
    }
  }
  return asked;
}

std::vector<ProbeRow> probe(const Backend& backend, const SessionOptions& options) {
  const Device device = backend.device(options);
  const std::unique_ptr<Session> session = backend.open(options);
  std::vector<ProbeRow> rows{fused_in_sweep("a * b + c, candidates", Rule::steps, *session),
                             fused_in_sweep("a * b + c, closed form", Rule::closed_form, *session)};
  if (const auto* const program = dynamic_cast<const ArithmeticProgram*>(&backend)) {
    std::ranges::move(arithmetic_rows(*program, device, backend.devices()), std::back_inserter(rows));
  }
  for (ProbeRow& row : rows) {
    row.backend = backend.name();
    row.device = device.name;
    row.driver = device.driver;
  }
  return rows;
}

std::string answer_text(const ProbeRow& row) {
  if (row.ulp && row.answer != ProbeAnswer::as_specified) {
    return fmt::format("up to {:.3g} ulp off, {} of {} correct", *row.ulp, row.specified, row.telling);
  }
  switch (row.answer) {
  case ProbeAnswer::as_specified:
    return row.as_specified;
  case ProbeAnswer::otherwise:
    return row.otherwise;
  case ProbeAnswer::mixed:
    return fmt::format("{} in {} of {}", row.otherwise, row.other, row.telling);
  case ProbeAnswer::neither: // such as flushed on the way
    return "neither of the two";
  default:
    return "cannot tell";
  }
}

std::string findings(const std::vector<ProbeRow>& rows) {
  std::string text;
  for (const ProbeRow& row : rows) {
    if (row.answer != ProbeAnswer::as_specified) {
      text +=
          fmt::format("{}{}: {}: {}", text.empty() ? "" : "; ", row.program, row.question, answer_text(row));
    }
  }
  return text;
}

std::string expected_tier(const std::vector<ProbeRow>& rows) {
  for (const ProbeRow& row : rows) {
    if (row.agreement_needs_it && row.answer != ProbeAnswer::as_specified) {
      return fmt::format("certified: {}: {}", row.question, answer_text(row));
    }
  }
  const bool flushes = std::ranges::any_of(rows, [](const ProbeRow& row) {
    return row.question.starts_with("subnormal") && row.answer != ProbeAnswer::as_specified;
  });
  return fmt::format("bitwise: operations are rounded one by one, in the order written{}",
                     flushes ? "; but numbers below 1e-38 may be taken for 0" : "");
}

} // namespace hdmbench
