#version 430
#extension GL_GOOGLE_include_directive : require

// The first levels of a pyramid, from the null field, in one work group: their field never leaves its shared memory, and
// between two sweeps there is a barrier instead of a dispatch. For candidates with simultaneous updates of images.

#define real float
#define HDM_FUNCTION
#define HDM_CONSTANT const
#define HDM_PRECISE precise

#include "fields.glsl" // material and observation are the full image's, improved takes the last level's displacement

#ifdef VULKAN
layout(local_size_x_id = 0) in;
layout(constant_id = 1) const int step_count = 1;
layout(constant_id = 2) const bool stops_at_rest = false; // a level ends with the first sweep that changes nothing
const int INVOCATIONS = int(gl_WorkGroupSize.x);
#else // supplied after #version
layout(local_size_x = INVOCATIONS) in;
const int step_count = STEP_COUNT;
const bool stops_at_rest = STOPS_AT_REST != 0;
#endif

PARAMETERS_AND_STEPS(4) // the penalty; then
#define full_width parameters[1]
#define first_level parameters[2] // of the table in `entries`: width, height, sweeps, where the level's own entries begin
#define level_count parameters[3]

#include "site.inc"
#include "energy.inc"
#include "update.inc"

const int most_sites = 1024; // of a level: backends/session/shapes.cpp

// 28 KiB of the 32 that every OpenGL 4.3 has.
shared vec2 displacements[2 * most_sites]; // two fields, read and written in turn
shared vec2 moduli[most_sites];            // modulus, 1 / modulus
shared int sampled_from[most_sites];       // index in the full image
shared bool moved[3];                      // by sweep modulo 3: one is written, one read, one cleared

int newest = 0; // first site of the field that is read; the other one begins at most_sites - newest

vec2 displacement_at(int i) { return displacements[newest + i]; }
vec2 material_at(int i) { return moduli[i]; }
vec2 target_at(int i) { return target_of(sampled_from[i]); }
vec2 confidence_at(int i) { return confidence_of(sampled_from[i]); }
#if HDM_INPUTS > 0
vec4 inputs_at(int i) { return texelFetch(inputs, sampled_from[i]); }
#endif
vec2 inverse_curvature_at(int i) { return vec2(0.0); } // no candidate asks for it
void store(int i, Displacement next) { displacements[most_sites - newest + i] = vec2(next.x, next.y); }

// A tile is one site, of any class.
#define TILE_WIDTH 1
#define TILE_HEIGHT 1
#define COLUMNS 1
#define WINDOW 3
const int rule = rule_steps;
const int colours = 1;
const bool border = true;
const bool observed = true;
const bool elastic = true;
#include "tile.glsl"

#include "projection.glsl"

void wait_for_all() {
  memoryBarrierShared();
  barrier();
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  real penalty = intBitsToFloat(parameters[0]);
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
        displacements[most_sites - newest + site] = projected_displacement(above, column, row, vec4(0.0));
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
        ivec3 tile = ivec3(site % size.x, site / size.x, 0);
        int seen_from = sweep_tile(tile, 0, ivec3(size, 1), penalty, Sweep(0.0, 0.0, 0.0, 0.0));
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
