#include "harness/judge/registration/elastic_registration.hpp"

#include "kernels/data/input_error.hpp"

// The registration of a build without ITK (-DHDMBENCH_IMAGES=OFF).

namespace hdmbench {

RegistrationResult register_elastically(const ScalarField&, const ScalarField&, const RegistrationOptions&,
                                        Progress&) {
  throw MissingFile("elastic registration: this hdmbench was built without image support; install "
                    "libinsighttoolkit5-dev and configure with -DHDMBENCH_IMAGES=ON");
}

} // namespace hdmbench
