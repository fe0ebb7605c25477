#pragma once

#include "harness/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <string_view>

namespace hdmbench {

/// What deforms the brain of a planted pair.
enum class Planted {
  growth,    ///< a disc of tissue expands; it looks different afterwards
  resection, ///< a disc near the surface becomes soft and dark, the surface beside it sinks
  pressure,  ///< the skull presses from one side; nothing looks different
};
inline constexpr std::array<std::string_view, 3> planted_names{"growth", "resection", "pressure"};

/// Truth is made with what the solver does not have: no inverse crime.
inline constexpr double planted_poisson = 0.4;

struct PlantedOptions {
  Planted kind = Planted::pressure;
  double amplitude = 10.0;    ///< largest displacement, pixels
  double noise = 0.03;        ///< standard deviation in both pictures, share of 255
  double region_share = 0.07; ///< radius of growth and resection over the image's width
  std::uint32_t seed = 1;     ///< place, direction, noise
};

struct PlantedPair {
  ScalarField source;
  ScalarField target;
  VectorField truth;  ///< pixels
  ScalarField region; ///< of interest: not 0
};

/// A pair of pictures whose displacement is known: plane-stress finite elements on a mesh of 0.8 pixels, in a
/// volume trilinear ones on a mesh of 3 voxels or at most about 30,000 nodes, with the scene's labels (label
/// 0 is the skull, prescribed), cubic interpolation of the picture, noise. Throws InputError where the scene
/// has no picture or no labels, or too few to find a place in, and for anything but pressure in a volume.
[[nodiscard]] PlantedPair plant(const Scene& scene, const PlantedOptions& options);

/// A part of the tissue that is stiffer or softer than its label says, which no picture shows.
struct PlantedInclusion {
  double radius = 8.0;   ///< pixels
  double contrast = 3.0; ///< its modulus over that of the labels; 1: nothing is hidden
  double noise = 0.01;   ///< of the observed displacement, standard deviation, share of the largest one
  double amplitude = 10.0;
  double region_share = 0.13; ///< radius of the region of interest over the image's width
  std::uint32_t seed = 1;
};

struct PlantedField {
  VectorField observed; ///< pixels
  ScalarField region;   ///< of interest, not 0: the tissue of a disc with the inclusion somewhere in it
  double x = 0.0;       ///< of the inclusion's centre
  double y = 0.0;
};

/// Pressure of the skull, as above.
[[nodiscard]] PlantedField plant(const Scene& scene, const PlantedInclusion& options);

/// The pictures before and after a planted field; `noise` as of PlantedOptions.
[[nodiscard]] PlantedPair pictures_of(const Scene& scene, const PlantedField& field, double noise,
                                      std::uint32_t seed);

} // namespace hdmbench
