// WebGPU: the sweep, of which a site is an invocation and two buffers take turns, and what elastic.js asks.

class ComputeGpu extends Gpu {
  /** Throws an Error that says what the browser lacks. */
  static async open(codes, missing) {
    const api = missing.includes("webgpu") ? null : navigator.gpu;
    const adapter = api ? await api.requestAdapter() : null;
    if (!adapter) { throw new Error("this browser has no WebGPU"); }
    return new ComputeGpu(adapter.info, await adapter.requestDevice(), codes);
  }

  /** `codes`: WGSL by name. */
  constructor(info, device, codes) {
    super();
    this.backend = "webgpu-compute";
    this.language = "WGSL compute shader";
    this.device = [info.vendor, info.architecture, info.description].filter(Boolean).join(" ") || "a GPU without a name";
    this.driver = "WebGPU";
    this.largest = Math.floor(Math.sqrt(device.limits.maxStorageBufferBindingSize / 16)); // of four floats a site
    this.gpu = device;
    this.codes = codes;
    this.modules = new Map();
    this.pipelines = new Map();
    this.module = this.module_of("sweep");
    this.buffers = [];
    this.error = "";
    device.onuncapturederror = (event) => { this.error = this.error || event.error.message; };
    device.lost.then((lost) => { this.error = this.error || "the device was lost: " + lost.message; });
  }

  module_of(name) {
    if (!this.modules.has(name)) {
      this.modules.set(name, this.gpu.createShaderModule({ code: this.codes[name] }));
    }
    return this.modules.get(name);
  }

  /** Returns the program of this name with these constants, and the bindings that it has. */
  pipeline_of(name, constants) {
    const key = name + JSON.stringify(constants);
    if (!this.pipelines.has(key)) {
      this.pipelines.set(key, {
        pipeline: this.gpu.createComputePipeline({ layout: "auto",
          compute: { module: this.module_of(name), entryPoint: "take_step", constants } }),
        bindings: new Set([...this.codes[name].matchAll(/@binding\((\d+)\)/g)].map((match) => Number(match[1])))
      });
    }
    return this.pipelines.get(key);
  }

  /** Gives all buffers back. */
  forget() {
    this.buffers.forEach((old) => old.destroy());
    this.buffers = [];
  }

  buffer(usage, size, values = null) {
    const buffer = this.gpu.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST });
    if (values) { this.gpu.queue.writeBuffer(buffer, 0, values); }
    this.buffers.push(buffer);
    return buffer;
  }

  group(pipeline, ...buffers) {
    return this.gpu.createBindGroup({ layout: pipeline.getBindGroupLayout(0),
      entries: buffers.map((buffer, binding) => ({ binding, resource: { buffer } })) });
  }

  dispatch(pipeline, group, across, down) {
    const encoder = this.gpu.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, group);
    pass.dispatchWorkgroups(across, down);
    pass.end();
    this.gpu.queue.submit([encoder.finish()]);
  }

  load(scene, level) {
    this.forget();
    const [observation, confidence] = this.pack(level);
    const stored = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC;
    const [from, seen, sure, to] = [this.image, observation, confidence, null].map((values) =>
      this.buffer(stored, this.texels.byteLength, values));
    this.told = new Float32Array(24); // Told of sweep.wgsl
    new Int32Array(this.told.buffer).set([level.width, level.height]);
    this.told[2] = scene.penalty;
    this.told.set(scene.steps.slice(0, 16), 8);
    const told = this.buffer(GPUBufferUsage.UNIFORM, this.told.byteLength);
    this.pipeline = this.gpu.createComputePipeline({ layout: "auto", compute: { module: this.module, entryPoint: "sweep", constants: {
      rule: scene.rule, colours: scene.sweeps_per_iteration, step_count: scene.steps.length } } });
    this.newest = { buffer: from, group: this.group(this.pipeline, from, seen, sure, to, told) };
    this.next = { buffer: to, group: this.group(this.pipeline, to, seen, sure, from, told) };
    this.told_to = told;
    this.read_to = this.buffer(GPUBufferUsage.MAP_READ, this.texels.byteLength);
  }

  write(x, y) {
    this.set_field(x, y);
    this.gpu.queue.writeBuffer(this.newest.buffer, 0, this.image);
  }

  sweep(turn) {
    this.told.set(turn, 4);
    this.gpu.queue.writeBuffer(this.told_to, 0, this.told);
    this.dispatch(this.pipeline, this.newest.group, Math.ceil(this.level.width / 8), Math.ceil(this.level.height / 8));
    [this.newest, this.next] = [this.next, this.newest];
  }

  /** The first two numbers of each site are the displacement. */
  read() { return this.fetch(this.newest.buffer, this.read_to, this.texels); }

  /** A number for each case of probe.inc, which are eight numbers. */
  async evaluate(cases) {
    const answers = new Float32Array(cases.length / 8);
    const asked = this.buffer(GPUBufferUsage.STORAGE, cases.byteLength, cases);
    const results = this.buffer(GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC, answers.byteLength);
    const pipeline = this.gpu.createComputePipeline({ layout: "auto", compute: { module: this.module, entryPoint: "probe" } });
    this.dispatch(pipeline, this.group(pipeline, asked, results), Math.ceil(answers.length / 16), 1);
    return this.fetch(results, this.buffer(GPUBufferUsage.MAP_READ, answers.byteLength), answers);
  }

  copy(from, first, to, at, size) {
    const encoder = this.gpu.createCommandEncoder();
    encoder.copyBufferToBuffer(from, first, to, at, size);
    this.gpu.queue.submit([encoder.finish()]);
  }

  async fetch(from, read_to, values) {
    this.copy(from, 0, read_to, 0, values.byteLength);
    try {
      await read_to.mapAsync(GPUMapMode.READ);
    } catch (error) {
      this.error = this.error || error.message;
    }
    if (this.error) { throw new Error("WebGPU: " + this.error); }
    values.set(new Float32Array(read_to.getMappedRange()));
    read_to.unmap();
    return values;
  }
}
