#include "harness/scene/images/intact.hpp"

#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <set>
#include <string_view>

namespace hdmbench::images {

namespace {

/// Bytes of one value of the types 0 ... 18; 0: there is no such type, and libtiff passes over it.
constexpr std::array<std::uint64_t, 19> type_sizes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};

/// Document's, image's and makers' names, page name, software, date, artist, host, inks, target printer,
/// copyright: libtiff ends these by itself. In other texts ITK reads on to the next 0 in memory.
constexpr std::array<std::uint64_t, 12> known_texts{269, 270, 271, 272, 285, 305,
                                                    306, 315, 316, 333, 337, 33432};

class Directories {
public:
  explicit Directories(const std::filesystem::path& file)
      : file_(file), stream_(file, std::ios::binary), size_(std::filesystem::file_size(file)) {
    little_endian_ = number(0, 1) == 'I';
    big_ = number(2, 2) == 43;
  }

  void require_sound() {
    std::set<std::uint64_t> seen;
    for (std::uint64_t at = big_ ? number(8, 8) : number(4, 4); at != 0;) {
      if (!seen.insert(at).second) {
        fail(fmt::format("the directory at byte {} comes again", at));
      }
      const std::uint64_t head = big_ ? 8 : 2;
      const std::uint64_t entry = big_ ? 20 : 12;
      const std::uint64_t entries = number(at, head);
      if (entries > size_ / entry) {
        fail(fmt::format("the directory at byte {} has {} entries", at, entries));
      }
      for (std::uint64_t i = 0; i < entries; ++i) {
        require_sound_entry(at + head + i * entry);
      }
      at = number(at + head + entries * entry, big_ ? 8 : 4);
    }
  }

private:
  void require_sound_entry(std::uint64_t entry) {
    const std::uint64_t type = number(entry + 2, 2);
    const std::uint64_t values = number(entry + 4, big_ ? 8 : 4);
    const std::uint64_t bytes = type < type_sizes.size() ? type_sizes[type] : 0;
    if (bytes > 0 && values > size_ / bytes) {
      fail(fmt::format("the entry at byte {} has {} values", entry, values));
    }
    constexpr std::uint64_t text = 2;
    const std::uint64_t tag = number(entry, 2);
    const bool is_known_text = std::ranges::find(known_texts, tag) != known_texts.end();
    if (is_known_text && type != text) {
      fail(fmt::format("the entry at byte {} (tag {}) is no text", entry, tag));
    }
    if (type == text && values > 0 && !is_known_text) {
      const std::uint64_t width = big_ ? 8 : 4;
      const std::uint64_t begin = values <= width ? entry + 4 + width : number(entry + 4 + width, width);
      if (begin > size_ || number(begin + values - 1, 1) != 0) {
        fail(fmt::format("the text of the entry at byte {} has no end", entry));
      }
    }
  }

  std::uint64_t number(std::uint64_t at, std::uint64_t bytes) {
    if (at > size_ || size_ - at < bytes) {
      fail(fmt::format("it goes on at byte {}, but ends at {}", at, size_));
    }
    std::array<unsigned char, 8> read{};
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(reinterpret_cast<char*>(read.data()), static_cast<std::streamsize>(bytes));
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < bytes; ++i) {
      value = (value << 8U) | read[little_endian_ ? bytes - 1 - i : i];
    }
    return value;
  }

  [[noreturn]] void fail(std::string_view how) const {
    throw InputError(
        fmt::format("cannot read the image {}: it is damaged or cut short: {}", file_.string(), how));
  }

  const std::filesystem::path& file_;
  std::ifstream stream_;
  std::uint64_t size_;
  bool little_endian_ = true;
  bool big_ = false;
};

} // namespace

void require_sound_tiff_directories(const std::filesystem::path& file) {
  Directories(file).require_sound();
}

} // namespace hdmbench::images
