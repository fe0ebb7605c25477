#include "kernels/data/elastic/masked_cells.hpp"

#include "kernels/specification/language.hpp"

namespace hdmbench {

namespace {

/// Along an axis one corner of a child is one of its parent's, the other lies in the middle of the parent's
/// edge and hangs on both ends by half: so the child's matrix becomes one between corners of the parent, axis
/// by axis, its rows and then its columns.
template <std::size_t axes>
HDM_FUNCTION void add_child(CellMatrix& sum, CellMatrix child, std::size_t place, const CellMask& mask,
                            unsigned halved) {
  constexpr std::size_t components = axes << axes;
  double* const values = child.values.data();
  for (std::size_t row = 0; row < components; ++row) {
    for (std::size_t column = 0; column < components; ++column) {
      values[components * row + column] *= mask[row] * mask[column];
    }
  }
  const auto along = [&]<int axis>() HDM_INLINED {
    constexpr std::size_t stride = axes << axis; // components from a corner to the next one along the axis
    if ((halved >> axis & 1U) == 0) {
      return;
    }
    const std::size_t middle = (place >> axis & 1) == 0 ? stride : 0;
    const std::size_t end = stride - middle;
    for (std::size_t first = 0; first < components; first += first % stride == stride - 1 ? stride + 1 : 1) {
      double* const half = values + components * (first + middle);
      double* const whole = values + components * (first + end);
      for (std::size_t column = 0; column < components; ++column) {
        half[column] *= 0.5;
        whole[column] += half[column];
      }
    }
    for (std::size_t first = 0; first < components * components; first += 2 * stride) {
      for (std::size_t i = first; i < first + stride; ++i) {
        values[i + middle] *= 0.5;
        values[i + end] += values[i + middle];
      }
    }
  };
  language::for_each_axis<axes>(along);
  for (std::size_t i = 0; i < components * components; ++i) {
    sum.values[i] += values[i];
  }
}

} // namespace

HDM_WIDE_VECTORS void add_galerkin(CellMatrix& sum, const CellMatrix& child, std::size_t place,
                                   const CellMask& mask, unsigned halved) {
  sum.axes == 2 ? add_child<2>(sum, child, place, mask, halved)
                : add_child<3>(sum, child, place, mask, halved);
}

} // namespace hdmbench
