#pragma once

#include "harness/scene/scene.hpp"
#include "kernels/data/shared_rows.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace hdmbench {

/// Numbers of a scene that nobody reads for now. As long as the object lives, equal rows share memory, and
/// the system has the pages that are free then. The addresses stay, so that the destructor, which brings the
/// numbers back, allocates nothing and cannot throw.
class FieldAside {
public:
  FieldAside(std::vector<float>& values, Extent extent);
  FieldAside(const FieldAside&) = delete;
  FieldAside& operator=(const FieldAside&) = delete;
  ~FieldAside() { values_ = std::move(rows_).values(); }

private:
  std::vector<float>& values_;
  SharedRows rows_;
};

/// Sets the fields of a scene aside that nobody reads while it is solved, a third of what a volume takes. An
/// image is left as it is, because it is small, and so is a scene with springs, which are read in the end.
class SetAside {
public:
  explicit SetAside(Scene& scene) : SetAside(scene.full, &scene.picture) {}
  /// The same of a level, and of a picture where there is one.
  explicit SetAside(Level& level, ScalarField* picture = nullptr);
  SetAside(const SetAside&) = delete;
  SetAside& operator=(const SetAside&) = delete;
  ~SetAside();

private:
  std::vector<std::unique_ptr<FieldAside>> fields_;
};

} // namespace hdmbench
