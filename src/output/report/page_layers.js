// Strokes for bonds, cracks, forces and walls.
"use strict";
(() => {
  const { movie } = Report.data;
  const { ranges } = movie?.scales ?? {};

  const bytes = (name) => {
    const hex = Report.colour(name).slice(1);
    return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
  };

  // Strokes: from, to, half width in m, minimum width in pixels; and colours.
  class Strokes {
    constructor() {
      this.lines = [];
      this.colours = [];
    }
    add(x0, y0, x1, y1, half, pixels, [r, g, b], alpha = 255) {
      this.lines.push(x0, y0, x1, y1, half, pixels);
      this.colours.push(r, g, b, alpha);
    }
  }

  // Strokes of a frame. `before` is the frame before, whose bonds tell what has just broken.
  Report.strokes = (frame, before, layers, picked) => {
    const out = new Strokes(),
      { still } = Report,
      n = movie.bodies;
    const [push, pull, bond, wall, fresh] = [
      "--push",
      "--pull",
      "--bond",
      "--wall",
      "--picked",
    ].map(bytes);
    const modes = [null, null, bytes("--tension"), bytes("--shear"), bytes("--rolling")];
    const typical = Report.meanRadius,
      full = ranges.force[1] || 1;
    const cracks = [],
      recent = [];
    const wanted = layers.bonds || layers.chains || layers.cracks || layers.normals;
    if (wanted)
      Report.eachPair(frame, (a, b, state, p, q, tau, kind, row) => {
        const x0 = frame.x[a],
          y0 = frame.y[a],
          [x1, y1] = Report.otherEnd(frame, a, b);
        const far = Math.hypot(x1 - x0, y1 - y0);
        if (!(far > 0)) return;
        const nx = (x1 - x0) / far,
          ny = (y1 - y0) / far;
        const ra = still.radius[a],
          rb = b < n ? still.radius[b] : ra;
        const arm = b < n ? (far + ra - rb) / 2 : far;
        const cx = x0 + arm * nx,
          cy = y0 + arm * ny,
          r = Math.min(ra, rb);
        if (layers.bonds && state === 1) out.add(x0, y0, x1, y1, 0.07 * r, 1, bond, 200);
        if (layers.chains && p !== 0) {
          const half = 0.5 * typical * Math.min(1.5, Math.abs(p) / full);
          if (half > 0.01 * typical) out.add(x0, y0, x1, y1, half, 0.4, p > 0 ? push : pull, 225);
        }
        if (layers.normals && p > 0)
          out.add(
            cx - 0.4 * r * nx,
            cy - 0.4 * r * ny,
            cx + 0.4 * r * nx,
            cy + 0.4 * r * ny,
            0.05 * r,
            1,
            wall,
            210,
          );
        if (layers.cracks && state > 1) {
          const isFresh = kind === "bond" && before && before.state[row] === 1;
          (isFresh ? recent : cracks).push([
            cx - r * ny,
            cy + r * nx,
            cx + r * ny,
            cy - r * nx,
            r,
            modes[state],
          ]);
        }
      });
    for (const [x0, y0, x1, y1, r, colour] of cracks)
      out.add(x0, y0, x1, y1, 0.07 * r, 1.3, colour);
    for (const [x0, y0, x1, y1, r, colour] of recent) {
      out.add(x0, y0, x1, y1, 0.18 * r, 4, fresh);
      out.add(x0, y0, x1, y1, 0.08 * r, 1.6, colour);
    }
    for (const { line } of frame.walls) {
      for (let k = 0; k + 3 < line.length; k += 2) out.add(...line.slice(k, k + 4), 0, 2.2, wall);
    }
    if (frame.cell) {
      const [width, height, tilt] = frame.cell,
        [left, bottom] = movie.origin.map((x) => -x);
      const corners = [
        [0, 0],
        [width, 0],
        [width + tilt, height],
        [tilt, height],
        [0, 0],
      ].map(([x, y]) => [left + x, bottom + y]);
      for (let k = 0; k < 4; k++) out.add(...corners[k], ...corners[k + 1], 0, 1.2, bond);
    }
    if (picked?.kind === "grain") ring(out, frame, picked.row, fresh);
    if (picked?.kind === "bond" || picked?.kind === "contact") {
      const [a, b] = Report.ends(frame, picked);
      out.add(frame.x[a], frame.y[a], ...Report.otherEnd(frame, a, b), 0.1 * typical, 3, fresh);
    }
    return { lines: new Float32Array(out.lines), colours: new Uint8Array(out.colours) };
  };

  function ring(out, frame, i, colour) {
    const r = Report.still.radius[i],
      steps = 36;
    for (let k = 0; k < steps; k++) {
      const [from, to] = [k, k + 1].map((k) => (2 * Math.PI * k) / steps);
      out.add(
        frame.x[i] + r * Math.cos(from),
        frame.y[i] + r * Math.sin(from),
        frame.x[i] + r * Math.cos(to),
        frame.y[i] + r * Math.sin(to),
        0.05 * r,
        3,
        colour,
      );
    }
  }

  // The two bodies of a picked pair.
  Report.ends = (frame, { kind, row }) =>
    kind === "bond" ? [Report.still.a[row], Report.still.b[row]] : [frame.a[row], frame.b[row]];
})();
