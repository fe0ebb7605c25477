#include "harness/web/browser_page.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/gl/objects.hpp"
#include "harness/check/golden.hpp"
#include "harness/check/probe.hpp"
#include "harness/measure/result_file.hpp"
#include "harness/report/html.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/method.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/solve.hpp"
#include "harness/web/elastic_steps.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <report_assets/elements_script.hpp>
#include <report_assets/page_style.hpp>
#include <shaders/probe_webgl.hpp>
#include <shaders/sweep_webgl.hpp>
#include <web_assets/arithmetic_script.hpp>
#include <web_assets/compute_script.hpp>
#include <web_assets/elastic_image_texts.hpp>
#include <web_assets/elastic_script.hpp>
#include <web_assets/elastic_volume_texts.hpp>
#include <web_assets/elastic_wgsl.hpp>
#include <web_assets/follow_script.hpp>
#include <web_assets/laws_image_texts.hpp>
#include <web_assets/laws_volume_texts.hpp>
#include <web_assets/laws_wgsl.hpp>
#include <web_assets/page_script.hpp>
#include <web_assets/page_text.hpp>
#include <web_assets/scalar_module.hpp>
#include <web_assets/specification_texts.hpp>
#include <web_assets/sweep_wgsl.hpp>
#include <web_assets/wgsl_script.hpp>

#include <array>
#include <initializer_list>
#include <string_view>

namespace hdmbench {

namespace {

using nlohmann::json;

/// One array after the other.
std::string base64_of(std::initializer_list<const std::vector<float>*> arrays) {
  std::vector<float> all;
  for (const std::vector<float>* array : arrays) {
    all.insert(all.end(), array->begin(), array->end());
  }
  return report::base64({reinterpret_cast<const char*>(all.data()), all.size() * sizeof(float)});
}

/// The levels as follow.js reads them: what scalar begins each with here, and the hash of what it ends with.
json data_of(const Scene& scene) {
  const Level& full = scene.full;
  LevelSequence sequence(scene);
  const std::unique_ptr<Backend> backend = make_scalar();
  const std::unique_ptr<Session> session = backend->open({});
  json levels = json::array();
  VectorField field;
  for (const int index : sequence.order()) {
    const VectorField begin = sequence.begin(index, field);
    const Level& level = sequence.sample(index);
    const int sweeps = sequence.iterations(index) * sweeps_per_iteration(level);
    session->load(level);
    session->write(begin);
    session->step(sweeps);
    session->read(field);
    levels.push_back(
        {{"index", index},
         {"width", level.extent.width},
         {"height", level.extent.height},
         {"sweeps", sweeps},
         {"strengths", level.strengths},
         {"arrays", base64_of({&begin[0], &begin[1], &level.modulus.values, &level.inverse_modulus.values,
                               &level.target[0], &level.target[1], &level.confidence[0], &level.confidence[1],
                               &level.inverse_curvature[0], &level.inverse_curvature[1]})},
         {"hash", fmt::format("{:016x}", state_hash(field))}});
  }
  return {{"name", scene.name},
          {"method", scene.schedule.method},
          {"width", full.extent.width},
          {"height", full.extent.height},
          {"exact", scene.exact},
          {"rule", static_cast<int>(scene.schedule.rule)},
          {"update", static_cast<int>(full.update)},
          {"sweeps_per_iteration", sweeps_per_iteration(full)},
          {"penalty", full.penalty},
          {"seed", full.seed},
          {"steps", full.steps.values()},
          {"shader", gl::assemble(sources::sweep_webgl, shader_constants(sequence.sample(0)))},
          {"levels", std::move(levels)}};
}

/// The questions as arithmetic.js reads them: all cases, then what each should come to, then what else it
/// could.
json arithmetic_questions() {
  json questions = json::array();
  for (const OperationQuestion& question : operation_questions()) {
    std::vector<float> cases;
    for (const ArithmeticCase& one : question.cases) {
      cases.insert(cases.end(), one.begin(), one.end());
    }
    questions.push_back({{"question", question.question},
                         {"as_specified", question.as_specified},
                         {"otherwise", question.otherwise},
                         {"numbers", base64_of({&cases, &question.specified, &question.other})}});
  }
  return questions;
}

/// JSON inside a <script>: nothing in it may end the element.
std::string script_text(const json& data) {
  std::string text = json_text(data);
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) {
    text.replace(at, 2, "<\\/");
  }
  return text;
}

void fill_in(std::string& page, std::string_view mark, std::string_view text) {
  page.replace(page.find(mark), mark.size(), text);
}

} // namespace

std::string browser_page(std::span<const Scene> scenes, const Context& context, Progress& progress) {
  json data{{"context", context}, {"scenes", json::array()}};
  const auto* const module = reinterpret_cast<const char*>(sources::scalar_module);
  data["scalar"] = report::base64({module, std::size(sources::scalar_module)});
  for (const auto& [name, texts, wgsl] : std::to_array<std::array<std::string_view, 3>>(
           {{"sweep", sources::specification_texts, sources::sweep_wgsl},
            {"elastic 2", sources::elastic_image_texts, sources::elastic_wgsl},
            {"elastic 3", sources::elastic_volume_texts, sources::elastic_wgsl},
            {"laws 2", sources::laws_image_texts, sources::laws_wgsl},
            {"laws 3", sources::laws_volume_texts, sources::laws_wgsl}})) {
    data["compute"].push_back({{"name", name}, {"texts", texts}, {"wgsl", wgsl}});
  }
  data["probe"] = sources::probe_webgl;
  data["arithmetic"] = arithmetic_questions();
  for (const Scene& scene : scenes) {
    if (scene.energy->is_of_cells()) {
      data["scenes"].push_back(elastic_steps_of(scene, progress));
      continue;
    }
    if (scene.energy->of_sites != &thesis_energy || scene.full.update == Update::sequential) {
      throw InputError(
          fmt::format("{} by {} cannot be compared in a browser: only what goes through the levels once, "
                      "all sites of a set at once",
                      scene.name, scene.schedule.method));
    }
    if (scene.extent().axes() == 3) {
      throw InputError(fmt::format("{} is a volume, which browsers are given with the elastic energy only: "
                                   "give --energy elastic",
                                   scene.name));
    }
    progress.describe(fmt::format("{}, {}", scene.name, scene.schedule.method));
    data["scenes"].push_back(data_of(scene));
  }
  std::string page(sources::page_text);
  fill_in(page, "@STYLE@", sources::page_style);
  fill_in(page, "@PROVENANCE@",
          report::escape(fmt::format("hdmbench {}, commit {}", context.version, context.commit)));
  fill_in(page, "@DATA@", script_text(data));
  fill_in(page, "@SCRIPT@",
          fmt::format("{}{}{}{}{}{}{}", sources::elements_script, sources::follow_script,
                      sources::wgsl_script, sources::compute_script, sources::elastic_script,
                      sources::arithmetic_script, sources::page_script));
  return page;
}

} // namespace hdmbench
