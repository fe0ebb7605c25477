#include "test/files.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

namespace hdmbench {
namespace {

TEST_F(ImageFiles, WhatIsNoImageIsRefused) {
  expect_refusal([&] { (void)read_scalar(path("gone.png")); }, "there is no such file");
  expect_refusal([&] { (void)read_scalar(path("")); }, "not a file");
  for (const auto* name : {"a.png", "a.nrrd", "a.nii", "a.nii.gz", "a.mha", "a.jpg", "a.tif", "a"}) {
    const auto text = write(name, "This is no image.\n");
    expect_refusal([&] { (void)read_scalar(text); }, text.string());
    expect_refusal([&] { (void)read_scalar(text); }, "NRRD, MetaImage, NIfTI, PNG, JPEG or TIFF");
    const auto empty = write(name, "");
    expect_refusal([&] { (void)read_scalar(empty); }, "NRRD, MetaImage, NIfTI, PNG, JPEG or TIFF");
  }
}

TEST_F(ImageFiles, NrrdCutShortIsRefused) {
  const auto raw =
      write("raw.nrrd", "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 4 4\nencoding: raw\n\n0123456789");
  expect_refusal([&] { (void)read_scalar(raw); }, "fread got only 10 1-sized things, not 16");
  const auto ascii = write_nrrd("ascii.nrrd", "float", "2 2", "1 2 3");
  expect_refusal([&] { (void)read_scalar(ascii); }, "element 4 of 4");
  const auto header = write("header.nrrd", "NRRD0004\ntype: uint8\n");
  expect_refusal([&] { (void)read_scalar(header); }, header.string());
  const auto huge =
      write("huge.nrrd", "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 1000000 1000000\nencoding: raw\n\nx");
  expect_refusal([&] { (void)read_scalar(huge); }, "promises 1000000000000 values");
}

TEST_F(ImageFiles, PngCutShortIsRefused) {
  ScalarField picture({30, 20});
  std::iota(picture.values.begin(), picture.values.end(), 0.0F);
  write_png(path("whole.png"), picture);
  for (const double share : {0.99, 0.7, 0.4, 0.1}) {
    const auto file = cut(path("whole.png"), share, "cut.png");
    expect_refusal([&] { (void)read_scalar(file); }, file.string());
  }
  std::string bytes = content(path("whole.png"));
  bytes[18] = '\x7f'; // a digit of the width, so that the header's checksum is wrong
  const auto damaged = write("damaged.png", bytes);
  expect_refusal([&] { (void)read_scalar(damaged); }, "IHDR: CRC error");
}

TEST_F(ImageFiles, MetaImageCutShortIsRefused) {
  write_displacement(path("whole.mha"), some_displacement({30, 20}), 1.0);
  const std::string whole = content(path("whole.mha"));
  for (const std::size_t missing : {std::size_t{1}, std::size_t{30}, whole.size() / 2}) {
    const auto file = write("cut.mha", std::string_view(whole).substr(0, whole.size() - missing));
    expect_refusal([&] { (void)read_vector(file); }, "cut short");
  }
  std::string bytes = whole;
  bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
  const auto damaged = write("damaged.mha", bytes);
  expect_refusal([&] { (void)read_vector(damaged); }, "damaged");

  const std::string header =
      "ObjectType = Image\nNDims = 2\nBinaryData = {}\nBinaryDataByteOrderMSB = False\n"
      "ElementSpacing = 1 1\nDimSize = 3 2\nElementType = MET_UCHAR\nElementDataFile = {}\n";
  const auto raw = write("raw.mha", fmt::format(fmt::runtime(header), "True", "LOCAL") + "abcdef");
  EXPECT_EQ(read_labels(raw).pixels.values, (std::vector<int>{'a', 'b', 'c', 'd', 'e', 'f'}));
  const auto short_of_one = write("raw.mha", fmt::format(fmt::runtime(header), "True", "LOCAL") + "abcde");
  expect_refusal([&] { (void)read_labels(short_of_one); }, "data not read completely ideal = 6 : actual = 5");
  const auto text = write("text.mha", fmt::format(fmt::runtime(header), "False", "LOCAL") + "1 2 3 4 5 6");
  expect_refusal([&] { (void)read_labels(text); }, "BinaryData = False");
  const auto alone = write("alone.mhd", fmt::format(fmt::runtime(header), "True", "gone.raw"));
  expect_refusal([&] { (void)read_labels(alone); }, "gone.raw");
}

TEST_F(ImageFiles, MetaImageHeadersThatAreNoneAreRefused) {
  const auto with = [&](std::string_view ndims, std::string_view size, std::string_view more) {
    return write("odd.mha",
                 fmt::format("NDims = {}\nBinaryData = True\nDimSize = {}\n{}ElementType = MET_UCHAR\n"
                             "ElementDataFile = LOCAL\nabcdef",
                             ndims, size, more));
  };
  EXPECT_EQ(read_labels(with("2", "3 2", "")).pixels.extent, (Extent{3, 2}));
  const std::string long_lines = "Comment = " + std::string(250, 'c') + "\n" + std::string(190, 'k') + " = " +
                                 std::string(3700, 'v') + "\n";
  EXPECT_EQ(read_labels(with("2", "3 2", long_lines)).pixels.extent, (Extent{3, 2}));
  for (const auto* number : {"0", "11", "x", ""}) {
    expect_refusal([&] { (void)read_labels(with(number, "3 2", "")); }, "odd.mha");
  }
  for (const auto* size : {"3", "3 0", "3 -2"}) {
    expect_refusal([&] { (void)read_labels(with("2", size, "")); }, "odd.mha");
  }
  for (const std::string& line :
       {std::string("ElementSpacing = 1 nan\n"), std::string("Offset = 1\n"),
        std::string(300, 'k') + " = v\n", "Comment = " + std::string(300, 'c') + "\n",
        std::string("CompressedData = True\n")}) {
    expect_refusal([&] { (void)read_labels(with("2", "3 2", line)); }, "odd.mha");
  }
}

TEST_F(ImageFiles, NiftiCutShortIsRefused) {
  const fs::path whole = fs::path(HDMBENCH_DAMAGED_IMAGES) / "short.nii"; // of 16-bit integers
  EXPECT_EQ(read_labels(whole).pixels.values, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  const auto file = write("cut.nii", content(whole).substr(0, content(whole).size() - 1));
  expect_refusal([&] { (void)read_labels(file); }, "data bytes needed = 12 data bytes input = 11");
}

/// What fuzzing has found: ITK crashes on these files, does not end, or would fill the memory, and says
/// nothing of what it takes from beside them.
TEST_F(ImageFiles, OnWhichItkFailsAreRefusedAndOthersAreRead) {
  const std::map<std::string, std::string_view> refusals{
      {"circle.tif", "its reader was ended by signal 24"}, // directories that lead back to themselves
      {"huge.nii", "non-finite"},
      {"huge.nrrd", "bytes for 1024000000 values"},
      {"huge.png", "its header promises 3600000000 values"},
      {"huge.tif", "134 bytes for 1024000000 values"},
      {"list-1.mha", "data not read completely"},
      {"list-2.mha", ""}, // writes beyond its memory
      {"list-3.mha", "data not read completely"},
      {"long-comment.mha", "signal 6"},
      {"many-values.tif", "its content or its name"},
      {"negative-axes.mha", "its reader was ended by signal 24"},
      {"not-finite.nii", "non-finite"},
      {"palette.png", "4 components"},
      {"compressed.mha", "2 components"},
      {"endless-text.tif", "4 components"},
      {"endless-text-2.tif", "4 components"},
      {"zero-spacing.nii", "non-finite"}};
  int count = 0;
  for (const auto& entry : fs::directory_iterator(HDMBENCH_DAMAGED_IMAGES)) {
    const fs::path& file = entry.path();
    SCOPED_TRACE(file);
    if (const auto found = refusals.find(file.filename()); found != refusals.end()) {
      const std::string words = test::refusal([&] { (void)read_scalar(file); });
      EXPECT_THAT(words,
                  testing::AllOf(testing::HasSubstr(file.string()), testing::HasSubstr(found->second)));
    } else {
      EXPECT_GT(read_scalar(file).pixels.values.size(), 0U);
    }
    ++count;
  }
  EXPECT_EQ(count, 28);
}

/// 8 x 8 pixels of gray value 100.
std::string jpeg_bytes() {
  const std::string_view hexadecimal = "ffd8ffdb0043000101010101010101010101010101010101010101010101010101010"
                                       "10101010101010101010101010101010101010101"
                                       "01010101010101010101010101010101ffc0000b080008000801011100ffc40014000"
                                       "100000000000000000000000000000008ffc40014"
                                       "100100000000000000000000000000000000ffda0008010100003f000fbfffd9";
  std::string bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(std::string(hexadecimal.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

TEST_F(ImageFiles, JpegIsReadWhereItIsWhole) {
  const auto image = read_scalar(write("a.jpg", jpeg_bytes()));
  EXPECT_EQ(image.pixels.extent, (Extent{8, 8}));
  EXPECT_EQ(image.pixels.values, std::vector<float>(64, 100.0F));
  const std::string whole = jpeg_bytes();
  for (std::size_t length = 2; length < whole.size(); length += length < 140 ? 9 : 1) {
    const auto file = write("cut.jpg", std::string_view(whole).substr(0, length));
    expect_refusal([&] { (void)read_scalar(file); }, "cut short");
  }
}

/// 20 x 10 pixels 0, 1, 2, ... in one strip behind the directory.
std::string tiff_bytes() {
  const auto little_endian = [](unsigned value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) {
      text.push_back(static_cast<char>((value >> (8 * i)) & 0xffU));
    }
    return text;
  };
  constexpr unsigned entries = 9;
  constexpr unsigned pixels_at = 8 + 2 + 12 * entries + 4;
  // width, height, bits, no compression, black is 0, strip offset, one sample, rows in the strip, bytes in
  // the strip
  const std::array<std::pair<unsigned, unsigned>, entries> tags{{{256, 20},
                                                                 {257, 10},
                                                                 {258, 8},
                                                                 {259, 1},
                                                                 {262, 1},
                                                                 {273, pixels_at},
                                                                 {277, 1},
                                                                 {278, 10},
                                                                 {279, 200}}};
  std::string bytes = "II" + little_endian(42, 2) + little_endian(8, 4) + little_endian(entries, 2);
  for (const auto& [tag, value] : tags) {
    bytes += little_endian(tag, 2) + little_endian(3, 2) + little_endian(1, 4) + little_endian(value, 4);
  }
  bytes += little_endian(0, 4);
  for (unsigned pixel = 0; pixel < 200; ++pixel) {
    bytes += little_endian(pixel, 1);
  }
  return bytes;
}

TEST_F(ImageFiles, TiffIsReadWhereItIsWhole) {
  const auto image = read_labels(write("a.tif", tiff_bytes()));
  ASSERT_EQ(image.pixels.extent, (Extent{20, 10}));
  for (int pixel = 0; pixel < 200; ++pixel) {
    EXPECT_EQ(image.pixels.values[static_cast<std::size_t>(pixel)], pixel);
  }
  for (const double share : {0.9, 0.5, 0.2}) {
    const auto file = cut(path("a.tif"), share, "cut.tif");
    expect_refusal([&] { (void)read_scalar(file); }, file.string());
  }
}

} // namespace
} // namespace hdmbench
