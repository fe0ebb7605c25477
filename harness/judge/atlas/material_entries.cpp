#include "harness/judge/atlas/families.hpp"

namespace hdmbench::atlas {

namespace {

constexpr int size = 96;

Entry contrast(bool stiff) {
  return {.name = stiff ? "stiff-inclusion" : "soft-inclusion",
          .title = stiff ? "An inclusion that is ever stiffer" : "An inclusion that is ever softer",
          .mechanism = "A stiff site at the interface gives way by 1 / ratio of what its softer neighbour is "
                       "ahead, so a candidate of 0.1 px pays only when that is half the ratio times 0.1 px; "
                       "from about 100 on both sides move as if they did not know each other, and nothing "
                       "changes any more.",
          .knob = "ratio of the two moduli",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "before the run: the largest ratio of neighbouring moduli",
          .survivor = stiff ? "every method: closed-form stays nearest" : "--method cascade or closed-form; --steps fine",
          .warnings = {"contrast", "stiff-boundary", "lost-tissue", "divergence", "stalled", "still-moving"},
          .knobs = {1, 3, 10, 100, 1e3, 1e4, 1e5, 1e6},
          .quick_knobs = {1, 100, 1e4},
          .series = usual_series(),
          .problem = stiff ? [](double knob) {
                               Scene scene = shipped("square", size);
                               set_moduli(scene, [&](int x, int y) {
                                 return in_inclusion(scene.extent(), x, y) ? 10.0F * static_cast<float>(knob) : 10.0F;
                               });
                               return against_fixed_point(std::move(scene));
                             }
                           : [](double knob) {
                               Scene scene = shipped("square", size);
                               set_moduli(scene, [&](int x, int y) {
                                 return in_inclusion(scene.extent(), x, y) ? 10.0F : 10.0F * static_cast<float>(knob);
                               });
                               return against_fixed_point(std::move(scene));
                             },
          .error = rmsd_to_truth};
}

Entry checkerboard() {
  return {.name = "checkerboard",
          .title = "A checkerboard of two materials",
          .mechanism =
              "A coarse site stands for as much of one material as of the other, and the mean of two "
              "moduli is not how their mixture moves: what a coarse level adds is wrong by as much as "
              "the materials differ.",
          .knob = "ratio of the two moduli",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "before the run: materials that no coarse level resolves",
          .survivor = "--method cascade, closed-form or icm-6, whose fine levels have the last word",
          .warnings = {"contrast", "stiff-boundary", "lost-tissue", "divergence", "stalled", "still-moving"},
          .knobs = {1, 2, 4, 10, 30, 100, 1e3, 1e4},
          .quick_knobs = {1, 10, 1e3},
          .series = usual_series(),
          .problem =
              [](double knob) {
                Scene scene = shipped("square", size);
                set_moduli(scene, [&](int x, int y) {
                  return (x + y) % 2 == 0 ? 10.0F : 10.0F * static_cast<float>(knob);
                });
                return against_fixed_point(std::move(scene));
              },
          .error = rmsd_to_truth};
}

Entry layers() {
  return {.name = "layers",
          .title = "Stiff layers one pixel thin",
          .mechanism =
              "Layers thinner than a coarse site are sampled by chance, as all stiff or all soft, or "
              "blurred into a mean that is too stiff across the layers.",
          .knob = "ratio of the two moduli",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "before the run: materials that no coarse level resolves",
          .survivor = "--method closed-form with 500 iterations a level",
          .warnings = {"contrast", "stiff-boundary", "lost-tissue", "divergence", "stalled", "still-moving"},
          .knobs = {1, 2, 4, 10, 30, 100, 300, 1000},
          .quick_knobs = {1, 10, 1e3},
          .series = usual_series(),
          .problem =
              [](double knob) {
                Scene scene = shipped("square", size);
                set_moduli(scene, [&](int x, int) {
                  return x % 2 == 1 && x < size / 2 ? 10.0F * static_cast<float>(knob) : 10.0F;
                });
                return against_fixed_point(std::move(scene));
              },
          .error = rmsd_to_truth};
}

} // namespace

std::vector<Entry> material_entries() {
  return {contrast(true), contrast(false), checkerboard(), layers()};
}

} // namespace hdmbench::atlas
