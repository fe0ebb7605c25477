#pragma once

#include "harness/scene/scene.hpp"
#include "harness/solve/progress.hpp"

namespace hdmbench {

/// Makes forces of what the tissue carried that was taken out of the scene ([[resect]]): what is missing for
/// the rest to be in balance where the loads of before had moved the body. So the scene's displacement is
/// from the state of its image, whose stress changes no stiffness, to the one without the tissue. No effect
/// where Scene::before is none. Takes the processor, so that all backends get the same bits. Throws
/// InputError where nothing held the body before, or its laws had no answer.
void unload(Scene& scene, Progress& progress);

/// Throws std::logic_error where unload() is still to be called.
void require_unloaded(const Scene& scene);

} // namespace hdmbench
