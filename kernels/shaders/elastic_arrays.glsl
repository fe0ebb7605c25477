// The language and the arrays of elastic.comp and elastic_coarse.comp; backends/session/elastic_steps.hpp says how they lie.

#define real float
#define HDM_FUNCTION
#define HDM_PRECISE precise
#define HDM_NUMBER(value) float(value)

#include "elastic_steps.h"

#ifdef VULKAN
#define samplerBuffer textureBuffer
#endif
const int COLUMNS = ELASTIC_COLUMNS;

layout(binding = ELASTIC_STORED, rg32f) uniform restrict writeonly imageBuffer stored;
layout(binding = ELASTIC_FROM) uniform samplerBuffer from;
layout(binding = ELASTIC_SECOND) uniform samplerBuffer second;
layout(binding = ELASTIC_MOMENTS) uniform samplerBuffer moments;
layout(binding = ELASTIC_MORE) uniform samplerBuffer more;
layout(binding = ELASTIC_RESPONSE) uniform samplerBuffer response;
layout(binding = ELASTIC_MATRICES) uniform samplerBuffer matrices;
layout(binding = ELASTIC_INVERSE) uniform samplerBuffer inverse;
layout(binding = ELASTIC_TOUCHED) uniform samplerBuffer touched; // ElasticArrays::listed_sites()

#include "elastic/cell.inc"
#include "elastic/site.inc"

vec4 matrix_at(float number, int i) { return texelFetch(matrices, int(number) * 16 + i); }

#include "elastic.glsl"
