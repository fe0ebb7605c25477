#pragma once

#include "harness/judge/atlas/entry.hpp"
#include "harness/scene/sites.hpp"

/// What the entries build their scenes and measures of.
namespace hdmbench::atlas {

/// A shipped scene of `size` x `size` pixels with its displacements multiplied by `size` / 300, so that
/// strains are those of the thesis at every size.
[[nodiscard]] Scene shipped(const char* name, int size);

/// The square scene (left border dx < 0, bottom border dy > 0, the other two 0) of one material.
[[nodiscard]] Scene one_material(int size);

/// Gives every site the modulus `modulus_at`(column, row) MPa.
template <typename ModulusAt>
void set_moduli(Scene& scene, ModulusAt&& modulus_at) {
  const Extent extent = scene.extent();
  for_each_site(extent,
                [&](int x, int y) { scene.full.modulus.values[extent.index(x, y)] = modulus_at(x, y); });
  set_inverse_modulus(scene.full);
}

/// Inside the square in the middle, a third of the image wide, of the square scene.
[[nodiscard]] bool in_inclusion(Extent extent, int x, int y);

/// Prescribes both components of a site, confidence 1.
void hold(Scene& scene, int x, int y, float dx, float dy);

/// The scene against its own fixed point.
[[nodiscard]] Problem against_fixed_point(Scene scene);

/// RMSD to the truth over all sites, pixels.
[[nodiscard]] double rmsd_to_truth(const Problem& problem, const Outcome& outcome);

/// Methods that most entries compare; those that this build lacks show as such.
[[nodiscard]] std::vector<Series> usual_series();

// The groups of entries, each in a file of its own.
[[nodiscard]] std::vector<Entry> pyramid_entries();
[[nodiscard]] std::vector<Entry> step_entries();
[[nodiscard]] std::vector<Entry> material_entries();
[[nodiscard]] std::vector<Entry> condition_entries();
[[nodiscard]] std::vector<Entry> model_entries();
[[nodiscard]] std::vector<Entry> elastic_entries();

} // namespace hdmbench::atlas
