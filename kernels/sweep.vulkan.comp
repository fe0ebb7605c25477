#version 450
#extension GL_GOOGLE_include_directive : require

// One sweep over the tiles of a list, a work group per tile; an invocation has COLUMNS x ROWS sites.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define POSITION ivec2

#include "tile_size.vulkan.h"

layout(local_size_x = TILE_WIDTH / COLUMNS, local_size_y = TILE_HEIGHT / ROWS) in;
layout(constant_id = 0) const int rule = 0;
layout(constant_id = 1) const int colours = 1;
layout(constant_id = 2) const int step_count = 1;
layout(constant_id = 3) const int tile_class = 0;
layout(constant_id = 4) const int marks_changes = 0; // 1: what may change in the next sweep is put on the next list

#include "level.vulkan.glsl"

#include "energy.inc"
#include "update.inc"

// A site as its neighbours see it: dx, dy, 1 / modulus.
vec3 seen_at(ivec2 at, float one_inverse_modulus) {
  float inverse_modulus = tile_class == class_uniform ? one_inverse_modulus : inverse_modulus_at(at);
  return vec3(displacement_at(at), inverse_modulus);
}

Neighbours component(int i, vec3 nw, vec3 n, vec3 ne, vec3 w, vec3 c, vec3 e, vec3 sw, vec3 s, vec3 se) {
  return Neighbours(nw[i], n[i], ne[i], w[i], c[i], e[i], sw[i], s[i], se[i]);
}

// Wakes the tiles beside `tile`, and itself, that see a change; bit (y + 1) * 3 + x + 1 is the tile at offset (x, y).
void wake(ivec2 tile, int which) {
  ivec2 across = ivec2(tiles_across, tile_count / tiles_across);
  while (which != 0) {
    int bit = findLSB(which);
    which &= which - 1;
    ivec2 to = tile + ivec2(bit % 3 - 1, bit / 3 - 1);
    if (all(greaterThanEqual(to, ivec2(0))) && all(lessThan(to, across))) {
      uint woken = uint(to.y * tiles_across + to.x);
      if (atomicExchange(tiles[tile_count + int(woken)], uint(stamp)) != uint(stamp)) {
        append_tile(woken, int(tiles[woken]), next_list, next_length);
      }
    }
  }
}

void main() {
  uint group = gl_WorkGroupID.y * most_groups_across + gl_WorkGroupID.x;
  if (group >= lengths[length + tile_class].w) {
    return;
  }
  int tile_number = int(tiles[list_begin(list, tile_class) + int(group)]);
  ivec2 tile = ivec2(tile_number % tiles_across, tile_number / tiles_across);
  ivec2 inside_tile = ivec2(gl_LocalInvocationID.xy) * ivec2(COLUMNS, ROWS);
  ivec2 at = tile * tile_size + inside_tile;
  ivec2 last = ivec2(width, height) - 1;
  vec2 moduli = texelFetch(observation, index_of(min(at, last))).zw; // of class_uniform

  vec3 north[COLUMNS + 2], middle[COLUMNS + 2], south[COLUMNS + 2];
  for (int i = 0; i < COLUMNS + 2; ++i) {
    ivec2 to = at + ivec2(i - 1, 0);
    ivec2 above = to - ivec2(0, 1);
    if (tile_class == class_border) {
      to = clamp(to, ivec2(0), last);
      above = clamp(above, ivec2(0), last);
    }
    north[i] = seen_at(above, moduli.y);
    middle[i] = seen_at(to, moduli.y);
  }
  bool any_change = false;
  bool north_change = false;
  bool south_change = false;
  for (int row = 0; row < ROWS; ++row) {
    south_change = false;
    for (int i = 0; i < COLUMNS + 2; ++i) {
      ivec2 below = at + ivec2(i - 1, row + 1);
      south[i] = seen_at(tile_class == class_border ? clamp(below, ivec2(0), last) : below, moduli.y);
    }
    for (int column = 0; column < COLUMNS; ++column) {
      ivec2 centre = at + ivec2(column, row);
      ivec2 within = tile_class == class_border ? min(centre, last) : centre;
      vec3 c = middle[column + 1];
      vec3 nw = north[column];
      vec3 n = north[column + 1];
      vec3 ne = north[column + 2];
      vec3 w = middle[column];
      vec3 e = middle[column + 2];
      vec3 sw = south[column];
      vec3 s = south[column + 1];
      vec3 se = south[column + 2];
      if (tile_class == class_border) { // a neighbour outside has the centre's values
        bool has_north = centre.y > 0;
        bool has_west = centre.x > 0;
        bool has_south = centre.y < last.y;
        bool has_east = centre.x < last.x;
        nw = has_north && has_west ? nw : c;
        n = has_north ? n : c;
        ne = has_north && has_east ? ne : c;
        w = has_west ? w : c;
        e = has_east ? e : c;
        sw = has_south && has_west ? sw : c;
        s = has_south ? s : c;
        se = has_south && has_east ? se : c;
      }
      Site site;
      site.dx = component(0, nw, n, ne, w, c, e, sw, s, se);
      site.dy = component(1, nw, n, ne, w, c, e, sw, s, se);
      site.inverse_modulus = component(2, nw, n, ne, w, c, e, sw, s, se);
      vec3 observed = vec3(0.0, 0.0, moduli.x);
      vec4 certain = vec4(0.0);
      if (tile_class != class_uniform) {
        observed = observation_at(within);
      }
      if (tile_class == class_border || tile_class == class_interior) {
        certain = confidence_at(within);
      } else {
        observed.xy = vec2(0.0);
      }
      site.modulus = observed.z;
      site.target_x = observed.x;
      site.target_y = observed.y;
      site.confidence_x = certain.x;
      site.confidence_y = certain.y;
      site.penalty = penalty;
      site.inverse_curvature_x = certain.z;
      site.inverse_curvature_y = certain.w;
      Displacement next = swept_displacement(rule, colours, site, Position(float(centre.x), float(centre.y)),
                                             Sweep(colour, strength, number, seed), steps, step_count);
      bool inside = tile_class != class_border || all(lessThanEqual(centre, last));
      if (inside) {
        imageStore(improved, index_of(centre), vec4(next.x, next.y, 0.0, 0.0));
      }
      if (marks_changes != 0) {
        bool change = inside && (next.x != c.x || next.y != c.y);
        south_change = south_change || change;
      }
    }
    any_change = any_change || south_change;
    north_change = row == 0 ? south_change : north_change;
    north = middle;
    middle = south;
  }
  if (marks_changes != 0) {
    int beside = any_change ? 2 : 0; // which columns of tiles
    beside |= any_change && inside_tile.x == 0 ? 1 : 0;
    beside |= any_change && inside_tile.x + COLUMNS == TILE_WIDTH ? 4 : 0;
    int which = beside << 3;
    which |= north_change && inside_tile.y == 0 ? beside : 0;
    which |= south_change && inside_tile.y + ROWS == TILE_HEIGHT ? beside << 6 : 0;
    wake(tile, which);
  }
}
