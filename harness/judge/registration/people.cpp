#include "harness/judge/registration/people.hpp"

#include "harness/applications/picture.hpp"
#include "harness/judge/diagnosis/folding.hpp"
#include "harness/judge/registration/rivals.hpp"
#include "harness/scene/row_fields.hpp"
#include "harness/scene/sites.hpp"
#include "kernels/data/input_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace hdmbench {

static void list_fields(Fields& fields, PeopleRow::Overlap& overlap) {
  fields("label", overlap.label);
  fields("dice", overlap.dice);
}

void list_fields(Fields& fields, PeopleRow& row) {
  list_fields(fields, static_cast<RegisteredScene&>(row));
  fields("other", row.other);
  fields("method", row.method);
  fields("dice", row.dice);
  fields("overlaps", row.overlaps);
  fields("correlation", row.correlation);
  fields("folds", row.folds);
  fields("seconds", row.seconds);
}

std::vector<PeopleRow::Overlap> overlaps_of(const LabelField& source, const LabelField& target,
                                            const VectorField& displacement) {
  const Extent extent = source.extent;
  struct Count {
    double source = 0.0, target = 0.0, both = 0.0;
  };
  std::map<int, Count> counts;
  for_each_site(extent, [&](int x, int y) {
    const std::size_t site = extent.index(x, y);
    const auto to_x = std::lround(static_cast<float>(x) + displacement.x[site]);
    const auto to_y = std::lround(static_cast<float>(y) + displacement.y[site]);
    const int here = source.values[site];
    const int there = target.values[extent.index(std::clamp(static_cast<int>(to_x), 0, extent.width - 1),
                                                 std::clamp(static_cast<int>(to_y), 0, extent.height - 1))];
    counts[here].source += 1.0;
    counts[there].target += 1.0;
    counts[here].both += here == there ? 1.0 : 0.0;
  });
  std::vector<PeopleRow::Overlap> overlaps;
  for (const auto& [label, count] : counts) {
    const bool in_both =
        std::ranges::count(source.values, label) > 0 && std::ranges::count(target.values, label) > 0;
    if (label > 0 && in_both) {
      overlaps.push_back({label, 2.0 * count.both / (count.source + count.target)});
    }
  }
  return overlaps;
}

std::vector<PeopleRow> compare_people(const Scene& scene, const Scene& other, bool slow,
                                      const Backend& backend, const SessionOptions& session,
                                      Progress& progress) {
  for (const Scene* const one : {&scene, &other}) {
    if (one->picture.values.empty() || one->labels.values.empty()) {
      throw InputError(fmt::format("{}: two people can only be compared by pictures with labels", one->name));
    }
  }
  if (scene.extent() != other.extent()) {
    throw InputError(
        fmt::format("{} is {} x {} pixels, {} is {} x {}: two people can only be compared at one size",
                    scene.name, scene.extent().width, scene.extent().height, other.name, other.extent().width,
                    other.extent().height));
  }
  const ScalarField nowhere(scene.extent());
  std::vector<PeopleRow> rows;
  register_every_way(
      {scene.picture, other.picture, nowhere, false}, scene, slow, backend, session,
      fmt::format("rivals {} to {}", scene.name, other.name), progress,
      [&](const RegisteredPair& registered) {
        PeopleRow row;
        row.set_scene(scene);
        row.other = other.name;
        row.method = registered.method;
        row.overlaps = overlaps_of(scene.labels, other.labels, registered.displacement);
        row.correlation =
            similarity(scene.picture, pulled_back(other.picture, registered.displacement)).correlation;
        row.folds = folds_of(registered.displacement, scene.labels);
        row.seconds = registered.seconds;
        for (const PeopleRow::Overlap& overlap : row.overlaps) {
          row.dice += overlap.dice / static_cast<double>(row.overlaps.size());
        }
        rows.push_back(std::move(row));
      });
  if (rows.front().overlaps.empty()) {
    throw InputError(fmt::format("{} and {} have no label above 0 in common", scene.name, other.name));
  }
  return rows;
}

} // namespace hdmbench
