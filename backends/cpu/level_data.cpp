#include "backends/cpu/level_data.hpp"

#include "backends/shared/tiles.hpp"
#include "kernels/data/default_steps.hpp"

namespace hdmbench::openmp {

void LevelData::prepare(const Level& level, Extent extent) {
  tiling_ = Tiling(extent);
  short_path_ = changes_spread_by_contact(level) && std::ranges::equal(level.steps.values(), default_steps);
  kinds_.assign(static_cast<std::size_t>(tiling_.count()), TileKind{});
  arrays_ = {};
}

LevelData::Arrays LevelData::arrays_of(const Level& level) {
  const bool curvature = needs_inverse_curvature(level.rule);
  Arrays arrays{level.modulus.values.data(), level.inverse_modulus.values.data()};
  for (std::size_t axis = 0; axis < level.extent.axes(); ++axis) {
    arrays[RowPart::target + axis] = level.target[axis].data();
    arrays[RowPart::confidence + axis] = level.confidence[axis].data();
    arrays[RowPart::inverse_curvature + axis] = curvature ? level.inverse_curvature[axis].data() : nullptr;
  }
  std::ranges::transform(level.inputs, arrays.begin() + RowPart::first_input,
                         [](const ScalarField& input) { return input.values.data(); });
  return arrays;
}

void LevelData::make_room(const Arrays& from) {
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    if (from[i] != nullptr) {
      own_[i].require(extent().sites());
      arrays_[i] = own_[i].data();
    }
  }
}

TileKind LevelData::classified(const Box& tile) const {
  const std::size_t origin = extent().index(tile.first[0], tile.first[1], tile.first[2]);
  // Whether a number is everywhere that of the tile's first site.
  const auto is_one = [&](std::size_t number, const Box& sites) {
    const float* const values = arrays_[number];
    const float value = values[origin];
    return !sites.has_row([&](int first, int end, int y, int z) {
      const float* row = values + extent().index(0, y, z);
      int differing = 0;
#pragma omp simd reduction(| : differing)
      for (int i = first; i < end; ++i) {
        differing |= static_cast<int>(row[i] != value);
      }
      return differing != 0;
    });
  };
  TileKind kind{.uniform_confidence = true};
  for (std::size_t axis = 0; axis < extent().axes(); ++axis) {
    kind.uniform_confidence = kind.uniform_confidence && is_one(RowPart::confidence + axis, tile);
  }
  for (std::size_t axis = 0; axis < extent().axes() && kind.uniform_confidence; ++axis) {
    kind.confidence[axis] = arrays_[RowPart::confidence + axis][origin];
    kind.observed = (axis > 0 && kind.observed) || kind.confidence[axis] != 0.0F;
  }
  if (short_path_ && is_one(RowPart::modulus, tile) &&
      is_one(RowPart::inverse_modulus, tile.with_rim(extent()))) {
    kind.uniform = true;
    kind.modulus = arrays_[RowPart::modulus][origin];
    kind.inverse_modulus = arrays_[RowPart::inverse_modulus][origin];
  }
  return kind;
}

std::vector<Run> LevelData::find_runs(int row) const {
  std::vector<Run> runs;
  for (int column = 0; column < tiling_.columns; ++column) {
    const Box tile = tiling_.tile(row, column);
    const TileKind& of_tile = kind(tiling_.index(row, column));
    if (column > 0 && runs.back().kind == of_tile) {
      runs.back().last = tile.end[0];
    } else {
      runs.push_back({tile.first[0], tile.end[0], of_tile});
    }
  }
  return runs;
}

template <typename Call>
void LevelData::for_each_tile(int threads, const Call& call) const {
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    for (int column = 0; column < tiling_.columns; ++column) {
      call(row, column, static_cast<std::size_t>(tiling_.index(row, column)));
    }
  }
}

void LevelData::classify(const std::vector<char>& known, int threads) {
  for_each_tile(threads, [&](int row, int column, std::size_t tile) {
    if (known.empty() || known[tile] == 0) {
      kinds_[tile] = classified(tiling_.tile(row, column));
    }
  });
  runs_.resize(static_cast<std::size_t>(tiling_.rows));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    runs_[static_cast<std::size_t>(row)] = find_runs(row);
  }
}

std::optional<TileKind> LevelData::kind_of(const std::vector<int>& rows, const std::vector<int>& columns,
                                           const Box& tile) const {
  const auto sampled = [](const std::vector<int>& axis, int site) {
    return axis[static_cast<std::size_t>(std::clamp(site, 0, static_cast<int>(axis.size()) - 1))];
  };
  const int left = sampled(columns, tile.first[0] - 1) / Tiling::width;
  const int right = sampled(columns, tile.end[0]) / Tiling::width;
  const int top = sampled(rows, tile.first[1] - 1) / Tiling::height;
  const int bottom = sampled(rows, tile.end[1]) / Tiling::height;
  const TileKind first = kind(tiling_.index(top, left));
  bool same = !first.observed && first.uniform;
  for (int row = top; row <= bottom && same; ++row) {
    for (int column = left; column <= right && same; ++column) {
      same = kind(tiling_.index(row, column)) == first;
    }
  }
  return same ? std::optional(first) : std::nullopt;
}

void LevelData::borrow(const Level& level, int threads) {
  prepare(level, level.extent);
  release_beyond(0);
  arrays_ = arrays_of(level);
  classify({}, threads);
}

void LevelData::copy(const Level& level, int threads) {
  prepare(level, level.extent);
  const Arrays from = arrays_of(level);
  make_room(from);
  const auto width = static_cast<std::size_t>(level.extent.width);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int y = 0; y < level.extent.rows(); ++y) {
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      if (from[i] != nullptr) {
        std::copy_n(from[i] + level.extent.index(0, y), width, own_[i].data() + level.extent.index(0, y));
      }
    }
  }
  classify({}, threads);
}

void LevelData::sample(const Level& level, const LevelData& full, Extent extent, Alignment alignment,
                       int threads) {
  prepare(level, extent);
  const SampledSites sites(level.extent, extent, alignment);
  const std::vector<int>& columns = sites.axes[0];
  // Inside a tile whose kind is known from those that it samples nothing is read but at an unknown one beside
  // it.
  std::vector<char> known(kinds_.size());
  if (short_path_ && level.inputs.empty() && extent.axes() == 2) {
    for_each_tile(threads, [&](int row, int column, std::size_t tile) {
      const auto found = full.kind_of(sites.axes[1], columns, tiling_.tile(row, column));
      const bool at_border =
          row == 0 || column == 0 || row == tiling_.rows - 1 || column == tiling_.columns - 1;
      known[tile] = found && !at_border ? 1 : 0;
      kinds_[tile] = found.value_or(TileKind{});
    });
  }
  const auto is_read = [&](int row, int column) {
    bool any = false;
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, tiling_.rows - 1); ++y) {
      for (int x = std::max(column - 1, 0); x <= std::min(column + 1, tiling_.columns - 1); ++x) {
        any = any || known[static_cast<std::size_t>(tiling_.index(y, x))] == 0;
      }
    }
    return any;
  };
  const Arrays from = arrays_of(level);
  make_room(from);
  for_each_tile(threads, [&](int row, int column, std::size_t at) {
    const Box tile = tiling_.tile(row, column);
    const int end = is_read(row, column) ? tile.end[1] : tile.first[1];
    const std::size_t count =
        known[at] == 0 ? arrays_.size() : RowPart::inverse_modulus + 1; // what is read from beside it
    for (std::size_t i = 0; i < count; ++i) {
      for (int y = tile.first[1]; y < end && from[i] != nullptr; ++y) {
        const float* const source = from[i] + sites.row(y, tile.first[2]);
        float* const to = own_[i].data() + extent.index(0, y, tile.first[2]);
        for (int x = tile.first[0]; x < tile.end[0]; ++x) {
          to[x] = source[columns[static_cast<std::size_t>(x)]];
        }
      }
    }
  });
  classify(known, threads);
}

void LevelData::release_beyond(std::size_t bytes) {
  for (Buffer& buffer : own_) {
    if (buffer.size() * sizeof(float) * arrays_.size() > bytes) {
      buffer.release();
    }
  }
}

void LevelData::point(RowPart& part, std::size_t offset) const {
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    part.arrays[i] = arrays_[i] == nullptr ? nullptr : arrays_[i] + offset;
  }
}

} // namespace hdmbench::openmp
