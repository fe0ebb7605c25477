"use strict";
// Follows a scene on the GPU beside scalar: every site, after every sweep. page.js shows what comes of it.

/** Returns the bytes of base64 text, and the floats. */
function bytes_of(text) { return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)); }
function floats(text) { return new Float32Array(bytes_of(text).buffer); }

/** scalar.cpp, compiled to WebAssembly. */
class Scalar {
  constructor(module) {
    this.calls = module.exports;
    if (this.calls._initialize) { this.calls._initialize(); }
  }

  /** A view of the module's memory, good until the next load(). */
  view(pointer, length) { return new Float32Array(this.calls.memory.buffer, pointer, length); }

  load(scene, level) {
    const calls = this.calls;
    calls.load(level.width, level.height, scene.rule, scene.update, scene.penalty, scene.seed);
    calls.set_strengths(this.give(level.strengths), level.strengths.length);
    calls.set_steps(this.give(scene.steps), scene.steps.length);
    const sites = level.width * level.height;
    for (let i = 0; i * sites < level.arrays.length; ++i) {
      this.view(calls.array(i), sites).set(level.arrays.subarray(i * sites, (i + 1) * sites));
    }
    this.find(sites);
  }

  /** A pointer to a copy in the module's memory, good until the next call. */
  give(values) {
    const pointer = this.calls.scratch(values.length);
    this.view(pointer, values.length).set(values);
    return pointer;
  }

  /** The newest field: a sweep swaps two, and growing moves the memory. */
  find(sites) {
    this.x = this.view(this.calls.array(0), sites);
    this.y = this.view(this.calls.array(1), sites);
  }

  turn(number) { return Float32Array.from(this.view(this.calls.turn(number), 4)); }

  sweep(number, sites) {
    const changed = this.calls.sweep(number);
    this.find(sites);
    return changed;
  }
}

/** What is given to a GPU: four numbers a site, in three arrays. `texels` are what comes back. */
class Gpu {
  pack(level) {
    const sites = level.width * level.height;
    const at = (array, i) => (level.arrays.length > array * sites ? level.arrays[array * sites + i] : 0);
    const texels = (...arrays) => {
      const data = new Float32Array(4 * sites);
      for (let i = 0; i < sites; ++i) {
        arrays.forEach((array, k) => { data[4 * i + k] = at(array, i); });
      }
      return data;
    };
    this.level = level;
    this.texels = new Float32Array(4 * sites);
    this.image = texels(0, 1, 3);
    return [texels(4, 5, 2), texels(6, 7, 8, 9)]; // observation, confidence
  }

  /** A displacement in the image. */
  set_field(x, y) {
    for (let i = 0; i < x.length; ++i) {
      this.image[4 * i] = x[i];
      this.image[4 * i + 1] = y[i];
    }
  }
}

/** The thesis's design: a fragment shader and two float textures that take turns. */
class FragmentGpu extends Gpu {
  /** Throws an Error that says what the browser lacks. `missing` are names of what to do without. */
  constructor(canvas, missing) {
    super();
    this.backend = "webgl-fragment";
    this.language = "GLSL ES 3.00 fragment shader";
    const gl = missing.includes("webgl2") ? null : canvas.getContext("webgl2", { antialias: false, depth: false });
    if (!gl) { throw new Error("this browser has no WebGL 2"); }
    if (missing.includes("EXT_color_buffer_float") || !gl.getExtension("EXT_color_buffer_float")) {
      throw new Error("this browser cannot draw into float textures (EXT_color_buffer_float)");
    }
    const names = gl.getExtension("WEBGL_debug_renderer_info");
    this.device = gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    this.driver = gl.getParameter(gl.VERSION);
    this.largest = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    this.gl = gl;
    this.programs = new Map();
    this.framebuffer = gl.createFramebuffer();
  }

  program(fragment) {
    const found = this.programs.get(fragment);
    if (found) { return found; }
    const gl = this.gl;
    const program = gl.createProgram();
    const vertex = "#version 300 es\nvoid main() {\n" +
      "  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);\n}\n";
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        throw new Error("the shader does not compile: " + gl.getShaderInfoLog(shader));
      }
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error("the shader does not link: " + gl.getProgramInfoLog(program));
    }
    this.programs.set(fragment, program);
    return program;
  }

  texture(width, height, texels) {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, height, 0, gl.RGBA, gl.FLOAT, texels);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  load(scene, level) {
    const gl = this.gl;
    [this.read_from, this.drawn_to, this.observation, this.confidence].forEach((old) => gl.deleteTexture(old || null));
    const [observation, confidence] = this.pack(level);
    this.read_from = this.texture(level.width, level.height, this.image);
    this.drawn_to = this.texture(level.width, level.height, null);
    this.observation = this.texture(level.width, level.height, observation);
    this.confidence = this.texture(level.width, level.height, confidence);
    const program = this.program(scene.shader);
    gl.useProgram(program);
    const place = (name) => gl.getUniformLocation(program, name);
    ["image", "observation", "confidence"].forEach((name, unit) => gl.uniform1i(place(name), unit));
    gl.uniform2i(place("dimension"), level.width, level.height);
    gl.uniform1f(place("penalty"), scene.penalty);
    gl.uniform1fv(place("steps"), Float32Array.from({ length: 16 }, (_, i) => scene.steps[i] || 0));
    this.turn = place("turn");
  }

  write(x, y) {
    this.set_field(x, y);
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, this.read_from);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, this.level.width, this.level.height, gl.RGBA, gl.FLOAT, this.image);
  }

  /** A number for each case of probe.inc, which are eight numbers. */
  evaluate(cases) {
    const gl = this.gl;
    const count = cases.length / 8;
    const [asked, answers] = [this.texture(2, count, cases), this.texture(1, count, null)];
    gl.useProgram(this.program(page_data.probe));
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, answers, 0);
    gl.bindTexture(gl.TEXTURE_2D, asked);
    gl.viewport(0, 0, 1, count);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const texels = new Float32Array(4 * count);
    gl.readPixels(0, 0, 1, count, gl.RGBA, gl.FLOAT, texels);
    return texels.filter((_, i) => i % 4 === 0);
  }

  sweep(turn) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.drawn_to, 0);
    [this.read_from, this.observation, this.confidence].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.viewport(0, 0, this.level.width, this.level.height);
    gl.uniform4fv(this.turn, turn);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    [this.read_from, this.drawn_to] = [this.drawn_to, this.read_from];
  }

  /** rg of every texel is the displacement. Waits for all that was drawn. */
  read() {
    const gl = this.gl;
    gl.readPixels(0, 0, this.level.width, this.level.height, gl.RGBA, gl.FLOAT, this.texels);
    const error = gl.getError();
    if (error !== gl.NO_ERROR) { throw new Error("WebGL error 0x" + error.toString(16)); }
    return this.texels;
  }
}

/** FNV-1a over extent, x, y, as harness/check/golden.cpp has it: sixteen hexadecimal digits. */
function state_hash(width, height, x, y) {
  let hash = 0xcbf29ce484222325n;
  const add = (word) => {
    for (let byte = 0; byte < 4; ++byte) {
      hash = BigInt.asUintN(64, (hash ^ BigInt((word >>> (8 * byte)) & 0xff)) * 0x100000001b3n);
    }
  };
  add(width);
  add(height);
  for (const component of [x, y]) {
    const words = new Uint32Array(Float32Array.from(component, (value) => value + 0).buffer); // -0 + 0 is 0
    words.forEach(add);
  }
  return hash.toString(16).padStart(16, "0");
}

/** An object like a row of `verify`'s results, before anything was compared. */
function new_row(scene, gpu, mode) {
  return {
    scene: scene.name, width: scene.width, height: scene.height, backend: gpu.backend, device: gpu.device, mode,
    levels: 0,
    method: scene.method, iterations: 0, sweeps: 0, sites_compared: 0, sites_differing: 0, not_finite: 0,
    counts_differing: 0, certified_ties: 0, uncertified: 0, max_abs_difference: 0, first_difference: null, tier: "none",
    verdict: "skipped", reason: "", sites_drifted: 0, largest_gap_over_bound: 0, sites_at_rest: 0
  };
}

/** Counts a site whose numbers are not scalar's; `place` says where it is. */
function count_difference(row, expected, found, place) {
  ++row.sites_differing;
  row.not_finite += found.every(Number.isFinite) ? 0 : 1;
  const distance = Math.max(...found.map((value, i) => Math.abs(value - expected[i])));
  row.max_abs_difference = Math.max(row.max_abs_difference, distance);
  row.first_difference = row.first_difference || { ...place, expected, found, certified: false, gap_over_bound: null };
}

/** One sweep's field against scalar's. */
function compare(row, scalar, texels, level, iteration) {
  const sites = level.width * level.height;
  row.sites_compared += sites;
  for (let i = 0; i < sites; ++i) {
    const found = [texels[4 * i], texels[4 * i + 1]];
    if (found[0] === scalar.x[i] && found[1] === scalar.y[i]) { continue; }
    count_difference(row, [scalar.x[i], scalar.y[i]], found,
      { level: level.index, iteration, x: i % level.width, y: Math.floor(i / level.width) });
  }
}

/** Sets the verdict. `moved`: whether anything had to be computed. */
function conclude_row(row, moved, exact) {
  row.sites_drifted = row.uncertified = row.sites_differing;
  if (row.reason) {
    row.verdict = "mistrusted";
  } else if (row.sites_differing + row.counts_differing > 0) {
    row.verdict = "disagree";
  } else if (!moved) {
    row.verdict = "mistrusted";
    row.reason = "no site ever moved, so a device that does nothing would pass";
  } else {
    row.verdict = "agree";
    row.tier = exact ? "exact" : "bitwise";
  }
}

/** Follows a scene in one mode; `step` is called after every level and may wait. Returns the row; row.fields are the
    last fields of both, for pictures. */
async function follow(scalar, gpu, scene, mode, step) {
  const row = new_row(scene, gpu, mode);
  if (Math.max(scene.width, scene.height) > gpu.largest) {
    row.reason = "fields here are at most " + gpu.largest + " sites a side";
    return row;
  }
  let moves = 0;
  for (const level of scene.levels) {
    scalar.load(scene, level);
    gpu.load(scene, level);
    for (let sweep = 0; sweep < level.sweeps; ++sweep) {
      if (mode === "resync") { gpu.write(scalar.x, scalar.y); }
      gpu.sweep(scalar.turn(sweep));
      moves += scalar.sweep(sweep, level.width * level.height);
      compare(row, scalar, await gpu.read(), level, 1 + Math.floor(sweep / scene.sweeps_per_iteration));
      ++row.sweeps;
    }
    ++row.levels;
    row.iterations = row.sweeps / scene.sweeps_per_iteration;
    const hash = state_hash(level.width, level.height, scalar.x, scalar.y);
    if (hash !== level.hash) {
      row.reason = "scalar in WebAssembly ends level " + level.index + " with " + hash +
        ", on the machine that wrote this page with " + level.hash;
    }
    await step(row, level);
  }
  conclude_row(row, moves > 0, scene.exact);
  row.fields = { scalar: [Float32Array.from(scalar.x), Float32Array.from(scalar.y)], gpu: Float32Array.from(gpu.texels) };
  return row;
}
