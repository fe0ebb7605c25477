#version 430
#extension GL_GOOGLE_include_directive : require

// The forces of tissues with laws of large strains (laws.h): numbers of a site are texels, displacements and forces of an
// image of two.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_NUMBER(value) float(value)
#define HDM_CONSTANT const
#define HDM_STRUCT(name)
#define HDM_BITS_LESS(number, x) intBitsToFloat(number - floatBitsToInt(x))

#include "law_steps.h"

#ifdef VULKAN // with HDM_AXES
layout(constant_id = 0) const int STEP = 0;
layout(constant_id = 1) const int FIBRES = 0;
layout(local_size_x_id = 2) in;
layout(constant_id = 3) const int COLUMNS = 1;
layout(push_constant) uniform Told { int told[32]; };
#define samplerBuffer textureBuffer
const int LANES = int(gl_WorkGroupSize.x);
#else // the others supplied after #version
layout(local_size_x = LANES) in;
layout(location = 0) uniform int told[32];
#endif

#if HDM_AXES == 3
#define COMPONENTS rgba32f
#define TEXEL(c) vec4(c.along[0], c.along[1], c.along[2], 0.0)
#else
#define COMPONENTS rg32f
#define TEXEL(c) vec4(c.along[0], c.along[1], 0.0, 0.0)
#endif
layout(binding = LAW_STORED, COMPONENTS) uniform restrict writeonly imageBuffer stored;
layout(std430, binding = LAW_SITE_BITS) readonly buffer SiteBits { int site_bits[]; };
layout(std430, binding = LAW_SHARES) buffer Shares { int shares[]; };
layout(std430, binding = LAW_LEAST_OF_ITEMS) writeonly buffer LeastOfItems { int least_of_items[]; };
layout(binding = LAW_DISPLACEMENT) uniform samplerBuffer displacement;
layout(binding = LAW_TISSUE) uniform samplerBuffer tissues;
layout(binding = LAW_FORCES) uniform samplerBuffer forces;
layout(binding = LAW_FIBRES) uniform samplerBuffer fibres;

#define SIDE_BY_SIDE
#define ARRAYS
#define WITH_ARRAYS
#define GET(c, fetched)            \
  {                                \
    vec4 texel = fetched;          \
    EACH_AXIS {                    \
      c.along[axis] = texel[axis]; \
    }                              \
  }
#define TOLD(i) told[i]
#define REAL_TOLD(i) intBitsToFloat(told[i])
#define BITS_OF(value) floatBitsToInt(value)
#define REAL_OF(bits) intBitsToFloat(bits)
#define GET_DISPLACEMENT(c, i) GET(c, texelFetch(displacement, i))
#define TISSUE(site, number) texelFetch(tissues, site)[number]
#define FIBRE(site, number) texelFetch(fibres, site)[number]
#define SITE_BITS(site) site_bits[site]
#define GET_FORCE(c, cell, corner) GET(c, texelFetch(forces, 8 * (cell) + (corner)))
#define STORE_FORCE(cell, corner, components)                  \
  {                                                            \
    Components c = components;                                 \
    imageStore(stored, 8 * (cell) + (corner), TEXEL(c));       \
  }
#define STORE_SITE(i, components) imageStore(stored, i, TEXEL(components));
#define SHARE(cell) shares[cell]
#define STORE_SHARE(cell, bits) shares[cell] = bits;
#define STORE_LEAST(item, bits, site)               \
  least_of_items[2 * (TOLD(19) + (item))] = bits;   \
  least_of_items[2 * (TOLD(19) + (item)) + 1] = site;

#include "laws.h"

void main() {
  int group = int(gl_WorkGroupID.y) * int(gl_NumWorkGroups.x) + int(gl_WorkGroupID.x);
  do_share(group * LANES + int(gl_LocalInvocationID.x), int(gl_NumWorkGroups.y) * int(gl_NumWorkGroups.x) * LANES);
}
