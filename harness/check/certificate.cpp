#include "harness/check/certificate.hpp"

#include "harness/check/proven_real.hpp"

#include <fmt/format.h>

#include <cmath>

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyProofs proofs;
}

const EnergyProofs& proofs_of(const Level& level) {
  return level.energy->proofs != nullptr ? *level.energy->proofs : energies::Hdm::proofs;
}

std::string InexactOperation::text() const {
  const std::string site = fmt::format("{}, sweep {}: ", place, sweep);
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

} // namespace hdmbench
