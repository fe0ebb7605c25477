// probe.inc, a work item for each case. Compiled after language.cl and probe.inc.

kernel void probe(global const float4* source, global float4* target) {
  size_t index = get_global_id(0);
  float4 first = source[2 * index];
  float4 second = source[2 * index + 1];
  target[index] = (float4)(probed(second.y, first.x, first.y, first.z, first.w, second.x), 0.0f, 0.0f, 0.0f);
}
