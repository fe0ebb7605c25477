#pragma once

#include "backends/backend.hpp"
#include "backends/openmp/row.hpp"

#include <memory>
#include <string_view>

namespace hdmbench {

/// With the row kernel of the best instruction set that this processor has.
[[nodiscard]] std::unique_ptr<Backend> make_openmp();

/// With a given row kernel and under another name: how tests plant one that computes otherwise. `name` and
/// `instruction_set` (for people) must outlive it.
[[nodiscard]] std::unique_ptr<Backend> make_openmp_with(std::string_view name, openmp::SweepRow sweep_row,
                                                        std::string_view instruction_set);

} // namespace hdmbench
