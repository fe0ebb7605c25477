// How many of its 512 instructions the thesis's card needs for our fragment shaders, and for the thesis's own
// evaluation.

#include "backends/gl/fragment.hpp"
#include "backends/gl/fragment_programs.hpp"
#include "backends/gl/objects.hpp"
#include "backends/shared/tiles.hpp"
#include "harness/cli/commands.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/table.hpp"
#include "harness/scene/method.hpp"
#include "kernels/data/input_error.hpp"
#include "test/r300/shader_compiler.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <shaders/passes_fragment.hpp>
#include <shaders/sweep_fragment.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hdmbench::test {
namespace {

using nlohmann::json;

/// What the card's compiler makes of one shader; what it does not tell is null. `shader` tells it apart
/// within its group, `candidates` are step sizes per component (0: the rule has none), `energies` the
/// candidate vectors whose energy is evaluated.
json measure(ShaderCompiler& compiler, std::string_view group, std::string_view shader,
             const std::string& text, int candidates = 0, int energies = 0) {
  const auto [resources, refusal] = compiler.compile(text);
  const auto of = [&, &resources = resources](int Resources::*number) {
    return resources ? json((*resources).*number) : json();
  };
  return {{"group", group},
          {"shader", shader},
          {"candidates", candidates},
          {"energies", energies},
          {"instructions", of(&Resources::instructions)},
          {"texture_instructions", of(&Resources::texture_instructions)},
          {"temporaries", of(&Resources::temporaries)},
          {"flow_control", of(&Resources::flow_control)},
          {"refusal", refusal},
          {"device", compiler.device().name},
          {"driver", compiler.device().driver},
          {"instructions_limit", compiler.limits().instructions},
          {"temporaries_limit", compiler.limits().temporaries}};
}

/// What gl-fragment sends for a sweep of `level`, where its tiles have everything: the longest text.
json measure_sweep(ShaderCompiler& compiler, std::string_view group, std::string_view shader,
                   const Level& level) {
  const bool has_candidates = level.rule == Rule::steps || level.rule == Rule::annealing;
  return measure(compiler, group, shader,
                 gl::sweep_text(shader_constants(level), general_class, {}, level.extent.axes()),
                 has_candidates ? level.steps.count() : 0);
}

/// `count` different candidates, 0 first.
StepSet some_steps(int count) {
  std::vector<float> steps;
  for (int i = 0; i < count; ++i) {
    steps.push_back(static_cast<float>(i));
  }
  return StepSet(steps);
}

/// The passes of gl-fragment for the elastic energy, and the count of changed sites.
const std::vector<std::pair<const char*, std::string>>& other_passes() {
  using enum ElasticStep;
  const auto pass = [](const ElasticKernel& kernel, std::size_t axes = 2) {
    return gl::elastic_fragment_text(kernel, axes);
  };
  static const std::vector<std::pair<const char*, std::string>> passes{
      {"the count of changed sites", gl::assemble(sources::passes_fragment, "#define COUNTS\n")},
      {"elastic, a sweep of the displacement", pass({.step = relax})},
      {"elastic, a sweep of a correction", pass({.step = relax, .has_load = true})},
      {"elastic, the same beside conditions", pass({.step = relax, .has_load = true, .has_masked = true})},
      {"elastic, the first sweep of a correction", pass({.step = relax_from_zero})},
      {"elastic, residuals of the image", pass({.step = residual, .has_load = true, .is_image = true})},
      {"elastic, restriction", pass({.step = restrict_sites})},
      {"elastic, interpolation", pass({.step = correct})},
      {"elastic, the coarsest level", pass({.step = solve})},
      {"elastic, products of a sum", pass({.step = products})},
      {"elastic, a sweep of a volume beside conditions",
       pass({.step = relax, .is_image = true, .has_masked = true}, 3)},
  };
  return passes;
}

constexpr std::string_view thesis_start = R"(
vec2 squared(vec2 v) { return v * v; }
vec2 triple(vec2 ds, float ms, vec2 dt, float mt, vec2 du, float mu) {
  return squared(mt / mu * (dt - ds) - (du - dt)) + squared(mt / ms * (dt - du) - (ds - dt));
}
struct Pixel {
  vec2 d;
  float m;
};
Pixel pixel(vec2 at, vec2 offset) {
  vec2 site = neighbour(at, offset, dimension);
  return Pixel(displacement_at(site), texture2DRect(observation, site).b);
}
struct Site3x3 {
  Pixel north_west, north, north_east, west, east, south_west, south, south_east;
  vec2 target, weight;
  float m;
};
float energy_at(Site3x3 site, vec2 d) {
  vec2 horizontal = triple(site.west.d, site.west.m, d, site.m, site.east.d, site.east.m);
  vec2 vertical = triple(site.north.d, site.north.m, d, site.m, site.south.d, site.south.m);
  vec2 falling = triple(site.north_west.d, site.north_west.m, d, site.m, site.south_east.d, site.south_east.m);
  vec2 rising = triple(site.south_west.d, site.south_west.m, d, site.m, site.north_east.d, site.north_east.m);
  return horizontal.x + vertical.y + dot(falling, vec2(1.0)) + dot(rising, vec2(1.0)) +
         dot(site.weight, abs(site.target - d));
}
void main() {
  vec2 at = gl_FragCoord.xy;
  vec2 centre = displacement_at(at);
  vec3 known = observation_at(at);
  Site3x3 site = Site3x3(pixel(at, vec2(-1, -1)), pixel(at, vec2(0, -1)), pixel(at, vec2(1, -1)), pixel(at, vec2(-1, 0)),
                         pixel(at, vec2(1, 0)), pixel(at, vec2(-1, 1)), pixel(at, vec2(0, 1)), pixel(at, vec2(1, 1)),
                         known.xy, penalty * confidence_at(at).xy, known.z);
  vec2 d = centre;
  vec2 best = centre;
  float u = 0.0;
  float lowest = 1e30;
)";

/// The thesis's shader as it may have been: a site's whole energy for every candidate VECTOR (its Algorithms
/// 1 to 4 have Gamma as a set of vectors), (4.7)-(4.17) line by line, unrolled because fragment programs of
/// its time had no loops. Its source is not printed; this is ours, in GLSL 1.20. The first `vectors` of
/// `steps` x `steps` vectors.
std::string thesis_shader(int steps, int vectors) {
  // sweep.frag up to its main has the textures, uniforms and the border.
  std::string text = gl::assemble(sources::sweep_fragment, {.rule = 0, .colours = 1, .step_count = 1});
  text.resize(text.find("void main()"));
  text += thesis_start;
  for (int i = 0; i < vectors; ++i) {
    text += fmt::format("  d = centre + vec2(steps[{}], steps[{}]);\n  u = energy_at(site, d);\n"
                        "  best = u < lowest ? d : best;\n  lowest = min(u, lowest);\n",
                        i / steps, i % steps);
  }
  return text + "  gl_FragColor = vec4(best, 0.0, 0.0);\n}\n";
}

/// "candidates": what gl-fragment sends for icm with 2 to 16 candidates, the largest number that a StepSet
/// takes. "methods": for every method that it supports, the count of changed sites and the passes of the
/// elastic energy. "vectors": thesis_shader() for 2 to 6 step sizes, and one vector more than 4 x 4.
json measure_instructions(ShaderCompiler& compiler) {
  json rows = json::array();
  for (int count = 2; count <= StepSet::maximum_count; ++count) {
    std::string names;
    for (const char* const name : {"default", "thesis", "fine"}) {
      if (StepSet::parse(name).count() == count) {
        names += fmt::format("{}--steps {}", names.empty() ? "" : ", ", name);
      }
    }
    rows.push_back(measure_sweep(compiler, "candidates", names, {.extent = {}, .steps = some_steps(count)}));
  }
  for (const Method& method : methods()) {
    Schedule schedule;
    Level level{.extent = {}};
    method.configure(schedule, level);
    level.rule = schedule.rule;
    if (level.update != Update::sequential) {
      rows.push_back(measure_sweep(compiler, "methods", method.name, level));
    }
  }
  rows.push_back(measure_sweep(compiler, "methods", "icm, of a volume", {.extent = {2, 2, 2}}));
  for (const auto& [name, text] : other_passes()) {
    rows.push_back(measure(compiler, "methods", name, text));
  }
  for (const auto& [steps, vectors] : {std::pair{2, 4}, {3, 9}, {4, 16}, {5, 17}, {5, 25}, {6, 36}}) {
    rows.push_back(
        measure(compiler, "vectors", "equations as printed", thesis_shader(steps, vectors), steps, vectors));
  }
  return rows;
}

/// commands::disagreement where a set of candidates does not fit.
int count(const std::filesystem::path& file) {
  require_results_writable(file);
  if (const std::string reason = why_missing(); !reason.empty()) {
    throw DeviceError(reason);
  }
  ShaderCompiler compiler;
  fmt::print(
      "Compiled for {} ({}), the thesis's Radeon X1300, which need not be there.\n"
      "It has room for {} instructions and {} temporaries. What gl-fragment sends for icm by the number of "
      "candidates and for every\nmethod, and the thesis's evaluation of the whole energy of every vector of "
      "n step sizes (it says: 4 come close, 6 go past):\n",
      compiler.device().name, compiler.device().driver, compiler.limits().instructions,
      compiler.limits().temporaries);
  json results = measure_instructions(compiler);
  const bool candidates_fit = std::ranges::none_of(
      results, [](const json& row) { return row["group"] == "candidates" && row["instructions"].is_null(); });
  fmt::print("{}", table_text(results,
                              "group|candidates|energies:vectors|instructions|texture_instructions:of them "
                              "texture|flow_control|temporaries|refusal:does not fit because|shader"));
  write_results(file, "instructions", run_context("--json " + file.string(), false), std::move(results));
  return candidates_fit ? commands::success : commands::disagreement;
}

} // namespace
} // namespace hdmbench::test

int main(int argc, char** argv) {
  using namespace hdmbench;
  CLI::App program(
      "Instructions of the fragment shaders on the thesis's Radeon X1300, as Mesa's r300 driver compiles "
      "them; the card need not be there.\nExit status: 0 all sets of candidates fit, 1 one does not, 2 "
      "there is no such driver here.");
  std::filesystem::path json;
  program.add_option("--json", json, "Write the results to this file, for hdmbench report");
  try {
    program.parse(argc, argv);
    return test::count(json);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? commands::success : commands::bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "instruction_count: {}\n", error.what());
    return commands::bad_input;
  }
}
