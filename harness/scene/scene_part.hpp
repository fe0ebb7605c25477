#pragma once

#include "backends/shared/cut.hpp"
#include "harness/scene/scene.hpp"

#include <functional>
#include <optional>
#include <string>

namespace hdmbench {

/// A scene of whose fields there is only a part.
struct ScenePart {
  Scene scene;     ///< scene.full has the image's extent and no fields; no start, picture, labels
  Rectangle sites; ///< which part
  Level full;      ///< fields and extent of these sites
  std::optional<VectorField> start; ///< of these sites; none: the null field
  /// The fields of the whole image were in memory on the way: an image from a file, or a condition on what is
  /// outside, whose outline runs through the whole image.
  bool made_whole = false;
};

/// Which part of an image of this extent; it may have no sites.
using ChoosePart = std::function<Rectangle(Extent)>;

/// load_scene(), but only a part is kept and, where the scene is generated, made: the same values.
[[nodiscard]] ScenePart load_scene_part(const std::string& scene, const SceneOptions& options,
                                        const ChoosePart& part);

} // namespace hdmbench
