#include "test/r300/instruction_rows.hpp"

#include "backends/gl/elastic_fragment.hpp"
#include "backends/gl/objects.hpp"
#include "harness/scene/method.hpp"
#include "test/r300/scalar_operations.hpp"
#include "test/r300/vector_candidates.hpp"

#include <fmt/format.h>
#include <shaders/count_fragment.hpp>
#include <shaders/sweep_fragment.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace hdmbench::test {

namespace {

InstructionRow measure(ShaderCompiler& compiler, InstructionRow row, std::string source) {
  row.compilation = compiler.compile(source);
  row.source = std::move(source);
  return row;
}

/// What gl-fragment sends for a sweep of `level`.
InstructionRow measure_sweep(ShaderCompiler& compiler, InstructionRow row, const Level& level) {
  const bool has_candidates = level.rule == Rule::steps || level.rule == Rule::annealing;
  row.candidates = has_candidates ? level.steps.count() : 0;
  return measure(compiler, std::move(row), gl::assemble(sources::sweep_fragment, shader_constants(level)));
}

/// What gl-fragment sends for a method, none where it does not support it.
std::optional<InstructionRow> measure_method(ShaderCompiler& compiler, const Method& method, StepSet steps,
                                             std::string shader) {
  Schedule schedule;
  Level level{.extent = {}, .steps = steps};
  method.configure(schedule, level);
  if (level.update == Update::sequential) {
    return std::nullopt;
  }
  return measure_sweep(compiler, {.group = "methods", .shader = std::move(shader)},
                       {.extent = {}, .steps = level.steps, .update = level.update, .rule = schedule.rule});
}

/// `count` different candidates, 0 first.
StepSet some_steps(int count) {
  std::vector<float> steps;
  for (int i = 0; i < count; ++i) {
    steps.push_back(static_cast<float>(i));
  }
  return StepSet(steps);
}

/// The passes of gl-fragment for the elastic energy.
std::vector<InstructionRow> measure_elastic(ShaderCompiler& compiler) {
  const std::array<std::pair<const char*, ElasticKernel>, 9> kernels{{
      {"elastic, a sweep of the displacement", {.step = ElasticStep::relax}},
      {"elastic, a sweep of a correction", {.step = ElasticStep::relax, .has_load = true}},
      {"elastic, the same beside conditions",
       {.step = ElasticStep::relax, .has_load = true, .masks = ElasticMasks::anyhow}},
      {"elastic, the first sweep of a correction", {.step = ElasticStep::relax_from_zero}},
      {"elastic, residuals of the image",
       {.step = ElasticStep::residual, .has_load = true, .is_image = true}},
      {"elastic, restriction", {.step = ElasticStep::restrict_sites}},
      {"elastic, interpolation", {.step = ElasticStep::correct}},
      {"elastic, the coarsest level", {.step = ElasticStep::solve}},
      {"elastic, products of a sum", {.step = ElasticStep::products}},
  }};
  std::vector<InstructionRow> rows;
  for (const auto& [name, kernel] : kernels) {
    rows.push_back(
        measure(compiler, {.group = "methods", .shader = name}, gl::elastic_fragment_text(kernel)));
  }
  return rows;
}

} // namespace

std::vector<InstructionRow> measure_candidates(ShaderCompiler& compiler) {
  std::vector<InstructionRow> rows;
  for (int count = 2; count <= StepSet::maximum_count; ++count) {
    std::string names;
    for (const char* const name : {"default", "thesis", "fine"}) {
      if (StepSet::parse(name).count() == count) {
        names += fmt::format("{}--steps {}", names.empty() ? "" : ", ", name);
      }
    }
    rows.push_back(measure_sweep(compiler, {.group = "candidates", .shader = names},
                                 {.extent = {}, .steps = some_steps(count)}));
  }
  return rows;
}

std::vector<InstructionRow> measure_methods(ShaderCompiler& compiler) {
  std::vector<InstructionRow> rows;
  for (const Method& method : methods()) {
    if (auto row = measure_method(compiler, method, StepSet(), std::string(method.name))) {
      rows.push_back(std::move(*row));
    }
  }
  rows.push_back(measure(compiler, {.group = "methods", .shader = "the count of changed sites"},
                         gl::assemble(sources::count_fragment, "")));
  // The longest shader of all. Of the sets larger than its usual one, the largest that fits and the first
  // that does not, if there is one. It leaves out the 0.
  const std::string larger = "annealing, more candidates";
  for (int count = StepSet().count() + 1; count <= StepSet::maximum_count; ++count) {
    InstructionRow row =
        measure_method(compiler, find_method("annealing"), some_steps(count), larger).value();
    const bool fits = row.compilation.resources.has_value();
    if (fits && rows.back().shader == larger) {
      rows.pop_back();
    }
    rows.push_back(std::move(row));
    if (!fits) {
      break;
    }
  }
  std::ranges::move(measure_elastic(compiler), std::back_inserter(rows));
  return rows;
}

std::vector<InstructionRow> measure_vectors(ShaderCompiler& compiler) {
  std::vector<InstructionRow> rows;
  const auto add = [&](const char* name, int count, Energy energy, const std::vector<Candidate>& vectors) {
    rows.push_back(measure(compiler,
                           {.group = "vectors",
                            .shader = name,
                            .candidates = count,
                            .energies = static_cast<int>(vectors.size())},
                           vector_candidates_shader(energy, vectors)));
  };
  const char* const as_printed = "equations as printed";
  for (int count = 2; count <= 6; ++count) {
    add(as_printed, count, Energy::as_printed, product_set(uniform_steps(count)));
    if (count == 4) { // one vector more: which limit is met first
      std::vector<Candidate> one_more = product_set(uniform_steps(5));
      one_more.resize(4 * 4 + 1);
      add(as_printed, 5, Energy::as_printed, one_more);
    }
  }
  for (const int count : {4, 6}) {
    add("equations as printed, step sizes as literals", count, Energy::as_printed,
        product_set(literal_steps(count)));
  }
  for (int count = 2; count <= 6; ++count) {
    add("energy.inc's site_energy on two-vectors", count, Energy::site_energy,
        product_set(uniform_steps(count)));
  }
  for (int count = 2; count <= 6; ++count) {
    add("energy.inc's site_energy on scalars", count, Energy::site_energy_on_scalars,
        product_set(uniform_steps(count)));
  }
  for (const int count : {4, 6}) {
    add("equations as printed, x and y in step", count, Energy::as_printed,
        diagonal_set(uniform_steps(count)));
  }
  return rows;
}

void add_second_opinions(std::vector<InstructionRow>& rows, Progress& progress) {
  for (InstructionRow& row : rows) {
    const std::optional<Resources>& resources = row.compilation.resources;
    if (!resources || resources->flow_control == 0) { // operations of a loop cannot be counted
      row.scalar_operations = scalar_operations(row.source);
    }
    progress.advance(1.0);
  }
}

nlohmann::json to_json(const InstructionRow& row, const ShaderCompiler& compiler) {
  const auto& [resources, refusal] = row.compilation;
  const auto of = [&](int Resources::*number) {
    return resources ? nlohmann::json((*resources).*number) : nlohmann::json();
  };
  return {{"group", row.group},
          {"shader", row.shader},
          {"candidates", row.candidates},
          {"energies", row.energies},
          {"instructions", of(&Resources::instructions)},
          {"texture_instructions", of(&Resources::texture_instructions)},
          {"temporaries", of(&Resources::temporaries)},
          {"flow_control", of(&Resources::flow_control)},
          {"refusal", refusal},
          {"scalar_operations",
           row.scalar_operations ? nlohmann::json(*row.scalar_operations) : nlohmann::json()},
          {"device", compiler.device().name},
          {"driver", compiler.device().driver},
          {"instructions_limit", compiler.limits().instructions},
          {"temporaries_limit", compiler.limits().temporaries}};
}

} // namespace hdmbench::test
