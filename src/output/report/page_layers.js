// What a frame looks like: a colour for every grain, and strokes for bonds, cracks and forces.
"use strict";
(() => {
  const { movie } = Report.data;
  const { make } = Report;

  // Colour maps through a few points, from low to high: viridis, and blue to red through a neutral.
  const SEQUENTIAL = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
  ];
  const DIVERGING = [
    [33, 84, 160],
    [84, 143, 200],
    [163, 200, 226],
    [226, 229, 232],
    [244, 190, 160],
    [222, 116, 92],
    [170, 24, 44],
  ];
  const KINDS = [
    [91, 142, 196],
    [226, 150, 72],
    [104, 172, 110],
    [176, 122, 190],
    [196, 178, 90],
    [92, 178, 178],
    [208, 116, 140],
    [140, 140, 150],
  ];

  const mapped = (points, part) => {
    const at = Math.min(1, Math.max(0, part)) * (points.length - 1);
    const k = Math.min(points.length - 2, Math.floor(at));
    return points[k].map((low, i) => low + (at - k) * (points[k + 1][i] - low));
  };
  // A colour for a number of a fragment: neighbours in number differ.
  const hashed = (id) => {
    const hue = ((id * 0.61803398875) % 1) * 6,
      k = Math.floor(hue) % 6,
      f = hue - Math.floor(hue);
    const [low, high] = [96, 214],
      [up, down] = [low + f * (high - low), high - f * (high - low)];
    return [
      [high, up, low],
      [down, high, low],
      [low, high, up],
      [low, down, high],
      [up, low, high],
      [high, low, down],
    ][k];
  };
  const listed = (k) => (k === Report.NONE ? [150, 155, 160] : KINDS[k % KINDS.length]);

  const { ranges } = movie?.scales ?? {};
  const size = (f, x, y, i) => Math.hypot(f[x][i], f[y][i]);
  // Ways to colour grains. `of(frame, before, row)` is a number, `unit` that of it.
  const COLOURS = {
    displacement: {
      name: "displacement since the start of the test",
      unit: "m",
      range: ranges?.displacement,
      of: (f, b, i) => size(f, "ux", "uy", i),
    },
    motion: {
      name: "motion since the frame before",
      unit: "m",
      range: ranges?.motion,
      of: (f, b, i) => (b ? Math.hypot(f.ux[i] - b.ux[i], f.uy[i] - b.uy[i]) : 0),
    },
    velocity: {
      name: "velocity",
      unit: "m/s",
      range: ranges?.velocity,
      needs: "vx",
      of: (f, b, i) => size(f, "vx", "vy", i),
    },
    rotation: {
      name: "rotation since the start (anticlockwise +)",
      unit: "rad",
      range: ranges?.rotation,
      signed: true,
      of: (f, b, i) => f.rotation[i],
    },
    stress: {
      name: "mean stress in the grain (compression +)",
      unit: "Pa",
      range: ranges?.stress,
      of: (f, b, i) => f.mean[i],
    },
    fragment: {
      name: "fragment (grains held together by bonds)",
      kinds: (f, i) => hashed(f.fragment[i]),
    },
    material: {
      name: "material",
      names: () => movie.materials,
      kinds: (f, i) => listed(Report.still.material[i]),
    },
    group: {
      name: "group",
      names: () => movie.groups,
      kinds: (f, i) => listed(Report.still.group[i]),
    },
  };
  // A scale about zero is drawn with two colours.
  for (const way of Object.values(COLOURS)) {
    if (way.range && !way.kinds && way.range[0] < 0) {
      const most = Math.max(...way.range.map(Math.abs));
      if (way.range[1] > 0 && -way.range[0] > 0.05 * most)
        [way.range, way.signed] = [[-most, most], true];
    }
  }
  Report.COLOURS = COLOURS;

  // Colours of all grains, four bytes each.
  Report.grainColours = (frame, before, key) => {
    const way = COLOURS[key],
      n = movie.bodies,
      out = new Uint8Array(4 * n);
    const map = way.signed ? DIVERGING : SEQUENTIAL;
    const [low, high] = way.range ?? [0, 1],
      width = high - low || 1;
    for (let i = 0; i < n; i++) {
      const rgb = way.kinds
        ? way.kinds(frame, i)
        : mapped(map, (way.of(frame, before, i) - low) / width);
      out.set(rgb, 4 * i);
      out[4 * i + 3] = Number.isNaN(frame.ux[i]) ? 0 : 255;
    }
    return out;
  };

  Report.drawLegend = (key, layers) => {
    const way = COLOURS[key],
      parts = [];
    if (way.kinds) {
      const names = way.names?.() ?? [];
      parts.push(make("span", {}, way.name + (names.length ? ":" : "")));
      names.forEach((name, k) =>
        parts.push(
          make(
            "span",
            {},
            make("i", { class: "block", style: `background: rgb(${listed(k)})` }),
            name,
          ),
        ),
      );
    } else {
      const bar = make("canvas", { width: 190, height: 1 }),
        ink = bar.getContext("2d");
      const map = way.signed ? DIVERGING : SEQUENTIAL;
      for (let x = 0; x < 190; x++) {
        ink.fillStyle = `rgb(${mapped(map, x / 189).map(Math.round)})`;
        ink.fillRect(x, 0, 1, 1);
      }
      const [low, high] = way.range;
      parts.push(
        make("span", {}, way.name),
        make(
          "span",
          { class: "scale" },
          bar,
          make("span", {}, Report.si(low, way.unit, 3)),
          make("span", {}, Report.si(high, way.unit, 3)),
        ),
      );
    }
    const key2 = (colour, text) =>
      make("span", {}, make("i", { style: `background: var(${colour})` }), text);
    if (layers.cracks) {
      parts.push(key2("--tension", "broken in tension"), key2("--shear", "in shear"));
      if (Report.hasRolling) parts.push(key2("--rolling", "in rolling"));
      parts.push(key2("--picked", "since the frame before"));
    }
    if (layers.chains)
      parts.push(
        key2("--push", `compression, ${Report.si(ranges.force[1], "N", 3)} at full width`),
        key2("--pull", "tension"),
      );
    document.getElementById("legend").replaceChildren(...parts);
  };

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
            cx - 0.6 * r * ny,
            cy + 0.6 * r * nx,
            cx + 0.6 * r * ny,
            cy - 0.6 * r * nx,
            r,
            modes[state],
          ]);
        }
      });
    for (const [x0, y0, x1, y1, r, colour] of cracks)
      out.add(x0, y0, x1, y1, 0.07 * r, 1.3, colour);
    for (const [x0, y0, x1, y1, r, colour] of recent) {
      out.add(x0, y0, x1, y1, 0.22 * r, 4.5, fresh);
      out.add(x0, y0, x1, y1, 0.08 * r, 1.6, colour);
    }
    for (const { line } of frame.walls) {
      for (let k = 0; k + 3 < line.length; k += 2) out.add(...line.slice(k, k + 4), 0, 2.2, wall);
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
