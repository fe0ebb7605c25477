#include "harness/check/golden.hpp"

#include "harness/check/compare.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "kernels/data/elastic/hierarchy.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <golden_text.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <stdexcept>

namespace hdmbench {

namespace {

/// FNV-1a (Fowler, Noll and Vo; offset basis 0xcbf29ce484222325, prime 0x100000001b3) over bytes, low byte
/// first, the same on every machine. Finds differences; no protection against people.
class StateHash {
public:
  /// 4 bytes, two's complement.
  void add(int number) {
    auto word = static_cast<std::uint32_t>(number);
    for (int byte = 0; byte < 4; ++byte, word >>= 8) {
      hash_ = (hash_ ^ (word & 0xff)) * 0x100000001b3;
    }
  }
  /// Its 4 bytes (IEEE 754), -0 as 0.
  void add(float value) { add(value == 0.0F ? 0 : std::bit_cast<int>(value)); }
  /// Their number, then they.
  void add(std::span<const float> values) {
    add(static_cast<int>(values.size()));
    add_each(values);
  }
  void add(std::string_view text) {
    add(static_cast<int>(text.size()));
    std::ranges::for_each(text, [this](unsigned char letter) { add(int{letter}); });
  }
  void add(Extent extent) {
    add(extent.width);
    add(extent.height);
    if (extent.depth > 1) { // hashes of images are older than volumes
      add(extent.depth);
    }
  }
  /// Extent, then all values in raster order.
  void add(const ScalarField& field) {
    add(field.extent);
    add_each(field.values);
  }
  /// Extent, then the planes in turn.
  void add(const VectorField& field) {
    add(field.extent);
    std::ranges::for_each(field.planes, [this](const auto& plane) { add_each(plane); });
  }

  [[nodiscard]] std::uint64_t value() const { return hash_; }

private:
  void add_each(std::span<const float> values) {
    std::ranges::for_each(values, [this](float value) { add(value); });
  }

  std::uint64_t hash_ = 0xcbf29ce484222325;
};

/// Of all that an elastic session is loaded with.
std::uint64_t hierarchy_hash(const ElasticHierarchy& hierarchy) {
  StateHash hash;
  hash.add(hierarchy.levels.front().ratio.nu);
  ElasticRatios<float> finer{}; // hashes in golden files are older than cells of other forms on coarse levels
  for (const ElasticLevel& level : hierarchy.levels) {
    if (level.ratio.y != finer.y || level.ratio.z != finer.z) {
      hash.add(level.ratio.y);
      hash.add(level.ratio.z);
    }
    finer = level.ratio;
    hash.add(level.grid.sites);
    if (level.bend != 1.0F) { // hashes in golden files are older
      hash.add(level.bend);
    }
    for (const std::vector<float>& moment : level.moments) {
      hash.add(moment);
    }
    for (const std::vector<float>& response : level.response) {
      hash.add(response);
    }
    const std::size_t entries = level.masked.components * level.masked.components;
    for (std::size_t cell = 0; cell < level.masked.x.size(); ++cell) {
      hash.add(level.masked.x[cell]);
      hash.add(std::span<const float>(level.masked.matrix(cell), entries));
    }
  }
  hash.add(hierarchy.coarsest_inverse);
  return hash.value();
}

/// The first level in which they differ, and how; none: they do not.
std::optional<std::pair<int, std::string>> first_difference(const std::vector<GoldenLevel>& expected,
                                                            const std::vector<GoldenLevel>& found) {
  const auto [golden, other] = std::ranges::mismatch(expected, found);
  const bool is_missing = other == found.end();
  if (golden == expected.end() && is_missing) {
    return std::nullopt;
  }
  const int level = (is_missing ? golden : other)->level;
  if (golden == expected.end() || is_missing) {
    return std::pair(level,
                     fmt::format("level {} {}", level, is_missing ? "is missing" : "should not be there"));
  }
  const auto text = [](const GoldenLevel& one) {
    return fmt::format("{:016x} after {} iterations on level {}", one.hash, one.iterations, one.level);
  };
  return std::pair(level, fmt::format("level {}: {} in place of {}", level, text(*other), text(*golden)));
}

/// Gives a solved outcome its verdict.
void judge(GoldenOutcome& outcome, const std::vector<GoldenLevel>& expected, bool is_golden) {
  if (const auto first = first_difference(expected, outcome.levels)) {
    outcome.verdict = Verdict::disagree;
    outcome.first_difference = first->first;
    outcome.reason = first->second + (is_golden ? "" : " (scalar's)");
  } else if (!outcome.is_sound) { // in one piece alone
    outcome.first_difference = outcome.levels.back().level;
  } else if (!is_golden) {
    outcome.verdict = Verdict::mistrusted;
    outcome.reason = "as scalar, but there is nothing golden to compare with";
  }
}

constexpr int schema = 1; // of a golden file

std::uint64_t parse_hash(const std::string& text) {
  std::uint64_t hash = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, hash, 16);
  if (text.size() != 16 || result.ec != std::errc{} || result.ptr != end) {
    throw InputError(fmt::format("\"{}\" is no hash of 16 hexadecimal digits", text));
  }
  return hash;
}

GoldenEntry read_entry(const nlohmann::json& json) {
  GoldenEntry entry;
  entry.problem = {.scene = json.at("scene"),
                   .size = Extent{json.at("width"), json.at("height"), json.value("depth", 1)},
                   .method = json.at("method")};
  entry.inputs.scene = parse_hash(json.at("inputs"));
  for (const nlohmann::json& level : json.at("levels")) {
    entry.levels.push_back({level.at("level"), level.at("iterations"), parse_hash(level.at("hash"))});
    if (level.contains("loaded")) {
      entry.inputs.levels.push_back(parse_hash(level.at("loaded")));
    }
  }
  return entry;
}

std::string entry_text(const GoldenEntry& entry) {
  std::string levels;
  for (std::size_t i = 0; i < entry.levels.size(); ++i) {
    const GoldenLevel& level = entry.levels[i];
    levels += fmt::format("{}    {{\"level\": {}, \"iterations\": {}, {}\"hash\": \"{:016x}\"}}",
                          i > 0 ? ",\n" : "\n", level.level, level.iterations,
                          entry.inputs.levels.empty()
                              ? ""
                              : fmt::format("\"loaded\": \"{:016x}\", ", entry.inputs.levels.at(i)),
                          level.hash);
  }
  return fmt::format(
      "  {{\"scene\": {}, \"width\": {}, \"height\": {}, {}\"method\": \"{}\", \"inputs\": "
      "\"{:016x}\", \"levels\": [{}]}}",
      nlohmann::json(entry.problem.scene).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
      entry.problem.size->width, entry.problem.size->height,
      entry.problem.size->depth > 1 ? fmt::format("\"depth\": {}, ", entry.problem.size->depth) : "",
      entry.problem.method, entry.inputs.scene, levels);
}

GoldenInputs hash_inputs(const Scene& scene) {
  StateHash hash;
  hash.add(scene.full.target);
  hash.add(scene.full.confidence);
  hash.add(scene.full.modulus);
  hash.add(scene.full.penalty);
  hash.add(scene.full.steps.values());
  hash.add(scene.start_field());
  if (has_forces(scene.full)) {
    hash.add(scene.full.force);
  }
  if (has_laws(scene.full)) {
    hash.add(scene.full.law_parameter);
  }
  if (has_fibres(scene.full)) {
    hash.add(scene.full.fibre);
    hash.add(scene.full.fibre_compression);
  }
  GoldenInputs inputs{.scene = hash.value(), .levels = {}};
  if (scene.energy->is_of_cells()) {
    inputs.levels = {hierarchy_hash(make_elastic_hierarchy({scene.full, scene.elastic}))};
  } else {
    LevelSequence levels(scene);
    for (const int index : levels.order()) {
      inputs.levels.push_back(level_hash(levels.sample(index)));
    }
  }
  return inputs;
}

/// One sentence about the first hash that differs; empty: none.
std::string inputs_difference(const GoldenInputs& golden, const GoldenInputs& found) {
  if (found.scene != golden.scene) {
    return fmt::format("the scene itself is another one ({:016x} in place of {:016x}): libm, ITK or its file",
                       found.scene, golden.scene);
  }
  const auto [mine, theirs] = std::ranges::mismatch(found.levels, golden.levels);
  if (mine == found.levels.end() && theirs == golden.levels.end()) {
    return {};
  }
  return fmt::format(
      "what level number {} of {}, the coarsest first, is loaded with is not what it was, with "
      "{} levels: sampling, 1/A or strengths",
      mine - found.levels.begin() + 1, found.levels.size(), golden.levels.size());
}

} // namespace

std::uint64_t state_hash(const VectorField& field) {
  StateHash hash;
  hash.add(field);
  return hash.value();
}

std::uint64_t level_hash(const Level& level) {
  StateHash hash;
  hash.add(level.extent);
  hash.add(level.modulus);
  hash.add(level.inverse_modulus);
  hash.add(level.target);
  hash.add(level.confidence);
  hash.add(level.penalty);
  hash.add(level.steps.values());
  hash.add(static_cast<int>(level.update));
  hash.add(level.rule == Rule::annealing ? 3 : static_cast<int>(level.rule)); // as it was numbered once
  hash.add(level.inverse_curvature);
  hash.add(level.strengths);
  hash.add(level.seed);
  if (level.energy != &thesis_energy) { // whose hashes are older than there were others
    hash.add(level.energy->name);
    for (const ScalarField& input : level.inputs) {
      hash.add(input);
    }
  }
  return hash.value();
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

GoldenOutcome GoldenSolver::solve(const Scene& scene, Progress& progress) {
  GoldenOutcome outcome{
      .backend = std::string(backend_->name()), .device = device_, .reason = absence(scene)};
  if (!outcome.reason.empty()) {
    return outcome;
  }
  progress.describe(fmt::format("golden {}, {}, {} on {}", scene.name, scene.extent().text(),
                                scene.schedule.method, outcome.backend));
  outcome.verdict = Verdict::agree;
  const auto doubt = [&](std::string reason) {
    outcome.is_sound = false;
    outcome.verdict = Verdict::disagree;
    outcome.reason = std::move(reason);
  };
  (void)solver_->solve(
      scene, progress, {.level_done = [&](const LevelResult& result, const VectorField& displacement) {
        outcome.levels.push_back({result.level, result.iterations, state_hash(displacement)});
        if (outcome.is_sound && !is_finite(displacement)) {
          doubt(fmt::format("level {}: a number is not finite", result.level));
          outcome.first_difference = result.level;
        }
      }});
  if (outcome.is_sound && !scene.energy->is_of_cells() && LevelSequence(scene).pyramid()) {
    Progress silent(false);
    const std::uint64_t found = state_hash(solver_->solve(scene, silent).displacement);
    if (found != outcome.levels.back().hash) {
      doubt(fmt::format("in one piece: {:016x} in place of {:016x}, which it is level by level", found,
                        outcome.levels.back().hash));
    }
  }
  return outcome;
}

GoldenResult check_golden(const Scene& scene, std::span<GoldenSolver> solvers, const GoldenEntry* golden,
                          Progress& progress) {
  GoldenResult result{.problem = case_of(scene), .inputs = hash_inputs(scene), .known = golden != nullptr};
  result.inputs_reason =
      result.known ? inputs_difference(golden->inputs, result.inputs) : "there are no golden hashes";
  for (GoldenSolver& solver : solvers) {
    result.outcomes.push_back(solver.solve(scene, progress));
  }
  const bool is_golden = golden != nullptr && result.inputs_reason.empty();
  const std::vector<GoldenLevel> expected = is_golden ? golden->levels : result.outcomes.front().levels;
  for (GoldenOutcome& outcome : result.outcomes) {
    if (outcome.verdict != Verdict::skipped && !outcome.first_difference) {
      judge(outcome, expected, is_golden);
    }
  }
  return result;
}

std::string doubt_about(const GoldenResult& result) {
  const std::vector<GoldenLevel>& scalar = result.outcomes.front().levels;
  for (const GoldenOutcome& outcome : result.outcomes) {
    if (!outcome.is_sound) {
      return fmt::format("{}: {}", outcome.backend, outcome.reason);
    }
    if (outcome.verdict != Verdict::skipped && outcome.levels != scalar) {
      return fmt::format("{} and scalar disagree", outcome.backend);
    }
  }
  return {};
}

std::string golden_text(const std::vector<GoldenEntry>& entries) {
  std::string text = fmt::format("{{\"schema\": {}, \"cases\": [", schema);
  for (const GoldenEntry& entry : entries) {
    text += (&entry == entries.data() ? "\n" : ",\n") + entry_text(entry);
  }
  return text + "]}\n";
}

std::vector<GoldenEntry> read_golden(std::string_view text, std::string_view name) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    if (json.at("schema") != schema) {
      throw InputError(fmt::format("this program reads schema {}", schema));
    }
    std::vector<GoldenEntry> entries;
    for (const nlohmann::json& entry : json.at("cases")) {
      entries.push_back(read_entry(entry));
    }
    return entries;
  } catch (const std::exception& error) { // of nlohmann, too
    throw InputError(fmt::format("{}: {}", name, error.what()));
  }
}

const std::vector<GoldenEntry>& committed_golden() {
  static const std::vector<GoldenEntry> entries = read_golden(sources::golden_text, "golden.json");
  return entries;
}

const GoldenEntry* find_golden(const std::vector<GoldenEntry>& entries, const Case& problem) {
  const auto found = std::ranges::find(entries, problem, &GoldenEntry::problem);
  return found != entries.end() ? &*found : nullptr;
}

nlohmann::json golden_row(const GoldenResult& result, const GoldenOutcome& outcome) {
  const auto text = [](std::uint64_t hash) { return fmt::format("{:016x}", hash); };
  nlohmann::json row = with_size({{"scene", result.problem.scene},
                                  {"method", result.problem.method},
                                  {"inputs", text(result.inputs.scene)},
                                  {"inputs_reason", result.inputs_reason},
                                  {"backend", outcome.backend},
                                  {"device", outcome.device.name},
                                  {"levels", nlohmann::json::array()},
                                  {"first_difference", nullptr},
                                  {"verdict", name_of(outcome.verdict)},
                                  {"reason", outcome.reason}},
                                 *result.problem.size);
  for (const GoldenLevel& level : outcome.levels) {
    row["levels"].push_back(
        {{"level", level.level}, {"iterations", level.iterations}, {"hash", text(level.hash)}});
  }
  if (outcome.first_difference) {
    row["first_difference"] = *outcome.first_difference;
  }
  return row;
}

} // namespace hdmbench
