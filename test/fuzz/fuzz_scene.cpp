// Scene files: load_scene, with images beside them.

#include "harness/scene/scene.hpp"
#include "test/fuzz/input.hpp"

namespace {

/// Once per process, 3 x 2 pixels each.
bool write_images() {
  using hdmbench::fuzz::file_with;
  (void)file_with("labels.nrrd",
                  "NRRD0004\ntype: short\ndimension: 2\nsizes: 3 2\nencoding: ascii\n\n0 1 0\n1 1 0\n");
  (void)file_with("modulus.nrrd",
                  "NRRD0004\ntype: float\ndimension: 2\nsizes: 3 2\nencoding: ascii\n\n5 1.5 3\n1 1 9\n");
  (void)file_with("vector.nrrd",
                  "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 3 2\nkinds: vector domain domain\n"
                  "encoding: ascii\n\n0 1 0.5 0 0 1\n1 1 1 0 0 0.25\n");
  return true;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hdmbench;
  [[maybe_unused]] static const bool written = write_images();
  fuzz::expect_an_answer([&] {
    const auto file = fuzz::file_with("scene.toml", fuzz::as_text(data, size));
    // Whatever size the file asks for: read, and replaced.
    (void)load_scene(file.string(), {.size = Extent{9, 7}});
  });
  return 0;
}
