#include "harness/scene/images/npz.hpp"

#include "harness/scene/files.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <initializer_list>

// PKWARE's APPNOTE (zip) and NumPy's NEP 1 (npy, version 1.0).
namespace hdmbench {

namespace {

static_assert(std::endian::native == std::endian::little, "what is written is in the machine's order");

constexpr std::uintmax_t most_bytes = 0xFFFFFFFF; // of a zip file without extensions

/// Appends numbers of so many bytes, the lowest first.
template <typename Number>
void append(std::string& bytes, std::initializer_list<Number> numbers) {
  for (const Number number : numbers) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
}

/// What stands before the values of an array in its .npy file.
std::string header_of(const NamedArray& array) {
  constexpr std::array types{"<i2", "<f4", "<f8"}; // as the alternatives of its values
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({},), }}",
                                 types.at(array.values.index()), fmt::join(array.shape, ", "));
  text.append(64 - (text.size() + 11) % 64, ' ').append(1, '\n'); // the values begin at a multiple of 64
  std::string header("\x93NUMPY\x01\x00", 8);
  append(header, {static_cast<std::uint16_t>(text.size())});
  return header + text;
}

/// What both places of a zip file say of an array's file: method 0 (stored), the date 1980-01-01, checksum,
/// sizes, length of the name.
std::string entry_of(std::uint32_t checksum, std::uint32_t size, const std::string& name) {
  std::string entry;
  append<std::uint16_t>(entry, {20, 0, 0, 0, 0x21});
  append<std::uint32_t>(entry, {checksum, size, size});
  append<std::uint16_t>(entry, {static_cast<std::uint16_t>(name.size()), 0});
  return entry;
}

} // namespace

void write_npz(const std::filesystem::path& file, std::span<const NamedArray> arrays) {
  write_atomically(file, [&](const std::filesystem::path& partial) {
    std::ofstream out(partial, std::ios::binary);
    std::string directory;
    std::uintmax_t offset = 0;
    for (const NamedArray& array : arrays) {
      const std::string header = header_of(array);
      const std::string name = array.name + ".npy";
      const auto bytes =
          std::visit([](const auto& values) { return std::as_bytes(std::span(values)); }, array.values);
      const auto* const first = reinterpret_cast<const unsigned char*>(bytes.data());
      const uLong checksum =
          crc32_z(crc32_z(0, reinterpret_cast<const unsigned char*>(header.data()), header.size()), first,
                  bytes.size());
      const std::uintmax_t size = header.size() + bytes.size();
      if (offset + size + directory.size() > most_bytes - 4096) {
        throw InputError(fmt::format("{}: would have 4 GiB, more than a zip file can; take --format nii.gz",
                                     file.string()));
      }
      const std::string entry =
          entry_of(static_cast<std::uint32_t>(checksum), static_cast<std::uint32_t>(size), name);
      out << "PK\x03\x04" << entry << name << header;
      out.write(reinterpret_cast<const char*>(first), std::ssize(bytes));
      directory += "PK\x01\x02";
      append<std::uint16_t>(directory, {20}); // made by
      directory += entry;
      append<std::uint16_t>(directory, {0, 0, 0}); // comment, disk, attributes
      append<std::uint32_t>(directory, {0, static_cast<std::uint32_t>(offset)});
      directory += name;
      offset += 4 + entry.size() + name.size() + size;
    }
    const auto count = static_cast<std::uint16_t>(arrays.size());
    std::string end = "PK\x05\x06";
    append<std::uint16_t>(end, {0, 0, count, count});
    append<std::uint32_t>(end,
                          {static_cast<std::uint32_t>(directory.size()), static_cast<std::uint32_t>(offset)});
    append<std::uint16_t>(end, {0});
    out << directory << end << std::flush;
    if (!out) {
      throw InputError(fmt::format("{}: the disk is full", file.string()));
    }
  });
}

} // namespace hdmbench
