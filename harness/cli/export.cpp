#include "harness/cli/arguments.hpp"
#include "harness/cli/commands.hpp"
#include "harness/judge/accuracy/truths.hpp"
#include "harness/scene/file_output.hpp"
#include "harness/scene/images/images.hpp"
#include "harness/solve/progress.hpp"
#include "harness/tools/export_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace hdmbench::commands {

namespace {

namespace fs = std::filesystem;

struct Arguments {
  SceneArguments scene;
  fs::path output = "hdmbench-scene";
  bool finite_elements = false;
};

void write_scene(const Arguments& arguments) {
  const Scene scene = arguments.scene.load();
  const std::vector<std::string> files{
      "scene.toml",    "picture.nrrd", "picture.png", "modulus.nrrd",    "target.nrrd",
      "target.png",    "labels.nrrd",  "start.nrrd",  "confidence.nrrd", "displacement-fem.nrrd",
      "confidence.png"};
  require_folder(arguments.output, files, arguments.scene.files());
  Progress progress;
  progress.describe(fmt::format("export {}", scene.name));
  std::vector<std::string> names;
  if (arguments.finite_elements) {
    progress.describe(fmt::format("export {}: solving the finite elements", scene.name));
    names.emplace_back("displacement-fem.nrrd");
    write_displacement(arguments.output / names.back(),
                       find_finite_elements(scene, scene.poisson).displacement.to_float(), scene.spacing,
                       scene.placement);
  }
  const auto images = export_scene(scene, arguments.output);
  names.insert(names.end(), images.begin(), images.end());
  progress.clear();
  fmt::print("{}, {} x {} pixels of {:.4g} mm: {} files in {}\n  {}\n", scene.title, scene.extent().width,
             scene.extent().height, scene.spacing, names.size(), arguments.output.string(),
             fmt::join(names, "\n  "));
  fmt::print("\n  hdmbench run {} solves the same problem.\n",
             shell_word((arguments.output / "scene.toml").string()));
}

} // namespace

void add_export(const Command& program) {
  const Command command = program.add_subcommand(
      "export",
      "Write all inputs of a scene as images (NRRD, with PNGs to look at) and a scene file that "
      "refers to them\n(thesis A.3, A.6, A.8). --size computes the scene, and the finite elements, at that "
      "size; the images of a scene file are\nscaled when it is read with --size.");
  const auto own = std::make_shared<Arguments>();
  own->scene.add_scene_to(command);
  command.add_option("--output", own->output, "Folder for the files, made if missing").capture_default_str();
  command.add_flag("--fem", own->finite_elements,
                   "Also the displacement by finite elements (plane stress), in millimetres");
  command.callback([own] { write_scene(*own); });
}

} // namespace hdmbench::commands
