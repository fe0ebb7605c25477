#include "harness/check/certificate.hpp"

#include "harness/check/energy_proofs.hpp"

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyProofs proofs;
}

const EnergyProofs& proofs_of(const Energy& energy) {
  return energy.proofs != nullptr ? *energy.proofs : energies::Hdm::proofs;
}

SiteAnswer specified_answer(const Level& level, const VectorField& before, int number, int x, int y) {
  return proofs_of(*level.energy).specified_answer(level, before, number, x, y);
}

Certificate certify(const Level& level, const VectorField& before, int number, int x, int y,
                    SiteAnswer found) {
  return proofs_of(*level.energy).certify(level, before, number, x, y, found);
}

} // namespace hdmbench
