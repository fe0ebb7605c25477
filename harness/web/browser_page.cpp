#include "harness/web/browser_page.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/gl/objects.hpp"
#include "harness/check/state_hash.hpp"
#include "harness/report/html.hpp"
#include "harness/scene/level_sequence.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/solve/solve.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <report_assets/chart_script.hpp>
#include <report_assets/elements_script.hpp>
#include <report_assets/page_style.hpp>
#include <shaders/sweep_webgl.hpp>
#include <web_assets/follow_script.hpp>
#include <web_assets/page_script.hpp>
#include <web_assets/page_text.hpp>
#include <web_assets/scalar_module.hpp>

#include <initializer_list>

namespace hdmbench {

namespace {

using nlohmann::json;

std::string base64_of(const std::vector<float>& values) {
  return report::base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
}

void append(std::vector<float>& all, std::initializer_list<const std::vector<float>*> arrays) {
  for (const std::vector<float>* array : arrays) {
    all.insert(all.end(), array->begin(), array->end());
  }
}

/// As scalar.cpp wants it: four floats an entry.
std::vector<float> entries(int coarse, int fine, Alignment alignment) {
  std::vector<float> all;
  for (const Interpolation& entry : interpolations(coarse, fine, alignment)) {
    all.insert(all.end(),
               {static_cast<float>(entry.first), static_cast<float>(entry.second), entry.weight, 0.0F});
  }
  return all;
}

/// The levels as follow.js reads them, and the hash of the field that scalar ends with here.
class SceneData {
public:
  explicit SceneData(const Scene& scene)
      : scene_(scene), levels_(scene), backend_(make_scalar()), session_(backend_->open({})) {}

  json data() {
    const Level& full = scene_.full;
    json levels = json::array();
    VectorField field;
    std::optional<Extent> before;
    for (const int index : levels_.order()) {
      const VectorField begin = levels_.begin(index, field);
      const Level& level = levels_.sample(index);
      const int sweeps = levels_.iterations(index) * sweeps_per_iteration(level);
      levels.push_back(level_data(level, index, sweeps, before));
      session_->load(level);
      session_->write(begin);
      session_->step(sweeps);
      session_->read(field);
      before = level.extent;
    }
    return {{"name", scene_.name},
            {"method", scene_.schedule.method},
            {"width", full.extent.width},
            {"height", full.extent.height},
            {"exact", scene_.exact},
            {"rule", static_cast<int>(scene_.schedule.rule)},
            {"update", static_cast<int>(full.update)},
            {"sweeps_per_iteration", sweeps_per_iteration(full)},
            {"penalty", full.penalty},
            {"seed", full.seed},
            {"steps", full.steps.values()},
            {"shader", gl::assemble(sources::sweep_webgl, shader_constants(levels_.sample(0)))},
            {"hash", fmt::format("{:016x}", state_hash(field))},
            {"levels", std::move(levels)}};
  }

private:
  json level_data(const Level& level, int index, int sweeps, std::optional<Extent> before) const {
    std::vector<float> arrays;
    append(arrays, {&level.modulus.values, &level.inverse_modulus.values, &level.target.x, &level.target.y,
                    &level.confidence.x, &level.confidence.y, &level.inverse_curvature.x,
                    &level.inverse_curvature.y});
    std::vector<float> start;
    if (scene_.start) {
      const VectorField at = scene_.start_at(level.extent);
      append(start, {&at.x, &at.y});
    }
    const Extent extent = level.extent;
    const Alignment alignment = scene_.schedule.alignment;
    const auto table = [&](int coarse, int fine) {
      return base64_of(before ? entries(coarse, fine, alignment) : std::vector<float>{});
    };
    const Extent coarse = before.value_or(extent);
    return {{"index", index},
            {"width", extent.width},
            {"height", extent.height},
            {"sweeps", sweeps},
            {"strengths", level.strengths},
            {"arrays", base64_of(arrays)},
            {"start", base64_of(start)},
            {"columns", table(coarse.width, extent.width)},
            {"rows", table(coarse.height, extent.height)}};
  }

  const Scene& scene_;
  LevelSequence levels_;
  std::unique_ptr<Backend> backend_;
  std::unique_ptr<Session> session_;
};

/// JSON inside a <script>: nothing in it may end the element.
std::string script_text(const json& data) {
  std::string text = data.dump();
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
  json data{{"context", to_json_row(context)}, {"scenes", json::array()}};
  const auto* const module = reinterpret_cast<const char*>(sources::scalar_module);
  data["scalar"] = report::base64({module, std::size(sources::scalar_module)});
  for (const Scene& scene : scenes) {
    if (scene.energy != EnergyModel::hdm || scene.full.update == Update::sequential) {
      throw InputError(
          fmt::format("{} by {} cannot be compared in a browser: only what goes through the levels once, "
                      "all sites of a set at once",
                      scene.name, scene.schedule.method));
    }
    progress.describe(fmt::format("{}, {}", scene.name, scene.schedule.method));
    data["scenes"].push_back(SceneData(scene).data());
  }
  std::string page(sources::page_text);
  fill_in(page, "@STYLE@", sources::page_style);
  fill_in(page, "@PROVENANCE@",
          report::escape(fmt::format("hdmbench {}, commit {}", context.version, context.commit)));
  fill_in(page, "@DATA@", script_text(data));
  fill_in(page, "@SCRIPT@",
          fmt::format("{}{}{}{}", sources::elements_script, sources::chart_script, sources::follow_script,
                      sources::page_script));
  return page;
}

} // namespace hdmbench
