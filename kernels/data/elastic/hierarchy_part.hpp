#pragma once

#include "kernels/data/elastic/cell_kinds.hpp"
#include "kernels/data/elastic/hierarchy.hpp"

namespace hdmbench {

/// The finest levels of a part of an image.
struct ElasticPart {
  ElasticHierarchy hierarchy;
  CellKinds kinds; ///< of the coarsest level that was asked for
};

/// `levels` >= 2 levels of a part of an image, then a level of 2 x 2 sites without stiffness, so that it can
/// be loaded like any hierarchy. Where the part begins at a multiple of 2^(levels - 1) sites of the image,
/// and ends one site after such a multiple or with the image, its cells are those of the image on every
/// level, but for the last row and column of cells at an edge inside the image, which may have a spring too
/// much. The response of sites on such an edge is not the image's either.
[[nodiscard]] ElasticPart make_elastic_part(const Level& part, double poisson, Springs springs, int levels);

/// A level whose cells have no stiffness and whose sites do not respond.
[[nodiscard]] ElasticLevel empty_level(Extent sites);

/// `finest` and all levels below it, from its cells; `finest` is level `number`, and those before it are
/// empty: nothing may be asked of them. The bits of make_elastic_hierarchy().
[[nodiscard]] ElasticHierarchy make_coarse_elastic(ElasticLevel finest, CellKinds kinds,
                                                   const ElasticInFloat::PoissonRatio& ratio, int number);

} // namespace hdmbench
