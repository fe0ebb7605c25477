// One sweep over the tiles of a level as OpenCL C 1.2, or several over a small one. The host
// supplies
//
//   RULE, COLOURS, STEP_COUNT  as update.inc has them
//   TILE_WIDTH, TILE_HEIGHT    sites
//   LANES                      work items of a group, which sweeps a tile row by row: its sites are side by side in the
//                              lanes. With one item the loop along the row is what a CPU's compiler makes SIMD of:
//                              PoCL 3.1 does not vectorise the items of a group, whether they have loops in them or not
//                              (measured: several times slower). This is why tile.glsl, where an item goes down its
//                              column, is not used here.
//   SIMD_WIDTH                 sites side by side of that loop: what a compiler takes of its own accord may be half as fast
//   ACTIVE                     whether only tiles are visited that can see a change; never of a volume
//   CLASS                      7 where all tiles are of the general class
//
// Arrays over the sites are planes, one number each, so that neighbours in a row are neighbours in memory. Around each there
// is room: neighbours beyond the border are read before they are replaced.

#include "language.cl"
#include "site.inc"
#include "energy.inc"
#include "update.inc"

// What is stored in a row is not what is read next.
#define PRAGMA(text) _Pragma(#text)
#define SIDE_BY_SIDE(width) PRAGMA(clang loop vectorize(assume_safety) vectorize_width(width))
#if defined(__clang__) && LANES == 1
#define SITES_SIDE_BY_SIDE SIDE_BY_SIDE(SIMD_WIDTH)
#else
#define SITES_SIDE_BY_SIDE
#endif

typedef struct {
  float penalty;
  float colour; // this and the next three are update.inc's Sweep
  float strength;
  float number;
  float seed;
  int width;
  int height;
  int depth;
  int tiles_across;
  int tiles_down; // of a slice
  int tile_count;
  int every;  // whether every tile is visited
  uint stamp; // of this sweep, another one for each since the flags were cleared
  uint first_input; // float of the energy's own numbers where the level's planes begin
  uint first_listed; // of other devices' lists of tiles
  uint end_listed;
  int sweeps; // more than one only where one group has all tiles, and nothing of the above changes
  uint origin; // where in a plane its first site is
  uint plane;  // from a plane to the next
  float steps[16];
} Parameters;

// From a row to what it sees of a plane beside it. A slice beyond the border is the row's own.
typedef struct {
  size_t south;
  size_t near;
  size_t far;
} Distances;

// Which neighbours of a site are outside.
typedef struct {
  bool north, west, east, south, near, far;
} Outside;

// What a site sees of a plane: itself where a neighbour is outside (thesis 6.2.6).
HDM_FUNCTION Neighbours around(__global const float* row, Distances to, int x, bool border, Outside outside) {
#define NINE(middle)                                                                                                   \
  (middle - to.south)[x - 1], (middle - to.south)[x], (middle - to.south)[x + 1], (middle)[x - 1], (middle)[x],        \
      (middle)[x + 1], (middle + to.south)[x - 1], (middle + to.south)[x], (middle + to.south)[x + 1]
#if HDM_AXES > 2
  Neighbours seen = {NINE(row), {NINE(row - to.near)}, {NINE(row + to.far)}};
#else
  Neighbours seen = {NINE(row)};
#endif
  if (border) {
    real centre = seen.centre;
#define REPLACE(plane, is_outside)                                                                                     \
  plane.north_west = (is_outside | outside.north | outside.west) ? centre : plane.north_west;                          \
  plane.north = (is_outside | outside.north) ? centre : plane.north;                                                   \
  plane.north_east = (is_outside | outside.north | outside.east) ? centre : plane.north_east;                          \
  plane.west = (is_outside | outside.west) ? centre : plane.west;                                                      \
  plane.centre = is_outside ? centre : plane.centre;                                                                   \
  plane.east = (is_outside | outside.east) ? centre : plane.east;                                                      \
  plane.south_west = (is_outside | outside.south | outside.west) ? centre : plane.south_west;                          \
  plane.south = (is_outside | outside.south) ? centre : plane.south;                                                   \
  plane.south_east = (is_outside | outside.south | outside.east) ? centre : plane.south_east
    REPLACE(seen, false);
#if HDM_AXES > 2
    REPLACE(seen.near, outside.near);
    REPLACE(seen.far, outside.far);
#endif
  }
  return seen;
}

HDM_FUNCTION Neighbours of_one_modulus() {
#define ONES 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f
#if HDM_AXES > 2
  Neighbours seen = {ONES, {ONES}, {ONES}};
#else
  Neighbours seen = {ONES};
#endif
  return seen;
}

// What does not change in the sweeps of a level; see the kernel.
typedef struct {
  __global const float* material;
  __global const float* observation;
  __global const float* inverse_curvature;
  __global const float* inputs;
} Fields;

// The tile at a column and row of tiles of slice z, of the class that the three say. Returns which tiles see a change of what this
// item swept: bit (x + 1) + 3 (y + 1) stands for the neighbour at x, y in tiles.
HDM_FUNCTION int sweep_tile(bool border, bool observed, bool elastic, int tile_x, int tile_y, int z,
                            __global const float* displacement, Fields fields, __global float* improved, Parameters p) {
  int left = tile_x * TILE_WIDTH;
  int top = tile_y * TILE_HEIGHT;
  int columns = border ? min(TILE_WIDTH, p.width - left) : TILE_WIDTH;
  int rows = border ? min(TILE_HEIGHT, p.height - top) : TILE_HEIGHT;
  Sweep sweep = {p.colour, p.strength, p.number, p.seed};
  int first_outside = left == 0 ? 0 : -1; // columns of the tile whose west, whose east is outside
  int last_outside = p.width - 1 - left;
  bool no_near = z == 0;
  bool no_far = z == p.depth - 1;
  size_t slice = (size_t)p.width * (size_t)p.height;
  Distances to = {p.width, no_near ? 0 : slice, no_far ? 0 : slice};

  int seen_from = 0;
  for (int row = 0; row < rows; ++row) {
    int y = top + row;
    size_t start = (size_t)p.origin + ((size_t)z * (size_t)p.height + (size_t)y) * (size_t)p.width + (size_t)left;
    __global const float* d = displacement + start;
    __global const float* material = fields.material + start;
    __global const float* observation = fields.observation + start;
    __global const float* inverse_curvature = fields.inverse_curvature + start;
    __global const float* inputs = fields.inputs + start;
    size_t plane = p.plane;
    __global float* next_d = improved + start;
    bool no_north = y == 0;
    bool no_south = y == p.height - 1;
    int changed_first = 0;
    int changed_last = 0;
    int changed_any = 0;
    SITES_SIDE_BY_SIDE
    for (int x = get_local_id(0); x < columns; x += LANES) {
      Outside outside = {no_north, x == first_outside, x == last_outside, no_south, no_near, no_far};
      Site site;
      site.dx = around(d, to, x, border, outside);
      site.dy = around(d + plane, to, x, border, outside);
      site.inverse_modulus = elastic ? around(material + plane, to, x, border, outside) : of_one_modulus();
      site.modulus = elastic ? material[x] : 1.0f;
      site.target_x = observed ? observation[x] : 0.0f;
      site.target_y = observed ? observation[plane + x] : 0.0f;
      site.confidence_x = observed ? observation[HDM_AXES * plane + x] : 0.0f;
      site.confidence_y = observed ? observation[(HDM_AXES + 1) * plane + x] : 0.0f;
      site.penalty = p.penalty;
      site.inverse_curvature_x = RULE == rule_steps ? 0.0f : inverse_curvature[x];
      site.inverse_curvature_y = RULE == rule_steps ? 0.0f : inverse_curvature[plane + x];
#if HDM_AXES > 2
      site.dz = around(d + 2 * plane, to, x, border, outside);
      site.target_z = observed ? observation[2 * plane + x] : 0.0f;
      site.confidence_z = observed ? observation[5 * plane + x] : 0.0f;
      site.inverse_curvature_z = RULE == rule_steps ? 0.0f : inverse_curvature[2 * plane + x];
      Position at = {(float)(left + x), (float)y, (float)z};
#else
      Position at = {(float)(left + x), (float)y};
#endif
#if HDM_INPUTS > 0
      site.first_input = around(inputs, to, x, border, outside);
#endif
#if HDM_INPUTS > 1
      site.second_input = around(inputs + plane, to, x, border, outside);
#endif
#if HDM_INPUTS > 2
      site.third_input = around(inputs + 2 * plane, to, x, border, outside);
#endif
#if HDM_INPUTS > 3
      site.fourth_input = around(inputs + 3 * plane, to, x, border, outside);
#endif
      Displacement next = swept_displacement(RULE, COLOURS, observed, site, at, sweep, p.steps, STEP_COUNT);
      next_d[x] = next.x;
      next_d[plane + x] = next.y;
#if HDM_AXES > 2
      next_d[2 * plane + x] = next.z;
#endif
      if (ACTIVE) {
        int changed = (next.x != site.dx.centre) | (next.y != site.dy.centre);
        changed_any |= changed;
        changed_first |= changed & (x == 0);
        changed_last |= changed & (x == TILE_WIDTH - 1);
      }
    }
    // The row's bits of the tiles above, here and below; one to the left and one to the right for those beside.
    int bits = 16 | (row == 0 ? 2 : 0) | (row == TILE_HEIGHT - 1 ? 128 : 0);
    seen_from |= changed_any ? bits : 0;
    seen_from |= changed_first ? bits >> 1 : 0;
    seen_from |= changed_last ? bits << 1 : 0;
  }
  return seen_from;
}

// Has the tiles visited in the next sweep that sweep_tile() named. Several items may store the same.
HDM_FUNCTION void wake(int tile_x, int tile_y, int seen_from, __global uint* next_flags, Parameters p) {
  for (int bit = 0; bit < 9; ++bit) {
    int x = tile_x + bit % 3 - 1;
    int y = tile_y + bit / 3 - 1;
    if (((seen_from >> bit) & 1) != 0 && x >= 0 && x < p.tiles_across && y >= 0 && y < p.tiles_down) {
      next_flags[y * p.tiles_across + x] = p.stamp + 1u;
    }
  }
}

// A group per tile, or one for all. `classes` has the class of each tile, `flags` twice per tile the last sweep that has to
// visit it: those with odd numbers, those with even ones.
kernel __attribute__((reqd_work_group_size(LANES, 1, 1))) void sweep(
    __global float* displacement,            // by axis
    __global float* improved,                // the same after the sweep
    __global const float* material,          // modulus, 1 / modulus
    __global const float* observation,       // target by axis, confidence by axis
    __global const float* inverse_curvature, // by axis, where the rule needs them
    __global const float* inputs,            // the energy's own
    __global const uint* classes, __global uint* flags, Parameters p) {
  Fields fields = {material, observation, inverse_curvature, inputs + p.first_input};
  int tile = get_group_id(0);
  uint now = (p.stamp & 1u) * (uint)p.tile_count;
  if (ACTIVE && !p.every && flags[now + tile] != p.stamp) {
    return;
  }
  for (int i = 0; i < p.sweeps; ++i) {
    for (; tile < p.tile_count; tile += get_num_groups(0)) {
      int tile_x = tile % p.tiles_across;
      int tile_y = tile / p.tiles_across % p.tiles_down;
      int z = tile / (p.tiles_across * p.tiles_down);
      int seen_from = 0;
#define SWEEP(border, observed, elastic)                                                                               \
  seen_from = sweep_tile(border, observed, elastic, tile_x, tile_y, z, displacement, fields, improved, p)
#if CLASS == 7
      SWEEP(true, true, true);
#else
      switch (classes[tile]) {
      case 0:
        SWEEP(false, false, false);
        break;
      case 1: // elastic_bit
        SWEEP(false, false, true);
        break;
      case 2: // observed_bit
        SWEEP(false, true, false);
        break;
      case 3:
        SWEEP(false, true, true);
        break;
      default:
        SWEEP(true, true, true);
      }
#endif
      if (ACTIVE) {
        wake(tile_x, tile_y, seen_from, flags + ((uint)p.tile_count - now), p);
      }
    }
    __global float* swept = improved;
    improved = displacement;
    displacement = swept;
    tile = get_group_id(0);
    barrier(CLK_GLOBAL_MEM_FENCE);
  }
}
