#include "harness/check/probe.hpp"

#include "harness/check/energy_proofs.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace hdmbench {

namespace {

constexpr Extent extent{32, 32};

struct Question {
  std::string text;
  std::string as_specified;
  std::string otherwise;
  Level level;
  VectorField before;
  /// The other case's answer where the specification's is `specified`.
  std::function<SiteAnswer(const Question& question, SiteAnswer specified, int x, int y)> other;
  bool agreement_needs_it = true;
};

/// One modulus, nothing observed, the displacements of `value` drawn at every site.
template <typename Value>
Question question_of(const StepSet& steps, Rule rule, Value value) {
  std::mt19937_64 engine(1);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; }; // the same everywhere
  Question question;
  Level& level = question.level;
  level.extent = extent;
  level.target = level.confidence = question.before = VectorField(extent);
  level.modulus = ScalarField(extent, 1.0F);
  level.steps = steps;
  level.rule = rule;
  if (rule != Rule::steps) {
    level.strengths = {0.9F};
  }
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    question.before.x[i] = static_cast<float>(value(uniform()));
    question.before.y[i] = static_cast<float>(value(uniform()));
  }
  return question;
}

/// A tenth of the components observed. What a candidate comes to shows only where two nearly tie: everything
/// on a grid of 0.1 with one modulus. A minimiser shows every rounding.
Question fusing(std::string_view text, Rule rule) {
  const bool ties = rule != Rule::closed_form;
  const double grid = ties ? 0.1 : 0.001;
  const double reach = ties ? 0.5 : 10.0; // pixels
  Question question = question_of(
      StepSet(), rule, [=](double draw) { return grid * std::round(reach * (2.0 * draw - 1.0) / grid); });
  std::mt19937_64 engine(2);
  Level& level = question.level;
  for (std::size_t i = 0; i < extent.sites(); ++i) {
    level.modulus.values[i] = ties ? 1.0F : 0.5F + static_cast<float>(engine() % 1000) / 700.0F;
    level.target.x[i] = static_cast<float>(grid * static_cast<double>(engine() % 10));
    level.confidence.x[i] = engine() % 10 == 0 ? 0.7F : 0.0F;
  }
  question.text = fmt::format("a * b + c, {}", text);
  question.as_specified = "rounded twice";
  question.otherwise = "fused";
  question.other = [](const Question& asked, SiteAnswer, int x, int y) {
    return proofs_of(*asked.level.energy).fused_answer(asked.level, asked.before, 0, x, y);
  };
  return question;
}

float without_subnormal(float value) {
  return std::fpclassify(value) == FP_SUBNORMAL ? std::copysign(0.0F, value) : value;
}

const StepSet& stay() {
  static const StepSet steps{std::array{0.0F}};
  return steps;
}

/// A sweep whose only candidate is 0 hands every component on.
Question passing(std::string text, float value, std::string as_specified, float other,
                 std::string otherwise) {
  Question question = question_of(stay(), Rule::steps, [=](double) { return value; });
  question.text = std::move(text);
  question.as_specified = std::move(as_specified);
  question.otherwise = std::move(otherwise);
  question.other = [=](const Question&, SiteAnswer, int, int) { return SiteAnswer{other, other}; };
  question.agreement_needs_it = false;
  return question;
}

/// The minimiser between neighbours of opposite signs, all near the smallest normal number.
Question small_results(std::string as_specified, std::string otherwise) {
  Question question =
      question_of(stay(), Rule::closed_form, [](double draw) { return (1.5 + draw) * 0x1p-126; });
  question.text = "subnormal result";
  question.as_specified = std::move(as_specified);
  question.otherwise = std::move(otherwise);
  question.other = [](const Question&, SiteAnswer specified, int, int) {
    return SiteAnswer{without_subnormal(specified.x), without_subnormal(specified.y)};
  };
  for_each_site(extent, [&](int x, int y) {
    const float sign = (x + y) % 2 == 0 ? 1.0F : -1.0F;
    question.before.x[extent.index(x, y)] *= sign;
    question.before.y[extent.index(x, y)] *= sign;
  });
  question.agreement_needs_it = false;
  return question;
}

std::vector<Question> questions() {
  return {fusing("candidates", Rule::steps), fusing("closed form", Rule::closed_form),
          passing("subnormal + 0", 3e-40F, "kept", 0.0F, "flushed to 0"),
          small_results("kept", "flushed to 0"),
          passing("infinity + 0", std::numeric_limits<float>::infinity(), "infinity", 0.0F, "0")};
}

/// -0 equals 0, as everywhere here.
bool same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

void judge(const Question& question, const VectorField& found, ProbeRow& row) {
  std::int64_t strange = 0;
  const auto judge_component = [&](float specified, float other, float answer) {
    strange += same(answer, specified) || same(answer, other) ? 0 : 1;
    if (!same(specified, other)) {
      ++row.telling;
      row.specified += same(answer, specified) ? 1 : 0;
      row.other += same(answer, other) ? 1 : 0;
    }
  };
  for_each_site(extent, [&](int x, int y) {
    const std::size_t at = extent.index(x, y);
    const SiteAnswer specified = specified_answer(question.level, question.before, 0, x, y);
    const SiteAnswer other = question.other(question, specified, x, y);
    judge_component(specified.x, other.x, found.x[at]);
    judge_component(specified.y, other.y, found.y[at]);
  });
  row.answer = row.telling == 0               ? ProbeAnswer::untold
               : strange > 0                  ? ProbeAnswer::neither
               : row.specified == row.telling ? ProbeAnswer::as_specified
               : row.other == row.telling     ? ProbeAnswer::otherwise
                                              : ProbeAnswer::mixed;
}

std::size_t index_of(const Device& device, const std::vector<Device>& all) {
  const auto same = [&](const Device& one) { return one.name == device.name && one.driver == device.driver; };
  return static_cast<std::size_t>(std::ranges::find_if(all, same) - all.begin());
}

/// A driver that refuses the program has still answered by its sweep.
std::vector<ProbeRow> arithmetic_rows(const ArithmeticProgram& program, std::size_t device) {
  try {
    return probe_arithmetic(program, device);
  } catch (const DeviceError& error) {
    return {{.program = std::string(program.language()),
             .question = "a program of its own",
             .as_specified = "runs",
             .otherwise = error.what(),
             .answer = ProbeAnswer::otherwise,
             .telling = 1,
             .specified = 0,
             .other = 1,
             .agreement_needs_it = false}};
  }
}

} // namespace

void list_fields(Fields& fields, ProbeRow& row) {
  fields("backend", row.backend);
  fields("device", row.device);
  fields("driver", row.driver);
  fields("program", row.program);
  fields("question", row.question);
  fields("as_specified", row.as_specified);
  fields("otherwise", row.otherwise);
  fields("answer", row.answer);
  fields("telling", row.telling);
  fields("specified", row.specified);
  fields("other", row.other);
  fields("ulp", row.ulp);
  fields("agreement_needs_it", row.agreement_needs_it);
}

std::vector<ProbeRow> probe(const Backend& backend, const SessionOptions& options) {
  const Device device = backend.device(options);
  const std::unique_ptr<Session> session = backend.open(options);
  std::vector<ProbeRow> rows;
  for (Question& question : questions()) {
    set_inverse_modulus(question.level);
    if (needs_inverse_curvature(question.level.rule)) {
      set_inverse_curvature(question.level);
    }
    ProbeRow row{.backend = std::string(backend.name()),
                 .device = device.name,
                 .driver = device.driver,
                 .question = question.text,
                 .as_specified = question.as_specified,
                 .otherwise = question.otherwise,
                 .agreement_needs_it = question.agreement_needs_it};
    VectorField found;
    session->load(question.level);
    session->write(question.before);
    session->step(1);
    session->read(found);
    judge(question, found, row);
    rows.push_back(std::move(row));
  }
  if (const auto* const program = dynamic_cast<const ArithmeticProgram*>(&backend)) {
    for (ProbeRow& row : arithmetic_rows(*program, index_of(device, backend.devices()))) {
      row.backend = backend.name();
      row.device = device.name;
      row.driver = device.driver;
      rows.push_back(std::move(row));
    }
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
