#include "kernels/data/energy.hpp"

#include "kernels/specification/hdm/energy.hpp"

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyOnHost on_host;
}

// test/cost_test.cpp counts the operations in the texts.
const Energy thesis_energy{.name = "hdm",
                           .inputs = HdmInFloat::input_count,
                           .couples = HdmInFloat::couples,
                           .coloured_sets = HdmInFloat::coloured_sets,
                           .costs = {{{109, 18}, {103, 8}, {78, 16}, {72, 6}}},
                           .host = &energies::Hdm::on_host,
                           .programs = nullptr,
                           .proofs = nullptr};

} // namespace hdmbench
