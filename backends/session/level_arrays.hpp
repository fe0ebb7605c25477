#pragma once

#include "backends/device/device.hpp"
#include "kernels/data/field.hpp"
#include "kernels/data/pyramid.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace hdmbench {

/// How numbers of the sites of a level lie in an array of a device: as texels of two or four in reading
/// order, or as planes of one number each, with room around for what a row reads beyond the border
/// (kernels/shaders/sweep.cl).
struct SiteLayout {
  SiteLayout() = default;
  SiteLayout(Extent extent, bool has_planes);

  /// Returns the length of an array with so many numbers a site, 2 or 4 of which are a texel where it has
  /// such.
  [[nodiscard]] std::size_t count(std::size_t numbers) const {
    return has_planes ? numbers * plane : extent.sites() * ((numbers + 3) / 4);
  }
  [[nodiscard]] Kind kind(std::size_t numbers) const {
    return has_planes ? Kind::words : numbers == 2 ? Kind::pairs : Kind::fours;
  }
  /// How many numbers a vector is: in texels of a volume there is one behind it that is nobody's.
  [[nodiscard]] std::size_t numbers_of_vector() const { return extent.axes() == 2 ? 2 : has_planes ? 3 : 4; }

  Extent extent;
  bool has_planes = false;
  std::size_t origin = 0; ///< of planes: floats before the first site
  std::size_t plane = 0;  ///< floats from a plane to the next
};

/// Below this many floats threads cost more than they bring.
inline constexpr std::size_t floats_worth_threads = std::size_t{1} << 16;

/// Sets floats to 0, on all threads where they are many.
void clear(std::span<float> values);

/// Writes `count` floats into an array, from its float `first` on, part by part of the device's staging
/// memory: fill(begin, part) makes the floats begin ... begin + part.size() - 1 of them. Parts begin and end
/// at multiples of `together`.
template <typename Fill>
void write_parts(ComputeDevice& device, const Array& to, std::size_t first, std::size_t count,
                 std::size_t together, const Fill& fill) {
  const std::size_t most = staging_bytes / sizeof(float) / together * together;
  for (std::size_t begin = 0; begin < count; begin += most) {
    const auto bytes = device.staging().first(std::min(most, count - begin) * sizeof(float));
    fill(begin, std::span(reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float)));
    device.write(to, (first + begin) * sizeof(float), bytes);
  }
}
/// Reads likewise: take(begin, part) gets the floats.
template <typename Take>
void read_parts(ComputeDevice& device, const Array& from, std::size_t first, std::size_t count,
                std::size_t together, const Take& take) {
  const std::size_t most = staging_bytes / sizeof(float) / together * together;
  for (std::size_t begin = 0; begin < count; begin += most) {
    const auto bytes = device.staging().first(std::min(most, count - begin) * sizeof(float));
    device.read(from, (first + begin) * sizeof(float), bytes);
    take(begin, std::span(reinterpret_cast<const float*>(bytes.data()), bytes.size() / sizeof(float)));
  }
}

/// Writes numbers of each site, in reading order, into the layout's part of an array that
/// begins with its element `first`. All these throw DeviceError.
void write_sites(ComputeDevice& device, const Array& to, std::size_t first, const SiteLayout& layout,
                 const std::vector<std::span<const float>>& numbers);
/// Likewise all of an array, in which a site has these vectors.
void write_vectors(ComputeDevice& device, const Array& to, const SiteLayout& layout,
                   const std::vector<const VectorField*>& vectors);
void read_vector(ComputeDevice& device, const Array& from, const SiteLayout& layout, VectorField& to);

/// Planes of numbers as texels, one after the other: number k of texel i is planes[k][i], 0 where a plane
/// that is not the first is empty.
[[nodiscard]] std::vector<float> interleaved(const std::vector<std::span<const float>>& planes);

/// How the sites of all levels of a pyramid lie in the full image and in the level before, as shaders read it
/// (kernels/shaders/levels.comp, coarse_levels.comp): texels of four floats, whole numbers below
/// 2^24 but for the weight.
struct ResamplingEntries {
  explicit ResamplingEntries(const Pyramid& pyramid);

  /// Per column, then per row, then per slice, of each level: the two coarse sites around, the weight of the
  /// second, the site sampled of the full image; the first level lies in one of a single site. Then per
  /// level: width, height, sweeps, where its columns begin.
  std::vector<std::array<float, 4>> texels;
  std::vector<std::int32_t> begins; ///< per level where its columns begin; rows and slices come after them
  std::int32_t levels_begin = 0;    ///< where the entries of the levels themselves begin
};

} // namespace hdmbench
