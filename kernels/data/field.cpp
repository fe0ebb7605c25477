#include "kernels/data/field.hpp"

namespace hdmbench {

void make_zeros(std::span<std::vector<float>* const> arrays, std::size_t size) {
  for (std::vector<float>* const values : arrays) {
    values->reserve(size); // where memory is short, outside of the threads
  }
#pragma omp parallel for if (size > sites_worth_threads)
  for (std::vector<float>* const values : arrays) {
    values->resize(size);
  }
}

} // namespace hdmbench
