#version 430
#extension GL_GOOGLE_include_directive : require

// A step of the elastic energy of a volume (elastic_volume.h): numbers of a site are texels of four, or two of them.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_NUMBER(value) float(value)

#include "elastic_steps.h"

#ifdef VULKAN
layout(constant_id = 0) const int STEP = 0;
layout(constant_id = 1) const int HAS_LOAD = 0;
layout(constant_id = 2) const int IS_IMAGE = 0;
layout(constant_id = 3) const int BY_LIST = 0;
layout(local_size_x_id = 4) in;
layout(constant_id = 5) const int ROWS = 1;
layout(constant_id = 6) const int COLUMNS = 1;
const int LANES = int(gl_WorkGroupSize.x);
layout(push_constant) uniform Parameters { int parameters[23]; };
#define samplerBuffer textureBuffer
#else // the others supplied after #version
layout(local_size_x = LANES) in;
layout(location = 0) uniform int parameters[23];
#endif

layout(binding = ELASTIC_STORED, rgba32f) uniform restrict writeonly imageBuffer stored;
layout(binding = ELASTIC_FROM) uniform samplerBuffer from;
layout(binding = ELASTIC_SECOND) uniform samplerBuffer second;
layout(binding = ELASTIC_MOMENTS) uniform samplerBuffer moments;
layout(binding = ELASTIC_MORE) uniform samplerBuffer more;
layout(binding = ELASTIC_RESPONSE) uniform samplerBuffer response;
layout(binding = ELASTIC_MATRICES) uniform samplerBuffer matrices;
layout(binding = ELASTIC_INVERSE) uniform samplerBuffer inverse;
layout(binding = ELASTIC_TOUCHED) uniform samplerBuffer touched;

#define ARRAYS
#define WITH_ARRAYS
#define COUNT(left) COLUMNS
#define SITES_SIDE_BY_SIDE
#define WORD(i) parameters[i]
#define REAL_WORD(i) intBitsToFloat(parameters[i])
#define FROM(i, axis) texelFetch(from, i)[axis]
#define SECOND(i, axis) texelFetch(second, i)[axis]
#define TOUCHED(i, axis) texelFetch(touched, i)[axis]
#define RESPONSE(i, entry) texelFetch(response, 2 * (i) + (entry) / 4)[(entry) % 4]
#define MODULUS(i) texelFetch(more, i).x
#define MATRIX_NUMBER(i) texelFetch(more, i).y
#define MOMENT(i, number) texelFetch(moments, 6 * ((i) - moments_from) + (number) / 4)[(number) % 4]
#define MATRIX(number, column, corner, axis) texelFetch(matrices, (number) * 192 + (column) * 8 + (corner))[axis]
#define INVERSE(column, sites, site, axis) texelFetch(inverse, (column) * (sites) + (site))[axis]
#define STORE(i, x, y, z) imageStore(stored, i, vec4(x, y, z, 0.0))
#define int_of(value) int(value)

#include "elastic_volume.h"

void main() {
  int group = int(gl_WorkGroupID.y) * int(gl_NumWorkGroups.x) + int(gl_WorkGroupID.x);
  do_item(group * LANES + int(gl_LocalInvocationID.x));
}
