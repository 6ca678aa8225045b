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

  // Reads columns one after the other: four bytes a row, in planes, the lowest bytes first.
  function reader(bytes) {
    let at = 0;
    const counts = (n) => {
      const column = new Uint32Array(n);
      for (let plane = 0; plane < 4; plane++)
        for (let i = 0; i < n; i++) column[i] |= bytes[at++] << (8 * plane);
      return column;
    };
    return { counts, numbers: (n) => new Float32Array(counts(n).buffer) };
  }

  async function unpack(name) {
    const text = atob(document.getElementById(name).textContent);
    const packed = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  async function readStill() {
    const { counts, numbers } = reader(await unpack("still")),
      { bodies: n, bonds: b } = movie;
    return {
      x: numbers(n),
      y: numbers(n),
      radius: numbers(n),
      id: counts(n),
      material: counts(n),
      group: counts(n),
      a: counts(b),
      b: counts(b),
      bond: counts(b),
    };
  }

  async function readFrame(k) {
    const { counts, numbers } = reader(await unpack("frame" + k)),
      { bodies: n, bonds: b } = movie,
      { contacts: c, walls, membranes, cell } = movie.frames[k];
    const forces = (n) => ({ p: numbers(n), q: numbers(n), tau: numbers(n) });
    const frame = {
      ux: numbers(n),
      uy: numbers(n),
      rotation: numbers(n),
      mean: numbers(n),
      shear: numbers(n),
      vx: numbers(n),
      vy: numbers(n),
      strain: numbers(n),
      strainStep: numbers(n),
      fragment: counts(n),
      state: counts(b),
      bonds: forces(b),
      a: counts(c),
      b: counts(c),
      contacts: forces(c),
      walls,
      membranes,
      cell,
    };
    // Where bodies are.
    frame.x = frame.ux.map((u, i) => Report.still.x[i] + u);
    frame.y = frame.uy.map((u, i) => Report.still.y[i] + u);
    return frame;
  }

  const frames = [];
  Report.NONE = 0xffffffff;
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
      { bonds, contacts } = frame;
    for (let k = 0; k < frame.state.length; k++) {
      if (frame.state[k] === 255) continue;
      see(still.a[k], still.b[k], frame.state[k], bonds.p[k], bonds.q[k], bonds.tau[k], "bond", k);
    }
    for (let k = 0; k < frame.a.length; k++) {
      const [p, q, tau] = [contacts.p[k], contacts.q[k], contacts.tau[k]];
      if (p !== 0 || q !== 0 || tau !== 0) see(frame.a[k], frame.b[k], 0, p, q, tau, "contact", k);
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
