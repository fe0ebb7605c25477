#include "harness/solve/set_aside.hpp"

#include "kernels/data/elastic/springs.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <memory>

namespace hdmbench {

FieldAside::FieldAside(std::vector<float>& values, Extent extent)
    : values_(values),
      rows_(values, static_cast<std::size_t>(extent.width), static_cast<std::size_t>(extent.height)) {
#ifdef __linux__
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* spare = rows_.spare().data();
  std::size_t bytes = rows_.spare().size_bytes();
  if (std::align(page, page, spare, bytes) != nullptr) { // where this fails the memory stays
    (void)madvise(spare, bytes / page * page, MADV_DONTNEED);
  }
#endif
}

SetAside::~SetAside() {
  on_all_threads(fields_.size(), true, [&](std::size_t i) { fields_[i].reset(); });
}

SetAside::SetAside(Level& level, ScalarField* picture) {
  if (level.extent.axes() == 2 || has_springs(level)) {
    return;
  }
  std::vector<std::vector<float>*> arrays{&level.modulus.values, &level.inverse_modulus.values};
  if (picture != nullptr) {
    arrays.push_back(&picture->values);
  }
  for (VectorField* const field : {&level.target, &level.confidence}) {
    for (std::vector<float>& values : field->planes) {
      arrays.push_back(&values);
    }
  }
  fields_.resize(arrays.size());
  on_all_threads(arrays.size(), true,
                 [&](std::size_t i) { fields_[i] = std::make_unique<FieldAside>(*arrays[i], level.extent); });
#ifdef __GLIBC__
  malloc_trim(0); // what set-up left between arrays that are still there
#endif
}

} // namespace hdmbench
