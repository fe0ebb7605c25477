#include "harness/check/golden.hpp"

#include "harness/check/state_hash.hpp"
#include "harness/scene/level_sequence.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hdmbench {

namespace {

/// The first level in which they differ.
std::optional<GoldenLevel> first_difference(std::span<const GoldenLevel> expected,
                                            std::span<const GoldenLevel> found) {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (i >= found.size() || found[i] != expected[i]) {
      return expected[i];
    }
  }
  return found.size() > expected.size() ? std::optional(found[expected.size()]) : std::nullopt;
}

std::string describe(const GoldenLevel& expected, std::span<const GoldenLevel> found) {
  const auto same = std::ranges::find(found, expected.level, &GoldenLevel::level);
  if (same == found.end()) {
    return fmt::format("level {} is missing", expected.level);
  }
  if (same->iterations != expected.iterations) {
    return fmt::format("level {}: {} iterations in place of {}", expected.level, same->iterations,
                       expected.iterations);
  }
  if (same->hash == expected.hash) {
    return fmt::format("level {} should not be there", expected.level);
  }
  return fmt::format("level {}: {:016x} in place of {:016x}", expected.level, same->hash, expected.hash);
}

GoldenOutcome solve(const Scene& scene, GoldenSolver& solver, Progress& progress) {
  GoldenOutcome outcome{.backend = std::string(solver.backend().name()),
                        .device = solver.device(),
                        .reason = solver.absence(scene)};
  if (outcome.reason.empty()) {
    progress.describe(fmt::format("golden {}, {} x {}, {} on {}", scene.name, scene.extent().width,
                                  scene.extent().height, scene.schedule.method, outcome.backend));
    outcome.verdict = Verdict::agree; // until compared
    try {
      outcome.levels = solver.solve(scene, progress);
      outcome.in_one_piece = solver.solve_in_one_piece(scene);
    } catch (const NotFinite& error) {
      outcome.verdict = Verdict::disagree;
      outcome.reason = error.what();
    }
  }
  return outcome;
}

/// Whether the last field is the same level by level and in one piece, where it was made in one.
bool is_the_same_in_one_piece(const GoldenOutcome& outcome) {
  return !outcome.in_one_piece ||
         (!outcome.levels.empty() && outcome.in_one_piece == outcome.levels.back().hash);
}

/// Gives a solved outcome its verdict.
void judge(GoldenOutcome& outcome, std::span<const GoldenLevel> expected, bool is_golden) {
  if (const auto first = first_difference(expected, outcome.levels)) {
    outcome.verdict = Verdict::disagree;
    outcome.first_difference = first->level;
    outcome.reason = describe(*first, outcome.levels) + (is_golden ? "" : " (scalar's)");
  } else if (!is_the_same_in_one_piece(outcome)) {
    outcome.verdict = Verdict::disagree;
    outcome.first_difference = outcome.levels.back().level;
    outcome.reason = fmt::format("in one piece: {:016x} in place of {:016x}, which it is level by level",
                                 *outcome.in_one_piece, outcome.levels.back().hash);
  } else if (!is_golden) {
    outcome.verdict = Verdict::mistrusted;
    outcome.reason = "as scalar, but there is nothing golden to compare with";
  }
}

} // namespace

GoldenInputs hash_inputs(const Scene& scene) {
  StateHash hash;
  hash.add(scene.full.target);
  hash.add(scene.full.confidence);
  hash.add(scene.full.modulus);
  hash.add(scene.full.penalty);
  hash.add(scene.full.steps.values());
  hash.add(scene.start_field());
  GoldenInputs inputs{.scene = hash.value(), .levels = {}};
  if (scene.energy == EnergyModel::elastic) {
    inputs.levels = {hierarchy_hash(make_elastic_hierarchy(scene.full, scene.poisson))};
  } else {
    LevelSequence levels(scene);
    for (const int index : levels.order()) {
      inputs.levels.push_back(level_hash(levels.sample(index)));
    }
  }
  return inputs;
}

std::string inputs_difference(const GoldenInputs& golden, const GoldenInputs& found) {
  if (found.scene != golden.scene) {
    return fmt::format("the scene itself is another one ({:016x} in place of {:016x}): libm, ITK or its file",
                       found.scene, golden.scene);
  }
  if (found.levels.size() != golden.levels.size()) {
    return fmt::format("{} levels in place of {}", found.levels.size(), golden.levels.size());
  }
  const auto [mine, theirs] = std::ranges::mismatch(found.levels, golden.levels);
  if (mine != found.levels.end()) {
    return fmt::format("what level number {} of {}, the coarsest first, is loaded with ({:016x} in place of "
                       "{:016x}): sampling, 1/A or strengths",
                       mine - found.levels.begin() + 1, found.levels.size(), *mine, *theirs);
  }
  return {};
}

GoldenSolver::GoldenSolver(const Backend& backend, const SessionOptions& options) : backend_(&backend) {
  try {
    device_ = backend.device(options);
    (void)backend.open(options);
    solver_ = std::make_unique<Solver>(backend, options);
  } catch (const DeviceError& error) {
    absence_ = error.what();
  }
}

std::string GoldenSolver::absence(const Scene& scene) const {
  return absence_.empty() ? why_not_solved(scene, *backend_) : absence_;
}

std::vector<GoldenLevel> GoldenSolver::solve(const Scene& scene, Progress& progress) {
  std::vector<GoldenLevel> levels;
  const auto add = [&](const LevelResult& result, const VectorField& displacement) {
    try {
      levels.push_back({result.level, result.iterations, state_hash(displacement)});
    } catch (const NotFinite& error) {
      throw NotFinite(fmt::format("level {}: {}", result.level, error.what()));
    }
  };
  (void)solver_->solve(scene, progress, {.level_done = add});
  return levels;
}

std::optional<std::uint64_t> GoldenSolver::solve_in_one_piece(const Scene& scene) {
  if (scene.energy == EnergyModel::elastic || !LevelSequence(scene).pyramid()) {
    return std::nullopt;
  }
  Progress silent(false);
  try {
    return state_hash(solver_->solve(scene, silent).displacement);
  } catch (const NotFinite& error) {
    throw NotFinite(fmt::format("in one piece: {}", error.what()));
  }
}

GoldenResult check_golden(const Scene& scene, std::span<GoldenSolver> solvers, const GoldenEntry* golden,
                          Progress& progress) {
  GoldenResult result{.problem = case_of(scene), .inputs = hash_inputs(scene), .known = golden != nullptr};
  result.inputs_reason =
      result.known ? inputs_difference(golden->inputs, result.inputs) : "there are no golden hashes";
  for (GoldenSolver& solver : solvers) {
    result.outcomes.push_back(solve(scene, solver, progress));
  }
  const bool is_golden = golden != nullptr && result.inputs_reason.empty();
  const std::vector<GoldenLevel> expected = is_golden ? golden->levels : result.outcomes.front().levels;
  for (GoldenOutcome& outcome : result.outcomes) {
    if (outcome.verdict == Verdict::agree) {
      judge(outcome, expected, is_golden);
    }
  }
  return result;
}

std::string doubt_about(const GoldenResult& result) {
  const std::vector<GoldenLevel>& scalar = result.outcomes.front().levels;
  for (const GoldenOutcome& outcome : result.outcomes) {
    if (outcome.verdict != Verdict::skipped && (scalar.empty() || outcome.levels != scalar)) {
      return scalar.empty() ? outcome.reason : fmt::format("{} and scalar disagree", outcome.backend);
    }
    if (!is_the_same_in_one_piece(outcome)) {
      return fmt::format("{} in one piece and level by level disagree", outcome.backend);
    }
  }
  return {};
}

} // namespace hdmbench
