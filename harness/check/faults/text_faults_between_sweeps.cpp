#include "harness/check/faults/device_faults.hpp"

#include <string_view>

namespace hdmbench::faults {

namespace {

/// Of one edit in the shader that has the word `shader`.
DeviceFault edit(Part part, std::string_view shader, std::string_view name, std::string_view what,
                 std::string_view find, std::string_view replace) {
  return {
      .name = std::string(name),
      .what = std::string(what),
      .part = part,
      .edits = {{.find = std::string(find), .replace = std::string(replace), .shader = std::string(shader)}}};
}

/// From level to level; seen in one piece only, as else the host samples and projects.
std::vector<DeviceFault> fragment_levels() {
  constexpr std::string_view sample = "uniform sampler2DRect full;";
  constexpr std::string_view project = "uniform sampler2DRect coarse;";
  return {
      edit(Part::levels, sample, "sampled-row-below", "a level samples the row below the one it stands for",
           "vec2(p.y, 1.5)).a)", "vec2(p.y, 1.5)).a + 1.0)"),
      edit(Part::levels, project, "projected-from-one-row",
           "the second row's western site is the first row's", "vec2(column.r, row.g)",
           "vec2(column.r, row.r)"),
      edit(Part::levels, project, "projection-sign", "a sign in the interpolation", "weight * (b - a)",
           "weight * (a - b)"),
  };
}

/// What tells the tiles that sleep; seen only where work is left out.
std::vector<DeviceFault> fragment_sleep() {
  constexpr std::string_view tiles = "uniform sampler2DRect awake;";
  constexpr std::string_view cells = "float(CELL)";
  constexpr std::string_view wake = "float(CELLS)";
  return {
      edit(Part::sleep, cells, "changed-by-x-only", "a site that moved along y has not changed",
           "texture2DRect(image, texel) != texture2DRect(previous, texel)",
           "texture2DRect(image, texel).rb != texture2DRect(previous, texel).rb"),
      edit(Part::sleep, cells, "cell-of-one-site", "of a cell only the last site is looked at",
           "changed = changed ||", "changed ="),
      edit(Part::sleep, wake, "woken-from-one-side", "the cells west and north of a tile are left out",
           "float(CELLS) - vec2(0.5)", "float(CELLS) + vec2(0.5)"),
      edit(Part::sleep, wake, "woken-not-from-the-east", "the cells east of a tile are left out",
           "x < CELLS + 2", "x < CELLS + 1"),
      edit(Part::sleep, tiles, "awake-transposed", "column for row where a tile asks whether it is awake",
           "corner / points", "corner.yx / points"),
  };
}

std::vector<DeviceFault> compute_levels() {
  constexpr std::string_view sample = "imageBuffer sampled_material;";
  constexpr std::string_view project = "vec2 between =";
  return {
      edit(Part::levels, sample, "sampled-by-columns", "rows are sampled where columns are",
           "row_entry(site.y)", "column_entry(site.y)"),
      edit(Part::levels, project, "projected-from-one-row",
           "the second row's western site is the first row's", "second_row + int(column.x)",
           "first_row + int(column.x)"),
      edit(Part::levels, project, "projection-sign", "a sign in the interpolation", "weight * (b - a)",
           "weight * (a - b)"),
  };
}

std::vector<DeviceFault> compute_sleep() {
  constexpr std::string_view sweep = "swept_displacement";
  return {
      edit(Part::sleep, sweep, "woken-transposed", "the neighbour below is woken for the one to the right",
           "bit % 3 - 1, bit / 3 - 1", "bit / 3 - 1, bit % 3 - 1"),
      edit(Part::sleep, sweep, "woken-once", "a tile that was on a list is never put on one again",
           "uint(stamp)) != uint(stamp)", "uint(stamp)) == 0u"),
      edit(Part::sleep, sweep, "list-of-one", "every tile is written over the first of its list",
           "+ place] = tile;", "] = tile;"),
      edit(Part::sleep, sweep, "last-row-wakes-nobody",
           "a change in a tile's last row does not wake the one below",
           "i == TILE_HEIGHT - 1 ? seen_here << 3", "i == TILE_HEIGHT ? seen_here << 3"),
      edit(Part::sleep, sweep, "first-column-wakes-nobody",
           "a change in a tile's first column does not wake the one to the left", "lane == 0 ? bits >> 1",
           "lane < 0 ? bits >> 1"),
  };
}

} // namespace

std::vector<DeviceFault> text_faults_between_sweeps(Pipeline pipeline) {
  const bool fragment = pipeline == Pipeline::fragment;
  std::vector<DeviceFault> all = fragment ? fragment_levels() : compute_levels();
  for (DeviceFault& fault : fragment ? fragment_sleep() : compute_sleep()) {
    all.push_back(std::move(fault));
  }
  return all;
}

} // namespace hdmbench::faults
