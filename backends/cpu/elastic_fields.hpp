#pragma once

#include "backends/shared/elastic_session.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>
#include <vector>

namespace hdmbench {

/// The components of a field in a RingedGrid, the ring being 0.
struct RingedField {
  std::array<std::vector<float>, 3> planes; ///< one for each axis of the grid

  [[nodiscard]] std::vector<float>& operator[](std::size_t axis) { return planes[axis]; }
  [[nodiscard]] const std::vector<float>& operator[](std::size_t axis) const { return planes[axis]; }

  void require(const RingedGrid& grid) {
    for (std::size_t axis = 0; axis < grid.axes(); ++axis) {
      planes[axis].resize(grid.size());
    }
  }
};

/// The fields of all levels in the memory of the CPU. A field takes memory from its first use on: two of the
/// image's five are for conjugate gradients alone.
class ElasticFields {
public:
  /// All 0.
  void load(const ElasticHierarchy& hierarchy) {
    levels_.clear();
    levels_.resize(hierarchy.levels.size());
    grids_.clear();
    std::ranges::transform(hierarchy.levels, std::back_inserter(grids_), &ElasticLevel::grid);
  }

  [[nodiscard]] RingedField& at(int level, ElasticField field) {
    return required(static_cast<std::size_t>(level), field);
  }
  [[nodiscard]] const RingedField& at(int level, ElasticField field) const {
    return required(static_cast<std::size_t>(level), field);
  }

  /// Values of the level's extent.
  void write(int level, ElasticField field, const VectorField& values) {
    RingedField& to = at(level, field);
    for_each_row(level, [&](std::size_t axis, std::size_t outside, std::size_t inside, int width) {
      std::copy_n(values[axis].data() + outside, width, to[axis].data() + inside);
    });
  }
  void read(int level, ElasticField field, VectorField& values) const {
    const RingedField& from = at(level, field);
    values = VectorField(grids_.at(static_cast<std::size_t>(level)).sites);
    for_each_row(level, [&](std::size_t axis, std::size_t outside, std::size_t inside, int width) {
      std::copy_n(from[axis].data() + inside, width, values[axis].data() + outside);
    });
  }

  /// That of the image alone.
  void keep_displacement() {
    RingedField displacement = std::move(at(0, ElasticField::displacement));
    levels_ = std::vector<std::array<RingedField, elastic_fields>>(1);
    at(0, ElasticField::displacement) = std::move(displacement);
  }

private:
  /// call(axis, where the row begins in a VectorField, and in a RingedField, width)
  template <typename Call>
  void for_each_row(int level, const Call& call) const {
    const RingedGrid& grid = grids_.at(static_cast<std::size_t>(level));
    const Extent sites = grid.sites;
    for (std::size_t axis = 0; axis < sites.axes(); ++axis) {
      for (int row = 0; row < sites.height * sites.depth; ++row) {
        call(axis, sites.index(0, row), grid.index(0, row % sites.height, row / sites.height), sites.width);
      }
    }
  }

  RingedField& required(std::size_t level, ElasticField field) const {
    RingedField& result = levels_.at(level)[static_cast<std::size_t>(field)];
    result.require(grids_.at(level));
    return result;
  }

  std::vector<RingedGrid> grids_;
  mutable std::vector<std::array<RingedField, elastic_fields>> levels_;
};

/// A session whose fields are in the memory of the CPU.
class ElasticInMemory : public ElasticSession {
public:
  void read(int level, ElasticField field, VectorField& values) const final {
    fields_.read(level, field, values);
  }

protected:
  void do_load(ElasticHierarchy& hierarchy) override { fields_.load(hierarchy); }
  void do_end() final { fields_.keep_displacement(); }

  ElasticFields fields_;
};

} // namespace hdmbench
