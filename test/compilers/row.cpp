// The row of the openmp backend for one instruction set, whatever the compiler's flags make of it, in place
// of all three.

#include "backends/cpu/row.cpp"

namespace hdmbench::energies::Hdm {

namespace avx2 {
std::int64_t sweep_row(const openmp::RowPart& part) {
  return baseline::sweep_row(part);
}
} // namespace avx2

namespace avx512 {
std::int64_t sweep_row(const openmp::RowPart& part) {
  return baseline::sweep_row(part);
}
} // namespace avx512

} // namespace hdmbench::energies::Hdm
