#pragma once

#include "harness/scene/scene.hpp"
#include "kernels/data/shared_rows.hpp"

#include <list>
#include <utility>
#include <vector>

namespace hdmbench {

/// Numbers of a scene that nobody reads for now: as long as the object lives their rows share memory. What
/// they do not need the system gets, and the addresses stay, so that to bring them back needs no allocation.
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

/// The fields of a scene that nobody reads while it is solved, a third of what a volume would take. Nothing
/// of an image, which is small, nor of a scene with springs, which are needed again in the end.
class SetAside {
public:
  explicit SetAside(Scene& scene);

private:
  std::list<FieldAside> fields_;
};

} // namespace hdmbench
