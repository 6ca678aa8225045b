// The data of the page: those that are read at once, and frames that are unpacked when they are
// needed.
"use strict";
const Report = {};
Report.state = {
  frame: -1,
  colour: "displacement",
  layers: {},
  picked: null,
  isPlaying: false,
};
Report.data = JSON.parse(document.getElementById("data").textContent);

(() => {
  const movie = Report.data.movie;
  const NONE = 0xffffffff;

  // float16 by its bits.
  const HALF = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31,
      fraction = bits & 1023;
    const size = exponent === 0 ? fraction * 2 ** -24 : (1024 + fraction) * 2 ** (exponent - 25);
    HALF[bits] = (bits & 32768 ? -1 : 1) * (exponent === 31 ? (fraction ? NaN : Infinity) : size);
  }
  // The same by whole numbers that grow with it, from -32768 on.
  const ORDERED = new Float32Array(65536);
  for (let code = -32768; code < 32768; code++)
    ORDERED[32768 + code] = HALF[code < 0 ? 32768 - code : code];

  // Reads columns one after the other. Their bytes lie in planes, the lowest bytes first. Columns
  // that change are whole numbers, as differences from those of the frame before, if it has one.
  class Reader {
    constructor(bytes, before = []) {
      this.bytes = bytes;
      this.at = 0;
      this.before = before;
      this.codes = [];
    }
    changing(n, width) {
      const { bytes, at } = this,
        before = this.before[this.codes.length],
        codes = new (width === 1 ? Int8Array : width === 2 ? Int16Array : Int32Array)(n),
        beyond = 32 - 8 * width;
      for (let i = 0; i < n; i++) {
        let code = bytes[at + i];
        for (let k = 1; k < width; k++) code |= bytes[at + k * n + i] << (8 * k);
        const change = (code >>> 1) ^ -(code & 1);
        codes[i] = (((before ? before[i] : 0) + change) << beyond) >> beyond;
      }
      this.at += n * width;
      this.codes.push(codes);
      return codes;
    }
    changingBytes(n) {
      return new Uint8Array(this.changing(n, 1).buffer);
    }
    changingCounts(n) {
      return new Uint32Array(this.changing(n, 4).buffer);
    }
    changingHalves(n, scale) {
      const codes = this.changing(n, 2),
        column = new Float32Array(n);
      for (let i = 0; i < n; i++) column[i] = scale * ORDERED[32768 + codes[i]];
      return column;
    }
    // Whole steps of two or three bytes.
    changingSteps(n, step) {
      const { width } = movie.scales,
        codes = this.changing(n, width),
        column = new Float32Array(n),
        absent = -(2 ** (8 * width - 1));
      for (let i = 0; i < n; i++) column[i] = codes[i] === absent ? NaN : step * codes[i];
      return column;
    }
    counts(n) {
      const { bytes, at } = this,
        column = new Uint32Array(n);
      for (let i = 0; i < n; i++) {
        column[i] =
          bytes[at + i] |
          (bytes[at + n + i] << 8) |
          (bytes[at + 2 * n + i] << 16) |
          (bytes[at + 3 * n + i] << 24);
      }
      this.at += 4 * n;
      return column;
    }
    numbers(n) {
      return new Float32Array(this.counts(n).buffer);
    }
  }

  async function unpack(name) {
    const text = atob(document.getElementById(name).textContent);
    const packed = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  async function readStill() {
    const from = new Reader(await unpack("still")),
      { bodies: n, bonds: b } = movie;
    return {
      x: from.numbers(n),
      y: from.numbers(n),
      radius: from.numbers(n),
      id: from.counts(n),
      material: from.counts(n),
      group: from.counts(n),
      a: from.counts(b),
      b: from.counts(b),
      bond: from.counts(b),
    };
  }

  async function readFrame(k) {
    // The frame before is wanted too, unless this one is whole.
    const [bytes, last] = await Promise.all([
      unpack("frame" + k),
      k % movie.key === 0 ? null : Report.frame(k - 1),
    ]);
    const from = new Reader(bytes, last?.codes),
      { bodies: n, bonds: b, scales } = movie;
    const c = movie.frames[k].contacts;
    const frame = {
      ux: from.changingSteps(n, scales.step),
      uy: from.changingSteps(n, scales.step),
      rotation: from.changingHalves(n, scales.rotation),
      mean: from.changingHalves(n, scales.stress),
      shear: from.changingHalves(n, scales.stress),
    };
    if (scales.velocity !== null) {
      frame.vx = from.changingHalves(n, scales.velocity);
      frame.vy = from.changingHalves(n, scales.velocity);
    }
    frame.fragment = from.changingCounts(n);
    frame.state = from.changingBytes(b);
    const forces = (read) => ({
      p: read(scales.force),
      q: read(scales.force),
      tau: scales.moment === null ? null : read(scales.moment),
    });
    frame.bonds = forces((scale) => from.changingHalves(b, scale));
    frame.contacts = forces((scale) => from.changingHalves(c, scale));
    // Contacts are those of the last frame that was whole.
    if (last) [frame.a, frame.b] = [last.a, last.b];
    else {
      [frame.a, frame.b] = [from.counts(c), from.counts(c)];
      for (let i = 1; i < c; i++) frame.a[i] += frame.a[i - 1];
      for (let i = 0; i < c; i++) frame.b[i] += frame.a[i];
    }
    // Only the next frame needs these.
    if (last) last.codes = null;
    frame.codes = from.codes;
    // Where bodies are.
    frame.x = frame.ux.map((u, i) => Report.still.x[i] + u);
    frame.y = frame.uy.map((u, i) => Report.still.y[i] + u);
    frame.walls = movie.frames[k].walls;
    frame.membranes = movie.frames[k].membranes;
    frame.cell = movie.frames[k].cell;
    return frame;
  }

  const frames = [];
  Report.NONE = NONE;
  Report.frame = (k) => (frames[k] ??= readFrame(k));
  Report.loadStill = async () => {
    Report.still = await readStill();
  };

  // The image of body b that is nearest to body a in a periodic cell.
  function image(frame, a, b) {
    const [width, height, tilt] = frame.cell;
    const rows = Math.round((frame.y[b] - frame.y[a]) / height);
    const columns = Math.round((frame.x[b] - frame.x[a] - rows * tilt) / width);
    return [frame.x[b] - columns * width - rows * tilt, frame.y[b] - rows * height];
  }

  // The end of a pair of bodies on the second one: its centre, or the nearest point of the wall.
  Report.otherEnd = (frame, a, b) => {
    const n = movie.bodies;
    if (b < n) return frame.cell ? image(frame, a, b) : [frame.x[b], frame.y[b]];
    const wall = frame.walls.find((wall) => wall.id === movie.walls[b - n]);
    if (!wall) return [NaN, NaN];
    const [x, y] = [frame.x[a], frame.y[a]];
    let best = [NaN, NaN],
      nearest = Infinity;
    for (let k = 0; k + 3 < wall.line.length; k += 2) {
      const [x0, y0, x1, y1] = wall.line.slice(k, k + 4);
      const [dx, dy] = [x1 - x0, y1 - y0];
      let t = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy);
      if (wall.thin) t = Math.min(1, Math.max(0, t));
      const point = [x0 + t * dx, y0 + t * dy];
      const far = Math.hypot(point[0] - x, point[1] - y);
      if (far < nearest) [nearest, best] = [far, point];
    }
    return best;
  };

  // Calls `see(a, b, state, p, q, tau, kind, row)` for every bond and contact of a frame.
  Report.eachPair = (frame, see) => {
    const { still } = Report,
      tau = (of, k) => (of.tau ? of.tau[k] : 0);
    for (let k = 0; k < frame.state.length; k++) {
      if (frame.state[k] === 255) continue;
      const of = frame.bonds;
      see(still.a[k], still.b[k], frame.state[k], of.p[k], of.q[k], tau(of, k), "bond", k);
    }
    for (let k = 0; k < frame.a.length; k++) {
      const of = frame.contacts;
      // A contact without force is one of another frame.
      if (of.p[k] === 0 && of.q[k] === 0 && tau(of, k) === 0) continue;
      see(frame.a[k], frame.b[k], 0, of.p[k], of.q[k], tau(of, k), "contact", k);
    }
  };
})();

// Numbers as text.
Report.format = (x, digits = 4) => {
  if (x === null || x === undefined || Number.isNaN(x)) return "\u2013";
  if (Number.isInteger(x) && Math.abs(x) < 1e7) return String(x);
  const text =
    Math.abs(x) >= 1e5 || (x !== 0 && Math.abs(x) < 1e-3)
      ? Number(x.toPrecision(digits)).toExponential().replace("e+", "e")
      : String(Number(x.toPrecision(digits)));
  return text.replace("-", "\u2212");
};
Report.PREFIXES = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "\u00b5"],
  [1e-9, "n"],
];
// Scale and prefix for numbers up to this size.
Report.prefix = (size) =>
  Report.PREFIXES.find(([scale]) => Math.abs(size) >= scale * 0.9999) ?? [1, ""];
Report.si = (x, unit, digits = 4) => {
  if (x === null || x === undefined || Number.isNaN(x)) return "\u2013";
  const [scale, letter] = x === 0 ? [1, ""] : Report.prefix(x);
  return `${Report.format(x / scale, digits)} ${letter}${unit}`;
};
Report.make = (tag, attributes = {}, ...children) => {
  const svg = ["svg", "path", "line", "text", "g", "circle", "rect", "title"].includes(tag);
  const node = svg
    ? document.createElementNS("http://www.w3.org/2000/svg", tag)
    : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false)
      node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children);
  return node;
};
Report.colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
