// The command that plants displacements and stiffness, and lets register, detect and others look for them.

#include "harness/judge/registration/rivals.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/judge/registration/plastimatch.hpp"

namespace hdmbench::commands {

namespace {

const Option<std::vector<std::string>>
    kinds("--planted", "What deforms: growth, resection, pressure, with commas",
          {planted_names.begin(), planted_names.end()},
          CLI::IsMember(std::vector<std::string>(planted_names.begin(), planted_names.end())));
const Option<int> detection("--detection", "So many cases with a hidden inclusion, and as many without", 0,
                            CLI::Range(1, 1'000'000));
const Option<bool> spread("--spread", "Radius 3 to 15 pixels and contrast 1.5 to 10, another each case");
const Option<bool> pictures(
    "--pictures",
    "The displacement is not given: Algorithm 6 finds it in pictures that do not show the inclusion");

/// For `register` and `detect`.
void write_pair(const std::filesystem::path& folder, const Scene& scene, const PlantedPair& pair,
                std::string_view what) {
  const std::vector<std::string> files{"source.nrrd", "target.nrrd", "region.nrrd", "truth.nrrd"};
  require_folder(folder, files, files_of_scene(scene.source));
  write_scalar(folder / "source.nrrd", pair.source, scene.spacing, scene.placement);
  write_scalar(folder / "target.nrrd", pair.target, scene.spacing, scene.placement);
  write_scalar(folder / "region.nrrd", pair.region, scene.spacing, scene.placement);
  write_vector(folder / "truth.nrrd", pair.truth, scene.spacing, scene.placement);
  fmt::print("  {}: source, target, region and truth (pixels) of {}\n\n", folder.string(), what);
}

json compare(const Call& call, const Scene& scene, const Backend& backend, Progress& progress) {
  json all = json::array();
  for (const std::string& name : call[kinds]) {
    const PlantedOptions options{
        .kind = static_cast<Planted>(std::ranges::find(planted_names, name) - planted_names.begin())};
    if (!call[option::output].empty()) {
      write_pair(call[option::output] / name, scene, plant(scene, options), name);
    }
    const json rows = compare_rivals(scene, options, !call[option::quick], backend, call.session(), progress);
    progress.clear();
    fmt::print("{}, {}: {} of {:g} px, noise {:g} %, seed {}; RMSD to the truth in pixels\n\n{}\n",
               scene.name, scene.extent().text(), name, options.amplitude, 100.0 * options.noise,
               options.seed, table_text(rows, "method|tissue|tissue_95:95 %|region|dice:Dice|folds|seconds"));
    if (scene.extent().axes() == 3 && !call[option::quick] && !have_plastimatch()) {
      fmt::print(
          "  plastimatch is not installed (Debian: plastimatch), so nobody else registers the volume\n\n");
    }
    all.insert(all.end(), rows.begin(), rows.end());
    call.keep(all, "rivals");
  }
  return all;
}

json look(const Call& call, const Scene& scene, const Backend& backend, Progress& progress) {
  const auto session = backend.open_elastic(call.session());
  progress.set_total(2.0 * call[detection]);
  progress.describe(fmt::format("rivals {}: planted inclusions", scene.name));
  const double noise = call[pictures] ? PlantedOptions{}.noise : PlantedInclusion{}.noise;
  const auto inclusion_of = [&](std::uint32_t number) {
    PlantedInclusion inclusion = call[spread] ? any_inclusion(number) : PlantedInclusion{.seed = number};
    inclusion.noise = noise;
    return inclusion;
  };
  if (call[pictures] && !call[option::output].empty()) {
    PlantedInclusion exact = inclusion_of(1);
    exact.noise = 0.0;
    const PlantedField field = plant(scene, exact);
    write_pair(call[option::output] / "inclusion", scene, pictures_of(scene, field, noise, exact.seed),
               fmt::format("an inclusion at x = {:.1f}, y = {:.1f}", field.x, field.y));
  }
  json rows = look_for_cases(call[detection], inclusion_of, {scene, call[pictures], *session}, progress);
  for (json& row : rows) {
    row["spread"] = call[spread];
  }
  progress.clear();
  fmt::print("{}, {}: {} cases with an inclusion of {}, as many without; noise {:g} % of {}\n{}", scene.name,
             scene.extent().text(), call[detection],
             call[spread] ? "radius 3 to 15 px and contrast 1.5 to 10"
                          : fmt::format("radius {:g} px and contrast {:g}", PlantedInclusion{}.radius,
                                        PlantedInclusion{}.contrast),
             100.0 * noise, call[pictures] ? "white, in the pictures" : "the largest displacement",
             row_text("  area under the ROC {area:.3f}; had the place been known {area_by_place:.3f}\n"
                      "  more than chance found in {found} cases with an inclusion, in {mistaken} without\n"
                      "  error of the position {distance:.2f} px, contrast found over the true one "
                      "{found_share:.2f}, medians\n",
                      detection_figures(rows)));
  return rows;
}

int run_rivals(Call& call) {
  const bool detects = call[detection] > 0;
  if (detects && !call[pictures]) {
    refuse_idle(*call.command, {"--output"}, "only pictures are written; with --detection give --pictures");
  }
  const Scene scene = scene_of(call);
  const auto registry = make_backends();
  const Backend& backend = choose_backend(call, registry, scene);
  if (!backend.has_elastic()) {
    throw InputError(fmt::format("{} has no elastic energy", backend.name()));
  }
  Progress progress;
  call.write((detects ? look : compare)(call, scene, backend, progress), detects ? "roc" : "rivals");
  return success;
}

} // namespace

void add_rivals(CLI::App& program, Call& call) {
  add_command(
      program, call, "rivals", run_rivals,
      "Both against planted truth, and what others do.\n"
      "register and detect against planted truth, and what others do: finite elements deform a slice,\n"
      "noise is added, and every method has to find out how.",
      {Options(option::scene, nullptr, "brain"), Options(option::size, "Image size: 300 (square) or 257x130"),
       option::orientation, option::slice, backend_options(),
       Options(option::quick, "Without mutual information: ITK's, and so without Algorithm 5; of a volume "
                              "without plastimatch"),
       kinds,
       Options(option::output,
               "Write the pictures of each pair to this folder, for register; with --pictures those of the "
               "first inclusion, for detect",
               ""),
       detection, spread, pictures, option::json},
      {"--slice needs --orientation", "--detection excludes --quick --planted", "--spread needs --detection",
       "--pictures needs --detection"});
}

} // namespace hdmbench::commands
