#include "backends/session/level_arrays.hpp"

namespace hdmbench {

namespace {

/// Texels from `first` on, as interleaved() has them.
void interleave(const std::vector<std::span<const float>>& planes, std::size_t first,
                std::span<float> texels) {
  const std::size_t each = planes.size();
#pragma omp parallel for if (texels.size() > floats_worth_threads)
  for (std::size_t i = 0; i < texels.size() / each; ++i) {
    for (std::size_t number = 0; number < each; ++number) {
      texels[each * i + number] = planes[number].empty() ? 0.0F : planes[number][first + i];
    }
  }
}

} // namespace

SiteLayout::SiteLayout(Extent extent_, bool has_planes_) : extent(extent_), has_planes(has_planes_) {
  if (has_planes) {
    origin = (static_cast<std::size_t>(extent.width) + 16) / 16 * 16;
    plane = (extent.sites() + 2 * origin + 15) / 16 * 16;
  }
}

void clear(std::span<float> values) {
#pragma omp parallel for simd if (values.size() > floats_worth_threads)
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = 0.0F;
  }
}

void write_sites(ComputeDevice& device, const Array& to, std::size_t first, const SiteLayout& layout,
                 const std::vector<std::span<const float>>& numbers) {
  std::size_t at = first * bytes_of(to.kind());
  if (!layout.has_planes) {
    const std::size_t each = numbers.size();
    write_parts(device, to, at / sizeof(float), each * layout.extent.sites(), each,
                [&](std::size_t begin, std::span<float> part) { interleave(numbers, begin / each, part); });
    return;
  }
  at += layout.origin * sizeof(float);
  for (const std::span<const float> plane : numbers) {
    device.write(to, at, std::as_bytes(plane));
    at += layout.plane * sizeof(float);
  }
}

void write_vectors(ComputeDevice& device, const Array& to, const SiteLayout& layout,
                   const std::vector<const VectorField*>& vectors) {
  std::vector<std::span<const float>> numbers;
  for (const VectorField* const vector : vectors) {
    const std::array<std::span<const float>, 4> planes{(*vector)[0], (*vector)[1], (*vector)[2]};
    numbers.insert(numbers.end(), planes.begin(), planes.begin() + layout.numbers_of_vector());
  }
  write_sites(device, to, 0, layout, numbers);
}

void read_vector(ComputeDevice& device, const Array& from, const SiteLayout& layout, VectorField& to) {
  const auto planes = std::span(to.planes).first(layout.extent.axes());
  if (layout.has_planes) {
    std::size_t at = layout.origin * sizeof(float);
    for (std::vector<float>& plane : planes) {
      device.read(from, at, std::as_writable_bytes(std::span(plane)));
      at += layout.plane * sizeof(float);
    }
    return;
  }
  const std::size_t numbers = layout.numbers_of_vector();
  read_parts(device, from, 0, numbers * layout.extent.sites(), numbers,
             [&](std::size_t begin, std::span<const float> part) {
               const std::size_t first = begin / numbers;
#pragma omp parallel for if (part.size() > floats_worth_threads)
               for (std::size_t site = 0; site < part.size() / numbers; ++site) {
                 for (std::size_t axis = 0; axis < planes.size(); ++axis) {
                   planes[axis][first + site] = part[numbers * site + axis];
                 }
               }
             });
}

std::vector<float> interleaved(const std::vector<std::span<const float>>& planes) {
  std::vector<float> texels(planes.size() * planes.front().size());
  interleave(planes, 0, texels);
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
  const Extent full = pyramid.full->extent;
  for (const PyramidLevel& level : pyramid.levels) {
    begins.push_back(static_cast<std::int32_t>(texels.size()));
    append_axis(before.width, level.extent.width, full.width);
    append_axis(before.height, level.extent.height, full.height);
    append_axis(before.depth, level.extent.depth, full.depth);
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
