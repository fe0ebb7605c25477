#include <backends/registry.hpp>
#include <reference/fixed_point.hpp>

#include <cmath>
#include <iostream>

int main() {
  for (const auto& backend : hdmbench::make_backends()) {
    std::cout << backend->name() << ": " << backend->description() << '\n';
  }
  hdmbench::Level level{.extent = {4, 4},
                        .target = hdmbench::VectorField({4, 4}, 2.0F),
                        .confidence = hdmbench::VectorField({4, 4}),
                        .modulus = hdmbench::ScalarField({4, 4}, 1.0F)};
  hdmbench::set_inverse_modulus(level);
  level.confidence[0][0] = level.confidence[1][0] = 1.0F;
  const double moved = hdmbench::solve_fixed_point(level).displacement[0].back();
  std::cout << "fixed point: one site moved by 2 px moves all, the last by " << moved << " px\n";
  return hdmbench::make_backends().empty() || !(std::abs(moved - 2.0) < 1e-9) ? 1 : 0;
}
