// Follows the steps of the elastic energy on WebGPU: what a device was told where the page was written, and what every step
// makes by scalar there (elastic_steps.cpp).

/** A scene's arrays on a ComputeGpu, and what is done to them. */
class ElasticArrays {
  constructor(gpu, scene) {
    gpu.forget();
    this.gpu = gpu;
    this.arrays = scene.arrays.map((size) => gpu.buffer(GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC, size));
    this.before = gpu.buffer(GPUBufferUsage.STORAGE, Math.max(...scene.arrays)); // of an array that is changed
    this.told = gpu.buffer(GPUBufferUsage.UNIFORM, 128);
  }

  write(array, first, bytes) { this.gpu.gpu.queue.writeBuffer(this.arrays[array], first, bytes); }

  do(told) {
    if (told.words) {
      this.dispatch(told);
    } else {
      this.write(told.array, told.first, told.zeros ? new Uint8Array(told.zeros) : bytes_of(told.bytes));
    }
  }

  dispatch({ program, constants, arrays, words, groups }) {
    const { TOGETHER, ROWS, COLUMNS, ...own } = constants; // the texts have these
    const { pipeline, bindings } = this.gpu.pipeline_of(program, own);
    // Levels lie one after the other in an array, and WebGPU takes none that is stored to and fetched from elsewhere.
    const stored = arrays.find(([binding]) => binding === 0)[1];
    const is_both = arrays.some(([binding, array]) => binding > 0 && array === stored);
    if (is_both) { this.gpu.copy(this.arrays[stored], 0, this.before, 0, this.arrays[stored].size); }
    const bound = [[15, this.told], ...arrays.filter(([binding]) => bindings.has(binding)).map(([binding, array]) =>
      [binding, binding > 0 && array === stored ? this.before : this.arrays[array]])];
    const group = this.gpu.gpu.createBindGroup({ layout: pipeline.getBindGroupLayout(0),
      entries: bound.map(([binding, buffer]) => ({ binding, resource: { buffer } })) });
    const one = 0x3f800000; // elastic.wgsl says why
    this.gpu.gpu.queue.writeBuffer(this.told, 0, Int32Array.from({ length: 32 }, (_, i) => (i === 31 ? one : words[i] || 0)));
    this.gpu.dispatch(pipeline, group, ...groups);
  }
}

/** Returns whether the first of the cells that have kept least of their volume is scalar's; `kept` has the bits of a share and a site
    for each work item. */
function is_least({ share, site }, kept) {
  const share_of = (bits) => new Float32Array(Int32Array.of(bits).buffer)[0];
  let least = [0x7f800000, 0];
  for (let i = 0; i < kept.length; i += 2) {
    const order = share_of(kept[i]) - share_of(least[0]);
    if (order < 0 || (kept[i] === least[0] && kept[i + 1] < least[1])) { least = [kept[i], kept[i + 1]]; }
  }
  return least[0] === share && least[1] === site;
}

/** Compares one step's sites with scalar's. `found` has what `made` has, one plane after the other. Returns whether anything had to
    be computed. */
function compare_step(row, step, number, found) {
  const [width, height, depth] = step.sites;
  const planes = step.made.map((plane) => plane.expected);
  if (step.step === "dot product") {
    row.counts_differing += planes[0][0] === found[0] ? 0 : 1;
    return true;
  }
  let first = 0;
  const of_device = planes.map((expected) => found.subarray(first, first += expected.length));
  for (let i = 0; i < width * height * depth; ++i) {
    const [x, y, z] = [i % width, Math.floor(i / width) % height, Math.floor(i / (width * height))];
    const at = z * step.layer + y * step.pitch + x;
    if (planes.every((expected, k) => expected[at] === of_device[k][at])) { continue; }
    const [wanted, got] = [planes, of_device].map((all) => all.map((plane) => plane[at]));
    count_difference(row, wanted, got, { level: step.level, iteration: number, step: step.step, x, y, z });
  }
  row.sites_compared += width * height * depth;
  row.sweeps += 1;
  return planes.some((expected) => expected.some((value) => value !== 0));
}

/** Follows a scene in one mode: in "resync" a step's field is scalar's as soon as it was kept to be compared. `step` is called
    now and then and may wait. Returns the row. */
async function follow_elastic(gpu, scene, mode, step) {
  const row = { ...new_row(scene, gpu, mode), depth: scene.depth };
  const device = new ElasticArrays(gpu, scene);
  scene.steps.forEach((one) => one.made.forEach((plane) => { plane.expected ??= floats(plane.bytes); }));
  const length_of = (one) => one.made.reduce((sum, plane) => sum + plane.expected.length, 0);
  const with_least = (one) => length_of(one) + (one.least ? one.least.size / 4 : 0);
  const all = new Float32Array(scene.steps.reduce((sum, one) => sum + with_least(one), 0));
  const kept = gpu.buffer(GPUBufferUsage.COPY_SRC, all.byteLength);
  const read_to = gpu.buffer(GPUBufferUsage.MAP_READ, all.byteLength);
  let at = 0;
  for (const one of scene.steps) {
    one.told.forEach((told) => device.do(told));
    for (const plane of one.made) {
      const size = plane.expected.byteLength;
      gpu.copy(device.arrays[plane.array], plane.first, kept, at, size);
      if (mode === "resync") { device.write(plane.array, plane.first, plane.expected); }
      at += size;
    }
    if (one.least) {
      gpu.copy(device.arrays[one.least.array], 0, kept, at, one.least.size);
      at += one.least.size;
    }
  }
  await gpu.fetch(kept, read_to, all);
  let number = 0;
  let first = 0;
  let moves = false;
  for (const one of scene.steps) {
    number += 1;
    const end = first + length_of(one);
    moves = compare_step(row, one, number, all.subarray(first, end)) || moves;
    first += with_least(one);
    if (one.least && !is_least(one.least, new Int32Array(all.buffer, 4 * end, first - end))) { row.counts_differing += 1; }
    row.levels = Math.max(row.levels, one.level + 1);
  }
  row.iterations = number;
  await step();
  conclude_row(row, moves, false);
  return row;
}
