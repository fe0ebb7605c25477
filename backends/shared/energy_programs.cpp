// Built once per energy (built_energy.hpp). The shaders it includes have the energy's text in them.

#include "backends/shared/energy_programs.hpp"

#include "kernels/specification/built_energy.hpp"

#include <energy_text.hpp>

namespace hdmbench::energies::HDMBENCH_ENERGY {

extern const EnergyPrograms programs;

std::int64_t scalar_sweep(const Level& level, int number, const VectorField& from, VectorField& to);
namespace baseline {
std::int64_t sweep_row(const openmp::RowPart& part);
}
namespace avx2 {
std::int64_t sweep_row(const openmp::RowPart& part);
}
namespace avx512 {
std::int64_t sweep_row(const openmp::RowPart& part);
}

namespace {

#ifdef HDMBENCH_WITH_VULKAN
#include <shaders/coarse_levels_vulkan.hpp>
#include <shaders/sweep_volume_vulkan.hpp>
#include <shaders/sweep_vulkan.hpp>
#else
constexpr std::span<const std::uint32_t> coarse_levels_vulkan;
constexpr std::span<const std::uint32_t> sweep_vulkan;
constexpr std::span<const std::uint32_t> sweep_volume_vulkan;
#endif

} // namespace

const EnergyPrograms programs{.text = sources::energy,
                              .vulkan_sweep = sweep_vulkan,
                              .vulkan_coarse_levels = coarse_levels_vulkan,
                              .scalar_sweep = scalar_sweep,
                              .rows = {baseline::sweep_row,
#if defined(__x86_64__)
                                       avx2::sweep_row, avx512::sweep_row
#endif
                              },
                              .vulkan_sweep_of_volumes = sweep_volume_vulkan};

} // namespace hdmbench::energies::HDMBENCH_ENERGY
