#pragma once

#include "backends/backend.hpp"
#include "backends/cpu/ceiling_loops.hpp"
#include "backends/cpu/elastic_rows.hpp"
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

/// memcpy by `threads` threads, each its own part, and the loop on each of them.
[[nodiscard]] Ceilings cpu_ceilings(int threads, openmp::MultiplyAdd multiply_add);

/// Site by site on one thread, as plainly as the specification reads: the reference for bits.
[[nodiscard]] std::unique_ptr<ElasticSession> make_elastic_scalar();

/// OpenMP threads x SIMD lanes; `rows` of an instruction set that this processor has must outlive it. With
/// less than `sites_worth_a_thread` for each a thread costs more than it brings; tests ask for less.
[[nodiscard]] std::unique_ptr<ElasticSession>
make_elastic_openmp(int threads, const openmp::ElasticRows& rows, std::size_t sites_worth_a_thread = 8192);

} // namespace hdmbench
