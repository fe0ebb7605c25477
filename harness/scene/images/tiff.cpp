#include "harness/scene/images/pixels.hpp"

#include <tiffio.h>

#include <memory>

namespace hdmbench::images {

namespace {

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

/// What the first picture of a file says about its pixels.
struct Layout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 1;
  std::uint16_t samples = 1;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t black = PHOTOMETRIC_MINISBLACK;

  explicit Layout(TIFF* tiff) {
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &black);
  }
  friend bool operator==(const Layout&, const Layout&) = default;
};

/// libtiff says nothing while it lives: ITK has read the header already, and what fails is told by results.
class Silence {
public:
  Silence() = default;
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  ~Silence() {
    TIFFSetErrorHandler(errors_);
    TIFFSetWarningHandler(warnings_);
  }

private:
  TIFFErrorHandler errors_ = TIFFSetErrorHandler(nullptr);
  TIFFErrorHandler warnings_ = TIFFSetWarningHandler(nullptr);
};

} // namespace

std::optional<Pixels> read_tiff_integers(const std::filesystem::path& file) {
  const Silence silence;
  const Tiff tiff(TIFFOpen(file.c_str(), "r"), &TIFFClose);
  if (tiff == nullptr) {
    throw unreadable(file, "its header is not that of a TIFF image");
  }
  const Layout first(tiff.get());
  if (first.black == PHOTOMETRIC_MINISWHITE) {
    throw unreadable(file,
                     "its 0 is white (MinIsWhite), which some programs turn round and others do not; save it "
                     "with 0 as black");
  }
  if (first.black == PHOTOMETRIC_PALETTE) {
    throw unreadable(
        file, "its pixels are numbers of colours in a palette, which are neither grey values nor labels; "
              "save it without one");
  }
  const bool is_integer = first.format == SAMPLEFORMAT_UINT || first.format == SAMPLEFORMAT_INT;
  const bool is_real = first.format == SAMPLEFORMAT_IEEEFP && first.bits == 32;
  const bool becomes_colours = first.bits < 8 || first.samples > 1;
  if ((is_integer && (first.bits == 8 || first.bits == 16)) || is_real || becomes_colours) {
    return std::nullopt;
  }
  if (!is_integer || first.bits != 32 || TIFFIsTiled(tiff.get()) != 0) {
    throw unreadable(
        file, fmt::format("its pixels have {} bits{}{}; integers of 8, 16 or 32 bits and reals of 32 can "
                          "be read",
                          first.bits, is_integer ? "" : " and are no integers",
                          TIFFIsTiled(tiff.get()) != 0 ? " and lie in tiles" : ""));
  }
  Pixels pixels;
  Geometry& geometry = pixels.geometry;
  geometry.axes = Placement{}.axes;
  geometry.size = {static_cast<int>(first.width), static_cast<int>(first.height), 0};
  std::vector<std::uint32_t> row(first.width);
  do {
    if (Layout(tiff.get()) != first) {
      throw unreadable(file, "its pictures are not of one size and type");
    }
    ++geometry.size[2];
    require_reasonable_number(file, geometry);
    for (std::uint32_t y = 0; y < first.height; ++y) {
      if (static_cast<std::size_t>(TIFFScanlineSize(tiff.get())) != row.size() * sizeof(std::uint32_t) ||
          TIFFReadScanline(tiff.get(), row.data(), y) != 1) {
        throw unreadable(file, fmt::format("it is damaged or cut short: row {} cannot be read", y));
      }
      std::ranges::transform(row, std::back_inserter(pixels.values), [&](std::uint32_t value) {
        return first.format == SAMPLEFORMAT_INT ? static_cast<float>(static_cast<std::int32_t>(value))
                                                : static_cast<float>(value);
      });
    }
  } while (TIFFReadDirectory(tiff.get()) != 0);
  return pixels;
}

} // namespace hdmbench::images
