#include "backends/session/elastic_steps.hpp"

#include "backends/session/part_rows.hpp"

#include <limits>
#include <map>

namespace hdmbench {

ElasticLayout::ElasticLayout(const ElasticHierarchy& hierarchy, int block) {
  for (const ElasticLevel& level : hierarchy.levels) {
    levels.push_back(alone(level.grid.sites));
    levels.back().first += size;
    size += static_cast<std::int64_t>(padded(level.grid.sites).sites());
  }
  const Extent sites = levels.front().sites;
  const Extent blocks = blocks_of(sites, block);
  sums_size = static_cast<std::int64_t>(blocks.sites());
  sums = {.sites = blocks,
          .first = 0,
          .pitch = blocks.width,
          .layer = static_cast<std::int64_t>(blocks.width) * blocks.height};
}

Extent ElasticLayout::blocks_of(Extent sites, int block) {
  const auto along = [&](int size) { return (size + block - 1) / block; };
  return {along(sites.width), along(sites.height), along(sites.depth)};
}

ElasticLayout::Part ElasticLayout::alone(Extent sites) {
  const std::int64_t pitch = padded(sites).width;
  const std::int64_t layer = pitch * padded(sites).height;
  return {
      .sites = sites, .first = pitch + 1 + (sites.axes() == 3 ? layer : 0), .pitch = pitch, .layer = layer};
}

void lay_out(const RingedGrid& grid, const std::vector<float>& values, const ElasticLayout::Part& part,
             float* to, std::size_t stride) {
  for_each_row(part, 0, std::numeric_limits<std::int64_t>::max(),
               [&](int y, int z, int first, int end, std::int64_t at) {
                 const float* const row = values.data() + grid.index(0, y, z);
                 for (int x = first; x < end; ++x) {
                   to[static_cast<std::size_t>(at + x) * stride] = row[x];
                 }
               });
}

std::vector<float> elastic_matrices(const ElasticHierarchy& hierarchy) {
  const std::size_t axes = hierarchy.levels.front().grid.axes();
  std::vector<float> texels;
  for (const ElasticLevel& level : hierarchy.levels) {
    const std::size_t components = level.masked.components;
    for (std::size_t cell = 0; cell < level.masked.x.size(); ++cell) {
      const float* const matrix = level.masked.matrix(cell);
      for (std::size_t corner = 0; corner < components; corner += axes) {
        for (std::size_t column = 0; column < components; ++column) {
          const float* const forces = matrix + components * column + corner;
          texels.insert(texels.end(), forces, forces + axes);
          texels.resize((texels.size() + 1) / 2 * 2);
        }
      }
    }
  }
  const auto row = 4 * static_cast<std::size_t>(elastic_matrices_width(axes));
  texels.resize((texels.size() / row + 1) * row);
  return texels;
}

namespace {

/// Appends what touched_sites() has of the sites of row (y, z) of a level, whose first matrix has this
/// number.
void append_touched(const ElasticLevel& level, int y, int z, std::int32_t first_matrix,
                    std::vector<std::int32_t>& words) {
  const bool is_volume = level.grid.axes() == 3;
  const std::size_t corners = is_volume ? 8 : 4;
  constexpr std::array<std::int32_t, 8> unmasked{-1, -1, -1, -1, -1, -1, -1, -1};
  std::map<int, std::array<std::int32_t, 8>> row; // cells by x, y, z from the lowest bit
  for (std::size_t cells = 0; cells < corners / 2; ++cells) {
    const int south = static_cast<int>(cells % 2);
    const int behind = static_cast<int>(cells / 2);
    const auto [first, last] = level.masked.row(y - 1 + south, is_volume ? z - 1 + behind : z);
    for (std::size_t i = first; i < last; ++i) {
      for (const int west : {0, 1}) {
        const auto added = row.try_emplace(level.masked.x[i] + west, unmasked).first;
        added->second.at(2 * cells + 1 - static_cast<std::size_t>(west)) =
            first_matrix + static_cast<std::int32_t>(i);
      }
    }
  }
  for (const auto& [x, matrices] : row) {
    words.insert(words.end(), {x, is_volume ? y : 0, is_volume ? z : y, 0});
    words.insert(words.end(), matrices.begin(), matrices.begin() + static_cast<std::ptrdiff_t>(corners));
  }
}

} // namespace

std::vector<std::int32_t> touched_sites(const ElasticHierarchy& hierarchy) {
  const std::size_t corners = std::size_t{1} << hierarchy.levels.front().grid.axes();
  std::vector<std::int32_t> words(2 * hierarchy.levels.size());
  std::int32_t first_matrix = 0;
  for (std::size_t number = 0; number < hierarchy.levels.size(); ++number) {
    const ElasticLevel& level = hierarchy.levels[number];
    const auto begin = static_cast<std::int32_t>(words.size());
    const Extent sites = level.grid.sites;
    std::vector<std::vector<std::int32_t>> rows(static_cast<std::size_t>(sites.rows()));
    on_all_threads(rows.size(), sites.sites() > sites_worth_threads, [&](std::size_t number_of_row) {
      const auto row = static_cast<int>(number_of_row);
      append_touched(level, row % sites.height, row / sites.height, first_matrix, rows[number_of_row]);
    });
    for (const std::vector<std::int32_t>& row : rows) {
      words.insert(words.end(), row.begin(), row.end());
    }
    words[2 * number] = begin;
    words[2 * number + 1] =
        (static_cast<std::int32_t>(words.size()) - begin) / static_cast<std::int32_t>(4 + corners);
    first_matrix += static_cast<std::int32_t>(level.masked.x.size());
  }
  return words;
}

} // namespace hdmbench
