#include "harness/check/probe.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace hdmbench {

namespace {

/// What a case can come to.
struct Answers {
  float specified;
  float other;             ///< of questions with two answers
  long double exact = 0.0; ///< of those about rounding
};

struct Question {
  std::string text;
  std::string as_specified;
  std::string otherwise; ///< empty: about rounding
  bool agreement_needs_it = false;
  std::vector<ArithmeticCase> cases{};
  std::vector<Answers> answers{};

  void add(const ArithmeticCase& one, const Answers& its) {
    cases.push_back(one);
    answers.push_back(its);
  }
};

/// Seeded, the same everywhere.
class Numbers {
public:
  /// 1 <= x < 2, every bit drawn.
  float significand() {
    return std::bit_cast<float>(0x3f800000U | static_cast<std::uint32_t>(engine_() >> 41));
  }
  /// The same times a power of two.
  float of_any_size(int exponents) {
    const auto exponent = static_cast<int>(engine_() % static_cast<unsigned>(2 * exponents + 1)) - exponents;
    return std::ldexp(significand(), exponent);
  }

private:
  std::mt19937_64 engine_{3};
};

constexpr int cases_of_a_question = 256;

/// What is subtracted is the rounded product: 0, or what rounding took away from it.
Question fusing(std::string text, Operation operation, bool agreement_needs_it) {
  Question question{.text = std::move(text),
                    .as_specified = "rounded twice",
                    .otherwise = "fused",
                    .agreement_needs_it = agreement_needs_it};
  Numbers draw;
  for (int i = 0; i < cases_of_a_question; ++i) {
    const float a = draw.significand();
    const float b = draw.significand();
    const float product = a * b;
    question.add(arithmetic_case(operation, a, b, -product), {0.0F, std::fma(a, b, -product)});
  }
  return question;
}

Question reordering(std::string text, Operation operation) {
  Question question{
      .text = std::move(text), .as_specified = "in this order", .otherwise = "(a * b + e) + c * d"};
  Numbers draw;
  for (int i = 0; i < cases_of_a_question; ++i) {
    const float a = draw.significand();
    const float b = draw.significand();
    const float c = 0.01F * draw.significand();
    const float d = draw.significand();
    const float first = a * b;
    const float second = c * d;
    const float sum = first + second;
    question.add(arithmetic_case(operation, a, b, c, d, -first), {sum - first, second});
  }
  return question;
}

/// `draw` gives a and b, `exact` the result as near as a long double has it.
Question rounding(std::string text, Operation operation,
                  const std::function<std::pair<float, float>(Numbers&)>& draw,
                  const std::function<long double(long double, long double)>& exact) {
  Question question{.text = std::move(text), .as_specified = "correctly rounded", .otherwise = ""};
  Numbers numbers;
  for (int i = 0; i < cases_of_a_question; ++i) {
    const auto [a, b] = draw(numbers);
    const long double result = exact(a, b);
    const auto rounded = static_cast<float>(result);
    question.add(arithmetic_case(operation, a, b), {rounded, rounded, result});
  }
  return question;
}

/// One number of a kind, sixteen times with other significands where it has one.
Question special(std::string text, std::string as_specified, std::string otherwise,
                 const std::function<std::pair<ArithmeticCase, Answers>(float significand)>& make) {
  Question question{
      .text = std::move(text), .as_specified = std::move(as_specified), .otherwise = std::move(otherwise)};
  Numbers draw;
  for (int i = 0; i < 16; ++i) {
    const auto [one, its] = make(draw.significand());
    question.add(one, its);
  }
  return question;
}

std::vector<Question> questions() {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr int exponents = 20;
  const auto any_two = [](Numbers& draw) {
    const float a = draw.of_any_size(exponents);
    return std::pair{a, draw.of_any_size(exponents)};
  };
  return {
      fusing("a * b + c", Operation::multiply_add, false),
      fusing("a * b + c, precise", Operation::precise_chain, true),
      reordering("(a * b + c * d) + e", Operation::sum_of_products),
      reordering("(a * b + c * d) + e, precise", Operation::precise_sum),
      rounding("a / b", Operation::divide, any_two, [](long double a, long double b) { return a / b; }),
      rounding("1 / a", Operation::reciprocal, any_two, [](long double a, long double) { return 1.0L / a; }),
      rounding("sqrt(a)", Operation::square_root, any_two,
               [](long double a, long double) { return std::sqrt(a); }),
      rounding(
          "exp(a), -8 ... 8", Operation::exponential,
          [](Numbers& draw) {
            return std::pair{16.0F * (draw.significand() - 1.5F), 0.0F};
          },
          [](long double a, long double) { return std::exp(a); }),
      special(
          "subnormal operand", "kept", "taken for 0",
          [](float x) {
            const float a = x * 0x1p-130F;
            return std::pair{arithmetic_case(Operation::multiply, a, 0x1p+30F), Answers{a * 0x1p+30F, 0.0F}};
          }),
      special(
          "subnormal result", "kept", "flushed to 0",
          [](float x) {
            const float a = x * 0x1p-100F;
            return std::pair{arithmetic_case(Operation::multiply, a, 0x1p-30F), Answers{a * 0x1p-30F, 0.0F}};
          }),
      special("subnormal handed on", "kept", "flushed to 0",
              [](float x) {
                const float a = x * 0x1p-130F;
                return std::pair{arithmetic_case(Operation::hand_on, a), Answers{a, 0.0F}};
              }),
      special("-0 * a", "-0", "+0",
              [](float x) {
                return std::pair{arithmetic_case(Operation::multiply, -0.0F, x), Answers{-0.0F, 0.0F}};
              }),
      special("infinity + a", "infinity", "the largest number",
              [=](float x) {
                return std::pair{arithmetic_case(Operation::add, infinity, x),
                                 Answers{infinity, std::numeric_limits<float>::max()}};
              }),
      special("NaN + a", "NaN", "a",
              [=](float x) {
                return std::pair{arithmetic_case(Operation::add, nan, x), Answers{nan, x}};
              }),
      special("infinity - infinity", "NaN", "0",
              [=](float) {
                return std::pair{arithmetic_case(Operation::add, infinity, -infinity), Answers{nan, 0.0F}};
              }),
      special("a loop of 100,000 turns", "all of them", "left after 65,535", [](float) {
        return std::pair{arithmetic_case(Operation::turns, 100'000.0F, 1.0F), Answers{100'000.0F, 65'535.0F}};
      })};
}

/// -0 is not 0 here, and any NaN is like another.
bool same(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) ||
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
  ProbeRow row{.question = question.text,
               .as_specified = question.as_specified,
               .otherwise = question.otherwise.empty() ? "rounded otherwise" : question.otherwise,
               .agreement_needs_it = question.agreement_needs_it};
  const bool about_rounding = question.otherwise.empty();
  std::int64_t strange = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < question.answers.size(); ++i) {
    const Answers& its = question.answers[i];
    const bool right = same(found[i], its.specified);
    if (about_rounding) {
      worst = std::max(worst, error_of(its, found[i]));
      ++row.telling;
      row.specified += right ? 1 : 0;
      row.other += right ? 0 : 1;
    } else {
      strange += right || same(found[i], its.other) ? 0 : 1;
      if (!same(its.specified, its.other)) {
        ++row.telling;
        row.specified += right ? 1 : 0;
        row.other += same(found[i], its.other) ? 1 : 0;
      }
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

} // namespace

std::vector<ProbeRow> probe_arithmetic(const ArithmeticProgram& program, std::size_t device) {
  const std::vector<Question> all = questions();
  std::vector<ArithmeticCase> cases;
  for (const Question& question : all) {
    cases.insert(cases.end(), question.cases.begin(), question.cases.end());
  }
  const std::size_t asked = cases.size();
  cases.resize((asked + cases_at_once - 1) / cases_at_once * cases_at_once,
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

} // namespace hdmbench
