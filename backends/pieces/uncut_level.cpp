#include "backends/pieces/uncut_level.hpp"

#include "backends/pieces/sharing.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

namespace hdmbench {

namespace {

std::size_t prescribed_of(std::size_t axes) {
  return axes == 3 ? axes : 0;
}
std::size_t entries_of(std::size_t axes) {
  return (axes << axes) * (axes << axes);
}

/// call(its place among all sites of `part`, its coordinates) for each that has a cell at its far corner.
template <typename Call>
void for_each_cell(const Box& part, Extent cells, const Call& call) {
  const Extent extent = part.extent();
  for (int row = 0; row < extent.rows(); ++row) {
    const int y = part.first[1] + row % extent.height;
    const int z = part.first[2] + row / extent.height;
    for (int x = 0; x < extent.width && y < cells.height && z < cells.depth; ++x) {
      if (part.first[0] + x < cells.width) {
        call(extent.index(x, row), part.first[0] + x, y, z);
      }
    }
  }
}

/// The matrices of masked cells in the order of the level. `numbers` are their places in the arrays.
MaskedCells masked_cells(CellKinds& kinds, std::size_t axes, std::span<const float> matrices,
                         std::span<const std::uint32_t> numbers) {
  const Extent cells = kinds.extent;
  MaskedCells masked;
  masked.components = axes << axes;
  masked.rows = static_cast<std::size_t>(cells.height);
  kinds.index.resize(cells.sites());
  const std::size_t entries = entries_of(axes);
  const std::size_t count = matrices.size() / entries;
  for (int row = 0; row < cells.rows(); ++row) {
    masked.begin.push_back(masked.x.size());
    for (int x = 0; x < cells.width; ++x) {
      const std::size_t cell = cells.index(x, row);
      if (kinds.kind[cell] == CellKind::masked) {
        kinds.index[cell] = static_cast<std::uint32_t>(masked.x.size());
        masked.x.push_back(x);
        for (std::size_t entry = 0; entry < entries; ++entry) {
          masked.stiffness.push_back(matrices[entry * count + numbers[cell]]);
        }
      }
    }
  }
  masked.begin.push_back(masked.x.size());
  return masked;
}

/// Where the masked cells of each piece lie among those of all pieces, as a row.
std::vector<Box> segments(Exchange& exchange, std::size_t pieces, std::span<const OwnCells> own) {
  const PieceRange here = own_pieces(exchange, pieces);
  std::vector<Box> result(pieces);
  int first = 0;
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const bool is_here = piece >= here.first && piece < here.end;
    const std::int64_t count =
        exchange.sum(is_here ? static_cast<std::int64_t>(own[piece - here.first].masked) : 0);
    if (count > 0) {
      result[piece] = {.first = {first, 0, 0}, .end = {first + static_cast<int>(count), 1, 1}};
      first += static_cast<int>(count);
    }
  }
  return result;
}

/// Returns what the first process has of an array of each piece, empty elsewhere.
std::vector<float> on_first(Exchange& exchange, std::span<const Box> held, Extent all,
                            std::span<const OwnCells> own, std::vector<float> OwnCells::*array,
                            std::size_t arrays) {
  std::vector<std::vector<float>> values;
  std::ranges::transform(own, std::back_inserter(values), array);
  return std::move(redistribute(exchange, Purpose::cells, held, all_on_first(all, held.size()), values,
                                static_cast<int>(arrays))
                       .front());
}

} // namespace

OwnCells::OwnCells(const ElasticLevel& level, const Coarsening& coarsening, const Box& owned) {
  const RingedGrid& grid = level.grid;
  const std::size_t axes = grid.axes();
  const std::size_t sites = owned.extent().sites();
  const CellKinds& kinds = coarsening.kinds;
  arrays.resize((moments_of_cells(axes) + 1 + prescribed_of(axes)) * sites);
  std::vector<std::size_t> with_matrix;
  for_each_cell(owned, kinds.extent, [&](std::size_t site, int x, int y, int z) {
    for (std::size_t moment = 0; moment < moments_of_cells(axes); ++moment) {
      arrays[moment * sites + site] = level.moments[moment][grid.index(x, y, z)];
    }
    const std::size_t cell = kinds.extent.index(x, y, z);
    arrays[moments_of_cells(axes) * sites + site] = static_cast<float>(kinds.kind[cell]);
    if (kinds.kind[cell] == CellKind::masked) {
      with_matrix.push_back(kinds.index[cell]);
    }
  });
  for (std::size_t axis = 0; axis < prescribed_of(axes); ++axis) {
    float* const to = arrays.data() + (moments_of_cells(axes) + 1 + axis) * sites;
    for_each_cell(owned, grid.sites, [&](std::size_t site, int x, int y, int z) {
      to[site] = static_cast<float>(coarsening.prescribed.component[axis][grid.index(x, y, z)]);
    });
  }
  masked = with_matrix.size();
  matrices.resize(masked * entries_of(axes));
  for (std::size_t i = 0; i < masked; ++i) {
    const float* const matrix = level.masked.matrix(with_matrix[i]);
    for (std::size_t entry = 0; entry < entries_of(axes); ++entry) {
      matrices[entry * masked + i] = matrix[entry];
    }
  }
}

ParentLevel uncut_level(Exchange& exchange, const ElasticLevel& shape, std::span<const Box> owned,
                        std::span<const OwnCells> own) {
  const Extent extent = shape.grid.sites;
  const std::size_t axes = extent.axes();
  const std::size_t sites = extent.sites();
  const std::vector<float> values = on_first(exchange, owned, extent, own, &OwnCells::arrays,
                                             moments_of_cells(axes) + 1 + prescribed_of(axes));
  const std::vector<Box> held = segments(exchange, owned.size(), own);
  const int count = std::ranges::max(held, {}, [](const Box& box) { return box.end[0]; }).end[0];
  std::vector<float> matrices;
  if (count > 0) {
    matrices = on_first(exchange, held, {count, 1}, own, &OwnCells::matrices, entries_of(axes));
  }
  if (exchange.rank() != 0) {
    return {};
  }
  ParentLevel all{.level = empty_level(extent, moments_of_cells(axes)), .coarsening = {}};
  all.level.ratio = shape.ratio;
  all.level.stride = shape.stride;
  CellKinds& kinds = all.coarsening.kinds;
  kinds.extent = shape.grid.cells();
  kinds.kind.resize(kinds.extent.sites());
  all.coarsening.prescribed.component.resize(prescribed_of(axes),
                                             std::vector<std::uint8_t>(shape.grid.size()));
  for_each_cell(all_of(extent), kinds.extent, [&](std::size_t site, int x, int y, int z) {
    for (std::size_t moment = 0; moment < moments_of_cells(axes); ++moment) {
      all.level.moments[moment][shape.grid.index(x, y, z)] = values[moment * sites + site];
    }
    kinds.kind[kinds.extent.index(x, y, z)] =
        static_cast<CellKind>(values[moments_of_cells(axes) * sites + site]);
  });
  for (std::size_t axis = 0; axis < prescribed_of(axes); ++axis) {
    const float* const from = values.data() + (moments_of_cells(axes) + 1 + axis) * sites;
    for_each_cell(all_of(extent), extent, [&](std::size_t site, int x, int y, int z) {
      all.coarsening.prescribed.component[axis][shape.grid.index(x, y, z)] = from[site] != 0.0F ? 1 : 0;
    });
  }
  std::vector<std::uint32_t> numbers(kinds.kind.size());
  std::uint32_t next = 0;
  for (const Box& part : owned) {
    for_each_cell(part, kinds.extent, [&](std::size_t /*site*/, int x, int y, int z) {
      const std::size_t cell = kinds.extent.index(x, y, z);
      numbers[cell] = kinds.kind[cell] == CellKind::masked ? next++ : 0;
    });
  }
  all.level.masked = masked_cells(kinds, axes, matrices, numbers);
  return all;
}

} // namespace hdmbench
