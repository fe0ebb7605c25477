// Image files: ITK's readers behind harness/scene/images.

#include "harness/scene/images/images.hpp"
#include "test/fuzz/input.hpp"

namespace {

/// ITK goes by the name as well: the one that these bytes would have.
std::string_view name_for(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("NRRD")) {
    return "image.nrrd";
  }
  if (bytes.starts_with("\x89PNG")) {
    return "image.png";
  }
  if (bytes.starts_with("\xff\xd8")) {
    return "image.jpg";
  }
  if (bytes.starts_with("II*") || bytes.starts_with("MM\0*"sv)) {
    return "image.tif";
  }
  if (bytes.starts_with("\x1f\x8b")) {
    return "image.nii.gz";
  }
  return bytes.starts_with("\x5c\x01\0\0"sv) || bytes.starts_with("\0\0\x01\x5c"sv) ? "image.nii"
                                                                                    : "image.mha";
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hdmbench;
  const auto bytes = fuzz::as_text(data, size);
  const auto file = fuzz::file_with(name_for(bytes), bytes);
  fuzz::expect_an_answer([&] { (void)read_scalar(file); });
  fuzz::expect_an_answer([&] { (void)read_brain(file, 0, 2, 0.05, {9, 7}); });
  return 0;
}
