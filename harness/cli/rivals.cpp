#include "harness/judge/registration/rivals.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/cli/arguments.hpp"
#include "harness/scene/images/images.hpp"

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;
struct Arguments {
  SceneArguments scene;
  std::vector<std::string> kinds{planted_names.begin(), planted_names.end()};
  bool quick = false;
  int detection = 0; ///< pairs of cases; 0: registration
  bool pictures = false;
  bool spread = false;
  fs::path output;
};

/// What one of the two things that rivals does comes to.
struct Found {
  const char* command; ///< as result files call it
  json rows;
};

/// For `register` and `detect`.
void write_pair(const fs::path& folder, const Scene& scene, const PlantedPair& pair, std::string_view what) {
  const std::vector<std::string> files{"source.nrrd", "target.nrrd", "region.nrrd", "truth.nrrd"};
  require_folder(folder, files, files_of_scene(scene.source));
  write_scalar(folder / "source.nrrd", pair.source, scene.spacing, scene.placement);
  write_scalar(folder / "target.nrrd", pair.target, scene.spacing, scene.placement);
  write_scalar(folder / "region.nrrd", pair.region, scene.spacing, scene.placement);
  write_vector(folder / "truth.nrrd", pair.truth, scene.spacing, scene.placement);
  fmt::print("  {}: source, target, region and truth (pixels) of {}\n\n", folder.string(), what);
}

Found compare(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress) {
  json all = json::array();
  for (const std::string& name : arguments.kinds) {
    const PlantedOptions options{
        .kind = static_cast<Planted>(std::ranges::find(planted_names, name) - planted_names.begin())};
    if (!arguments.output.empty()) {
      write_pair(arguments.output / name, scene, plant(scene, options), name);
    }
    const json rows =
        compare_rivals(scene, options, !arguments.quick, backend, arguments.scene.session, progress);
    progress.clear();
    fmt::print("{}, {}: {} of {:g} px, noise {:g} %, seed {}; RMSD to the truth in pixels\n\n{}\n",
               scene.name, size_text(scene.extent()), name, options.amplitude, 100.0 * options.noise,
               options.seed, table_text(rows, "method|tissue|tissue_95:95 %|region|dice:Dice|folds|seconds"));
    all.insert(all.end(), rows.begin(), rows.end());
  }
  return {"rivals", std::move(all)};
}

Found look(const Arguments& arguments, const Scene& scene, const Backend& backend, Progress& progress) {
  const auto session = backend.open_elastic(arguments.scene.session);
  progress.set_total(2.0 * arguments.detection);
  progress.describe(fmt::format("rivals {}: planted inclusions", scene.name));
  const double noise = arguments.pictures ? PlantedOptions{}.noise : PlantedInclusion{}.noise;
  const auto inclusion_of = [&](std::uint32_t number) {
    PlantedInclusion inclusion = arguments.spread ? any_inclusion(number) : PlantedInclusion{.seed = number};
    inclusion.noise = noise;
    return inclusion;
  };
  if (arguments.pictures && !arguments.output.empty()) {
    PlantedInclusion exact = inclusion_of(1);
    exact.noise = 0.0;
    const PlantedField field = plant(scene, exact);
    write_pair(arguments.output / "inclusion", scene, pictures_of(scene, field, noise, exact.seed),
               fmt::format("an inclusion at x = {:.1f}, y = {:.1f}", field.x, field.y));
  }
  json rows =
      look_for_cases(arguments.detection, inclusion_of, {scene, arguments.pictures, *session}, progress);
  for (json& row : rows) {
    row["spread"] = arguments.spread;
  }
  progress.clear();
  fmt::print("{}, {}: {} cases with an inclusion of {}, as many without; noise {:g} % of {}\n{}", scene.name,
             size_text(scene.extent()), arguments.detection,
             arguments.spread ? "radius 3 to 15 px and contrast 1.5 to 10"
                              : fmt::format("radius {:g} px and contrast {:g}", PlantedInclusion{}.radius,
                                            PlantedInclusion{}.contrast),
             100.0 * noise, arguments.pictures ? "white, in the pictures" : "the largest displacement",
             row_text("  area under the ROC {area:.3f}; had the place been known {area_by_place:.3f}\n"
                      "  more than chance found in {found} cases with an inclusion, in {mistaken} without\n"
                      "  error of the position {distance:.2f} px, contrast found over the true one "
                      "{found_share:.2f}, medians\n",
                      detection_figures(rows)));
  return {"roc", std::move(rows)};
}

int run_rivals(Arguments& arguments, Call& call) {
  if (arguments.detection > 0 && !arguments.pictures) {
    refuse_idle(*call.command, {"--output"}, "only pictures are written; with --detection give --pictures");
  }
  const Scene scene = arguments.scene.load();
  const auto registry = make_backends();
  const Backend& backend = arguments.scene.choose(registry, scene);
  if (!backend.has_elastic()) {
    throw InputError(fmt::format("{} has no elastic energy", backend.name()));
  }
  Progress progress;
  const auto& run = arguments.detection > 0 ? look : compare;
  Found found = run(arguments, scene, backend, progress);
  call.write(std::move(found.rows), arguments.quick, found.command);
  return success;
}

} // namespace

void add_rivals(CLI::App& program, Call& call) {
  const auto [command, own] =
      declare(program, call, "rivals",
              "register and detect against planted truth, and what others do: finite elements deform a "
              "slice,\nnoise is added, and every method has to find out how.",
              run_rivals);
  own.scene.scene = "brain";
  own.scene.schedule.takes_energy = true;
  add_option(command, "scene", own.scene.scene, "Scene by name or TOML file");
  add_option(command, "--size", own.scene.size, "Image size: 300 (square) or 257x130");
  own.scene.add_orientation_to(command);
  own.scene.add_backend_to(command);
  CLI::Option* const quick = add_flag(command, "--quick", own.quick,
                                      "Without mutual information: ITK's, and so without Algorithm 5");
  CLI::Option* const planted =
      add_option(command, "--planted", own.kinds, "What deforms: growth, resection, pressure, with commas")
          ->delimiter(',')
          ->check(CLI::IsMember(std::vector<std::string>(planted_names.begin(), planted_names.end())));
  add_output_folder(
      command, own.output,
      "Write the pictures of each pair to this folder, for register; with --pictures those of the "
      "first inclusion, for detect");
  CLI::Option* const detection = add_option(command, "--detection", own.detection,
                                            "So many cases with a hidden inclusion, and as many without")
                                     ->check(CLI::Range(1, 1'000'000))
                                     ->excludes(quick)
                                     ->excludes(planted);
  add_flag(command, "--spread", own.spread, "Radius 3 to 15 pixels and contrast 1.5 to 10, another each case")
      ->needs(detection);
  add_flag(command, "--pictures", own.pictures,
           "The displacement is not given: Algorithm 6 finds it in pictures that do not show the inclusion")
      ->needs(detection);
  add_json(command, call);
}

} // namespace hdmbench::commands
