#include "harness/check/certificate.hpp"

#include "harness/check/proven_real.hpp"

#include <fmt/format.h>

#include <cmath>

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

EnergyBound energy_change_bound(const Level& level, const VectorField& displacement, int x, int y,
                                float step_x, float step_y) {
  return proofs_of(*level.energy).energy_change_bound(level, displacement, x, y, step_x, step_y);
}

std::string InexactOperation::text() const {
  const std::string site = fmt::format("x = {}, y = {}, sweep {}: ", x, y, sweep);
  const std::string where = site + (operation == '=' ? fmt::format("the value {}", left)
                                                     : fmt::format("{} {} {}", left, operation, right));
  if (operation == '/') {
    return where + " is not a power of two";
  }
  if (!std::isfinite(magnitude)) {
    return where + " is not finite";
  }
  if (proven::fits(magnitude, quantum)) {
    return where + " is rounded";
  }
  if (!proven::is_in_range(magnitude, quantum)) {
    return fmt::format("{}, in units of 2^{}, leaves the range 2^-30 ... 2^30", where, std::ilogb(quantum));
  }
  return fmt::format("{}: terms of up to {:.6g} in units of 2^{} need {} bits, float32 has 24", where,
                     magnitude, std::ilogb(quantum), std::ilogb(magnitude / quantum) + 1);
}

std::optional<InexactOperation> first_inexact(const Level& level, const VectorField& before, int number) {
  return proofs_of(*level.energy).first_inexact(level, before, number);
}

} // namespace hdmbench
