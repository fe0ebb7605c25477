#include "harness/judge/atlas/families.hpp"

namespace hdmbench::atlas {

namespace {

constexpr int size = 128; // levels 0 ... 7

void start_at(Scene& scene, double knob) {
  scene.schedule.start_level = static_cast<int>(knob);
}

std::vector<Series> starting_at_knob() {
  std::vector<Series> series = usual_series();
  for (Series& one : series) {
    one.adjust = start_at;
  }
  return series;
}

Entry too_late() {
  return {.name = "start-level-late",
          .title = "Pyramid started too late (thesis 5.8)",
          .mechanism =
              "A condition travels one site per iteration and ICM moves a site by 1 px at most: on a "
              "fine first level the middle of the image never hears of the border, and the field "
              "rests in a local minimum.",
          .knob = "start level (0 = full image only)",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "before the run: iterations per level against the sites between a condition and the "
                     "farthest free site, and against the range of the targets",
          .survivor = "leave --start-level out",
          .warnings = {"out-of-reach", "still-moving", "stalled"},
          .knobs = {7, 6, 5, 4, 3, 2, 1, 0},
          .quick_knobs = {7, 3, 0},
          .series = starting_at_knob(),
          .problem = [](double) { return against_fixed_point(shipped("square", size)); },
          .error = rmsd_to_truth,
          .picture = PictureWanted{.series = "icm",
                                   .knob = 0.0,
                                   .shows = "icm on the full image only: the error of dx, red where the "
                                            "pull of the left border did not arrive"}};
}

Entry too_early() {
  return {.name = "start-level-early",
          .title = "Pyramid started too early (thesis 5.6)",
          .mechanism = "A coarse level computes another, coarser problem; but a level of n sites forgets its "
                       "start within about n iterations, so what a very coarse one got wrong is gone two "
                       "levels later: no method minds.",
          .knob = "start level (0 = full image only)",
          .measure = "RMSD to the fixed point [px]",
          .limit = 0.5,
          .seen_by = "nothing to see",
          .survivor = "every method, from the coarsest level on",
          .knobs = {3, 4, 5, 6, 7},
          .quick_knobs = {4, 7},
          .series = starting_at_knob(),
          .problem = [](double) { return against_fixed_point(shipped("circular-radial", size)); },
          .error = rmsd_to_truth};
}

Scene rim(int width) {
  Scene scene = one_material(size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (x < width || y < width || x >= size - width || y >= size - width) {
        // The values of a field that is its own fixed point, bent so that no level is right by chance.
        const float u = static_cast<float>(x) / (size - 1);
        const float v = static_cast<float>(y) / (size - 1);
        hold(scene, x, y, 20.0F * (u - 1.0F) * (1.0F - 0.5F * v), 20.0F * v * u);
      }
    }
  }
  return scene;
}

void centre_alignment(Scene& scene, double) {
  scene.schedule.alignment = Alignment::center;
}

Entry alignment() {
  std::vector<Series> series;
  for (const auto& [corner, center] :
       {std::pair{"icm", "icm, center"}, std::pair{"closed-form", "closed-form, center"},
        std::pair{"cascade", "cascade, center"}}) {
    series.push_back({.name = corner, .method = corner});
    series.push_back({.name = center, .method = corner, .adjust = centre_alignment});
  }
  return {
      .name = "alignment",
      .title = "Coarse levels lose the conditions (--alignment center)",
      .mechanism = "Where pixel areas coincide, a coarse site samples the middle of its block, so a border "
                   "of known displacement thinner than half a block exists on no coarse level.",
      .knob = "width of the known border [px]",
      .measure = "RMSD to the fixed point [px]",
      .limit = 0.5,
      .seen_by = "before the run: each level's count of observed sites",
      .survivor = "--alignment corner (the default)",
      .warnings = {"lost-condition", "not-met", "stalled", "still-moving"},
      .knobs = {32, 16, 8, 4, 2, 1},
      .quick_knobs = {16, 4, 1},
      .series = std::move(series),
      .problem = [](double knob) { return against_fixed_point(rim(static_cast<int>(knob))); },
      .error = rmsd_to_truth,
      .picture = PictureWanted{.series = "icm, center",
                               .knob = 1.0,
                               .shows = "icm with centred alignment, border of one pixel: the error of dx"}};
}

} // namespace

std::vector<Entry> pyramid_entries() {
  return {too_late(), too_early(), alignment()};
}

} // namespace hdmbench::atlas
