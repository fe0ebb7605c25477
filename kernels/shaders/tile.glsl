// One sweep of one tile, TILE_WIDTH x TILE_HEIGHT sites of a slice: every invocation computes COLUMNS sites side by side from the
// first row of the tile to the last, and fetches each row once. The includer supplies, after the energy and update.inc,
//
//   TILE_WIDTH, TILE_HEIGHT, COLUMNS  constants, COLUMNS 1 or 2; a tile takes TILE_WIDTH / COLUMNS invocations
//   WINDOW                            COLUMNS + 2 or more: the sites of a row that an invocation sees
//   border, observed, elastic         constant bools, the class of the tile: whether it reaches
//                                     the border of the image, whether a site in it has confidence, whether a ratio of
//                                     moduli in it is not 1
//   rule, colours, step_count, steps  constants, as update.inc has them
//   displacement_at(i)                Vector of site i = (z * height + y) * width + x
//   material_at(i)                    vec2: modulus, 1 / modulus; only where elastic
//   target_at(i), confidence_at(i)    Vectors; only where observed
//   inverse_curvature_at(i)           Vector; only where the rule is not rule_steps
//   inputs_at(i)                      vec4: the energy's own; only where HDM_INPUTS is above 0
//   store(i, displacement)
//
// The classes are the same arithmetic with constants in it: same bits. They have to be programs of their own, because a
// rasterizer that runs on the CPU executes both sides of a branch.

// Which tiles see a change of a tile in the next sweep, the result of sweep_tile(): bit (x + 1) + 3 (y + 1) stands for
// the neighbour at x, y in tiles. This one is the tile itself.
const int seen_here = 16;

#include "seen.glsl"

SeenSite seen_site(int index) {
  SeenSite seen;
  seen.displacement = displacement_at(index);
  seen.material = elastic ? material_at(index) : vec2(1.0);
#if HDM_INPUTS > 0
  seen.inputs = inputs_at(index);
#endif
  return seen;
}

#if HDM_AXES > 2
int to_near = 0; // from a site of the tile to those before and behind it; 0 where they are outside
int to_far = 0;
#endif

Seen seen_at(int index) {
  Seen seen;
  seen.here = seen_site(index);
#if HDM_AXES > 2
  seen.near = seen_site(index + to_near);
  seen.far = seen_site(index + to_far);
#endif
  return seen;
}

// The neighbour, or the centre where the neighbour is outside (thesis 6.2.6).
SeenSite site_or(SeenSite centre, bool outside, SeenSite neighbour) {
  SeenSite seen;
  seen.displacement = border && outside ? centre.displacement : neighbour.displacement;
  seen.material = border && outside ? centre.material : neighbour.material;
#if HDM_INPUTS > 0
  seen.inputs = border && outside ? centre.inputs : neighbour.inputs;
#endif
  return seen;
}
Seen neighbour_or(Seen centre, bool outside, Seen neighbour) {
  Seen seen;
  seen.here = site_or(centre.here, outside, neighbour.here);
#if HDM_AXES > 2
  seen.near = site_or(centre.here, outside || to_near == 0, neighbour.near);
  seen.far = site_or(centre.here, outside || to_far == 0, neighbour.far);
#endif
  return seen;
}

// Sweeps site first + (k, 0, 0); true where its displacement changed. The three rows are those of the window, sites
// first.x - 1 ... first.x + COLUMNS; start is the index of the row's first site.
bool sweep_site(int k, ivec3 first, int start, ivec3 size, Seen north[WINDOW], Seen middle[WINDOW],
                Seen south[WINDOW], real penalty, Sweep sweep) {
  int x = first.x + k;
  int y = first.y;
  bool inside = !border || x < size.x;
  bool no_west = x == 0;
  bool no_east = x == size.x - 1;
  bool no_north = y == 0;
  bool no_south = y == size.y - 1;
  Seen c = neighbour_or(middle[k + 1], false, middle[k + 1]);
  Seen nw = neighbour_or(c, no_north || no_west, north[k]);
  Seen n = neighbour_or(c, no_north, north[k + 1]);
  Seen ne = neighbour_or(c, no_north || no_east, north[k + 2]);
  Seen w = neighbour_or(c, no_west, middle[k]);
  Seen e = neighbour_or(c, no_east, middle[k + 2]);
  Seen sw = neighbour_or(c, no_south || no_west, south[k]);
  Seen s = neighbour_or(c, no_south, south[k + 1]);
  Seen se = neighbour_or(c, no_south || no_east, south[k + 2]);

  int index = start + (inside ? x : 0);
  Vector target = observed ? target_at(index) : Vector(0.0);
  Vector confidence = observed ? confidence_at(index) : Vector(0.0);
  Vector inverse_curvature = rule == rule_steps ? Vector(0.0) : inverse_curvature_at(index);
  Site site = site_of(nw, n, ne, w, c, e, sw, s, se, c.here.material.x, target, confidence, inverse_curvature, penalty);
  Position at = Position(float(x), float(y) AND_Z(float(first.z)));
  Displacement next = swept_displacement(rule, colours, observed, site, at, sweep, steps, step_count);
  if (inside) {
    store(start + x, next);
  }
  return inside && Vector(next.x, next.y AND_Z(next.z)) != c.here.displacement;
}

// `tile` counts tiles from the top left of the first slice, `lane` is 0 ... TILE_WIDTH / COLUMNS - 1. Returns which tiles see a change.
int sweep_tile(ivec3 tile, int lane, ivec3 size, real penalty, Sweep sweep) {
  int left = tile.x * TILE_WIDTH + lane * COLUMNS;
  int top = tile.y * TILE_HEIGHT;
  int rows = border ? min(TILE_HEIGHT, size.y - top) : TILE_HEIGHT;
  rows = border && left >= size.x ? 0 : rows;

  int column[WINDOW];
  for (int k = 0; k < COLUMNS + 2; ++k) {
    column[k] = border ? min(max(left + k - 1, 0), size.x - 1) : left + k - 1;
  }
  Seen north[WINDOW];
  Seen middle[WINDOW];
  Seen south[WINDOW];
  int slice = size.x * size.y;
  int above = tile.z * slice + (border ? max(top - 1, 0) : top - 1) * size.x;
  int start = tile.z * slice + top * size.x; // index of the row's first site
#if HDM_AXES > 2
  to_near = border && tile.z == 0 ? 0 : -slice;
  to_far = border && tile.z == size.z - 1 ? 0 : slice;
#endif
  for (int k = 0; k < COLUMNS + 2; ++k) {
    north[k] = seen_at(above + column[k]);
    middle[k] = seen_at(start + column[k]);
  }

  int seen_from = 0;
  for (int i = 0; i < rows; ++i) {
    ivec3 first = ivec3(left, top + i, tile.z);
    int below = start + (border && first.y == size.y - 1 ? 0 : size.x);
    for (int k = 0; k < COLUMNS + 2; ++k) {
      south[k] = seen_at(below + column[k]);
    }
    // Not a loop: compilers leave one as it is, with the window in memory.
    bool first_changed = sweep_site(0, first, start, size, north, middle, south, penalty, sweep);
    bool last_changed = first_changed;
    bool row_changed = first_changed;
    if (COLUMNS > 1) {
      last_changed = sweep_site(1, first, start, size, north, middle, south, penalty, sweep);
      row_changed = row_changed || last_changed;
    }
    // The row's bits of the tiles above, here and below; one to the left and one to the right for those beside.
    int bits = seen_here | (i == 0 ? seen_here >> 3 : 0) | (i == TILE_HEIGHT - 1 ? seen_here << 3 : 0);
    seen_from = seen_from | (row_changed ? bits : 0);
    seen_from = seen_from | (first_changed && lane == 0 ? bits >> 1 : 0);
    seen_from = seen_from | (last_changed && lane == TILE_WIDTH / COLUMNS - 1 ? bits << 1 : 0);
    for (int k = 0; k < COLUMNS + 2; ++k) {
      north[k] = middle[k];
      middle[k] = south[k];
    }
    start += size.x;
  }
  return seen_from;
}
