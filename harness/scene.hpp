#pragma once

#include "kernels/level.hpp"
#include "kernels/pyramid.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// When the iterations of a level end.
enum class Stop {
  fixed,  ///< after exactly `iterations`
  still,  ///< when no site changed, at the latest after `iterations`
  energy, ///< when the mean energy moved by less than `epsilon` (thesis 5.3), at the latest after
          ///< `iterations`
};

/// How the pyramid is run: thesis Alg. 3.
struct Schedule {
  int iterations = 50; ///< per level, exact or at most, see stop; >= 0
  Stop stop = Stop::fixed;
  double epsilon = 1e-6;          ///< for Stop::energy
  std::optional<int> start_level; ///< first level computed, 0 = full resolution; none: the coarsest
  Alignment alignment = Alignment::corner;
  Update update = Update::simultaneous;
};

/// A problem at full resolution together with the way the thesis solves it.
struct Scene {
  std::string name;     ///< "square"
  std::string source;   ///< the name or path it was loaded by
  std::string title;    ///< one line for people
  Level full;           ///< the finest level: everything but the displacement
  VectorField start;    ///< displacement to begin with, pixels
  ScalarField picture;  ///< gray values 0 ... 255, only to look at
  double spacing = 1.0; ///< millimetres per pixel
  double poisson = 0.3; ///< Poisson's ratio of all tissues, for the finite elements; HDM has none
  Schedule schedule;

  [[nodiscard]] Extent extent() const { return full.extent; }
};

/// What the command line may change about a scene file.
struct SceneOptions {
  std::optional<Extent> size; ///< pixels; none: the file's own
};

/// The shipped scenes in the order of the thesis, the brain last.
[[nodiscard]] std::vector<std::string> shipped_scenes();

/// `scene` is the name of a shipped scene or the path of a TOML file (harness/scenes/README.md). Throws
/// InputError with file, line where there is one, and what to do; MissingFile where a file that the scene
/// refers to, or what is needed to read it, is not on this machine.
[[nodiscard]] Scene load_scene(const std::string& scene, const SceneOptions& options = {});

} // namespace hdmbench
