#include "backends/shared/energy_programs.hpp"

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyPrograms programs;
}

const EnergyPrograms& programs_of(const Energy& energy) {
  return energy.programs != nullptr ? *energy.programs : energies::Hdm::programs;
}

} // namespace hdmbench
