#version 430
#extension GL_GOOGLE_include_directive : require

// Steps of the elastic energy (elastic_sites.h): numbers of a site are texels of four, its components of an image of two.
// Several steps in one work group are done in a buffer that is read and written, so that no dispatch is between them.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_NUMBER(value) float(value)

#include "elastic_steps.h"

#ifdef VULKAN // with HDM_AXES and TOGETHER
layout(constant_id = 1) const int STEP = 0;
layout(constant_id = 2) const int HAS_LOAD = 0;
layout(constant_id = 3) const int IS_IMAGE = 0;
layout(constant_id = 4) const int BY_LIST = 0;
layout(local_size_x_id = 5) in;
layout(constant_id = 6) const int ROWS = 1;
layout(constant_id = 7) const int COLUMNS = 1;
layout(constant_id = 8) const int BOXES = 0;
layout(constant_id = 9) const int HALVED = 7;
const int LANES = int(gl_WorkGroupSize.x);
layout(push_constant) uniform Told { int told[32]; };
#define samplerBuffer textureBuffer
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
layout(binding = ELASTIC_STORED, COMPONENTS) uniform restrict writeonly imageBuffer stored;
layout(binding = ELASTIC_STORED_SECOND, COMPONENTS) uniform restrict writeonly imageBuffer stored_second;
layout(binding = ELASTIC_STORED_THIRD, COMPONENTS) uniform restrict writeonly imageBuffer stored_third;
layout(binding = ELASTIC_KEPT, COMPONENTS) uniform coherent imageBuffer kept; // three fields of coarse levels
layout(std430, binding = ELASTIC_TOUCHED) readonly buffer Touched { int touched[]; };
layout(binding = ELASTIC_FROM) uniform samplerBuffer from;
layout(binding = ELASTIC_SECOND) uniform samplerBuffer second;
layout(binding = ELASTIC_THIRD) uniform samplerBuffer third;
layout(binding = ELASTIC_MOMENTS) uniform samplerBuffer moments;
layout(binding = ELASTIC_RESPONSE) uniform samplerBuffer response;
layout(binding = ELASTIC_MATRICES) uniform samplerBuffer matrices;
layout(binding = ELASTIC_INVERSE) uniform samplerBuffer inverse;

#define ARRAYS
#define WITH_ARRAYS
#define COUNT(left, columns) columns
#define IS_THERE(column) ((column) < work.place.width)
#define SITES_SIDE_BY_SIDE
#define ONLY_WHERE(condition)
#define MY(name) work.name
#define WORK_OF_ITEM Work work;
#define GET(c, fetched)            \
  {                                \
    vec4 texel = fetched;          \
    EACH_AXIS {                    \
      c.along[axis] = texel[axis]; \
    }                              \
  }
#define TOLD(i) told[i]
#define CODE_TOLD(number) told[12 + (number)]
#define REAL_TOLD(i) intBitsToFloat(told[i])
#define NUMBER_OF(array, texels, i, entry) texelFetch(array, (texels) * (i) + (entry) / 4)[(entry) % 4]
#define RESPONSE(i, entry) NUMBER_OF(response, HDM_AXES - 1, base + (i), entry)
#define MOMENT(i, number) NUMBER_OF(moments, 4 * HDM_AXES - 6, base + (i) - moments_from, number)
#define MATRIX(block, number) NUMBER_OF(matrices, (HDM_AXES * HDM_AXES + 3) / 4, block, number)
#define GET_INVERSE(c, i) GET(c, texelFetch(inverse, i))
#define TOUCHED(i) touched[i]
#if TOGETHER == 0
#define DIVIDED(number, by) ((number) / (by))
#define SITE_COLUMNS COLUMNS
#define SITE_ROWS ROWS
#define GET_FROM(c, i) GET(c, texelFetch(from, i))
#define GET_SECOND(c, i) GET(c, texelFetch(second, i))
#define STORE(i, components) imageStore(stored, i, TEXEL(components));
#else
// By floats, exact for so few: whole numbers are divided slowly.
int divided(int number, int by) {
  precise float quotient = (float(number) + 0.5) / float(by);
  return int(quotient);
}
#define DIVIDED(number, by) divided(number, by)
#define SITE_COLUMNS 1
#define SITE_ROWS 1
#define KEPT(slot, i) (work.slot * ELASTIC_COARSE_SITES + (i))
#define GET_FROM(c, i) GET(c, imageLoad(kept, KEPT(from_slot, i)))
#define GET_SECOND(c, i) GET(c, imageLoad(kept, KEPT(second_slot, i)))
#define STORE(i, components) imageStore(kept, KEPT(stored_slot, i), TEXEL(components));
#endif
#define WAIT_FOR_ALL     \
  memoryBarrierImage();  \
  barrier()

#include "elastic_sites.h"

void main() {
  int lane = int(gl_LocalInvocationID.x);
#if TOGETHER == 0
  int group = int(gl_WorkGroupID.y) * int(gl_NumWorkGroups.x) + int(gl_WorkGroupID.x);
  do_share(group * LANES + lane, int(gl_NumWorkGroups.y) * int(gl_NumWorkGroups.x) * LANES);
#else
  for (int i = lane; i < TOLD(6); i += LANES) {
    imageStore(kept, i, texelFetch(from, base + i));
    imageStore(kept, ELASTIC_COARSE_SITES + i, texelFetch(second, base + i));
    imageStore(kept, 2 * ELASTIC_COARSE_SITES + i, texelFetch(third, base + i));
  }
  WAIT_FOR_ALL;
  do_share(lane, LANES);
  for (int i = lane; i < TOLD(6); i += LANES) {
    imageStore(stored, base + i, imageLoad(kept, i));
    imageStore(stored_second, base + i, imageLoad(kept, ELASTIC_COARSE_SITES + i));
    imageStore(stored_third, base + i, imageLoad(kept, 2 * ELASTIC_COARSE_SITES + i));
  }
#endif
}
