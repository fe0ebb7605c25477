#pragma once

#include "harness/cli/arguments.hpp"
#include "harness/ranks/message_passing.hpp"

#include <cstddef>
#include <filesystem>
#include <string>

namespace hdmbench::commands {

/// What run takes among ranks.
struct RankArguments {
  std::filesystem::path output;
  std::filesystem::path json;
  std::size_t sites_per_rank = 0; ///< Sharing::fewest_sites; 0: its own
  int halo = 0;                   ///< sites, Sharing::halo; 0: chosen
};

/// `run` on several ranks, each of which holds a part of the scene and writes its part of the file. Returns
/// an ExitStatus.
[[nodiscard]] int run_scene_on_ranks(const SceneArguments& arguments, const RankArguments& rank_arguments,
                                     const std::string& line, Ranks& ranks);

} // namespace hdmbench::commands
