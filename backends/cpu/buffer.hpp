#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace hdmbench::openmp {

/// Floats that nobody has touched yet: the thread that first writes a page gets it near itself, and pages
/// that are never written cost nothing.
class Buffer {
public:
  /// Room for `size` floats; the content is then undefined. Keeps larger room that is there. Throws
  /// std::bad_alloc.
  void require(std::size_t size) {
    if (size <= size_) {
      return;
    }
    release();
    const std::size_t bytes = (size * sizeof(float) + page - 1) / page * page;
    // NOLINTNEXTLINE(cppcoreguidelines-owning-memory): into the owner at once
    values_.reset(static_cast<float*>(std::aligned_alloc(bytes < huge ? page : huge, bytes)));
    if (values_ == nullptr) {
      throw std::bad_alloc();
    }
#if defined(__linux__)
    if (bytes >= huge) {
      // Advice only: where it fails pages are small.
      (void)madvise(values_.get(), bytes, MADV_HUGEPAGE);
    }
#endif
    size_ = size;
  }
  void release() {
    values_.reset();
    size_ = 0;
  }
  [[nodiscard]] float* data() {
    return values_.get();
  }
  [[nodiscard]] const float* data() const {
    return values_.get();
  }
  [[nodiscard]] std::size_t size() const {
    return size_;
  }

private:
  static constexpr std::size_t page = 4096;
  static constexpr std::size_t huge = std::size_t{1} << 21;

  struct Free {
    // NOLINTNEXTLINE(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): what aligned_alloc gave
    void operator()(float* values) const { std::free(values); }
  };
  std::unique_ptr<float, Free> values_;
  std::size_t size_ = 0;
};

} // namespace hdmbench::openmp
