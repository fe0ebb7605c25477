#include "harness/cli/run_conditions.hpp"

#include "harness/scene/walls.hpp"
#include "kernels/data/elastic/conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace hdmbench::commands {

namespace {

/// What a site and the unit of displacements are called.
const char* sites_of(const Scene& scene) {
  return scene.extent().axes() == 3 ? "voxels" : "pixels";
}
const char* unit_of(const Scene& scene) {
  return scene.extent().axes() == 3 ? "voxels" : "px";
}

/// Prints what became of the pixels of the images of targets, and puts it into the row of the run; nothing of
/// a scene without such.
void report_observations(const Scene& scene, json& row) {
  if (const auto& observed = scene.observed) {
    row["observations"] = {{"given", observed->given},
                           {"acting", observed->acting},
                           {"exact", observed->exact},
                           {"farthest_px", observed->farthest}};
    fmt::print("  {} {} with a target: {} act, {} are certain{}\n", observed->given, sites_of(scene),
               observed->acting, observed->exact,
               observed->exact > 0 ? fmt::format(" and met to {:.2g} {}", observed->farthest, unit_of(scene))
                                   : "");
  }
}

/// Prints what pulls in all, and puts it into the row of the run; nothing of a scene without loads.
void report_loads(const Scene& scene, json& row) {
  if (has_forces(scene.full)) {
    const std::array<double, 3> sum = resultant_of_loads(scene);
    row["loads"] = {{"resultant_N", sum}};
    fmt::print("  loads: {:.3g} N{} in all (LPS)\n", fmt::join(sum, ", "),
               scene.extent().axes() == 3 ? "" : " per mm of thickness");
  }
}

/// Prints what was taken out, and puts it into the row of the run; nothing of a scene without such.
void report_resected(const Scene& scene, json& row) {
  if (const auto& resected = scene.resected) {
    row["resected"] = {{"sites", resected->sites}, {"sag_px", resected->sag}};
    fmt::print("  {} {} are taken out, which the loads of before had moved by {:.2g} {} at most\n",
               resected->sites, sites_of(scene), resected->sag, unit_of(scene));
  }
}

/// Prints how far walls gave way, and puts it into the row of the run; nothing of a scene without such.
void report_walls(const Scene& scene, const VectorField& displacement, json& row) {
  if (const WallReport walls = walls_under(scene.full, displacement); walls.sites > 0) {
    row["walls"] = {{"sites", walls.sites}, {"gave_way_px", walls.gave_way}};
    fmt::print("  {} {} slide along walls, which give way by {:.2g} {} at most\n", walls.sites,
               sites_of(scene), walls.gave_way, unit_of(scene));
  }
}

/// Prints how much of the scene has fibres, and puts it into the row of the run; nothing of one without.
void report_fibres(const Scene& scene, json& row) {
  std::size_t sites = 0;
  for (std::size_t site = 0; has_fibres(scene.full) && site < scene.extent().sites(); ++site) {
    sites += std::ranges::any_of(
                 scene.full.fibre.planes,
                 [&](const auto& component) { return !component.empty() && component[site] != 0.0F; })
                 ? 1
                 : 0;
  }
  if (sites > 0) {
    row["fibre_sites"] = sites;
    fmt::print("  {} {} have fibres\n", sites, sites_of(scene));
  }
}

/// Prints how much of the scene is void, and puts it into the row of the run; nothing of one without.
void report_void(const Scene& scene, json& row) {
  if (const auto sites = std::ranges::count(tissue_of(scene).values, 0.0F); sites > 0) {
    row["void_sites"] = sites;
    fmt::print(
        "  {} {} are void: the displacement there goes on smoothly from what is around, and no tissue has "
        "it\n",
        sites, sites_of(scene));
  }
}

} // namespace

void report_conditions(const Scene& scene, const VectorField& displacement, json& row) {
  report_observations(scene, row);
  report_resected(scene, row);
  report_loads(scene, row);
  report_walls(scene, displacement, row);
  report_fibres(scene, row);
  report_void(scene, row);
}

} // namespace hdmbench::commands
