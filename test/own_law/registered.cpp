// Linked into a program, this lets scenes name the tests' own law.
#include "harness/scene/laws.hpp"

namespace hdmbench {

namespace laws::saint_venant {
extern const Law law;
}

namespace {

const RegisteredLaw saint_venant{
    .name = "saint-venant", .text = &laws::saint_venant::law, .key = "volume_hardening"};
[[maybe_unused]] const bool is_registered = register_law(saint_venant);

} // namespace
} // namespace hdmbench
