#include "backends/cpu/level_data.hpp"

#include "kernels/data/default_steps.hpp"
#include "kernels/specification/tile_class.hpp"

#include <algorithm>

namespace hdmbench::openmp {

namespace {

/// What classify.inc reads, of a phase; its materials are asked for where there is one phase.
class ArrangedRows {
public:
  ArrangedRows(const float* modulus, const float* inverse_modulus, const float* confidence_x,
               const float* confidence_y, const Layout& layout, int phase)
      : modulus_(modulus), inverse_modulus_(inverse_modulus), confidence_x_(confidence_x),
        confidence_y_(confidence_y), layout_(layout), phase_(phase) {}

  [[nodiscard]] bool any_other_confidence(int y, int first, int end, float of_x, float of_y) const {
    return any_other(confidence_x_, y, first, end, of_x) || any_other(confidence_y_, y, first, end, of_y);
  }
  [[nodiscard]] bool any_other_modulus(int y, int first, int end, float value) const {
    return any_other(modulus_, y, first, end, value);
  }
  [[nodiscard]] bool any_other_inverse(int y, int first, int end, float value) const {
    return any_other(inverse_modulus_, y, first, end, value);
  }

private:
  [[nodiscard]] bool any_other(const float* values, int y, int first, int end, float value) const {
    const float* row = values + layout_.start(y, phase_);
    int differing = 0;
#pragma omp simd reduction(| : differing)
    for (int i = first; i < end; ++i) {
      differing |= static_cast<int>(row[i] != value);
    }
    return differing != 0;
  }

  const float* modulus_;
  const float* inverse_modulus_;
  const float* confidence_x_;
  const float* confidence_y_;
  Layout layout_;
  int phase_;
};

/// Of tiles in some columns and rows of a pyramid's full level.
struct TileRange {
  int first;
  int last;
};

/// The tiles, `size` sites long, that sites first - 1 ... last of a coarse axis sample.
TileRange sampled_tiles(const std::vector<int>& sampled, int first, int last, int size) {
  const int most = static_cast<int>(sampled.size()) - 1;
  return {sampled[static_cast<std::size_t>(std::max(first - 1, 0))] / size,
          sampled[static_cast<std::size_t>(std::min(last, most))] / size + 1};
}

} // namespace

void LevelData::prepare(const Level& level, Extent extent) {
  const int stride = sweeps_per_iteration(level) == 1 ? 1 : 2;
  tiling_ = Tiling({.extent = extent, .stride = stride});
  short_path_ = changes_spread_by_contact(level) && std::ranges::equal(level.steps.values(), default_steps);
  kinds_.assign(static_cast<std::size_t>(tiling_.count()), TileKind{});
  arrays_ = {};
}

LevelData::Arrays LevelData::arrays_of(const Level& level) {
  const bool curvature = needs_inverse_curvature(level.rule);
  Arrays arrays{level.modulus.values.data(),
                level.inverse_modulus.values.data(),
                level.target.x.data(),
                level.target.y.data(),
                level.confidence.x.data(),
                level.confidence.y.data(),
                curvature ? level.inverse_curvature.x.data() : nullptr,
                curvature ? level.inverse_curvature.y.data() : nullptr};
  std::ranges::transform(level.inputs, arrays.begin() + first_input,
                         [](const ScalarField& input) { return input.values.data(); });
  return arrays;
}

TileKind LevelData::classified(const Arrays& arrays, Rectangle tile, int phase) const {
  if (tile.first >= tile.last) {
    return {.observed = false, .uniform_confidence = true, .uniform = short_path_}; // of the shorter phase
  }
  tile_class::Classifier<ArrangedRows> sites({arrays[modulus], arrays[inverse_modulus], arrays[confidence_x],
                                              arrays[confidence_y], layout(), phase});
  const std::size_t origin = layout().start(tile.first_row, phase) + static_cast<std::size_t>(tile.first);
  const Extent extent = layout().extent;
  TileKind kind;
  if (sites.is_of_one_confidence(tile.first, tile.first_row, tile.last, tile.last_row,
                                 arrays[confidence_x][origin], arrays[confidence_y][origin])) {
    kind.uniform_confidence = true;
    kind.confidence_x = arrays[confidence_x][origin];
    kind.confidence_y = arrays[confidence_y][origin];
    kind.observed = kind.confidence_x != 0.0F || kind.confidence_y != 0.0F;
  }
  if (short_path_ &&
      sites.is_of_one_material(tile.first, tile.first_row, tile.last, tile.last_row, extent.width,
                               extent.height, arrays[modulus][origin], arrays[inverse_modulus][origin])) {
    kind.uniform = true;
    kind.modulus = arrays[modulus][origin];
    kind.inverse_modulus = arrays[inverse_modulus][origin];
  }
  return kind;
}

void LevelData::classify(const Arrays& arrays, int threads) {
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    for (int phase = 0; phase < layout().stride; ++phase) {
      for (int column = 0; column < tiling_.columns; ++column) {
        kinds_[static_cast<std::size_t>(tiling_.index(row, phase, column))] =
            classified(arrays, tiling_.rectangle(row, phase, column), phase);
      }
    }
  }
}

bool LevelData::at_border(int row, int column) const {
  return row == 0 || column == 0 || row == tiling_.rows - 1 || column == tiling_.columns - 1;
}

bool LevelData::reads_modulus(int row, int column) const {
  return at_border(row, column) || !kind(tiling_.index(row, 0, column)).uniform;
}

bool LevelData::rim_reads_modulus(int row, int column) const {
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, tiling_.rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, tiling_.columns - 1); ++x) {
      if (reads_modulus(y, x)) {
        return true;
      }
    }
  }
  return false;
}

template <typename CopyArray>
void LevelData::copy_needed(const Arrays& from, int threads, const CopyArray& copy_array) {
  for (std::size_t i = 0; i < array_count; ++i) {
    if (from[i] != nullptr) {
      own_[i].require(layout().extent.sites());
      arrays_[i] = own_[i].data();
    }
  }
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    for (int column = 0; column < tiling_.columns; ++column) {
      const Rectangle tile = tiling_.rectangle(row, 0, column);
      if (reads_modulus(row, column)) {
        copy_array(modulus, tile);
      }
      if (rim_reads_modulus(row, column)) {
        copy_array(inverse_modulus, tile);
      }
      const TileKind& known = kind(tiling_.index(row, 0, column));
      if (known.observed) {
        copy_array(target_x, tile);
        copy_array(target_y, tile);
      }
      if (known.observed && (at_border(row, column) || !known.uniform_confidence)) {
        copy_array(confidence_x, tile);
        copy_array(confidence_y, tile);
      }
      for (std::size_t i = first_input; i < array_count && from[i] != nullptr; ++i) {
        copy_array(i, tile);
      }
    }
  }
}

void LevelData::join_runs(int threads) {
  runs_.resize(static_cast<std::size_t>(tiling_.rows * layout().stride));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    for (int phase = 0; phase < layout().stride; ++phase) {
      runs_[static_cast<std::size_t>(row * layout().stride + phase)] = find_runs(tiling_, kinds_, row, phase);
    }
  }
}

void LevelData::borrow(const Level& level, int threads) {
  prepare(level, level.extent);
  if (layout().stride != 1) {
    copy(level, threads);
    return;
  }
  release_beyond(0);
  arrays_ = arrays_of(level);
  classify(arrays_, threads);
  join_runs(threads);
}

void LevelData::copy(const Level& level, int threads) {
  prepare(level, level.extent);
  const Arrays from = arrays_of(level);
  if (short_path_) {
    classify(from, threads);
    copy_needed(from, threads, [&](std::size_t array, Rectangle tile) {
      for (int y = tile.first_row; y < tile.last_row; ++y) {
        const std::size_t row = layout().extent.index(tile.first, y);
        std::copy_n(from[array] + row, tile.last - tile.first, own_[array].data() + row);
      }
    });
  } else {
    for (std::size_t i = 0; i < array_count; ++i) {
      if (from[i] != nullptr) {
        own_[i].require(layout().extent.sites());
        layout().arrange(from[i], own_[i].data(), threads);
        arrays_[i] = own_[i].data();
      }
    }
    classify(arrays_, threads);
  }
  join_runs(threads);
}

void LevelData::sample(const Level& level, const LevelData& full, Extent extent, Alignment alignment,
                       int threads) {
  prepare(level, extent);
  const std::vector<int> columns = sampled_indices(extent.width, level.extent.width, alignment);
  const std::vector<int> rows = sampled_indices(extent.height, level.extent.height, alignment);
  const Arrays from = arrays_of(level);
  if (layout().stride != 1) {
    copy(sample_level(level, extent, alignment), threads);
    return;
  }
  // A tile whose sites all sample tiles of one kind is of that kind, and nothing of it need be read.
  std::vector<char> decided(kinds_.size(), 0);
  if (short_path_) {
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int row = 0; row < tiling_.rows; ++row) {
      for (int column = 0; column < tiling_.columns; ++column) {
        const Rectangle tile = tiling_.rectangle(row, 0, column);
        const TileRange down = sampled_tiles(rows, tile.first_row, tile.last_row, Tiling::height);
        const TileRange across = sampled_tiles(columns, tile.first, tile.last, Tiling::width);
        const TileKind first = full.kind(full.tiling().index(down.first, 0, across.first));
        bool same = first.uniform_confidence && first.uniform;
        for (int y = down.first; y < down.last && same; ++y) {
          for (int x = across.first; x < across.last && same; ++x) {
            same = full.kind(full.tiling().index(y, 0, x)) == first;
          }
        }
        const auto tile_index = static_cast<std::size_t>(tiling_.index(row, 0, column));
        if (same) {
          kinds_[tile_index] = first;
          decided[tile_index] = 1;
        }
      }
    }
  }
  copy_needed(from, threads, [&](std::size_t array, Rectangle tile) {
    for (int y = tile.first_row; y < tile.last_row; ++y) {
      const float* source = from[array] + level.extent.index(0, rows[static_cast<std::size_t>(y)]);
      float* to = own_[array].data() + extent.index(0, y);
      for (int x = tile.first; x < tile.last; ++x) {
        to[x] = source[columns[static_cast<std::size_t>(x)]];
      }
    }
  });
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int row = 0; row < tiling_.rows; ++row) {
    for (int column = 0; column < tiling_.columns; ++column) {
      const auto tile = static_cast<std::size_t>(tiling_.index(row, 0, column));
      if (decided[tile] == 0) {
        kinds_[tile] = classified(arrays_, tiling_.rectangle(row, 0, column), 0);
      }
    }
  }
  join_runs(threads);
}

void LevelData::release_beyond(std::size_t bytes) {
  for (Buffer& buffer : own_) {
    if (buffer.size() * sizeof(float) * array_count > bytes) {
      buffer.release();
    }
  }
}

void LevelData::point(RowPart& part, std::size_t offset) const {
  const auto at = [&](std::size_t array) {
    return arrays_[array] == nullptr ? nullptr : arrays_[array] + offset;
  };
  part.modulus = at(modulus);
  part.inverse_modulus = at(inverse_modulus);
  part.target_x = at(target_x);
  part.target_y = at(target_y);
  part.confidence_x = at(confidence_x);
  part.confidence_y = at(confidence_y);
  part.inverse_curvature_x = at(curvature_x);
  part.inverse_curvature_y = at(curvature_y);
  for (std::size_t i = 0; i < array_count - first_input; ++i) {
    part.inputs[i] = at(first_input + i);
  }
}

} // namespace hdmbench::openmp
