#include "backends/session/level_arrays.hpp"

namespace hdmbench {

SiteLayout::SiteLayout(Extent extent_, bool has_planes_) : extent(extent_), has_planes(has_planes_) {
  if (has_planes) {
    origin = (static_cast<std::size_t>(extent.width) + 16) / 16 * 16;
    plane = (extent.sites() + 2 * origin + 15) / 16 * 16;
  }
}

void write_sites(ComputeDevice& device, const Array& to, std::size_t first, const SiteLayout& layout,
                 const std::vector<std::span<const float>>& components) {
  std::size_t at = first * bytes_of(to.kind());
  if (!layout.has_planes) {
    const std::vector<float> texels = interleaved(components);
    device.write(to, at, std::as_bytes(std::span(texels)));
    return;
  }
  at += layout.origin * sizeof(float);
  for (const std::span<const float> plane : components) {
    device.write(to, at, std::as_bytes(plane));
    at += layout.plane * sizeof(float);
  }
}

void read_sites(ComputeDevice& device, const Array& from, const SiteLayout& layout, VectorField& to) {
  if (layout.has_planes) {
    device.read(from, layout.origin * sizeof(float), std::as_writable_bytes(std::span(to[0])));
    device.read(from, (layout.origin + layout.plane) * sizeof(float),
                std::as_writable_bytes(std::span(to[1])));
    return;
  }
  std::vector<std::array<float, 2>> texels(layout.extent.sites());
  device.read(from, 0, std::as_writable_bytes(std::span(texels)));
  for (std::size_t i = 0; i < texels.size(); ++i) {
    to[0][i] = texels[i][0];
    to[1][i] = texels[i][1];
  }
}

std::vector<float> interleaved(const std::vector<std::span<const float>>& planes) {
  std::vector<float> texels(planes.size() * planes.front().size());
  for (std::size_t number = 0; number < planes.size(); ++number) {
    float* texel = texels.data() + number;
    for (const float value : planes[number]) {
      *texel = value;
      texel += planes.size();
    }
  }
  return texels;
}

ResamplingEntries::ResamplingEntries(const Pyramid& pyramid) {
  const auto append_axis = [&](int coarse, int fine, int full) {
    const auto around = interpolations(coarse, fine, pyramid.alignment);
    const auto sampled = sampled_indices(fine, full, pyramid.alignment);
    for (std::size_t i = 0; i < around.size(); ++i) {
      texels.push_back({static_cast<float>(around[i].first), static_cast<float>(around[i].second),
                        around[i].weight, static_cast<float>(sampled[i])});
    }
  };
  Extent before{1, 1};
  for (const PyramidLevel& level : pyramid.levels) {
    begins.push_back(static_cast<std::int32_t>(texels.size()));
    append_axis(before.width, level.extent.width, pyramid.full->extent.width);
    append_axis(before.height, level.extent.height, pyramid.full->extent.height);
    before = level.extent;
  }
  levels_begin = static_cast<std::int32_t>(texels.size());
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const PyramidLevel& level = pyramid.levels[i];
    texels.push_back({static_cast<float>(level.extent.width), static_cast<float>(level.extent.height),
                      static_cast<float>(level.sweeps), static_cast<float>(begins[i])});
  }
}

} // namespace hdmbench
