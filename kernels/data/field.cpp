#include "kernels/data/field.hpp"

#include <exception>

namespace hdmbench {

#ifdef _OPENMP
void on_all_threads(std::size_t count, bool is_worth_it, const std::function<void(std::size_t)>& call) {
  std::exception_ptr thrown;
#pragma omp parallel for schedule(dynamic) if (is_worth_it)
  for (std::size_t i = 0; i < count; ++i) {
    try {
      call(i);
    } catch (...) {
#pragma omp critical(hdmbench_thrown)
      thrown = thrown ? thrown : std::current_exception();
    }
  }
  if (thrown) {
    std::rethrow_exception(thrown);
  }
}
#else // for browsers, where there are no exceptions
void on_all_threads(std::size_t count, bool /*is_worth_it*/, const std::function<void(std::size_t)>& call) {
  for (std::size_t i = 0; i < count; ++i) {
    call(i);
  }
}
#endif

void make_zeros(std::span<std::vector<float>* const> arrays, std::size_t size) {
  on_all_threads(arrays.size(), size > sites_worth_threads, [&](std::size_t i) { arrays[i]->resize(size); });
}

} // namespace hdmbench
