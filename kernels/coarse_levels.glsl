// The first levels of a pyramid in one work group: their field never leaves its shared memory, and between two sweeps
// there is a barrier instead of a dispatch. For candidates with simultaneous updates. The includer supplies, after
// energy.inc, update.inc and projection.inc,
//
//   INVOCATIONS            constant, of the work group
//   step_count, steps      as update.inc has them
//   stops_at_rest          constant bool: whether a level ends with the first sweep that changes nothing
//   entries, material, observation  buffer textures as in resampling.vulkan.glsl, the latter two of the full image
//   improved               image buffer for the last level's displacement

const int most_sites = 1024; // of a level: backends/coarse_levels.hpp

// 28 KiB of the 32 that every OpenGL 4.3 has.
shared vec2 displacements[2 * most_sites]; // two fields, read and written in turn
shared vec2 moduli[most_sites];            // modulus, 1 / modulus
shared int sampled_from[most_sites];       // index in the full image
shared bool moved[3];                      // by sweep modulo 3: one is written, one read, one cleared

int newest = 0; // first site of the field that is read; the other one begins at most_sites - newest

vec2 displacement_at(int i) { return displacements[newest + i]; }
vec2 material_at(int i) { return moduli[i]; }
vec4 observation_at(int i) { return texelFetch(observation, sampled_from[i]); }
vec2 inverse_curvature_at(int i) { return vec2(0.0); } // no candidate asks for it
void store(int i, Displacement next) { displacements[most_sites - newest + i] = vec2(next.x, next.y); }

// A tile is one site, of any class.
#define TILE_WIDTH 1
#define TILE_HEIGHT 1
#define COLUMNS 1
const int rule = rule_steps;
const int colours = 1;
const bool border = true;
const bool observed = true;
const bool elastic = true;
#include "tile.glsl"

void wait_for_all() {
  memoryBarrierShared();
  barrier();
}

Displacement projected_displacement(int from_width, vec4 column, vec4 row) {
  int first_row = int(row.x) * from_width;
  int second_row = int(row.y) * from_width;
  vec2 north_west = displacement_at(first_row + int(column.x));
  vec2 north_east = displacement_at(first_row + int(column.y));
  vec2 south_west = displacement_at(second_row + int(column.x));
  vec2 south_east = displacement_at(second_row + int(column.y));
  return Displacement(projected(north_west.x, north_east.x, south_west.x, south_east.x, column.z, row.z),
                      projected(north_west.y, north_east.y, south_west.y, south_east.y, column.z, row.z));
}

// Levels first_level ... first_level + level_count - 1 of the table in `entries`: width, height, sweeps, and where the
// level's own entries begin.
void solve_coarse_levels(int lane, int first_level, int level_count, int full_width, real penalty) {
  if (lane == 0) {
    moved[0] = false;
  }
  int done = 0; // sweeps, of all levels
  ivec2 above = ivec2(0);
  int sites = 0;
  for (int index = 0; index < level_count; ++index) {
    vec4 level = texelFetch(entries, first_level + index);
    ivec2 size = ivec2(level.xy);
    int first_column = int(level.w);
    bool projects = index > 0 && above != size;
    sites = size.x * size.y;
    for (int site = lane; site < sites; site += INVOCATIONS) {
      vec4 column = texelFetch(entries, first_column + site % size.x);
      vec4 row = texelFetch(entries, first_column + size.x + site / size.x);
      int from = int(row.w) * full_width + int(column.w);
      sampled_from[site] = from;
      moduli[site] = texelFetch(material, from).xy;
      if (index == 0) {
        displacements[newest + site] = vec2(0.0);
      } else if (projects) {
        store(site, projected_displacement(above.x, column, row));
      }
    }
    newest = projects ? most_sites - newest : newest;
    above = size;
    wait_for_all();

    int sweeps = int(level.z);
    bool moves = true;
    for (int sweep = 0; sweep < sweeps && moves; ++sweep) {
      bool changes = false;
      for (int site = lane; site < sites; site += INVOCATIONS) {
        int seen_from = sweep_tile(ivec2(site % size.x, site / size.x), 0, size, penalty, Sweep(0.0, 0.0, 0.0, 0.0));
        changes = changes || seen_from != 0;
      }
      if (stops_at_rest) {
        if (changes) {
          moved[done % 3] = true;
        }
        if (lane == 0) {
          moved[(done + 1) % 3] = false;
        }
      }
      newest = most_sites - newest;
      wait_for_all();
      moves = !stops_at_rest || moved[done % 3];
      ++done;
    }
  }
  for (int site = lane; site < sites; site += INVOCATIONS) {
    imageStore(improved, site, vec4(displacement_at(site), 0.0, 0.0));
  }
}
