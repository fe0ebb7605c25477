#include "harness/check/faults/device_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

namespace hdmbench::faults {

namespace {

/// One direction in which the border rule can be wrong.
struct Border {
  std::string_view name;
  int x; ///< offset of the neighbour
  int y;
};

constexpr Border borders[] = {{"north", 0, -1},     {"east", 1, 0},         {"south", 0, 1},
                              {"west", -1, 0},      {"north-west", -1, -1}, {"north-east", 1, -1},
                              {"south-east", 1, 1}, {"south-west", -1, 1}};

/// Whether the centre lies at the side that an offset of -1 or 1 leaves along an axis, 'x' or 'y'.
std::string at_side(int offset, char axis) {
  return offset < 0 ? fmt::format("lessThan(at, POSITION(1)).{}", axis)
                    : fmt::format("greaterThanEqual(at + POSITION(1), size).{}", axis);
}

/// Beyond one side, or at one corner's single site beyond that corner, the image is mirrored instead.
DeviceFault mirrored(const Border& border) {
  std::string where;
  if (border.x != 0) {
    where = at_side(border.x, 'x');
  }
  if (border.y != 0) {
    where += fmt::format("{}{}", where.empty() ? "" : " && ", at_side(border.y, 'y'));
  }
  const bool corner = border.x != 0 && border.y != 0;
  const std::string offset = fmt::format("POSITION({}, {})", border.x, border.y);
  return {.name = fmt::format("border-{}", border.name),
          .what = corner
                      ? fmt::format("at the {} corner's one site, what lies beyond is mirrored", border.name)
                      : fmt::format("beyond the {} side the image is mirrored", border.name),
          .edits = {{.find = fmt::format("neighbour(at, {}, size)", offset),
                     .replace = fmt::format("neighbour(at, {} ? POSITION({}, {}) : {}, size)", where,
                                            -border.x, -border.y, offset)}}};
}

DeviceFault edit(std::string_view name, std::string_view what, std::string_view find,
                 std::string_view replace, std::string_view method = "icm") {
  return {.name = std::string(name),
          .what = std::string(what),
          .method = std::string(method),
          .edits = {{.find = std::string(find), .replace = std::string(replace)}}};
}

/// The same in the window of tile.glsl.
DeviceFault mirrored_in_window(const Border& border) {
  constexpr std::string_view rows[] = {"north", "middle", "south"};
  const auto site = [&](int x, int y) {
    return fmt::format("{}[k{}]", rows[static_cast<std::size_t>(y + 1)],
                       x < 0   ? ""
                       : x > 0 ? " + 2"
                               : " + 1");
  };
  const std::string no_row = border.y < 0 ? "no_north" : "no_south";
  const std::string no_column = border.x < 0 ? "no_west" : "no_east";
  const bool corner = border.x != 0 && border.y != 0;
  const std::string outside = corner ? no_row + " || " + no_column : border.x == 0 ? no_row : no_column;
  const std::string opposite = site(-border.x, -border.y);
  const std::string stand_in =
      corner ? fmt::format("neighbour_or(c, {} && {}, {})", no_row, no_column, opposite) : opposite;
  const std::string call = fmt::format("{}, {})", outside, site(border.x, border.y));
  DeviceFault fault = mirrored(border);
  fault.edits = {
      {.find = "neighbour_or(c, " + call, .replace = fmt::format("neighbour_or({}, {}", stand_in, call)}};
  return fault;
}

std::vector<DeviceFault> window_faults() {
  std::vector<DeviceFault> list;
  std::ranges::transform(borders, std::back_inserter(list), mirrored_in_window);
  list.push_back({.name = "border-clamped",
                  .what = "beyond the border lies the nearest site, not the centre",
                  .edits = {
                      {.find = "border && outside ? centre.displacement :", .replace = ""},
                      {.find = "border && outside ? centre.material :", .replace = ""},
                  }});
  list.push_back(edit("border-too-early", "the last column counts as outside", "no_east = x == size.x - 1;",
                      "no_east = x >= size.x - 2;"));
  list.push_back(edit("neighbours-swapped", "south and south-east neighbour swapped in x",
                      "s.displacement.x, se.displacement.x)", "se.displacement.x, s.displacement.x)"));
  list.push_back(edit("wrong-inverse-modulus", "1 / m of the south-east neighbour for the north-east one",
                      "ne.material.y,", "se.material.y,"));
  list.push_back(edit("window-stale", "the row in the middle becomes the one to the north again",
                      "middle[k] = south[k];", "middle[k] = north[k];"));
  list.push_back(edit("observation-left-out", "tiles with observations are taken for such without",
                      "const bool observed = (tile_class & observed_bit) != 0u;",
                      "const bool observed = false;"));
  list.push_back(edit("material-left-out", "tiles of several materials are taken for such of one",
                      "const bool elastic = (tile_class & elastic_bit) != 0u;",
                      "const bool elastic = false;"));
  list.push_back(edit("steps-constant", "one candidate fewer in the program",
                      "const int step_count = STEP_COUNT;", "const int step_count = STEP_COUNT - 1;"));
  return list;
}

std::vector<DeviceFault> observation_faults() {
  return {
      edit("target-swapped", "y's target for x", "site.target_x = observation.x;",
           "site.target_x = observation.y;"),
      edit("confidence-shared", "x's confidence for y", "site.confidence_y = confidence.y;",
           "site.confidence_y = confidence.x;"),
  };
}

std::vector<DeviceFault> gather_faults() {
  std::vector<DeviceFault> list;
  std::ranges::transform(borders, std::back_inserter(list), mirrored);
  list.push_back(edit("border-clamped", "beyond the border lies the nearest site, not the centre",
                      "return inside ? site : centre;",
                      "return min(max(site, POSITION(0)), size - POSITION(1));"));
  list.push_back(edit("border-too-early", "the last row and column count as outside", "lessThan(site, size)",
                      "lessThan(site, size - POSITION(1))"));
  list.push_back(edit("neighbours-swapped", "south and south-east neighbour swapped in x",
                      "d_south.x, d_south_east.x)", "d_south_east.x, d_south.x)"));
  list.push_back(edit("wrong-inverse-modulus", "1 / m of the south-east neighbour for the north-east one",
                      "inverse_modulus_at(north_east)", "inverse_modulus_at(south_east)"));
  return list;
}

std::vector<DeviceFault> energy_faults() {
  return {
      edit("diagonal-missing", "one diagonal is missing in the gradient of x",
           "gradient_x = add_gradient(gradient_x, toward.north_east",
           "add_gradient(gradient_x, toward.north_east"),
      edit("curvature-diagonal-missing", "one diagonal is missing in both curvatures",
           "curvature = add_curvature(curvature, toward.north_east, toward.south_west);", ""),
      edit("curvature-term-missing", "a triple has one residual's curvature",
           "curvature = curvature + (real(1) + toward_s) * (real(1) + toward_s);", ""),
      edit("ratio-inverted", "m_u / m_t for m_t / m_u to the north",
           "site.modulus * site.inverse_modulus.north;",
           "(real(1) / site.modulus) / site.inverse_modulus.north;"),
      edit("ratio-lost", "the same material to the east", "site.modulus * site.inverse_modulus.east;",
           "real(1);"),
      edit("residual-sign", "a sign in the residual", "(dt - ds) - (du - dt)", "(dt - ds) - (dt - du)"),
      edit("half-the-gradient", "g where 2 g belongs", "(gradient + gradient)", "gradient"),
      edit("observation-sign", "a sign in the observation", "abs(gap - step_size)", "abs(gap + step_size)"),
      edit("observation-squared", "squares where absolute values belong", "(abs(gap - step_size) - abs(gap))",
           "((gap - step_size) * (gap - step_size) - gap * gap)"),
      edit("tie-rule", "<= for <: among equal candidates the last one wins",
           "best = change < lowest ? steps[i] : best;", "best = change <= lowest ? steps[i] : best;"),
      edit("tie-tolerance", "a candidate must be better by 0.01", "best = change < lowest ? steps[i] : best;",
           "best = change < lowest - real(0.01) ? steps[i] : best;"),
      edit("last-candidate-skipped", "the loop over the candidates ends one too early",
           "i < step_count; ++i) {\n    HDM_PRECISE real change",
           "i < step_count - 1; ++i) {\n    HDM_PRECISE real change"),
      edit("decay", "the centre loses an ulp or two",
           "moved_x = site.dx.centre + step_x;\n      moved_y = site.dy.centre + step_y;\n    } else",
           "moved_x = site.dx.centre * real(0.9999999) + step_x;\n      moved_y = site.dy.centre + step_y;\n "
           "   } else"),
      edit("output-swapped", "x stored as y", "vec4(next.x, next.y", "vec4(next.y, next.x"),
  };
}

std::vector<DeviceFault> rule_faults() {
  return {
      edit("colour-by-row", "x takes turns by rows, not columns", "colours == 2 ? parity(at.column)",
           "colours == 2 ? parity(at.row)", "coloured"),
      edit("pull-sign", "the observation pushes", "remaining > real(0) ? reach : real(0) - reach",
           "remaining > real(0) ? real(0) - reach : reach", "closed-form"),
      edit("target-not-held", "a held component is not put on its target",
           "return abs(remaining) < reach ? target : moved;", "return moved;", "closed-form"),
      edit("random-key", "one round of the random numbers has another key",
           "pair = mixed_pair(pair, sweep.seed);", "pair = mixed_pair(pair, sweep.seed + real(1));",
           "annealing"),
      edit("always-accepted", "worse candidates are always taken", "change <= real(0) || odds < real(1)",
           "change <= real(0) || odds < real(1e30)", "annealing"),
  };
}

std::vector<DeviceFault> fragment_faults() {
  std::vector<DeviceFault> list{
      edit("half-a-pixel", "the image is sampled half a pixel off",
           "vec4 middle = texture2DRect(image, gl_FragCoord.xy + vec2(0.0, offset));",
           "vec4 middle = texture2DRect(image, gl_FragCoord.xy + vec2(0.5, offset));"),
      edit("pair-swapped", "of a texel's two sites the other one", "fract(0.5 * p.x) < 0.5",
           "fract(0.5 * p.x) > 0.5"),
      edit("window-east", "the site after the next for the one to the east",
           "texture2DRect(image, gl_FragCoord.xy + vec2(1.0, offset)).rg",
           "texture2DRect(image, gl_FragCoord.xy + vec2(1.0, offset)).ba"),
      edit("second-beyond", "the last texel's second site never moves", "first_site().x + 1.0 > dimension.x",
           "first_site().x + 2.0 > dimension.x"),
      edit("observation-left-out", "observations are not fetched",
           "return texture2DRect(observation, pixel_of(p));", "return vec4(0.0);"),
      edit("first-twice", "the first site of a texel for both",
           "ivec2 site(int k) { return ivec2(1 + k, 1); }", "ivec2 site(int k) { return ivec2(1, 1); }"),
      edit("half-a-pixel-alone", "the image of one site a texel is sampled half a pixel off",
           "vec2 displacement_at(vec2 p) { return texture2DRect(image, p).rg; }",
           "vec2 displacement_at(vec2 p) { return texture2DRect(image, p + vec2(0.5)).rg; }", "closed-form"),
      edit("inverse-modulus-lost", "1 / m is not handed on from sweep to sweep",
           "texture2DRect(image, gl_FragCoord.xy).b, 0.0)", "0.0, 0.0)", "closed-form"),
  };
  list.push_back({.name = "count-of-x",
                  .what = "only changes of x are counted",
                  .edits = {{.find = "now == before",
                             .replace = "now.x == before.x",
                             .shader = "an occlusion query counts"}}});
  return list;
}

/// Of the shader that computes a pyramid's coarse levels in one dispatch.
DeviceFault in_coarse_levels(std::string_view name, std::string_view what, std::string_view find,
                             std::string_view replace) {
  DeviceFault fault = edit(name, what, find, replace);
  fault.edits.front().shader = "stops_at_rest";
  fault.variant = 1;
  return fault;
}

std::vector<DeviceFault> coarse_level_faults() {
  return {
      in_coarse_levels("coarse-sweep-lost", "coarse levels in one dispatch get a sweep too few",
                       "sweep < sweeps && moves", "sweep < sweeps - 1 && moves"),
      in_coarse_levels("coarse-weights-swapped", "there the weights of x and y are swapped in a projection",
                       "south_east.x, column.z, row.z)", "south_east.x, row.z, column.z)"),
      in_coarse_levels("coarse-sample-shifted", "there a site has the row above's observation and modulus",
                       "int from = int(row.w) * full_width",
                       "int from = max(int(row.w) - 1, 0) * full_width"),
      in_coarse_levels("coarse-level-skipped", "there the table is read from its second level on",
                       "texelFetch(entries, first_level + index)",
                       "texelFetch(entries, first_level + min(index + 1, level_count - 1))"),
      in_coarse_levels("coarse-rest-too-early", "there active work rests after the first sweep",
                       "!stops_at_rest || moved[done % 3]", "!stops_at_rest"),
  };
}

std::vector<DeviceFault> compute_faults() {
  std::vector<DeviceFault> list{
      edit("pitch", "rows one element too long", "start += size.x;", "start += size.x + 1;"),
      edit("half-float-displacement", "displacements fetched with 11 significant bits",
           "{ return texelFetch(displacement, i).xy; }",
           "{ return unpackHalf2x16(packHalf2x16(texelFetch(displacement, i).xy)); }"),
  };
  list.push_back({.name = "half-float-energy",
                  .what = "energies with 11 significant bits",
                  .edits = {{.find = "(gradient + gradient)",
                             .replace = "unpackHalf2x16(packHalf2x16(vec2(gradient + gradient, 0.0))).x"},
                            {.find = "return change;",
                             .replace = "return unpackHalf2x16(packHalf2x16(vec2(change, 0.0))).x;"}}});
  list.push_back({.name = "count-of-x",
                  .what = "only changes of x are counted",
                  .edits = {{.find = "texelFetch(displacement, index).xy != imageLoad(improved, index).xy",
                             .replace = "texelFetch(displacement, index).x != imageLoad(improved, index).x",
                             .shader = "uint changed;"}}});
  DeviceFault overrun =
      edit("overrun", "the end of a row is not checked: what no other row overwrites ends in the guard",
           "bool inside = !border || x < size.x;", "bool inside = true;");
  overrun.edits.push_back({.find = "rows = border && left >= size.x ? 0 : rows;", .replace = ""});
  overrun.calls = guard_bands();
  list.push_back(std::move(overrun));
  std::ranges::move(coarse_level_faults(), std::back_inserter(list));
  return list;
}

/// glGetIntegerv of a device whose vertex shaders cannot fetch.
void without_vertex_textures(GLenum name, GLint* value) {
  HDMBENCH_DRIVER(GetIntegerv)(name, value);
  if (name == GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS) {
    record_changed_call();
    *value = 0;
  }
}

} // namespace

std::vector<DeviceFault> text_faults(Pipeline pipeline) {
  std::vector<DeviceFault> all;
  const bool fragment = pipeline == Pipeline::fragment;
  for (const auto& list : {fragment ? gather_faults() : window_faults(), observation_faults(),
                           energy_faults(), rule_faults(), fragment ? fragment_faults() : compute_faults()}) {
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}

std::vector<DeviceFault> device_controls(Pipeline pipeline) {
  std::vector<DeviceFault> list;
  list.push_back({.name = "unedited",
                  .what = "the shaders as they are, by the way that mistakes take",
                  .method = "",
                  .expected = Expected::let_through});
  list.push_back(
      {.name = "reassociated",
       .what = "the gradient's terms added as s + (a + b), not (s + a) + b",
       .expected = Expected::let_through,
       .edits = {{.find = "real gradient = sum + (real(1) + toward_u)",
                  .replace = "real gradient = (real(1) + toward_u)"},
                 {.find = "gradient = gradient + (real(1) + toward_s) * residual(toward_s, du, dt, ds);",
                  .replace = "gradient = sum + (gradient + (real(1) + toward_s) * "
                             "residual(toward_s, du, dt, ds));"}}});
  if (pipeline == Pipeline::fragment) {
    list.push_back({.name = "of-the-thesis",
                    .what = "a device of the thesis's time: texels of one site also for candidates",
                    .expected = Expected::let_through,
                    .calls = {{"glGetIntegerv", reinterpret_cast<gl::Address>(&without_vertex_textures)}}});
  }
  if (pipeline == Pipeline::compute) {
    list.push_back(
        {.name = "fused",
         .what = "fma() in the gradient; a driver may split it again",
         .expected = Expected::let_through,
         .edits = {
             {.find = "real gradient = sum + (real(1) + toward_u) * residual(toward_u, ds, dt, du);",
              .replace = "real gradient = fma(real(1) + toward_u, residual(toward_u, ds, dt, du), sum);"},
             {.find = "gradient = gradient + (real(1) + toward_s) * residual(toward_s, du, dt, ds);",
              .replace = "gradient = fma(real(1) + toward_s, residual(toward_s, du, dt, ds), gradient);"}}});
    list.push_back({.name = "not-precise",
                    .what = "without the word `precise`",
                    .expected = Expected::let_through,
                    .edits = {{.find = "#define HDM_PRECISE precise", .replace = "#define HDM_PRECISE"}}});
    list.push_back({.name = "guarded",
                    .what = "guard bands behind the buffers, and no mistake",
                    .expected = Expected::let_through,
                    .calls = guard_bands()});
  }
  return list;
}

} // namespace hdmbench::faults
