// Loops that probe and measure a device; backends/session/device_loops.cpp knows what comes out. An item that measures has
// eight texels, so that a CPU has wide vectors and enough of them under way.

#include "language.cl"
#include "level_passes.h"
#include "probe.inc"

// What the components of four texels begin with.
float16 begin(float16 given) {
  float4 component = (float4)(0.0f, 1.0f, 2.0f, 3.0f);
  return (float16)(given.s0 + component, given.s4 + component, given.s8 + component, given.sc + component);
}

#define STEP(chain) chain = chain * factor + term;
#define ROUND STEP(a) STEP(b) STEP(c) STEP(d) STEP(e) STEP(f)

kernel void loop(__global const float16* source, __global float16* target) {
  size_t i = 2 * get_global_id(0);
#if LOOP == LOOP_PROBE
  float8 given = ((__global const float8*)source)[get_global_id(0)]; // a, b, c, d; e, operation
  float result = probed(given.s5, given.s0, given.s1, given.s2, given.s3, given.s4);
  ((__global float4*)target)[get_global_id(0)] = (float4)(result, 0.0f, 0.0f, 0.0f);
#elif LOOP == LOOP_COPY
  target[i] = source[i];
  target[i + 1] = source[i + 1];
#else
  float factor = source[i].s2;
  float term = source[i].s3;
  float16 a = begin(source[i]);
  float16 b = a + 4.0f;
  float16 c = a + 8.0f;
  float16 d = begin(source[i + 1]);
  float16 e = d + 4.0f;
  float16 f = d + 8.0f;
  for (int round = 0; round < 64; ++round) {
    ROUND ROUND ROUND ROUND ROUND ROUND ROUND ROUND
  }
  ROUND
  target[i] = a + b + c;
  target[i + 1] = d + e + f;
#endif
}
