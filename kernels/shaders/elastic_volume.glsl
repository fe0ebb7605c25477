// What the steps of the elastic energy need of a volume (elastic.frag). Everything is gathered: a site computes the eight
// cells around it, one after the other.

#include "elastic/volume.inc"
#include "slices.glsl"

uniform vec3 from_slices;   // of all textures of its level
uniform vec3 second_slices; // those of `second`, which may be of a coarser level
uniform vec3 to_slices;     // what is drawn
uniform float slice;        // of it

vec4 level_at(sampler2DRect texels, vec3 p) { return texture2DRect(texels, texel_of(p, from_slices)); }
vec3 site_drawn() { return vec3(gl_FragCoord.xy - texel_of(vec3(0.0, 0.0, slice), to_slices), slice); }
vec3 straight_at(vec3 p) {
  vec4 entries = level_at(response[0], p);
  return vec3(entries.x, entries.w, level_at(response[1], p).y);
}

// Corner 0 ... 7 of a cell, x in the lowest bit.
vec3 corner_of(float number) {
  float rows = floor(0.5 * number);
  float planes = floor(0.5 * rows);
  return vec3(number - 2.0 * rows, rows - 2.0 * planes, planes);
}

float modulus_at(vec3 p, float x, float y, float z) { return level_at(response[1], p + vec3(x, y, z)).z; }

// Cells of the ring around the image have no stiffness; those of other levels have moments of 0 there.
CellMoments cell_at(vec3 p) {
#if IS_IMAGE
  bool there = all(greaterThan(p, vec3(1.0, 1.0, 0.5))) && all(lessThan(p, extent - vec3(0.0, 0.0, 0.5)));
  float weight = there ? 1.0 : 0.0;
  return image_cell(CellCorners(
      weight * modulus_at(p, 0.0, 0.0, 0.0), weight * modulus_at(p, 1.0, 0.0, 0.0), weight * modulus_at(p, 0.0, 1.0, 0.0),
      weight * modulus_at(p, 1.0, 1.0, 0.0), weight * modulus_at(p, 0.0, 0.0, 1.0), weight * modulus_at(p, 1.0, 0.0, 1.0),
      weight * modulus_at(p, 0.0, 1.0, 1.0), weight * modulus_at(p, 1.0, 1.0, 1.0)), law_told.w);
#else
  vec4 a = level_at(moments[0], p);
  vec4 b = level_at(moments[1], p);
  vec4 c = level_at(moments[2], p);
  vec4 d = level_at(moments[3], p);
  vec4 e = level_at(moments[4], p);
  vec4 f = level_at(moments[5], p);
  return CellMoments(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w, d.x, d.y, d.z, d.w, e.x, e.y, e.z, e.w,
                     f.x, f.y, f.z, 1.0, a.x);
#endif
}

float force_on(CellCorners forces, vec3 corner) {
  vec4 slab = corner.z > 0.5 ? vec4(forces.c001, forces.c101, forces.c011, forces.c111)
                             : vec4(forces.c000, forces.c100, forces.c010, forces.c110);
  vec2 line = corner.y > 0.5 ? slab.zw : slab.xy;
  return corner.x > 0.5 ? line.y : line.x;
}

vec3 value_at(vec3 p, float x, float y, float z) { return level_at(from, p + vec3(x, y, z)).xyz; }

vec3 more_masked_force(vec3 force, vec2 stiffness_at, float moved) {
  vec3 stiffness = texture2DRect(matrices, stiffness_at).xyz;
  return vec3(masked_force(force.x, stiffness.x, moved), masked_force(force.y, stiffness.y, moved),
              masked_force(force.z, stiffness.z, moved));
}

// What the cell at p does to one of its corners.
vec3 force_of_cell(vec3 p, vec3 corner) {
  vec3 u000 = value_at(p, 0.0, 0.0, 0.0);
  vec3 u100 = value_at(p, 1.0, 0.0, 0.0);
  vec3 u010 = value_at(p, 0.0, 1.0, 0.0);
  vec3 u110 = value_at(p, 1.0, 1.0, 0.0);
  vec3 u001 = value_at(p, 0.0, 0.0, 1.0);
  vec3 u101 = value_at(p, 1.0, 0.0, 1.0);
  vec3 u011 = value_at(p, 0.0, 1.0, 1.0);
  vec3 u111 = value_at(p, 1.0, 1.0, 1.0);
  CellTension tension = cell_tension(
      cell_at(p), coefficients_of(CellCorners(u000.x, u100.x, u010.x, u110.x, u001.x, u101.x, u011.x, u111.x)),
      coefficients_of(CellCorners(u000.y, u100.y, u010.y, u110.y, u001.y, u101.y, u011.y, u111.y)),
      coefficients_of(CellCorners(u000.z, u100.z, u010.z, u110.z, u001.z, u101.z, u011.z, u111.z)),
      Law(law_told.x, law_told.y, law_told.z));
  vec3 force = vec3(force_on(forces_of(tension.x), corner), force_on(forces_of(tension.y), corner),
                    force_on(forces_of(tension.z), corner));
#if HAS_MASKED
  // A loop, not a branch: rasterizers on the CPU execute both sides of a branch, but leave a loop when all are done.
  float number = level_at(response[1], p).w - 1.0;
  float row = floor(number / 16.0); // of the cells' matrices (elastic_matrices())
  vec2 texel = vec2(192.0 * (number - 16.0 * row) + 24.0 * dot(corner, vec3(1.0, 2.0, 4.0)), row) + 0.5;
  float other = number >= 0.0 ? 0.0 : 8.0;
  force = number >= 0.0 ? vec3(0.0) : force;
  for (; other < 7.5; other += 1.0) {
    vec3 moved = level_at(from, p + corner_of(other)).xyz;
    force = more_masked_force(force, texel, moved.x);
    force = more_masked_force(force, texel + vec2(1.0, 0.0), moved.y);
    force = more_masked_force(force, texel + vec2(2.0, 0.0), moved.z);
    texel.x += 3.0;
  }
#endif
  return force;
}

// Of the cells around: along x, then y, then z.
vec3 force_at(vec3 p) {
  vec3 sum = vec3(0.0);
  for (float z = 1.0; z > -0.5; z -= 1.0) {
    vec3 slab = vec3(0.0);
    for (float y = 1.0; y > -0.5; y -= 1.0) {
      vec3 line = vec3(0.0);
      for (float x = 1.0; x > -0.5; x -= 1.0) {
        line += force_of_cell(p - vec3(x, y, z), vec3(x, y, z));
      }
      slab += line;
    }
    sum += slab;
  }
  return sum;
}

vec3 relaxed_site(vec3 displacement, vec3 p, vec3 residual) {
  vec4 entries = level_at(response[0], p);
  vec4 more = level_at(response[1], p);
  return vec3(
      relaxed_in_volume(displacement.x, entries.x, residual.x, entries.y, residual.y, entries.z, residual.z),
      relaxed_in_volume(displacement.y, entries.w, residual.y, entries.y, residual.x, more.x, residual.z),
      relaxed_in_volume(displacement.z, more.y, residual.z, entries.z, residual.x, more.x, residual.y));
}

// A component, by those of the coarse sites in two slices.
float corrected(float value, vec3 odd, vec4 near, vec4 far) {
  float one = corrected_by_one(value, near.x);
  float two = corrected_by_two(value, near.x, far.w);
  float four =
      corrected_by_four(value, near.x, odd.x > 0.5 ? near.y : near.z, odd.z > 0.5 ? far.x : near.z, far.w);
  float eight = corrected_by_eight(value, near.x, near.y, near.z, near.w, far.x, far.y, far.z, far.w);
  float count = odd.x + odd.y + odd.z;
  return count > 2.5 ? eight : count > 1.5 ? four : count > 0.5 ? two : one;
}

vec3 coarse_at(vec3 p) { return texture2DRect(second, texel_of(p, second_slices)).xyz; }

// By the coarse sites around, some of which may be one; `odd`: 0 or 1. The first one is at p.
vec3 corrected_site(vec3 value, vec3 odd, vec3 p) {
  vec3 x = vec3(odd.x, 0.0, 0.0);
  vec3 y = vec3(0.0, odd.y, 0.0);
  vec3 z = vec3(0.0, 0.0, odd.z);
  vec3 c000 = coarse_at(p);
  vec3 c100 = coarse_at(p + x);
  vec3 c010 = coarse_at(p + y);
  vec3 c110 = coarse_at(p + x + y);
  vec3 c001 = coarse_at(p + z);
  vec3 c101 = coarse_at(p + x + z);
  vec3 c011 = coarse_at(p + y + z);
  vec3 c111 = coarse_at(p + odd);
  return vec3(corrected(value.x, odd, vec4(c000.x, c100.x, c010.x, c110.x), vec4(c001.x, c101.x, c011.x, c111.x)),
              corrected(value.y, odd, vec4(c000.y, c100.y, c010.y, c110.y), vec4(c001.y, c101.y, c011.y, c111.y)),
              corrected(value.z, odd, vec4(c000.z, c100.z, c010.z, c110.z), vec4(c001.z, c101.z, c011.z, c111.z)));
}
