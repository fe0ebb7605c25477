#pragma once

#include "harness/ranks/crew_member.hpp"
#include "harness/scene/scene.hpp"

#include <string>

namespace hdmbench {

/// What a scene is but for its fields.
void put_outline(const Scene& scene, RankMessage& message);

/// Such a scene, whose fields the first rank has (`given`: level, and start where there is one), solved by
/// its method on all ranks; given.result becomes the displacement. Collective. `fault`: as find_rank_fault()
/// takes it.
void solve_scene(RankMessage& message, const CrewGiven& given, Ranks& ranks, const Sharing& sharing,
                 const std::string& fault, const Backend& backend, const SessionOptions& options);

} // namespace hdmbench
