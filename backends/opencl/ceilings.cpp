#include "backends/opencl/ceilings.hpp"

#include "backends/opencl/programs.hpp"
#include "backends/shared/ceiling_shaders.hpp"

#include <opencl_shaders/ceilings.hpp>

#include <algorithm>
#include <bit>
#include <vector>

namespace hdmbench::opencl {

namespace {

constexpr std::size_t texels_of_item = 8; // of ceilings.cl

class Loops {
public:
  explicit Loops(const Queue& queue)
      : queue_(queue), group_(std::bit_floor(std::min<std::size_t>(64, queue.device().largest_group))),
        texels_(std::min(bytes_to_copy(), std::bit_floor(queue.device().largest_buffer)) /
                ceiling_shaders::texel_bytes) {
    if (texels_ < ceiling_shaders::texels) {
      throw TooLarge("a buffer of this device ends before 4 MiB");
    }
    given_ = ceiling_shaders::source(texels_);
    source_ = queue_.make_buffer(texels_ * ceiling_shaders::texel_bytes);
    target_ = queue_.make_buffer(texels_ * ceiling_shaders::texel_bytes);
    queue_.write(source_, 0, given_);
  }

  [[nodiscard]] Ceilings measure() const {
    Ceilings ceilings;
    const double bytes = 2.0 * static_cast<double>(texels_ * ceiling_shaders::texel_bytes);
    const Kernel copy = kernel("copy");
    ceilings.copy_bytes_per_second = sample_rates(bytes, [&](int times) { run(copy, texels_, times); });
    ceiling_shaders::require_copied(given_, result(texels_));
    const Kernel multiply_add = kernel("multiply_add");
    ceilings.operations_per_second = sample_rates(
        ceiling_shaders::operations(), [&](int times) { run(multiply_add, ceiling_shaders::texels, times); });
    ceiling_shaders::require_computed(given_, result(ceiling_shaders::texels));
    return ceilings;
  }

private:
  [[nodiscard]] Kernel kernel(const char* name) const {
    Kernel kernel = queue_.make_kernel(std::string(sources::ceilings_opencl), build_options, name);
    kernel.set(0, source_);
    kernel.set(1, target_);
    return kernel;
  }

  void run(const Kernel& kernel, std::size_t texels, int times) const {
    for (int i = 0; i < times; ++i) {
      queue_.run(kernel, texels / texels_of_item / group_, group_);
    }
    queue_.finish();
  }

  [[nodiscard]] std::vector<float> result(std::size_t texels) const {
    std::vector<float> values(4 * texels);
    queue_.read(target_, 0, values);
    return values;
  }

  const Queue& queue_;
  std::size_t group_;  ///< work items
  std::size_t texels_; ///< a power of two
  std::vector<float> given_;
  Buffer source_;
  Buffer target_;
};

} // namespace

Ceilings measure_ceilings(const Queue& queue) {
  return Loops(queue).measure();
}

} // namespace hdmbench::opencl
