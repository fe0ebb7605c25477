#pragma once

#include "kernels/specification/language.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

/// tile_class.inc and classify.inc as C++.
namespace hdmbench::tile_class {

using integer = std::size_t;

#include "kernels/specification/tile_class.inc"

using std::max;
using std::min;

/// classify.inc as members of `Rows`, which has what is read: any_other_confidence(), any_other_modulus()
/// and any_other_inverse().
template <typename Rows>
class Classifier : public Rows {
public:
  using real = float;
  using Rows::any_other_confidence;
  using Rows::any_other_inverse;
  using Rows::any_other_modulus;

  explicit Classifier(Rows rows) : Rows(std::move(rows)) {}

#include "kernels/specification/classify.inc"
};

} // namespace hdmbench::tile_class
