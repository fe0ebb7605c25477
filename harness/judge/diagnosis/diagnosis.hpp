#pragma once

#include "harness/applications/picture.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/scene.hpp"
#include "harness/solve/planner.hpp"
#include "harness/solve/solve.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hdmbench {

/// One reason not to trust a result, found before or after the run.
struct Warning {
  std::string kind;                   ///< a word that stays the same: "fold-over"
  std::string message;                ///< what is seen, with its numbers
  std::string advice;                 ///< what to do about it, by options of this program where there are any
  std::optional<std::size_t> sites{}; ///< how many sites (fold-over: cells between sites) show it
};

using Warnings = std::vector<Warning>;

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Warning, kind, message, advice, sites)

/// Says for people that a scene has no displacement: why, and what to do.
[[nodiscard]] std::string no_result_text(const Scene& scene, std::string_view why);

/// A block for people, lines of at most 110 characters that end in a newline; one line where nothing was
/// found.
[[nodiscard]] std::string warnings_text(std::span<const Warning> warnings);

/// What can be said before the run, from the scene and its schedule alone: the work of a few sweeps. The
/// kinds and what they say are in warnings.json.
[[nodiscard]] Warnings diagnose(const Scene& scene);

/// What the field itself says, `solution` being the scene's: again the work of a few sweeps.
[[nodiscard]] Warnings diagnose(const Scene& scene, const Solution& solution);

/// Both of these for a scene that is_inspected(); of a field that a plan has made, whose error it knows by a
/// method of its own, without what is said of methods.
[[nodiscard]] Warnings diagnose(const Scene& scene, const Solution& solution,
                                const std::optional<Plan>& plan);

inline constexpr std::string_view fold_over = "fold-over";

/// What a displacement alone says: fold_over where it turns cells over, near-fold where it nearly does;
/// `tissue` as least_area_ratios() has it.
[[nodiscard]] Warnings diagnose(const VectorField& displacement, const ScalarField& tissue = {});

inline constexpr std::string_view no_likeness = "no-likeness";
inline constexpr std::string_view worse_than_nothing = "worse-than-nothing";

/// What two pictures (gray values 0 ... 255) say about their registration, by how alike they were `before`
/// and are `after` it: no_likeness where they are no more alike than two pictures of noise, nothing-gained
/// where they did not differ by more than their noise, worse_than_nothing where by no measure they are more
/// alike than before.
[[nodiscard]] Warnings diagnose(const ScalarField& source, const ScalarField& target,
                                const Similarity& before, const Similarity& after);

// What a displacement does to the image: areas, in a volume volumes, from its gradient.

/// The area that a pixel takes after x -> x + d(x), relative to before: det(I + grad d), below 0 where the
/// image is turned over. Inside a cell of four sites d is bilinear and the determinant therefore linear in
/// both directions, so its least value over a cell is at a corner: this is exact, not a sample. One value
/// per cell, (width - 1) x (height - 1); an image one site thick has none. Of a volume alike, with the eight
/// corners of its cells, between which the determinant may be a little less: there it is a sample. Cells with
/// a corner where `tissue` is 0 have 1, whatever becomes of them; empty: all count.
[[nodiscard]] ScalarField least_area_ratios(const VectorField& displacement, const ScalarField& tissue = {});

/// least_area_ratios as a map with one value per site: the least of the cells around it, minus 1, so that 0
/// is unchanged, -1 a fold, 1 a doubled area or volume. 0 where there is no cell. Cells with a corner where
/// `tissue` is 0 do not count.
[[nodiscard]] ScalarField area_change_map(const VectorField& displacement, const ScalarField& tissue = {});

} // namespace hdmbench
