#pragma once

#include "backends/shared/elastic_session.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

namespace hdmbench {

/// Both components of a field in a RingedGrid, the ring being 0.
struct RingedField {
  std::vector<float> x;
  std::vector<float> y;

  void require(const RingedGrid& grid) {
    x.resize(grid.size());
    y.resize(grid.size());
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
    const RingedGrid& grid = grids_.at(static_cast<std::size_t>(level));
    RingedField& to = at(level, field);
    for (int y = 0; y < grid.sites.height; ++y) {
      const std::size_t from = grid.sites.index(0, y);
      std::copy_n(values[0].data() + from, grid.sites.width, to.x.data() + grid.index(0, y));
      std::copy_n(values[1].data() + from, grid.sites.width, to.y.data() + grid.index(0, y));
    }
  }
  void read(int level, ElasticField field, VectorField& values) const {
    const RingedGrid& grid = grids_.at(static_cast<std::size_t>(level));
    const RingedField& from = at(level, field);
    values = VectorField(grid.sites);
    for (int y = 0; y < grid.sites.height; ++y) {
      const std::size_t to = grid.sites.index(0, y);
      std::copy_n(from.x.data() + grid.index(0, y), grid.sites.width, values[0].data() + to);
      std::copy_n(from.y.data() + grid.index(0, y), grid.sites.width, values[1].data() + to);
    }
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
  void load(const ElasticHierarchy& hierarchy) override {
    hierarchy_ = &hierarchy;
    fields_.load(hierarchy);
  }
  void write(int level, ElasticField field, const VectorField& values) final {
    fields_.write(level, field, values);
  }
  void read(int level, ElasticField field, VectorField& values) const final {
    fields_.read(level, field, values);
  }

protected:
  [[nodiscard]] const ElasticLevel& level_at(int level) const {
    return hierarchy_->levels.at(static_cast<std::size_t>(level));
  }
  [[nodiscard]] const RingedGrid& grid(int level) const { return level_at(level).grid; }
  [[nodiscard]] int coarsest() const { return static_cast<int>(hierarchy_->levels.size()) - 1; }

  const ElasticHierarchy* hierarchy_ = nullptr;
  ElasticFields fields_;
};

} // namespace hdmbench
