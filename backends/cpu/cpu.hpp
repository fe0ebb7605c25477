#pragma once

#include "backends/backend.hpp"
#include "backends/cpu/loops.hpp"
#include "backends/cpu/row.hpp"
#include "backends/shared/ceilings.hpp"
#include "backends/shared/elastic_session.hpp"

#include <memory>
#include <string_view>
#include <vector>

namespace hdmbench {

namespace openmp {

/// What is compiled once per instruction set.
struct InstructionSet {
  std::string_view name; ///< for people
  std::size_t row;       ///< index in EnergyPrograms::rows
  MultiplyAdd multiply_add;
  const ElasticRows* elastic_rows;
};

/// Those that this processor has, the best one last.
[[nodiscard]] std::vector<InstructionSet> instruction_sets();

} // namespace openmp

/// With the row kernel of the best instruction set that this processor has.
[[nodiscard]] std::unique_ptr<Backend> make_openmp();

/// With a given row kernel for the thesis's energy and under another name: how tests plant one that computes
/// otherwise. `name` and `instruction_set` (for people) must outlive it.
[[nodiscard]] std::unique_ptr<Backend> make_openmp_with(std::string_view name, openmp::SweepRow sweep_row,
                                                        std::string_view instruction_set);

[[nodiscard]] std::unique_ptr<Backend> make_scalar();

/// The processor's name as the operating system has it; `driver` says how it is used ("2 threads, AVX2").
[[nodiscard]] Device cpu_device(std::string_view driver);

/// Starts the threads of OpenMP, each on a processor of its own. Without it a second thread may begin on the
/// first one's, and both wait for each other in turn until the system moves one: up to 0.1 s. Afterwards
/// every thread may run where the process may. Does nothing where there are not as many processors as
/// threads, or the system cannot say.
void place_threads();

/// memcpy by `threads` threads, each its own part, and the loop on each of them.
[[nodiscard]] Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add);

/// OpenMP threads x SIMD lanes; `rows` of an instruction set that this processor has must outlive it. With
/// less than `sites_worth_a_thread` for each a thread costs more than it brings; tests ask for less.
[[nodiscard]] std::unique_ptr<ElasticSession>
make_elastic_openmp(int threads, const openmp::ElasticRows& rows, std::size_t sites_worth_a_thread = 8192);

} // namespace hdmbench
