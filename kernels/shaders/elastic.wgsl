// A step of the elastic energy as WebGPU computes it. What elastic.wgsl.in has stands before this, as WGSL. The constants are
// those of ElasticKernel and of how work is shared out, by their names in elastic_sites.h.

override STEP: i32;
override HAS_LOAD: i32;
override IS_IMAGE: i32;
override BY_LIST: i32;
override BOXES: i32;
override HALVED: i32;
override LANES: i32;

// The arrays of elastic_steps.h, by their numbers there.
@group(0) @binding(0) var<storage, read_write> stored: array<f32>;
@group(0) @binding(4) var<storage, read> touched: array<i32>;
@group(0) @binding(7) var<storage, read> fetched: array<f32>;
@group(0) @binding(8) var<storage, read> fetched_second: array<f32>;
@group(0) @binding(10) var<storage, read> moments: array<f32>;
@group(0) @binding(11) var<storage, read> response: array<f32>;
@group(0) @binding(12) var<storage, read> matrices: array<f32>;
@group(0) @binding(13) var<storage, read> inverse: array<f32>;
@group(0) @binding(15) var<uniform> told: array<vec4<i32>, 8>;

fn word_told(i: i32) -> i32 { return told[i / 4][i % 4]; }
fn real_told(i: i32) -> f32 { return bitcast<f32>(word_told(i)); }
// The last word is 1. WGSL has no word against making one constant of two, whose product is then rounded otherwise: what is
// multiplied by a number that is told is none to a compiler.
fn constant_of(value: f32) -> f32 { return value * real_told(31); }

@compute @workgroup_size(LANES) fn take_step(@builtin(workgroup_id) group: vec3<u32>,
                                             @builtin(num_workgroups) groups: vec3<u32>,
                                             @builtin(local_invocation_index) lane: u32) {
  let before = i32(group.y * groups.x + group.x) * LANES;
  do_share(before + i32(lane), i32(groups.y * groups.x) * LANES);
}
