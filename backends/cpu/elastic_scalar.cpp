#include "backends/cpu/elastic_scalar.hpp"

#include "backends/cpu/elastic_fields.hpp"

namespace hdmbench {

namespace {

using InFloat = ElasticInFloat;

class ElasticScalar final : public ElasticSession {
public:
  void load(const ElasticHierarchy& hierarchy) override {
    hierarchy_ = &hierarchy;
    fields_.load(hierarchy);
  }
  void write(int level, ElasticField field, const VectorField& values) override {
    fields_.write(level_at(level).grid, level, field, values);
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    fields_.read(level_at(level).grid, level, field, values);
  }

  void relax(int level, ElasticField field) override {
    RingedField& current = fields_.at(level, field);
    RingedField next = current;
    for_each_site(level, [&](int x, int y, std::size_t at) {
      move(level, at, residual(level, field, x, y), current, next);
    });
    current = std::move(next);
  }

  void relax_from_zero(int level) override {
    RingedField& correction = fields_.at(level, ElasticField::correction);
    const RingedField& load = fields_.at(level, ElasticField::load);
    const RingedField null{std::vector<float>(load.x.size()), std::vector<float>(load.y.size())};
    for_each_site(level, [&](int /*x*/, int /*y*/, std::size_t at) {
      move(level, at, {load.x[at], load.y[at]}, null, correction);
    });
  }

  void forces(ElasticField of, ElasticField to) override {
    RingedField& result = fields_.at(0, to);
    for_each_site(0, [&](int x, int y, std::size_t at) {
      const InFloat::Force force = on_free(0, at, force_on(0, of, x, y));
      result.x[at] = force.x;
      result.y[at] = force.y;
    });
  }

  void restrict_residual(int level, ElasticField of) override {
    restrict_sites(level, [&](int x, int y) { return residual(level, of, x, y); });
  }

  void restrict_load(int level) override {
    const RingedField& load = fields_.at(level, ElasticField::load);
    const RingedGrid& grid = level_at(level).grid;
    restrict_sites(level, [&](int x, int y) {
      return InFloat::Force{load.x[grid.index(x, y)], load.y[grid.index(x, y)]};
    });
  }

  void interpolate(int level) override {
    RingedField& correction = fields_.at(level, ElasticField::correction);
    std::ranges::fill(correction.x, 0.0F);
    std::ranges::fill(correction.y, 0.0F);
    correct(level, ElasticField::correction);
  }

  void correct(int level, ElasticField field) override {
    RingedField& values = fields_.at(level, field);
    const RingedField& coarse = fields_.at(level + 1, ElasticField::correction);
    const RingedGrid& grid = level_at(level + 1).grid;
    for_each_site(level, [&](int x, int y, std::size_t at) {
      const std::array around{grid.index(x / 2, y / 2), grid.index(x / 2 + x % 2, y / 2),
                              grid.index(x / 2, y / 2 + y % 2), grid.index(x / 2 + x % 2, y / 2 + y % 2)};
      const bool is_image = level == 0;
      if (!is_image || level_at(0).response[0][at] > 0.0F) {
        values.x[at] = corrected(values.x[at], coarse.x, around, x % 2, y % 2);
      }
      if (!is_image || level_at(0).response[2][at] > 0.0F) {
        values.y[at] = corrected(values.y[at], coarse.y, around, x % 2, y % 2);
      }
    });
  }

  void solve_coarsest() override {
    const int level = static_cast<int>(hierarchy_->levels.size()) - 1;
    const RingedGrid& grid = level_at(level).grid;
    const RingedField& load = fields_.at(level, ElasticField::load);
    RingedField& correction = fields_.at(level, ElasticField::correction);
    const std::size_t size = 2 * grid.sites.sites();
    for_each_site(level, [&](int x, int y, std::size_t at) {
      for (std::size_t component = 0; component < 2; ++component) {
        const std::size_t row = 2 * grid.sites.index(x, y) + component;
        float sum = 0.0F;
        for (int j = 0; j < grid.sites.height; ++j) {
          for (int i = 0; i < grid.sites.width; ++i) {
            const std::size_t column = 2 * grid.sites.index(i, j);
            sum = InFloat::with_term(sum, hierarchy_->coarsest_inverse[column * size + row],
                                     load.x[grid.index(i, j)]);
            sum = InFloat::with_term(sum, hierarchy_->coarsest_inverse[(column + 1) * size + row],
                                     load.y[grid.index(i, j)]);
          }
        }
        (component == 0 ? correction.x : correction.y)[at] = sum;
      }
    });
  }

  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    RingedField& result = fields_.at(0, to);
    const RingedField& from = fields_.at(0, value);
    const RingedField& along = fields_.at(0, direction);
    for_each_site(0, [&](int /*x*/, int /*y*/, std::size_t at) {
      result.x[at] = InFloat::advanced(from.x[at], factor, along.x[at]);
      result.y[at] = InFloat::advanced(from.y[at], factor, along.y[at]);
    });
  }

  float dot(ElasticField first, ElasticField second) const override {
    const RingedGrid& grid = level_at(0).grid;
    const RingedField& a = fields_.at(0, first);
    const RingedField& b = fields_.at(0, second);
    ScalarField sums(grid.sites);
    for_each_site(0, [&](int x, int y, std::size_t at) {
      sums.values[grid.sites.index(x, y)] = InFloat::site_product(a.x[at], b.x[at], a.y[at], b.y[at]);
    });
    while (sums.extent.sites() > 1) {
      const Extent fine = sums.extent;
      const auto value = [&](int x, int y) {
        return x < fine.width && y < fine.height ? sums.values[fine.index(x, y)] : 0.0F;
      };
      ScalarField squares({(fine.width + 1) / 2, (fine.height + 1) / 2});
      for (int y = 0; y < squares.extent.height; ++y) {
        for (int x = 0; x < squares.extent.width; ++x) {
          squares.values[squares.extent.index(x, y)] =
              InFloat::square_sum(value(2 * x, 2 * y), value(2 * x + 1, 2 * y), value(2 * x, 2 * y + 1),
                                  value(2 * x + 1, 2 * y + 1));
        }
      }
      sums = std::move(squares);
    }
    return sums.values.front();
  }

private:
  [[nodiscard]] const ElasticLevel& level_at(int level) const {
    return hierarchy_->levels.at(static_cast<std::size_t>(level));
  }

  /// call(x, y, index) for every site.
  template <typename Call>
  void for_each_site(int level, const Call& call) const {
    const RingedGrid& grid = level_at(level).grid;
    for (int y = 0; y < grid.sites.height; ++y) {
      for (int x = 0; x < grid.sites.width; ++x) {
        call(x, y, grid.index(x, y));
      }
    }
  }

  /// What cell (x, y) does to its corner, 0 ... 3 in reading order. Cells of the ring do nothing.
  [[nodiscard]] InFloat::Force force_of_cell(int level, ElasticField field, int x, int y, int corner) const {
    const ElasticLevel& here = level_at(level);
    const RingedField& values = fields_.at(level, field);
    const std::size_t at = here.grid.index(x, y);
    const auto corners = [&](const std::vector<float>& of) {
      return InFloat::CellCorners{of[at], of[at + 1], of[at + here.grid.pitch], of[at + here.grid.pitch + 1]};
    };
    const InFloat::CellCorners dx = corners(values.x);
    const InFloat::CellCorners dy = corners(values.y);
    const auto [first, last] = here.masked.row(y);
    for (std::size_t i = first; i < last; ++i) {
      if (here.masked.cells[i].x == x) {
        return force_of_masked(here.masked.cells[i], dx, dy, corner);
      }
    }
    const InFloat::CellTension tension = InFloat::cell_tension(here.cell(at), dx, dy, hierarchy_->ratio);
    return corner == 0   ? InFloat::force_on_top_left(tension)
           : corner == 1 ? InFloat::force_on_top_right(tension)
           : corner == 2 ? InFloat::force_on_bottom_left(tension)
                         : InFloat::force_on_bottom_right(tension);
  }

  [[nodiscard]] static InFloat::Force force_of_masked(const MaskedCell& cell, const InFloat::CellCorners& dx,
                                                      const InFloat::CellCorners& dy, int corner) {
    const std::array values{dx.top_left,    dy.top_left,    dx.top_right,    dy.top_right,
                            dx.bottom_left, dy.bottom_left, dx.bottom_right, dy.bottom_right};
    const std::size_t row = 2 * static_cast<std::size_t>(corner);
    InFloat::Force force{0.0F, 0.0F};
    for (std::size_t column = 0; column < 8; ++column) {
      force.x = InFloat::masked_force(force.x, cell.stiffness[8 * column + row], values[column]);
      force.y = InFloat::masked_force(force.y, cell.stiffness[8 * column + row + 1], values[column]);
    }
    return force;
  }

  [[nodiscard]] InFloat::Force force_on(int level, ElasticField field, int x, int y) const {
    return InFloat::sum_of_cells(
        force_of_cell(level, field, x - 1, y - 1, 3), force_of_cell(level, field, x, y - 1, 2),
        force_of_cell(level, field, x - 1, y, 1), force_of_cell(level, field, x, y, 0));
  }

  /// With the load, where the field is a correction.
  [[nodiscard]] InFloat::Force residual(int level, ElasticField field, int x, int y) const {
    const InFloat::Force force = force_on(level, field, x, y);
    if (field != ElasticField::correction) {
      return force;
    }
    const std::size_t at = level_at(level).grid.index(x, y);
    const RingedField& load = fields_.at(level, ElasticField::load);
    return InFloat::residual_of({load.x[at], load.y[at]}, force);
  }

  void move(int level, std::size_t at, const InFloat::Force& residual, const RingedField& from,
            RingedField& to) const {
    const auto& response = level_at(level).response;
    to.x[at] = InFloat::relaxed(from.x[at], response[0][at], residual.x, response[1][at], residual.y);
    to.y[at] = InFloat::relaxed(from.y[at], response[2][at], residual.y, response[1][at], residual.x);
  }

  /// Prescribed components are those of the image: on coarse levels nothing pulls at them.
  [[nodiscard]] InFloat::Force on_free(int level, std::size_t at, const InFloat::Force& force) const {
    const auto& response = level_at(level).response;
    return level > 0 ? force
                     : InFloat::Force{InFloat::free_part(force.x, response[0][at]),
                                      InFloat::free_part(force.y, response[2][at])};
  }

  /// load of level + 1 from fine(x, y), where that may move.
  template <typename Fine>
  void restrict_sites(int level, const Fine& fine) {
    const RingedGrid& grid = level_at(level).grid;
    RingedField from;
    from.require(grid);
    for_each_site(level, [&](int x, int y, std::size_t at) {
      const InFloat::Force force = on_free(level, at, fine(x, y));
      from.x[at] = force.x;
      from.y[at] = force.y;
    });
    RingedField& load = fields_.at(level + 1, ElasticField::load);
    for_each_site(level + 1, [&](int x, int y, std::size_t at) {
      load.x[at] = restricted_to(grid, from.x, 2 * x, 2 * y);
      load.y[at] = restricted_to(grid, from.y, 2 * x, 2 * y);
    });
  }

  /// A coarse site beyond the image sees the ring, and beyond that nothing.
  [[nodiscard]] static float restricted_to(const RingedGrid& grid, const std::vector<float>& values, int x,
                                           int y) {
    const auto value = [&](int i, int j) {
      return i <= grid.sites.width && j <= grid.sites.height ? values[grid.index(i, j)] : 0.0F;
    };
    const auto row = [&](int j) {
      return InFloat::restricted(value(x - 1, j), value(x, j), value(x + 1, j));
    };
    return InFloat::restricted(row(y - 1), row(y), row(y + 1));
  }

  [[nodiscard]] static float corrected(float value, const std::vector<float>& coarse,
                                       const std::array<std::size_t, 4>& around, int odd_x, int odd_y) {
    if (odd_x == 0 && odd_y == 0) {
      return InFloat::corrected_by_one(value, coarse[around[0]]);
    }
    if (odd_x == 0 || odd_y == 0) {
      return InFloat::corrected_by_two(value, coarse[around[0]], coarse[around[3]]);
    }
    return InFloat::corrected_by_four(value, coarse[around[0]], coarse[around[1]], coarse[around[2]],
                                      coarse[around[3]]);
  }

  const ElasticHierarchy* hierarchy_ = nullptr;
  ElasticFields fields_;
};

} // namespace

std::unique_ptr<ElasticSession> make_elastic_scalar() {
  return std::make_unique<ElasticScalar>();
}

} // namespace hdmbench
