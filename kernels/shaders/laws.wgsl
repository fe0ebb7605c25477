// A step of laws.h as WebGPU computes it. What laws.wgsl.in has stands before this, as WGSL.

override STEP: i32;
override FIBRES: i32;
override LANES: i32;

// The arrays of law_steps.h, by their numbers there.
@group(0) @binding(0) var<storage, read_write> stored: array<f32>;
@group(0) @binding(4) var<storage, read> site_bits: array<i32>;
@group(0) @binding(5) var<storage, read_write> shares: array<i32>;
@group(0) @binding(6) var<storage, read_write> least_of_items: array<i32>;
@group(0) @binding(7) var<storage, read> displacement: array<f32>;
@group(0) @binding(8) var<storage, read> tissues: array<f32>;
@group(0) @binding(9) var<storage, read> forces: array<f32>;
@group(0) @binding(10) var<storage, read> fibres: array<f32>;
@group(0) @binding(15) var<uniform> told: array<vec4<i32>, 8>;

fn word_told(i: i32) -> i32 { return told[i / 4][i % 4]; }
fn real_of(bits: i32) -> f32 { return bitcast<f32>(bits); }
fn bits_of(value: f32) -> i32 { return bitcast<i32>(value); }

@compute @workgroup_size(LANES) fn take_step(@builtin(workgroup_id) group: vec3<u32>,
                                             @builtin(num_workgroups) groups: vec3<u32>,
                                             @builtin(local_invocation_index) lane: u32) {
  let before = i32(group.y * groups.x + group.x) * LANES;
  do_share(before + i32(lane), i32(groups.y * groups.x) * LANES);
}
