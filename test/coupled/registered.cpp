// Linked into a program, this lets scenes name the coupled energy.
#include "harness/scene/method.hpp"
#include "test/coupled/coupled.hpp"

namespace hdmbench::test {
namespace {

const RegisteredEnergy coupled{.name = "coupled",
                               .summary = "the tests' own",
                               .methods = methods(),
                               .of_sites = &coupled_energy,
                               .set_inputs = couple};
[[maybe_unused]] const bool is_registered = register_energy(coupled);

} // namespace
} // namespace hdmbench::test
