#include "backends/session/elastic_steps.hpp"

#include <algorithm>
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
  for (int z = 0; z < grid.sites.depth; ++z) {
    for (int y = 0; y < grid.sites.height; ++y) {
      float* at = to + static_cast<std::size_t>(part.first + z * part.layer + y * part.pitch) * stride;
      const float* const row = values.data() + grid.index(0, y, z);
      for (int x = 0; x < grid.sites.width; ++x, at += stride) {
        *at = row[x];
      }
    }
  }
}

ElasticTexels::ElasticTexels(std::size_t size) : moments(4 * size), more(4 * size), response(4 * size) {}

void ElasticTexels::add(const ElasticLevel& level, const ElasticLayout::Part& part) {
  for (std::size_t i = 0; i < level.moments.size(); ++i) {
    lay_out(level.grid, level.moments[i], part, (i < 4 ? moments : more).data() + i % 4, 4);
  }
  for (std::size_t i = 0; i < level.response.size(); ++i) {
    lay_out(level.grid, level.response[i], part, response.data() + i, 4);
  }
  for (int y = 0; y < level.grid.sites.height; ++y) {
    const auto [first, last] = level.masked.row(y);
    for (std::size_t i = first; i < last; ++i) {
      const std::int64_t at = part.first + y * part.pitch + level.masked.x[i];
      more[4 * static_cast<std::size_t>(at) + 2] = static_cast<float>(matrices + i + 1);
    }
  }
  matrices += level.masked.x.size();
}

std::vector<float> elastic_matrices(const ElasticHierarchy& hierarchy) {
  std::vector<float> texels;
  for (const ElasticLevel& level : hierarchy.levels) {
    for (std::size_t cell = 0; cell < level.masked.x.size(); ++cell) {
      const float* const matrix = level.masked.matrix(cell);
      for (std::size_t corner = 0; corner < 4; ++corner) {
        for (std::size_t column = 0; column < 8; ++column) {
          texels.push_back(matrix[8 * column + 2 * corner]);
          texels.push_back(matrix[8 * column + 2 * corner + 1]);
        }
      }
    }
  }
  constexpr std::size_t row = 4 * elastic_matrix_texels * elastic_matrices_across;
  texels.resize((texels.size() / row + 1) * row);
  return texels;
}

std::vector<std::array<int, 3>> sites_beside_masked(const ElasticLevel& level) {
  std::vector<std::array<int, 3>> sites;
  for (int z = 0; z < level.grid.sites.depth; ++z) {
    for (int y = 0; y < level.grid.sites.height; ++y) {
      const std::size_t before = sites.size();
      for (const int row : {0, 1, 2, 3}) {
        const auto [first, last] = level.masked.row(y - row % 2, z - row / 2);
        for (std::size_t i = first; i < last; ++i) {
          const int x = level.masked.x[i];
          sites.insert(sites.end(), {{x, y, z}, {x + 1, y, z}});
        }
      }
      const auto begin = sites.begin() + static_cast<std::ptrdiff_t>(before);
      std::sort(begin, sites.end());
      sites.erase(std::unique(begin, sites.end()), sites.end());
    }
  }
  return sites;
}

std::vector<std::vector<TouchedSite>> touched_sites(const ElasticHierarchy& hierarchy) {
  std::vector<std::vector<TouchedSite>> levels;
  std::int32_t first_matrix = 0;
  for (const ElasticLevel& level : hierarchy.levels) {
    std::vector<TouchedSite>& sites = levels.emplace_back();
    for (int y = 0; y < level.grid.sites.height; ++y) {
      std::map<int, TouchedSite> row;
      for (const int below : {0, 1}) {
        const auto [first, last] = level.masked.row(y - 1 + below);
        for (std::size_t i = first; i < last; ++i) {
          const int x = level.masked.x[i];
          const std::int32_t number = first_matrix + static_cast<std::int32_t>(i);
          row[x].masked.at(static_cast<std::size_t>(2 * below + 1)) = number;
          row[x + 1].masked.at(static_cast<std::size_t>(2 * below)) = number;
        }
      }
      for (const auto& [x, site] : row) {
        sites.push_back({.x = x, .y = y, .masked = site.masked});
      }
    }
    first_matrix += static_cast<std::int32_t>(level.masked.x.size());
  }
  return levels;
}

} // namespace hdmbench
