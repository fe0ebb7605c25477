#include "harness/tools/thesis_tools.hpp"

#include "harness/check/compare.hpp"
#include "harness/scene/files.hpp"
#include "harness/scene/method.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <sstream>

namespace hdmbench {

namespace {

/// In quotes, as TOML wants it.
std::string quoted(const std::string& text) {
  std::ostringstream stream;
  stream << toml::value<std::string>(text);
  return stream.str();
}

template <typename Names, typename Enumerator>
std::string name_of(const Names& names, Enumerator enumerator) {
  return fmt::format("\"{}\"", names.at(static_cast<std::size_t>(enumerator)));
}

bool is_zero(const VectorField& field) {
  const auto zero = [](float value) { return value == 0.0F; };
  return std::ranges::all_of(field[0], zero) && std::ranges::all_of(field[1], zero);
}

/// The method with the options that it takes.
std::string method_text(const Scene& scene) {
  const Schedule& schedule = scene.schedule;
  std::string text = fmt::format("method = \"{}\"\niterations = {}\n", schedule.method, schedule.iterations);
  if (schedule.method == "icm") {
    text += fmt::format("update = {}\n", name_of(update_names, scene.full.update));
  }
  if (schedule.rule == Rule::closed_form && schedule.relaxation.reach == 0.0) {
    text += fmt::format("relaxation = {}\n", schedule.relaxation.factor);
  }
  if (schedule.rule == Rule::annealing) {
    text += fmt::format("temperatures = [{}, {}]\nseed = {}\n", schedule.cooling.highest,
                        schedule.cooling.lowest, scene.full.seed);
  }
  return text;
}

std::string scene_text(const Scene& scene, bool with_start) {
  const Schedule& schedule = scene.schedule;
  const bool has_steps = find_method(schedule.method, scene.energy).takes.starts_with("steps");
  const std::string steps = has_steps ? fmt::format("steps = [{}]\n", scene.full.steps.text()) : "";
  std::string text =
      fmt::format("# The scene {0} at {1} x {2} pixels, as hdmbench export wrote it.\n"
                  "title = {3}\npenalty = {4}\nprior_weight = {5}\n{6}spacing = {7}\n"
                  "poisson = {8}\n\n[schedule]\n{9}stop = {10}\n{11}",
                  scene.name, scene.extent().width, scene.extent().height, quoted(scene.title),
                  scene.weight.penalty, scene.weight.prior_weight, steps, scene.spacing,
                  scene.elastic.poisson, method_text(scene), name_of(stop_names, schedule.stop),
                  schedule.stop == Stop::energy ? fmt::format("epsilon = {}\n", schedule.epsilon) : "");
  if (schedule.start_level) {
    text += fmt::format("start_level = {}\n", *schedule.start_level);
  }
  text += fmt::format("alignment = {}\n\n", name_of(alignment_names, schedule.alignment));
  return text + "[image]\nmodulus = \"modulus.nrrd\"\n" +
         (scene.picture.values.empty() ? "" : "picture = \"picture.nrrd\"\npicture_range = [0, 255]\n") +
         "target = \"target.nrrd\"\nconfidence = \"confidence.nrrd\"\n" +
         (with_start ? "start = \"start.nrrd\"\n" : "");
}

/// 255 where either component is certain.
ScalarField confidence_picture(const VectorField& confidence) {
  ScalarField picture(confidence.extent);
  std::ranges::transform(confidence[0], confidence[1], picture.values.begin(),
                         [](float x, float y) { return 255.0F * std::max(x, y); });
  return picture;
}

} // namespace

std::vector<std::string> export_scene(const Scene& scene, const std::filesystem::path& folder) {
  const Level& full = scene.full;
  std::vector<std::string> names;
  const auto file = [&](const char* name) {
    names.emplace_back(name);
    return folder / name;
  };
  const bool with_picture = !scene.picture.values.empty();
  if (with_picture) {
    write_scalar(file("picture.nrrd"), scene.picture, scene.spacing, scene.placement);
    write_png(file("picture.png"), scene.picture);
  }
  write_scalar(file("modulus.nrrd"), full.modulus, scene.spacing, scene.placement);
  write_vector(file("target.nrrd"), full.target, scene.spacing, scene.placement);
  write_vector(file("confidence.nrrd"), full.confidence, scene.spacing, scene.placement);
  if (!scene.labels.values.empty()) {
    write_labels(file("labels.nrrd"), scene.labels, scene.spacing, scene.placement);
  }
  const bool with_start = scene.start && !is_zero(*scene.start);
  if (with_start) {
    write_vector(file("start.nrrd"), *scene.start, scene.spacing, scene.placement);
  }
  if (with_picture) {
    write_magnitude_png(file("target.png"), magnitude_of(full.target),
                        std::max(largest_magnitude(full.target), 1e-6));
    write_png(file("confidence.png"), confidence_picture(full.confidence));
  }
  write_text(file("scene.toml"), scene_text(scene, with_start));
  return names;
}

} // namespace hdmbench
