#include "backends/session/site_layout.hpp"

#include <array>
#include <vector>

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
  if (layout.has_planes) {
    at += layout.origin * sizeof(float);
    for (const std::span<const float> plane : components) {
      device.write(to, at, std::as_bytes(plane));
      at += layout.plane * sizeof(float);
    }
    return;
  }
  std::vector<float> texels(components.size() * components.front().size());
  std::size_t number = 0;
  for (const std::span<const float> plane : components) {
    float* texel = texels.data() + number++;
    for (const float value : plane) {
      *texel = value;
      texel += components.size();
    }
  }
  device.write(to, at, std::as_bytes(std::span(texels)));
}

void read_sites(ComputeDevice& device, const Array& from, const SiteLayout& layout, VectorField& to) {
  if (layout.has_planes) {
    device.read(from, layout.origin * sizeof(float), std::as_writable_bytes(std::span(to.x)));
    device.read(from, (layout.origin + layout.plane) * sizeof(float),
                std::as_writable_bytes(std::span(to.y)));
    return;
  }
  std::vector<std::array<float, 2>> texels(layout.extent.sites());
  device.read(from, 0, std::as_writable_bytes(std::span(texels)));
  for (std::size_t i = 0; i < texels.size(); ++i) {
    to.x[i] = texels[i][0];
    to.y[i] = texels[i][1];
  }
}

} // namespace hdmbench
