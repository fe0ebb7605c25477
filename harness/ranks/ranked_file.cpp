#include "harness/ranks/ranked_file.hpp"

#include "harness/scene/displacement_file.hpp"
#include "harness/scene/file_output.hpp"
#include "kernels/data/input_error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <system_error>
#include <vector>

namespace hdmbench {

namespace {

std::span<const std::byte> bytes_of(const std::vector<float>& values) {
  return std::as_bytes(std::span(values));
}

/// Room for the whole file, so that a full disk is noticed before anybody writes.
void reserve(const std::filesystem::path& file, std::uint64_t bytes) {
  const int opened = open(file.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0666);
  const int error = opened < 0 ? errno : posix_fallocate(opened, 0, static_cast<off_t>(bytes));
  if (opened >= 0) {
    close(opened);
  }
  if (error != 0) {
    throw InputError(fmt::format("{}: there is no room for {} bytes: {}", file.string(), bytes,
                                 std::generic_category().message(error)));
  }
}

void write_own(const std::filesystem::path& file, const std::string& header, Extent extent,
               const Rectangle& owned, const VectorField& displacement, double spacing,
               const Placement& placement, Ranks& ranks) {
  const std::unique_ptr<SharedFile> shared = ranks.open(file);
  if (ranks.is_first()) {
    shared->write_at(0, std::as_bytes(std::span(header)));
  }
  const auto width = static_cast<std::size_t>(owned.width);
  // Rows that are as wide as the image follow each other in the file.
  const int rows_at_once =
      owned.width == extent.width ? static_cast<int>(std::max<std::size_t>(1, (1U << 20U) / width)) : 1;
  for (int y = 0; y < owned.height; y += rows_at_once) {
    const auto rows = static_cast<std::size_t>(std::min(rows_at_once, owned.height - y));
    const std::size_t first_in_file = extent.index(owned.left, owned.top + y);
    shared->write_at(header.size() + displacement_bytes_per_site * first_in_file,
                     bytes_of(displacement_values(displacement, owned.extent().index(0, y), rows * width,
                                                  spacing, placement)));
  }
  shared->close();
}

std::vector<std::byte> packed(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

} // namespace

void write_displacement_on_ranks(const std::filesystem::path& file, Extent extent, const Rectangle& owned,
                                 const VectorField& displacement, double spacing, const Placement& placement,
                                 Ranks& ranks) {
  const std::string header = displacement_header(extent, spacing, placement);
  // What a rank met, to the first one; that throws where one met something.
  const auto write_part = [&](const std::filesystem::path& partial) {
    std::string error;
    try {
      write_own(partial, header, extent, owned, displacement, spacing, placement, ranks);
    } catch (const std::exception& met) {
      error = met.what();
    }
    const std::vector<std::string> errors = ranks.gather(error);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (!errors[i].empty()) {
        throw InputError(fmt::format("{} (rank {}): {}", file.string(), i, errors[i]));
      }
    }
  };
  std::vector<std::byte> name;
  if (ranks.is_first()) {
    write_atomically(file, [&](const std::filesystem::path& partial) {
      reserve(partial, header.size() + displacement_bytes_per_site * extent.sites());
      name = packed(std::filesystem::absolute(partial).string());
      ranks.broadcast(name);
      write_part(partial);
    });
  } else {
    ranks.broadcast(name);
    write_part(std::string(reinterpret_cast<const char*>(name.data()), name.size()));
  }
  name.clear();
  ranks.broadcast(name); // the file has its name
}

} // namespace hdmbench
