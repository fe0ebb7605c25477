#pragma once

#include "harness/scene/images/images.hpp"
#include "harness/scene/scene.hpp"
#include "kernels/data/field.hpp"
#include "kernels/data/level.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace hdmbench {

/// A point of a finite element result: position and displacement in the same unit of length, y downwards as
/// in images.
struct MeshNode {
  double x = 0.0;
  double y = 0.0;
  double u = 0.0; ///< along x
  double v = 0.0; ///< along y
};

/// A strictly convex element with three (CPS3) or four (CPS4R) corners in order around it, either way round.
struct MeshElement {
  std::array<std::size_t, 4> nodes{}; ///< indices into Mesh::nodes; the first `corners` count
  std::size_t corners = 4;
};

struct Mesh {
  std::vector<MeshNode> nodes;
  std::vector<MeshElement> elements; ///< none: a cloud of points
};

/// Reads a node list, a line "id, x, y, u, v" per node, and an element list, a line "id, n1, n2, n3" or
/// "id, n1, n2, n3, n4" per element with the ids of its nodes. Commas, semicolons or white space between; '#'
/// begins a comment; a line of titles may come first. Throws InputError with file and line: a field that is
/// missing or no finite number, an id twice, an unknown node, an element that is concave, crosses itself or
/// has no area; and where a list is empty.
[[nodiscard]] Mesh read_mesh(const std::filesystem::path& nodes,
                             const std::optional<std::filesystem::path>& elements = std::nullopt);

/// Where the pixels lie among the nodes: the centre of pixel (i, j) is at origin + pixel * (i, j).
struct PixelGrid {
  Extent extent;
  double origin_x = 0.0; ///< in the mesh's unit, as is `pixel`
  double origin_y = 0.0;
  double pixel = 1.0; ///< side, > 0
};

struct MeshImage {
  VectorField displacement;  ///< pixels, 0 where undefined
  ScalarField mask;          ///< 255 where defined, else 0
  std::size_t undefined = 0; ///< pixels
};

/// The smallest grid of `extent` pixel centres over all nodes: the first and the last ones on the outermost
/// nodes along the axis that needs the larger pixels, centred along the other. Throws InputError where the
/// nodes or the pixels are a single point.
[[nodiscard]] PixelGrid grid_over(const Mesh& mesh, Extent extent);

/// Every pixel takes the displacement of the nearest node, the first one listed among equals (thesis Fig.
/// A.1); none within `reach` pixels: undefined. Throws InputError unless
/// grid.pixel > 0, every node is finite in pixels and reach >= 0.
[[nodiscard]] MeshImage nearest_node_image(const Mesh& mesh, const PixelGrid& grid, double reach);

/// Every pixel is interpolated with the shape functions of the element it lies in, bilinear (A.1)-(A.6) or
/// linear; outside all elements: undefined. What lies on an edge counts as inside, to a billionth of the
/// element. Throws InputError unless grid.pixel > 0 and every node is finite in
/// pixels.
[[nodiscard]] MeshImage element_image(const Mesh& mesh, const PixelGrid& grid);

/// Where every pixel goes, in pixels: a vector image, or the text that bUnwarpJ saves as "raw transformation"
/// (lines Width=W, Height=H, "X Trans ---", H rows of W numbers, "Y Trans ---", H rows), told apart by the
/// content. The spacing of a text is 1. Throws InputError with file and, in a text, line.
[[nodiscard]] Image<VectorField> read_positions(const std::filesystem::path& file);

/// Position minus the pixel's own position (thesis A.2).
[[nodiscard]] VectorField displacements_from_positions(const VectorField& positions);

/// Everything a scene is computed from as images that ITK, 3D Slicer and ParaView open, in `folder`:
/// picture.nrrd, modulus.nrrd (MPa), target.nrrd (pixels) and confidence.nrrd, labels.nrrd where the scene
/// has a segmentation and start.nrrd where it does not begin at 0; picture.png, target.png and confidence.png
/// to look at, in an image that is inspected (harness/scene/scene.hpp), as picture.nrrd; and, last,
/// scene.toml that refers to them and is the same problem to the bit (thesis A.3, A.6). Returns the names of
/// the files. Throws InputError where the folder does not exist or cannot be written, or in a build without
/// images.
std::vector<std::string> export_scene(const Scene& scene, const std::filesystem::path& folder);

/// A pixel: column and row.
struct SiteIndex {
  int x = 0;
  int y = 0;
  bool operator==(const SiteIndex&) const = default;
};

/// Which displacements of two sites are tried: `points` values of one component from low to high, for each.
struct EnergyPlaneOptions {
  std::array<SiteIndex, 2> sites;
  std::size_t axis = 0; ///< of the displacements
  double low = 0.0;     ///< pixels
  double high = 1.0;
  int points = 81; ///< >= 2
};

/// The total energy over two displacements, everything else as it is (thesis A.5).
struct EnergyPlane {
  std::vector<float> values;  ///< tried, pixels
  std::vector<double> energy; ///< [second * values.size() + first]: sum of U_t over all sites, not the mean
  std::size_t lowest = 0;     ///< index of the first smallest energy

  [[nodiscard]] double at(std::size_t first, std::size_t second) const {
    return energy[second * values.size() + first];
  }
  [[nodiscard]] float lowest_first() const { return values[lowest % values.size()]; }
  [[nodiscard]] float lowest_second() const { return values[lowest / values.size()]; }
};

/// The sum of U_t over all sites in double, thesis_energy.hpp.
[[nodiscard]] double total_energy(const Level& level, const VectorField& displacement);

/// Throws InputError where a site is not in the image or both are the same one.
void require_sites(const std::array<SiteIndex, 2>& sites, Extent extent);

/// Only the sites that have one of the two in their 3 x 3 are computed again for each pair. Throws InputError
/// where a site is not in the image, both are the same one, low is not below high or points < 2.
[[nodiscard]] EnergyPlane energy_plane(const Level& level, VectorField displacement,
                                       const EnergyPlaneOptions& options);

/// A standalone SVG file: the energy as a heat map in bands, a red ring at the lowest one of the grid, an
/// orange one at `here`, the displacements that the two sites have, where these are in the range.
[[nodiscard]] std::string energy_plot_svg(const EnergyPlane& plane, const EnergyPlaneOptions& options,
                                          std::array<float, 2> here, const std::string& title);

enum class SearchMethod { simplex, annealing };

struct TuneOptions {
  SearchMethod method = SearchMethod::simplex;
  double low = 0.01; ///< alpha is sought in low ... high, 0 < low < high < 1
  double high = 0.99;
  int evaluations = 40; ///< of the search, after the scan, about the most that are made; >= 1
};

struct Evaluation {
  double prior_weight; ///< alpha
  double rmsd;         ///< pixels
};

struct Tuning {
  /// Below this spread of the RMSD in pixels alpha is said not to matter.
  static constexpr double flat = 1e-3;

  std::vector<Evaluation> evaluations; ///< in the order they were made; the first ones are the scan
  std::size_t best = 0;                ///< index of the smallest RMSD; of equals the nearest to alpha = 0.5
  std::size_t scanned = 0;             ///< how many belong to the scan

  [[nodiscard]] double spread() const; ///< largest RMSD minus smallest
  [[nodiscard]] bool matters() const { return spread() >= flat; }
};

/// The alpha of the smallest RMSD (A.8). First a scan of five alphas over the range; where that is flat it is
/// all that is done. Then a search from the best of them over log(alpha / (1 - alpha)), so that it cannot
/// leave 0 ... 1: the downhill simplex of Nelder and Mead (thesis A.7.2), or simulated annealing (thesis
/// A.7.1, Alg. 1, which prints the rise with the other sign), the same chain on every machine. `rmsd_at` is
/// asked once for each alpha. Throws InputError where the range is impossible, and what rmsd_at throws.
[[nodiscard]] Tuning tune_prior_weight(const std::function<double(double)>& rmsd_at,
                                       const TuneOptions& options);

} // namespace hdmbench
