// Image files as other programs write them: types, units, spaces and odd headers are read right, or refused.

#include "test/files.hpp"

#include <bit>
#include <cstring>

namespace hdmbench {
namespace {

template <typename Number>
void put(std::string& bytes, std::size_t at, Number number) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
}

template <typename Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// Byte by byte what nifti1.h says.
namespace nifti {
enum Field : std::size_t {
  dim = 40,
  intent = 68,
  type = 70,
  bits = 72,
  side = 76,
  offset = 108,
  slope = 112,
  intercept = 116,
  units = 123,
  qform_code = 252,
  sform_code = 254,
  quaternion = 256,
  qform_origin = 268,
  sform = 280,
  magic = 344
};
} // namespace nifti

/// Voxels 0 ... 23 of 2 mm, which begin at (10, 20, 30) of NIfTI's axes.
std::string nifti_volume() {
  std::string bytes(352, '\0');
  put(bytes, 0, 348);
  for (const auto& [at, number] : {std::pair{0, 3}, {1, 2}, {2, 3}, {3, 4}, {4, 1}, {5, 1}, {6, 1}, {7, 1}}) {
    put(bytes, nifti::dim + 2 * static_cast<std::size_t>(at), static_cast<std::int16_t>(number));
  }
  put(bytes, nifti::type, std::int16_t{16}); // 32-bit reals
  put(bytes, nifti::bits, std::int16_t{32});
  for (std::size_t axis = 0; axis < 4; ++axis) {
    put(bytes, nifti::side + 4 * axis, axis == 0 ? 1.0F : 2.0F);
  }
  put(bytes, nifti::offset, 352.0F);
  put(bytes, nifti::units, char{2});
  put(bytes, nifti::sform_code, std::int16_t{1});
  for (std::size_t row = 0; row < 3; ++row) {
    put(bytes, nifti::sform + 20 * row, 2.0F);
    put(bytes, nifti::sform + 16 * row + 12, 10.0F * static_cast<float>(row + 1));
  }
  std::memcpy(bytes.data() + nifti::magic, "n+1", 3);
  std::vector<float> values(24);
  std::iota(values.begin(), values.end(), 0.0F);
  return bytes + bytes_of(values);
}

class ForeignFiles : public ImageFiles {
protected:
  [[nodiscard]] Image<ScalarField> read_nifti(const std::string& bytes) const {
    return read_scalar(write("a.nii", bytes), {.takes_volumes = true});
  }
};

using Vector = Placement::Vector;

TEST_F(ForeignFiles, OfNiftiHaveTheirUnitAndTheirPlace) {
  for (const auto& [unit, millimetres] : {std::pair{0, 1.0}, {1, 1000.0}, {2, 1.0}, {3, 0.001}}) {
    std::string bytes = nifti_volume();
    put(bytes, nifti::units, static_cast<char>(unit + 8)); // and seconds
    const auto image = read_nifti(bytes);
    EXPECT_DOUBLE_EQ(image.spacing, 2.0 * millimetres);
    EXPECT_DOUBLE_EQ(image.placement.origin[0], -10.0 * millimetres);
    EXPECT_DOUBLE_EQ(image.placement.origin[1], -20.0 * millimetres);
    EXPECT_DOUBLE_EQ(image.placement.origin[2], 30.0 * millimetres);
    EXPECT_EQ(image.placement.axes, (std::array{Vector{-1, 0, 0}, Vector{0, -1, 0}, Vector{0, 0, 1}}));
    EXPECT_EQ(image.pixels.values[23], 23.0F);
  }
}

TEST_F(ForeignFiles, OfNiftiKeepValuesThatAreNotFinite) {
  std::string bytes = nifti_volume();
  put(bytes, 352, std::numeric_limits<float>::infinity());
  put(bytes, 356, std::nanf(""));
  const auto values = read_nifti(bytes).pixels.values;
  EXPECT_EQ(values[0], HUGE_VALF);
  EXPECT_TRUE(std::isnan(values[1]));
  expect_refusal([&] { (void)read_labels(path("a.nii"), {.takes_volumes = true}); },
                 "x = 0, y = 0, z = 0 is inf");
}

TEST_F(ForeignFiles, OfNiftiHaveAnyTypeAndScale) {
  const auto expect_read = [&](int type, int width, const std::string& pixels) {
    std::string bytes = nifti_volume().substr(0, 352) + pixels;
    put(bytes, nifti::type, static_cast<std::int16_t>(type));
    put(bytes, nifti::bits, static_cast<std::int16_t>(8 * width));
    EXPECT_EQ(read_nifti(bytes).pixels.values[23], 23.0F) << type;
    put(bytes, nifti::slope, 2.0F);
    put(bytes, nifti::intercept, 0.5F);
    EXPECT_EQ(read_nifti(bytes).pixels.values[23], 46.5F) << type;
  };
  const auto numbers = [](auto zero) {
    std::vector<decltype(zero)> values(24);
    std::iota(values.begin(), values.end(), zero);
    return bytes_of(values);
  };
  expect_read(2, 1, numbers(std::uint8_t{}));
  expect_read(256, 1, numbers(std::int8_t{}));
  expect_read(4, 2, numbers(std::int16_t{}));
  expect_read(512, 2, numbers(std::uint16_t{}));
  expect_read(8, 4, numbers(std::int32_t{}));
  expect_read(768, 4, numbers(std::uint32_t{}));
  expect_read(1024, 8, numbers(std::int64_t{}));
  expect_read(1280, 8, numbers(std::uint64_t{}));
  expect_read(64, 8, numbers(0.0));
  std::string complex = nifti_volume() + bytes_of(std::vector<float>(24));
  put(complex, nifti::type, std::int16_t{32});
  put(complex, nifti::bits, std::int16_t{64});
  expect_refusal([&] { (void)read_nifti(complex); }, "are of the type COMPLEX64");
}

/// In the order of the other machines.
TEST_F(ForeignFiles, OfNiftiAreReadInBothOrdersOfBytes) {
  std::string bytes = nifti_volume();
  const auto turn = [&](std::size_t from, std::size_t count, std::size_t width) {
    for (std::size_t at = from; at < from + count * width; at += width) {
      std::reverse(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + width));
    }
  };
  turn(0, 1, 4);
  turn(nifti::dim, 8, 2);
  turn(nifti::intent, 3, 2);
  turn(nifti::side, 11, 4); // and offset, slope, intercept
  turn(nifti::qform_code, 2, 2);
  turn(nifti::quaternion, 18, 4);
  turn(352, 24, 4);
  const auto image = read_nifti(bytes);
  EXPECT_EQ(image.pixels.values[23], 23.0F);
  EXPECT_EQ(image.placement.origin, (Vector{-10, -20, 30}));
}

TEST_F(ForeignFiles, OfNiftiLieWhereTheirSformSays) {
  std::string bytes = nifti_volume();
  put(bytes, nifti::qform_code, std::int16_t{1}); // 12 degrees about z
  put(bytes, nifti::quaternion + 8, static_cast<float>(std::sin(std::numbers::pi / 30.0)));
  testing::internal::CaptureStderr();
  const auto by_sform = read_nifti(bytes);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("sform is taken"));
  EXPECT_EQ(by_sform.placement.axes[0], (Vector{-1, 0, 0}));
  put(bytes, nifti::sform_code, std::int16_t{0});
  const auto by_qform = read_nifti(bytes);
  EXPECT_NEAR(by_qform.placement.axes[0][0], -std::cos(std::numbers::pi / 15.0), 1e-6);
  put(bytes, nifti::qform_code, std::int16_t{0});
  testing::internal::CaptureStderr();
  EXPECT_EQ(read_nifti(bytes).grid.stated, Stated::sides);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("neither sform nor qform"));
  // Directions whose rounding is that of small sides, which ITK calls not orthonormal.
  put(bytes, nifti::sform_code, std::int16_t{1});
  put(bytes, nifti::sform + 4, 1e-4F);
  EXPECT_EQ(read_nifti(bytes).pixels.extent, (Extent{2, 3, 4}));
}

TEST_F(ForeignFiles, OfNiftiMayHaveTwoAxes) {
  std::string bytes = nifti_volume().substr(0, 352 + 6 * sizeof(float));
  put(bytes, nifti::dim, std::int16_t{2});
  for (std::size_t axis = 3; axis < 8; ++axis) {
    put(bytes, nifti::dim + 2 * axis, std::int16_t{0});
    put(bytes, nifti::side + 4 * axis, 0.0F);
  }
  EXPECT_EQ(read_scalar(write("a.nii", bytes)).pixels.values, (std::vector<float>{0, 1, 2, 3, 4, 5}));
}

TEST_F(ForeignFiles, OfNiftiWithAWrongHeaderAreRefused) {
  const auto with = [](std::size_t at, auto number) {
    std::string bytes = nifti_volume();
    put(bytes, at, number);
    return bytes;
  };
  for (const float offset : {0.0F, 348.0F, std::nanf(""), 1e30F}) {
    expect_refusal([&] { (void)read_nifti(with(nifti::offset, offset)); }, "vox_offset");
  }
  for (const float side : {0.0F, -2.0F, std::nanf(""), HUGE_VALF}) {
    expect_refusal([&] { (void)read_nifti(with(nifti::side + 8, side)); }, "mm along axis 2 (pixdim)");
  }
  expect_refusal([&] { (void)read_nifti(with(nifti::units, char{5})); }, "unit of length is number 5");
  expect_refusal([&] { (void)read_nifti(with(nifti::sform, std::nanf(""))); },
                 "non-finite direction of axis 1");
  expect_refusal([&] { (void)read_nifti(with(nifti::dim + 2, std::int16_t{3})); }, "damaged or cut short");
  std::string analyze = nifti_volume();
  put(analyze, nifti::magic, 0);
  (void)write("old.img", analyze.substr(352));
  expect_refusal([&] { (void)read_scalar(write("old.hdr", analyze.substr(0, 348))); }, "Analyze 7.5");
}

TEST_F(ForeignFiles, OfNiftiWithDisplacementsAreAlongItsAxes) {
  VectorField field = some_displacement({4, 3, 2});
  write_displacement(path("d.nii.gz"), field, 1.0);
  ASSERT_EQ(
      std::system(
          fmt::format("gzip -dc '{0}' > '{1}'", path("d.nii.gz").string(), path("d.nii").string()).c_str()),
      0);
  const std::string bytes = content(path("d.nii"));
  std::int16_t intent = 0;
  std::memcpy(&intent, bytes.data() + nifti::intent, sizeof intent);
  EXPECT_EQ(intent, 1006);
  std::array<float, 3> first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::memcpy(&first.at(axis), bytes.data() + 352 + axis * 24 * sizeof(float), sizeof(float));
  }
  EXPECT_THAT(first, ElementsAre(-field[0][0], -field[1][0], field[2][0]));
  EXPECT_EQ(read_displacement(path("d.nii"), true).pixels.planes, field.planes);
  write_displacement(path("d.nrrd"), field, 1.0);
  EXPECT_THAT(content(path("d.nrrd")), HasSubstr("\ndisplacement field type:=modeling\n"));
  write_displacement(path("back.nrrd"), field, 1.0, {}, {}, Mapping::backward);
  EXPECT_THAT(content(path("back.nrrd")), HasSubstr("\ndisplacement field type:=resampling\n"));
}

TEST_F(ForeignFiles, WithAllTheirCompressedPartsAreWhole) {
  const auto zip = [&](const std::string& name, const std::string& bytes) {
    const fs::path file = write(name, bytes);
    EXPECT_EQ(std::system(fmt::format("gzip -nf '{}'", file.string()).c_str()), 0);
    return content(path(name + ".gz"));
  };
  const std::string volume = nifti_volume();
  const std::string first = zip("first", volume.substr(0, 400));
  std::string second = zip("second", volume.substr(400));
  const auto read = [&] { return read_scalar(write("a.nii.gz", first + second), {.takes_volumes = true}); };
  EXPECT_EQ(read().pixels.values[23], 23.0F);
  second[second.size() - 6] ^= 1; // its checksum
  expect_refusal([&] { (void)read(); }, "damaged");
  // Zeros, of which half a file gives more than enough.
  LabelField labels{{60, 50, 40}, std::vector<int>(60 * 50 * 40)};
  for (const char* name : {"z.nrrd", "z.mha", "z.nii.gz"}) {
    write_labels(path(name), labels, 1.0);
    const std::string bytes = content(path(name));
    EXPECT_EQ(read_labels(path(name), {.takes_volumes = true}).pixels.values, labels.values);
    for (const double share : {0.999, 0.9, 0.7, 0.5}) {
      const auto half = cut(path(name), share, std::string("half-") + name);
      expect_refusal([&] { (void)read_labels(half, {.takes_volumes = true}); }, half.string());
    }
  }
}

TEST_F(ForeignFiles, OfNrrdLieInTheSpaceTheySay) {
  const auto read = [&](std::string_view space, std::string_view more = "") {
    return read_labels(write_nrrd("a.nrrd", "uchar", "2 2 2", "1 2 3 4 5 6 7 8",
                                  fmt::format("space: {}\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"
                                              "space origin: (10,20,30)\n{}",
                                              space, more)),
                       {.takes_volumes = true});
  };
  for (const auto& [space, x, y] :
       {std::tuple{"left-posterior-superior", 1.0, 1.0}, std::tuple{"LPS", 1.0, 1.0},
        std::tuple{"right-anterior-superior", -1.0, -1.0}, std::tuple{"RAS", -1.0, -1.0},
        std::tuple{"left-anterior-superior", 1.0, -1.0}, std::tuple{"LAS", 1.0, -1.0}}) {
    const Placement placement = read(space).grid.placement;
    EXPECT_EQ(placement.origin, (Vector{10.0 * x, 20.0 * y, 30.0})) << space;
    EXPECT_EQ(placement.axes, (std::array{Vector{x, 0, 0}, Vector{0, y, 0}, Vector{0, 0, 1}})) << space;
  }
  for (const char* space : {"scanner-xyz", "3D-right-handed", "3D-left-handed"}) {
    expect_refusal([&] { (void)read(space); }, "does not say where the patient's left");
  }
  const auto small = read("LPS", "space units: \"microns\" \"microns\" \"microns\"\n");
  EXPECT_DOUBLE_EQ(small.spacing, 0.001);
  EXPECT_DOUBLE_EQ(small.grid.sides[2], 0.003);
  EXPECT_DOUBLE_EQ(small.grid.placement.origin[2], 0.03);
  EXPECT_DOUBLE_EQ(read("LPS", "space units: \"mm\" \"mm\" \"mm\"\n").spacing, 1.0);
  expect_refusal([&] { (void)read("LPS", "space units: \"furlong\" \"furlong\" \"furlong\"\n"); }, "furlong");
  const auto flat = write_nrrd("f.nrrd", "uchar", "2 1", "1 2", "spacings: 0.5 0.5\nunits: \"cm\" \"cm\"\n");
  EXPECT_DOUBLE_EQ(read_labels(flat).spacing, 5.0);
}

/// One strip of 2 x 2 pixels.
std::string tiff(int bits, int format, int black, const std::string& pixels) {
  constexpr int entries = 11;
  constexpr int begin = 8 + 2 + 12 * entries + 4;
  const auto length = static_cast<int>(pixels.size());
  const std::vector<std::array<int, 4>> fields{{256, 4, 1, 2},      {257, 4, 1, 2},
                                               {258, 3, 1, bits},   {259, 3, 1, 1},
                                               {262, 3, 1, black},  {273, 4, 1, begin},
                                               {277, 3, 1, 1},      {278, 4, 1, 2},
                                               {279, 4, 1, length}, {320, 3, 768, begin + length},
                                               {339, 3, 1, format}};
  std::string bytes("II*\0\x08\0\0\0", 8);
  bytes += bytes_of(std::vector{static_cast<std::int16_t>(entries)});
  for (const auto& [tag, type, count, value] : fields) {
    bytes += bytes_of(std::vector{static_cast<std::int16_t>(tag), static_cast<std::int16_t>(type)});
    bytes += bytes_of(std::vector{count, value});
  }
  return bytes + std::string(4, '\0') + pixels + std::string(1536, '\0');
}

TEST_F(ForeignFiles, OfTiffHaveTheirNumbersOrAreRefused) {
  const auto values = [&](int bits, int format, const std::string& pixels, int black = 1) {
    return read_scalar(write("a.tif", tiff(bits, format, black, pixels))).pixels.values;
  };
  constexpr int is_unsigned = 1;
  constexpr int is_signed = 2;
  constexpr int is_real = 3;
  const std::vector<float> whole{0, 1, 70, 100};
  EXPECT_EQ(values(8, is_unsigned, bytes_of(std::vector<std::uint8_t>{0, 1, 70, 100})), whole);
  EXPECT_EQ(values(16, is_unsigned, bytes_of(std::vector<std::uint16_t>{0, 1, 70, 100})), whole);
  EXPECT_EQ(values(32, is_unsigned, bytes_of(std::vector<std::uint32_t>{0, 1, 70, 100})), whole);
  EXPECT_EQ(values(16, is_signed, bytes_of(std::vector<std::int16_t>{0, 1, -70, 100}))[2], -70.0F);
  EXPECT_EQ(values(32, is_signed, bytes_of(std::vector<std::int32_t>{0, 1, -70, 70000})),
            (std::vector<float>{0, 1, -70, 70000}));
  EXPECT_EQ(values(32, is_real, bytes_of(std::vector<float>{0, 1, 70, 100})), whole);
  expect_refusal([&] { (void)values(64, is_real, bytes_of(std::vector<double>(4))); }, "64-bit");
  expect_refusal([&] { (void)values(64, is_unsigned, std::string(32, '\0')); }, "64-bit");
  expect_refusal([&] { (void)values(8, is_unsigned, std::string(4, '\1'), 0); }, "MinIsWhite");
  expect_refusal([&] { (void)values(8, is_unsigned, std::string(4, '\1'), 3); }, "palette");
  expect_refusal([&] { (void)values(1, is_unsigned, std::string(2, '\1')); }, "4 components");
}

TEST_F(ForeignFiles, OfPngWithOddNotesAreReadWithTheWarning) {
  const std::string whole = content(fs::path(HDMBENCH_DAMAGED_IMAGES) / "grey.png");
  const auto values = read_scalar(write("grey.png", whole)).pixels.values;
  for (const auto& [name, chunk] :
       {std::pair{"tIME",
                  std::string_view(
                      "\x00\x00\x00\x07\x74\x49\x4d\x45\x07\xe5\x0d\x01\x01\x01\x01\xa5\xaf\xe8\xa5", 19)},
        std::pair{"sBIT", std::string_view("\x00\x00\x00\x01\x73\x42\x49\x54\x63\x3c\x6a\xe3\x49", 13)},
        std::pair{"iCCP",
                  std::string_view("\x00\x00\x00\x15\x69\x43\x43\x50\x78\x00\x00\x78\x9c\xcb\xcb\x57\x28\x28"
                                   "\xca\x4f\xcb\xcc\x49\x05\x00\x15\x34\x03\xef\xcc\xc2\xf8\x98",
                                   33)}}) {
    std::string bytes = whole;
    bytes.insert(33, chunk); // behind the header
    testing::internal::CaptureStderr();
    EXPECT_EQ(read_scalar(write("odd.png", bytes)).pixels.values, values) << name;
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                AllOf(HasSubstr("libpng warning: "), HasSubstr("odd.png")))
        << name;
  }
}

TEST_F(ForeignFiles, KeepTheirOwnSidesAndAreNotResampledAThousandfold) {
  const auto volume =
      write_nrrd("v.nrrd", "float", "3 2 2", "0 1 2 0 1 2 3 4 5 3 4 5", "spacings: 1 1 1.0078125\n");
  const auto image = read_scalar(volume, {.takes_volumes = true});
  ASSERT_TRUE(image.oblong);
  const VectorField field = some_displacement(image.pixels.extent);
  write_displacement(path("w.nrrd"), field, image.spacing, image.placement, image.oblong);
  EXPECT_EQ(read_vector(path("w.nrrd"), {.takes_volumes = true}).pixels.planes, field.planes);
  EXPECT_THAT(content(path("w.nrrd")), HasSubstr("(0,0,1.0078125)"));
  for (const auto& [sides, says] :
       {std::pair{"1 1 0.001", "give a size"}, std::pair{"1e308 1e308 1e308", "1e+06 are possible"},
        std::pair{"1e-8 1e-8 1e-8", "1e-06 ... 1e+06"}}) {
    std::string pixels;
    for (int pixel = 0; pixel < 6 * 5 * 4; ++pixel) {
      pixels += "1 ";
    }
    const auto file = write_nrrd("s.nrrd", "uchar", "6 5 4", pixels, fmt::format("spacings: {}\n", sides));
    expect_refusal([&] { (void)read_labels(file, {.takes_volumes = true}); }, says);
  }
}

} // namespace
} // namespace hdmbench
