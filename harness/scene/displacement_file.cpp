#include "harness/scene/displacement_file.hpp"

#include "harness/scene/file_output.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <fstream>
#include <system_error>

namespace hdmbench {

std::string displacement_header(Extent extent, double spacing, const Placement& placement) {
  const auto vector_text = [](const Placement::Vector& vector) {
    return fmt::format("({},{},{})", vector[0], vector[1], vector[2]);
  };
  const double thickness = placement.thickness > 0.0 ? placement.thickness : spacing;
  std::string header = fmt::format(
      "NRRD0004\n"
      "# Complete NRRD file format specification at:\n"
      "# http://teem.sourceforge.net/nrrd/format.html\n"
      "type: float\n"
      "dimension: 4\n"
      "space: left-posterior-superior\n"
      "sizes: 3 {} {} 1\n"
      "space directions: none {} {} {}\n"
      "kinds: vector domain domain domain\n"
      "endian: {}\n"
      "encoding: raw\n"
      "space origin: {}\n",
      extent.width, extent.height, vector_text(placement.vector(spacing, 0.0)),
      vector_text(placement.vector(0.0, spacing)), vector_text(placement.vector(0.0, 0.0, thickness)),
      std::endian::native == std::endian::little ? "little" : "big", vector_text(placement.origin));
  for (const auto& [key, text] : displacement_keys) {
    header += fmt::format("{}:={}\n", key, text);
  }
  return header + '\n';
}

std::vector<float> displacement_values(const VectorField& displacement, std::size_t first, std::size_t count,
                                       double spacing, const Placement& placement) {
  std::vector<float> values;
  values.reserve(3 * count);
  for (std::size_t site = first; site < first + count; ++site) {
    for (const double component :
         placement.vector(displacement.x[site] * spacing, displacement.y[site] * spacing)) {
      values.push_back(static_cast<float>(component));
    }
  }
  return values;
}

void write_displacement_file(const std::filesystem::path& file, const VectorField& displacement,
                             double spacing, const Placement& placement) {
  write_atomically(file, [&](const std::filesystem::path& partial) {
    errno = 0;
    std::ofstream stream(partial, std::ios::binary);
    stream << displacement_header(displacement.extent, spacing, placement);
    const std::size_t sites = displacement.extent.sites();
    constexpr std::size_t at_once = 1U << 16U;
    for (std::size_t first = 0; first < sites && stream; first += at_once) {
      const std::vector<float> values =
          displacement_values(displacement, first, std::min(at_once, sites - first), spacing, placement);
      stream.write(reinterpret_cast<const char*>(values.data()),
                   static_cast<std::streamsize>(values.size() * sizeof(float)));
    }
    stream.close();
    if (!stream) {
      throw InputError(fmt::format("{}: cannot be written: {}", file.string(),
                                   std::generic_category().message(errno != 0 ? errno : EIO)));
    }
  });
}

} // namespace hdmbench
