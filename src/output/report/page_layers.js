// Strokes for bonds, cracks, forces and walls.
"use strict";
(() => {
  const { movie } = Report.data;
  const { ranges } = movie ?? {};

  const bytes = (name) => {
    const hex = Report.colour(name).slice(1);
    return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
  };

  // Strokes: from, to, half width in m, minimum width in pixels; and colours. The arrays are used
  // again for the next frame.
  class Strokes {
    constructor() {
      this.lines = new Float32Array(6 * 1024);
      this.colours = new Uint8Array(4 * 1024);
      this.number = 0;
    }
    // Room for more of them.
    reserve(more) {
      const needed = this.number + more;
      if (4 * needed <= this.colours.length) return;
      const { lines, colours } = this,
        room = 2 * needed;
      this.lines = new Float32Array(6 * room);
      this.lines.set(lines);
      this.colours = new Uint8Array(4 * room);
      this.colours.set(colours);
    }
    add(x0, y0, x1, y1, half, pixels, colour, alpha = 255) {
      this.reserve(1);
      const { lines, colours } = this;
      let k = 6 * this.number;
      lines[k++] = x0;
      lines[k++] = y0;
      lines[k++] = x1;
      lines[k++] = y1;
      lines[k++] = half;
      lines[k] = pixels;
      k = 4 * this.number++;
      colours[k++] = colour[0];
      colours[k++] = colour[1];
      colours[k++] = colour[2];
      colours[k] = alpha;
    }
    append(other) {
      this.reserve(other.number);
      this.lines.set(other.lines.subarray(0, 6 * other.number), 6 * this.number);
      this.colours.set(other.colours.subarray(0, 4 * other.number), 4 * this.number);
      this.number += other.number;
    }
  }
  const [out, cracks, recent] = [new Strokes(), new Strokes(), new Strokes()];

  // Strokes of a frame. `before` is the frame before, whose bonds show which ones have just broken.
  Report.strokes = (frame, before, layers, picked) => {
    const { still } = Report,
      n = movie.bodies;
    for (const strokes of [out, cracks, recent]) strokes.number = 0;
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
    const wanted = layers.bonds || layers.chains || layers.cracks || layers.normals;
    if (wanted)
      Report.eachPair(frame, (a, b, state, p, q, tau, kind, row) => {
        // Unloaded contacts, and bonds that hold while only cracks are drawn, have no stroke.
        if (p === 0 && state < 2 && !layers.bonds) return;
        if (state < 2 && !layers.bonds && !layers.chains && !layers.normals) return;
        const x0 = frame.x[a],
          y0 = frame.y[a];
        let x1 = frame.x[b],
          y1 = frame.y[b];
        if (b >= n || frame.cell) [x1, y1] = Report.otherEnd(frame, a, b);
        const far = Math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2);
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
          const [sx, sy] = [r * ny, r * nx],
            [x0, y0, x1, y1] = [cx - sx, cy + sy, cx + sx, cy - sy];
          if (isFresh) {
            recent.add(x0, y0, x1, y1, 0.18 * r, 4, fresh);
            recent.add(x0, y0, x1, y1, 0.08 * r, 1.6, modes[state]);
          } else cracks.add(x0, y0, x1, y1, 0.08 * r, 1.6, modes[state]);
        }
      });
    out.append(cracks);
    out.append(recent);
    for (const { line } of frame.walls) {
      for (let k = 0; k + 3 < line.length; k += 2) out.add(...line.slice(k, k + 4), 0, 2.2, wall);
    }
    if (layers.membrane) {
      const skin = bytes("--membrane");
      // A chain goes from grain to grain; an open one begins and ends at walls.
      for (const { bodies, closed } of frame.membranes ?? []) {
        const count = bodies.length;
        const place = (k) => {
          if (bodies[k] < n) return [frame.x[bodies[k]], frame.y[bodies[k]]];
          return Report.otherEnd(frame, bodies[k === 0 ? 1 : k - 1], bodies[k]);
        };
        const points = bodies.map((_, k) => place(k));
        for (let k = 0; k + (closed ? 0 : 1) < count; k++)
          out.add(...points[k], ...points[(k + 1) % count], 0, 2, skin);
      }
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
    return {
      lines: out.lines.subarray(0, 6 * out.number),
      colours: out.colours.subarray(0, 4 * out.number),
    };
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
