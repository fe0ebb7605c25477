// One sweep as WebGPU computes it. What texts.wgsl.in has stands before this, as WGSL.

override rule: i32;
override colours: i32;
override step_count: i32;

struct Told {
  size: vec2<i32>,
  penalty: f32,
  unused: f32,
  turn: vec4<f32>, // colour, strength, number, seed of update.inc's Sweep
  steps: array<vec4<f32>, 4>,
}

// Four numbers a site, as the textures of sweep.webgl.frag have them.
@group(0) @binding(0) var<storage, read> image: array<vec4<f32>>;       // displacement, 1 / modulus, handed on
@group(0) @binding(1) var<storage, read> observation: array<vec4<f32>>; // target, modulus
@group(0) @binding(2) var<storage, read> confidence: array<vec4<f32>>;  // of x and y, 1 / curvature where the rule needs it
@group(0) @binding(3) var<storage, read_write> swept: array<vec4<f32>>;
@group(0) @binding(4) var<uniform> told: Told;

fn neighbour(at: vec2<i32>, x: i32, y: i32) -> vec4<f32> {
  let other = at + vec2<i32>(x, y);
  let inside = all(other >= vec2<i32>(0)) && all(other < told.size);
  let site = select(at, other, inside);
  return image[site.y * told.size.x + site.x];
}

fn site_at(at: vec2<i32>, index: i32) -> Site {
  let nw = neighbour(at, -1, -1);
  let n = neighbour(at, 0, -1);
  let ne = neighbour(at, 1, -1);
  let w = neighbour(at, -1, 0);
  let c = image[index];
  let e = neighbour(at, 1, 0);
  let sw = neighbour(at, -1, 1);
  let s = neighbour(at, 0, 1);
  let se = neighbour(at, 1, 1);
  let seen = observation[index];
  let sure = confidence[index];
  var site: Site;
  site.dx = Neighbours(nw.x, n.x, ne.x, w.x, c.x, e.x, sw.x, s.x, se.x);
  site.dy = Neighbours(nw.y, n.y, ne.y, w.y, c.y, e.y, sw.y, s.y, se.y);
  site.inverse_modulus = Neighbours(nw.z, n.z, ne.z, w.z, c.z, e.z, sw.z, s.z, se.z);
  site.modulus = seen.z;
  site.target_x = seen.x;
  site.target_y = seen.y;
  site.confidence_x = sure.x;
  site.confidence_y = sure.y;
  site.penalty = told.penalty;
  site.inverse_curvature_x = sure.z;
  site.inverse_curvature_y = sure.w;
  return site;
}

@compute @workgroup_size(8, 8) fn sweep(@builtin(global_invocation_id) id: vec3<u32>) {
  let at = vec2<i32>(id.xy);
  if (any(at >= told.size)) {
    return;
  }
  let index = at.y * told.size.x + at.x;
  var steps: array<f32, 16>;
  for (var i = 0; i < 16; i++) {
    steps[i] = told.steps[i / 4][i % 4];
  }
  let next = swept_displacement(rule, colours, true, site_at(at, index), Position(f32(at.x), f32(at.y)),
                                Sweep(told.turn.x, told.turn.y, told.turn.z, told.turn.w), steps, step_count);
  swept[index] = vec4<f32>(next.x, next.y, image[index].z, 0.0);
}

// A case of probe.inc is two vectors: a, b, c, d; e, operation.
@group(0) @binding(0) var<storage, read> cases: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;

@compute @workgroup_size(16) fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x < arrayLength(&results)) {
    let first = cases[2 * id.x];
    let second = cases[2 * id.x + 1];
    results[id.x] = probed(second.y, first.x, first.y, first.z, first.w, second.x);
  }
}
