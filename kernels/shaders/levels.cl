// What is done once to every site of a level, a group per row. The entries are backends/session/level_arrays.hpp's.

#include "language.cl"
#include "level_passes.h"
#include "projection.inc"

// As sweep.cl has them, of the level and of what is read.
typedef struct {
  int width;
  uint origin;
  uint plane;
  int from_width;
  uint from_origin;
  uint from_plane;
  int first_column; // of the level's entries
  int first_row;
} LevelPass;

kernel void level_pass(global const float* displacement, global float* improved, global const float* material,
                       global const float* observation, global float* sampled_material,
                       global float* sampled_observation, global const float4* entries, global uint* changed,
                       LevelPass p) {
  int y = get_group_id(0);
  size_t start = (size_t)p.origin + (size_t)y * (size_t)p.width;
#if PASS == LEVEL_COUNT
  uint differing = 0;
  for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
    size_t site = start + (size_t)x;
    differing += (displacement[site] != improved[site]) | (displacement[p.plane + site] != improved[p.plane + site]);
  }
  if (differing > 0) {
    atomic_add(changed, differing);
  }
#elif PASS == LEVEL_SAMPLE
  size_t row = (size_t)p.from_origin + (size_t)entries[p.first_row + y].w * (size_t)p.from_width;
  for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
    size_t from = row + (size_t)entries[p.first_column + x].w;
    size_t to = start + (size_t)x;
    for (int number = 0; number < 2; ++number) {
      sampled_material[number * (size_t)p.plane + to] = material[number * (size_t)p.from_plane + from];
    }
    for (int number = 0; number < 4; ++number) {
      sampled_observation[number * (size_t)p.plane + to] = observation[number * (size_t)p.from_plane + from];
    }
  }
#else
  float4 row = entries[p.first_row + y];
  size_t first_row = (size_t)p.from_origin + (size_t)row.x * (size_t)p.from_width;
  size_t second_row = (size_t)p.from_origin + (size_t)row.y * (size_t)p.from_width;
  for (int number = 0; number < 2; ++number) {
    global const float* north = displacement + number * (size_t)p.from_plane + first_row;
    global const float* south = displacement + number * (size_t)p.from_plane + second_row;
    global float* to = improved + number * (size_t)p.plane + start;
    for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
      float4 column = entries[p.first_column + x];
      int west = (int)column.x;
      int east = (int)column.y;
      to[x] = projected(north[west], north[east], south[west], south[east], column.z, row.z);
    }
  }
#endif
}
