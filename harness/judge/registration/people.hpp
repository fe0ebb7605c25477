#pragma once

#include "harness/judge/registration/registered_scene.hpp"
#include "harness/judge/registration/ways.hpp"
#include "harness/scene/label_field.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace hdmbench {

class Fields;

/// A row of `rivals --other`: one way to register the picture of one person to that of another. Nobody knows
/// the true displacement; what can be said is whether one label lies on the same label.
struct PeopleRow : RegisteredScene {
  /// How much the two have in common of one label.
  struct Overlap {
    int label = 0;
    double dice = 0.0; ///< 0 ... 1
  };
  std::string other; ///< the target; the source is `scene`
  std::string method;
  double dice = 0.0;             ///< mean over the labels above 0 that both have
  std::vector<Overlap> overlaps; ///< of each of them
  double correlation = 0.0;      ///< of the pictures afterwards
  std::int64_t folds = 0;        ///< cells of tissue that are turned over
  double seconds = 0.0;
};
void list_fields(Fields& fields, PeopleRow& row);

/// Of each label above 0 that both have: twice the sites where `source` at x and `target` at x + d(x), to the
/// nearest site, are of that label, over those of either.
[[nodiscard]] std::vector<PeopleRow::Overlap> overlaps_of(const LabelField& source, const LabelField& target,
                                                          const VectorField& displacement);

/// Every way of register_every_way, from the picture of `scene` to that of `other`. A label must be the same
/// tissue in both. Throws InputError where they have not the same size, or one has no picture or labels.
[[nodiscard]] std::vector<PeopleRow> compare_people(const Scene& scene, const Scene& other, bool slow,
                                                    const Backend& backend, const SessionOptions& session,
                                                    Progress& progress);

} // namespace hdmbench
