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

  /// Takes memory for all sites of the grid, all 0, unless it has it.
  void require(const RingedGrid& grid);
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
  void write(int level, ElasticField field, const VectorField& values);
  void read(int level, ElasticField field, VectorField& values) const;

  /// That of the image alone.
  void keep_displacement() {
    RingedField displacement = std::move(at(0, ElasticField::displacement));
    levels_ = std::vector<std::array<RingedField, elastic_fields>>(1);
    at(0, ElasticField::displacement) = std::move(displacement);
  }

private:
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
