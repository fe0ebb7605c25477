#include "harness/check/faults/device_faults.hpp"
#include "harness/scene/method.hpp"

#include <string_view>

namespace hdmbench::faults {

namespace {

DeviceFault fault(std::string_view name, std::string_view what, std::vector<Edit> edits) {
  return {.name = std::string(name),
          .what = std::string(what),
          .method = std::string(elastic_conjugate_gradients),
          .edits = std::move(edits)};
}

/// A control: the order of a sum is another one, which a bound explains.
DeviceFault columns_first(std::string_view shader) {
  const std::string word(shader);
  DeviceFault control = fault("elastic-sum-order", "a dot product adds columns first",
                              {{.find = "real north = north_west + north_east;",
                                .replace = "real north = north_west + south_west;",
                                .shader = word},
                               {.find = "real south = south_west + south_east;",
                                .replace = "real south = north_east + south_east;",
                                .shader = word}});
  control.expected = Expected::let_through;
  return control;
}

DeviceFault edit(std::string_view shader, std::string_view name, std::string_view what, std::string_view find,
                 std::string_view replace) {
  return fault(name, what,
               {{.find = std::string(find), .replace = std::string(replace), .shader = std::string(shader)}});
}

/// In the texts of the energy, which both pipelines compile.
std::vector<DeviceFault> energy_faults(std::string_view shader) {
  return {
      edit(shader, "elastic-poisson-ratio-text", "the stress along x takes the strain along x twice",
           "mean_xx + ratio.nu * mean_yy", "mean_xx + ratio.nu * mean_xx"),
      edit(shader, "elastic-bend-sign", "a sign in the shear that bending makes",
           "xy_by_r = xy_by_r + cell.mrs * bend_y", "xy_by_r = xy_by_r - cell.mrs * bend_y"),
      edit(shader, "elastic-other-residual", "the residual of one component does not move the other",
           "moved = moved + across * other_residual;", ""),
      edit(shader, "elastic-restriction-weight-text", "a quarter for a half where a residual is restricted",
           "HDM_NUMBER(0.5) * after", "HDM_NUMBER(0.25) * after"),
      edit(shader, "elastic-prescribed-pulled", "prescribed components have a residual",
           "straight > HDM_NUMBER(0) ? residual", "straight >= HDM_NUMBER(0) ? residual"),
      edit(shader, "elastic-response-transposed", "y answers as x does", "response.z, residual.y",
           "response.x, residual.y"),
  };
}

std::vector<DeviceFault> fragment_faults() {
  constexpr std::string_view shader = "uniform sampler2DRect moments;";
  std::vector<DeviceFault> list = energy_faults(shader);
  list.push_back(columns_first(shader));
  list.push_back(edit(shader, "elastic-corner", "a cell takes the site to the west for the one to the east",
                      "north, north_east, centre, east)", "north, north_east, centre, west)"));
  list.push_back(edit(shader, "elastic-mask-text", "no cell counts as masked", "more.z > 0.0 ? 0 : 4",
                      "more.z < 0.0 ? 0 : 4"));
  list.push_back(edit(shader, "elastic-coarse-texel", "interpolation begins a coarse site too far west",
                      "vec2 north_west = coarse + 1.5;", "vec2 north_west = coarse + vec2(0.5, 1.5);"));
  return list;
}

std::vector<DeviceFault> compute_faults() {
  constexpr std::string_view both = "vec4 moments_at(int i)";
  constexpr std::string_view coarse = "Place place_of(int level)";
  std::vector<DeviceFault> list = energy_faults(both);
  list.push_back(columns_first(both));
  list.push_back(edit(both, "elastic-window-stale", "an invocation keeps the row above for the next one",
                      "above[i] = below[i];", "above[i] = above[i];"));
  list.push_back(edit(both, "elastic-mask-text", "no cell counts as masked", "Force(number > 0.0 ? force.x",
                      "Force(number < 0.0 ? force.x"));
  list.push_back(edit(both, "elastic-matrix-corner", "a masked cell takes the rows of another corner",
                      "rest_sw.z, 1, west", "rest_sw.z, 0, west"));
  list.push_back(edit(coarse, "elastic-coarse-place", "coarse levels lose their last row",
                      "place.height = place.height / 2 + 1;", "place.height = place.height / 2;"));
  list.push_back(edit(coarse, "elastic-coarse-array", "a coarse step writes where it reads",
                      "stored_array = (code >> 8 & 3)", "stored_array = (code >> 6 & 3)"));
  return list;
}

} // namespace

std::vector<DeviceFault> text_faults_of_elastic(Pipeline pipeline) {
  return pipeline == Pipeline::fragment ? fragment_faults() : compute_faults();
}

} // namespace hdmbench::faults
