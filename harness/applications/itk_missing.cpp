#include "harness/applications/registration.hpp"

#include "harness/applications/detection.hpp"
#include "kernels/data/input_error.hpp"

// What ITK would do, in a build without ITK (-DHDMBENCH_IMAGES=OFF).

namespace hdmbench {

ConventionalRegistration register_conventionally(const ScalarField&, const ScalarField&, const ScalarField&,
                                                 Progress&) {
  throw MissingFile("conventional registration: this hdmbench was built without image support; install "
                    "libinsighttoolkit5-dev and configure with -DHDMBENCH_IMAGES=ON");
}

std::vector<double> minimise(const Objective&, std::size_t, double, int) {
  throw MissingFile("L-BFGS: this hdmbench was built without image support; install libinsighttoolkit5-dev "
                    "and configure with -DHDMBENCH_IMAGES=ON");
}

} // namespace hdmbench
