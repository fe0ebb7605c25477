// What is done once to every site of a level, a group per row of a slice. The entries are backends/session/level_arrays.hpp's.

#include "language.cl"
#include "level_passes.h"
#include "projection.inc"

// As sweep.cl has them, of the level and of what is read.
typedef struct {
  int width;
  int height;
  uint origin;
  uint plane;
  int from_width;
  int from_height;
  uint from_origin;
  uint from_plane;
  int first_column; // of the level's entries
} LevelPass;

// What is read of a coarse plane by column, between two rows of a slice.
HDM_FUNCTION real between_rows(__global const float* plane, int slice, float4 column, float4 row, LevelPass p) {
  __global const float* north = plane + ((size_t)slice * p.from_height + (uint)row.x) * p.from_width;
  __global const float* south = plane + ((size_t)slice * p.from_height + (uint)row.y) * p.from_width;
  int west = (int)column.x;
  int east = (int)column.y;
  return projected(north[west], north[east], south[west], south[east], column.z, row.z);
}

kernel void level_pass(__global const float* displacement, __global float* improved, __global const float* material,
                       __global const float* observation, __global float* sampled_material,
                       __global float* sampled_observation, __global const float4* entries, __global uint* changed,
                       LevelPass p) {
  uint group = (uint)get_group_id(0); // 64 bits are divided slowly, and slowly made of a float
  int y = (int)(group % (uint)p.height);
  int z = (int)(group / (uint)p.height);
  size_t start = (size_t)p.origin + (size_t)group * (size_t)p.width;
#if PASS == LEVEL_COUNT
  uint differing = 0;
  for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
    int differs = 0;
    for (int axis = 0; axis < HDM_AXES; ++axis) {
      size_t site = axis * (size_t)p.plane + start + (size_t)x;
      differs |= displacement[site] != improved[site];
    }
    differing += differs;
  }
  if (differing > 0) {
    atomic_add(changed, differing);
  }
#else
  float4 row = entries[p.first_column + p.width + y];
  float4 slice = entries[p.first_column + p.width + p.height + z];
  for (int x = get_local_id(0); x < p.width; x += get_local_size(0)) {
    float4 column = entries[p.first_column + x];
    size_t to = start + (size_t)x;
#if PASS == LEVEL_SAMPLE
    size_t from = (size_t)p.from_origin + (uint)column.w +
                  ((size_t)(uint)slice.w * (size_t)p.from_height + (uint)row.w) * (size_t)p.from_width;
    for (int number = 0; number < 2; ++number) {
      sampled_material[number * (size_t)p.plane + to] = material[number * (size_t)p.from_plane + from];
    }
    for (int number = 0; number < 2 * HDM_AXES; ++number) {
      sampled_observation[number * (size_t)p.plane + to] = observation[number * (size_t)p.from_plane + from];
    }
#else
    for (int axis = 0; axis < HDM_AXES; ++axis) {
      __global const float* plane = displacement + p.from_origin + axis * (size_t)p.from_plane;
      real near = between_rows(plane, (int)slice.x, column, row, p);
      improved[axis * (size_t)p.plane + to] =
          HDM_AXES > 2 ? interpolated(near, between_rows(plane, (int)slice.y, column, row, p), slice.z) : near;
    }
#endif
  }
#endif
}
