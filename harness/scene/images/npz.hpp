#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

/// NumPy's format for several arrays in one file: a zip archive of .npy files.
namespace hdmbench {

/// An array, the last axis fastest.
struct NamedArray {
  std::string name;               ///< the key in NumPy
  std::vector<std::size_t> shape; ///< as many values in all
  std::variant<std::vector<std::int16_t>, std::vector<float>, std::vector<double>> values;
};

/// Writes the arrays, nothing compressed and no date, so that the same arrays are the same bytes. Written
/// beside the target and renamed. Throws InputError where it cannot be written, or would have 4 GiB.
void write_npz(const std::filesystem::path& file, std::span<const NamedArray> arrays);

} // namespace hdmbench
