#include "harness/tools/simplex.hpp"

#include "kernels/data/input_error.hpp"

// The simplex of a build without ITK (-DHDMBENCH_IMAGES=OFF).

namespace hdmbench {

double minimise_by_simplex(const std::function<double(double)>&, const SearchOptions&) {
  throw InputError(
      "the simplex is ITK's, and this hdmbench was built without it; simulated annealing is there, "
      "or install libinsighttoolkit5-dev and configure with -DHDMBENCH_IMAGES=ON");
}

} // namespace hdmbench
