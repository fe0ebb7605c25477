#version 430
#extension GL_GOOGLE_include_directive : require

// Several steps of the elastic energy on the coarsest levels, in one work group, with a barrier between two steps instead
// of a dispatch. Fields are in its shared memory, or in a buffer: rasterizers on the CPU have shared memory there, too, and
// read buffers of texels faster.

#include "elastic_arrays.glsl"

#ifdef VULKAN
layout(local_size_x_id = 0) in;
layout(constant_id = 1) const int ROWS = 1;
layout(constant_id = 2) const bool in_shared = true;
const int LANES = int(gl_WorkGroupSize.x);
layout(push_constant) uniform Parameters { int parameters[32]; };
#else // supplied after #version
layout(local_size_x = LANES) in;
const bool in_shared = IN_SHARED != 0;
layout(location = 0) uniform int parameters[32];
#endif

layout(binding = ELASTIC_STORED_SECOND, rg32f) uniform restrict writeonly imageBuffer stored_second;
layout(binding = ELASTIC_STORED_THIRD, rg32f) uniform restrict writeonly imageBuffer stored_third;
layout(binding = ELASTIC_KEPT, rg32f) uniform coherent imageBuffer kept; // three fields, where they are not in shared memory
layout(binding = ELASTIC_THIRD) uniform samplerBuffer third;

// ElasticCoarse. Arrays here begin with the level `finest`, at `base` of the device's.
#define base parameters[0]
#define size parameters[1]
#define finest parameters[2]
#define finest_width parameters[3]
#define finest_height parameters[4]
#define steps parameters[5]
#define ratio PoissonRatio(intBitsToFloat(parameters[6]), intBitsToFloat(parameters[7]))
const int first_step = 8;

shared vec2 fields[3 * ELASTIC_SHARED_SITES];
const int array_sites = in_shared ? ELASTIC_SHARED_SITES : ELASTIC_COARSE_SITES;

vec2 field_at(int i) { return in_shared ? fields[i] : imageLoad(kept, i).xy; }
void keep(int i, vec2 value) {
  if (in_shared) {
    fields[i] = value;
  } else {
    imageStore(kept, i, vec4(value, 0.0, 0.0));
  }
}

// Of the step that is done, as ElasticParameters has them.
int work;
int width;
int height;
int first;
int pitch;
int from_first;
int from_pitch;
int second_first;
int second_pitch;
int from_array; // where it begins
int second_array;
int stored_array;
const bool has_load = true;
const bool is_image = false;

vec2 from_at(int i) { return field_at(from_array + i); }
vec2 second_at(int i) { return field_at(second_array + i); }
void store(int i, vec2 value) { keep(stored_array + i, value); }

#include "elastic_sites.glsl"

void wait_for_all() {
  memoryBarrierShared();
  memoryBarrierImage();
  barrier();
}

// Of a level counted from the finest one here.
struct Place {
  int first;
  int pitch;
  int width;
  int height;
};

Place place_of(int level) {
  Place place = Place(0, 0, finest_width, finest_height);
  for (int i = 0; i < level; ++i) {
    place.first += (place.width + 3) * (place.height + 3);
    place.width = place.width / 2 + 1;
    place.height = place.height / 2 + 1;
  }
  place.pitch = place.width + 3;
  place.first += place.pitch + 1;
  return place;
}

// Column and row of item i of rows of `across`. By floats, exact for so few: whole numbers are divided slowly.
ivec2 item(int i, int across) {
  HDM_PRECISE float middle = float(i) + 0.5;
  int row = int(middle / float(across));
  return ivec2(i - row * across, row);
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  for (int i = lane; i < size; i += LANES) {
    keep(i, texelFetch(from, base + i).xy);
    keep(array_sites + i, texelFetch(second, base + i).xy);
    keep(2 * array_sites + i, texelFetch(third, base + i).xy);
  }
  wait_for_all();
  for (int number = 0; number < steps; ++number) {
    int code = parameters[first_step + number];
    work = code & 15;
    from_array = (code >> 4 & 3) * array_sites;
    second_array = (code >> 6 & 3) * array_sites;
    stored_array = (code >> 8 & 3) * array_sites;
    int level = code >> 10;
    Place from_place = place_of(level);
    bool to_coarser = work == ELASTIC_RESTRICT;
    bool from_coarser = work == ELASTIC_INTERPOLATE || work == ELASTIC_CORRECT;
    Place coarser = place_of(level + 1);
    from_first = from_place.first;
    from_pitch = from_place.pitch;
    second_first = from_coarser ? coarser.first : from_place.first;
    second_pitch = from_coarser ? coarser.pitch : from_place.pitch;
    first = to_coarser ? coarser.first : from_place.first;
    pitch = to_coarser ? coarser.pitch : from_place.pitch;
    width = to_coarser ? coarser.width : from_place.width;
    height = to_coarser ? coarser.height : from_place.height;

    // Loops that do nothing for the other steps, not branches: see elastic.glsl.
    bool sweeps = work == ELASTIC_RELAX || work == ELASTIC_RESIDUAL;
    int across = (width + COLUMNS - 1) / COLUMNS;
    int strips = sweeps ? across * ((height + ROWS - 1) / ROWS) : 0;
    for (int i = lane; i < strips; i += LANES) {
      ivec2 strip = item(i, across);
      sweep_columns(strip.x * COLUMNS, strip.y * ROWS, min(strip.y * ROWS + ROWS, height));
    }
    int half_width = (width + 1) / 2;
    int blocks = from_coarser ? half_width * ((height + 1) / 2) : 0;
    for (int i = lane; i < blocks; i += LANES) {
      ivec2 block = item(i, half_width);
      correct_block(2 * block.x, 2 * block.y);
    }
    int sites = width * height;
    int restricted_count = to_coarser ? sites : 0;
    for (int i = lane; i < restricted_count; i += LANES) {
      ivec2 site = item(i, width);
      store(first + site.y * pitch + site.x, restricted_at(site.x, site.y));
    }
    int from_zero = work == ELASTIC_RELAX_FROM_ZERO ? sites : 0;
    for (int i = lane; i < from_zero; i += LANES) {
      ivec2 site = item(i, width);
      int at = first + site.y * pitch + site.x;
      store(at, relaxed_from_zero(at));
    }
    int solved = work == ELASTIC_SOLVE ? sites : 0;
    for (int i = lane; i < solved; i += LANES) {
      ivec2 site = item(i, width);
      store(first + site.y * pitch + site.x, solved_at(site.x, site.y));
    }
    wait_for_all();
    vec2 list = texelFetch(touched, finest + level).xy;
    int listed = sweeps ? int(list.y) : 0;
    for (int i = lane; i < listed; i += LANES) {
      ivec2 site = ivec2(texelFetch(touched, int(list.x) + i).xy);
      sweep_listed(site.x, site.y);
    }
    wait_for_all();
  }
  for (int i = lane; i < size; i += LANES) {
    imageStore(stored, base + i, vec4(field_at(i), 0.0, 0.0));
    imageStore(stored_second, base + i, vec4(field_at(array_sites + i), 0.0, 0.0));
    imageStore(stored_third, base + i, vec4(field_at(2 * array_sites + i), 0.0, 0.0));
  }
}
