#include "backends/cpu/elastic_fields.hpp"

#include <span>

namespace hdmbench {

namespace {

/// call(axis, where the row begins in a VectorField, and in a RingedField) for all rows, on all threads.
template <typename Call>
void for_each_row(const RingedGrid& grid, const Call& call) {
  const Extent sites = grid.sites;
  for (std::size_t axis = 0; axis < sites.axes(); ++axis) {
#pragma omp parallel for if (sites.sites() > sites_worth_threads)
    for (int row = 0; row < sites.rows(); ++row) {
      call(axis, sites.index(0, row), grid.index(0, row % sites.height, row / sites.height));
    }
  }
}

} // namespace

void RingedField::require(const RingedGrid& grid) {
  if (planes[0].empty()) {
    const std::array<std::vector<float>*, 3> arrays{&planes[0], &planes[1], &planes[2]};
    make_zeros(std::span(arrays).first(grid.axes()), grid.size());
  }
}

void ElasticFields::write(int level, ElasticField field, const VectorField& values) {
  RingedField& to = at(level, field);
  const RingedGrid& grid = grids_.at(static_cast<std::size_t>(level));
  for_each_row(grid, [&](std::size_t axis, std::size_t outside, std::size_t inside) {
    std::copy_n(values[axis].data() + outside, grid.sites.width, to[axis].data() + inside);
  });
}

void ElasticFields::read(int level, ElasticField field, VectorField& values) const {
  const RingedField& from = at(level, field);
  const RingedGrid& grid = grids_.at(static_cast<std::size_t>(level));
  resize(values, grid.sites);
  for_each_row(grid, [&](std::size_t axis, std::size_t outside, std::size_t inside) {
    std::copy_n(from[axis].data() + inside, grid.sites.width, values[axis].data() + outside);
  });
}

} // namespace hdmbench
