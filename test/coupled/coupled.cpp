#include "test/coupled/coupled.hpp"

#include "test/coupled/energy.hpp"

namespace hdmbench {

namespace energies::Coupled {
extern const EnergyOnHost on_host;
extern const EnergyPrograms programs;
extern const EnergyProofs proofs;
} // namespace energies::Coupled

namespace test {

const Energy coupled_energy{.name = "coupled",
                            .inputs = Coupled<float>::input_count,
                            .couples = Coupled<float>::couples,
                            .coloured_sets = Coupled<float>::coloured_sets,
                            .costs = {{{0, 18}, {0, 8}, {0, 16}, {0, 6}}},
                            .host = &energies::Coupled::on_host,
                            .programs = &energies::Coupled::programs,
                            .proofs = &energies::Coupled::proofs};

void couple(Level& level) {
  level.energy = &coupled_energy;
  level.inputs.assign(1, ScalarField(level.extent));
  std::vector<float>& coupling = level.inputs.front().values;
  for (std::size_t i = 0; i < coupling.size(); ++i) {
    coupling[i] = 0.25F * static_cast<float>(static_cast<int>(i * 7 % 5) - 2);
  }
  if (needs_inverse_curvature(level.rule)) {
    set_inverse_curvature(level);
  }
}

} // namespace test
} // namespace hdmbench
