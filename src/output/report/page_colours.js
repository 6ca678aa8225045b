// A colour for every grain of a frame, and the legend.
"use strict";
(() => {
  const { movie } = Report.data;
  const { make } = Report;

  // Colour maps through a few points, from low to high: pale to purple, and blue to red through a
  // neutral. Most grains are pale, so that strokes stand out.
  const SEQUENTIAL = [
    [243, 241, 236],
    [224, 216, 226],
    [202, 188, 214],
    [176, 156, 199],
    [148, 122, 181],
    [119, 88, 161],
    [90, 54, 139],
    [62, 22, 112],
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
  const LARGEST = [168, 176, 186];
  // Pale as well; those of materials in the figures.
  const KINDS = [
    [243, 241, 236],
    [158, 202, 225],
    [253, 207, 156],
    [181, 223, 174],
    [212, 197, 232],
    [232, 220, 150],
    [196, 196, 196],
    [227, 184, 196],
  ];

  // A body that is not in the frame has no number; it is not drawn.
  const mapped = (points, part) => {
    if (Number.isNaN(part)) return points[0];
    const at = Math.min(1, Math.max(0, part)) * (points.length - 1);
    const k = Math.min(points.length - 2, Math.floor(at));
    return points[k].map((low, i) => low + (at - k) * (points[k + 1][i] - low));
  };
  // The same in 1024 steps, which is as fine as a screen shows.
  const STEPS = 1023;
  const stepped = (points) =>
    Uint8Array.from({ length: 3 * (STEPS + 1) }, (_, k) =>
      Math.round(mapped(points, Math.floor(k / 3) / STEPS)[k % 3]),
    );
  const MAPS = { signed: stepped(DIVERGING), plain: stepped(SEQUENTIAL) };
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

  const { ranges } = movie ?? {};
  const length = (x, y) => Math.sqrt(x * x + y * y);
  // Ways to colour grains. `of(frame, before, row)` is a number, `unit` that of it.
  const COLOURS = {
    displacement: {
      name: "displacement since the start of the test",
      unit: "m",
      range: ranges?.displacement,
      of: (f, b, i) => length(f.ux[i], f.uy[i]),
    },
    motion: {
      name: "motion since the frame before",
      unit: "m",
      range: ranges?.motion,
      of: (f, b, i) => (b ? length(f.ux[i] - b.ux[i], f.uy[i] - b.uy[i]) : 0),
    },
    velocity: {
      name: "velocity",
      unit: "m/s",
      range: ranges?.velocity,
      of: (f, b, i) => length(f.vx[i], f.vy[i]),
    },
    rotation: {
      name: "rotation since the start (anticlockwise +)",
      unit: "rad",
      range: ranges?.rotation,
      signed: true,
      of: (f, b, i) => f.rotation[i],
    },
    strain: {
      name: "shear strain since the start of the test",
      unit: "%",
      range: ranges?.strain,
      of: (f, b, i) => f.strain[i],
    },
    "strain-step": {
      name: "shear strain since the frame before",
      unit: "%",
      range: ranges?.strainStep,
      of: (f, b, i) => f.strainStep[i],
    },
    stress: {
      name: "mean stress in the grain (compression +)",
      unit: "Pa",
      range: ranges?.stress,
      of: (f, b, i) => f.mean[i],
    },
    fragment: {
      name: "fragment (grains held together by bonds)",
      kinds: (f, i) => (f.fragment[i] === f.largest ? LARGEST : hashed(f.fragment[i])),
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

  // The fragment with the most grains, which is drawn in grey.
  const largest = (frame) => {
    const sizes = new Uint32Array(movie.bodies);
    for (const fragment of frame.fragment) sizes[fragment]++;
    return sizes.indexOf(sizes.reduce((a, b) => Math.max(a, b), 0));
  };

  // Colours of all grains, four bytes each.
  Report.grainColours = (frame, before, key) => {
    const way = COLOURS[key],
      n = movie.bodies,
      out = new Uint8Array(4 * n);
    const map = way.signed ? MAPS.signed : MAPS.plain;
    if (key === "fragment") frame.largest ??= largest(frame);
    const [low, high] = way.range ?? [0, 1],
      scale = STEPS / (high - low || 1);
    for (let i = 0; i < n; i++) {
      if (way.kinds) out.set(way.kinds(frame, i), 4 * i);
      else {
        // A body that is not in the frame has no number, and becomes the first step.
        const step = Math.round((way.of(frame, before, i) - low) * scale);
        const k = 3 * (step > 0 ? Math.min(STEPS, step) : 0);
        out[4 * i] = map[k];
        out[4 * i + 1] = map[k + 1];
        out[4 * i + 2] = map[k + 2];
      }
      out[4 * i + 3] = Number.isNaN(frame.ux[i]) ? 0 : 255;
    }
    return out;
  };

  const told = (x, unit) =>
    unit === "%" ? `${Report.format(100 * x, 3)} %` : Report.si(x, unit, 3);

  Report.drawLegend = (key, layers) => {
    const way = COLOURS[key],
      parts = [];
    if (way.kinds) {
      const names = way.names?.() ?? [];
      const note = key === "fragment" ? ", the largest in grey" : names.length ? ":" : "";
      parts.push(make("span", {}, way.name + note));
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
          make("span", {}, told(low, way.unit)),
          make("span", {}, told(high, way.unit)),
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
    if (layers.membrane) parts.push(key2("--membrane", "membrane"));
    document.getElementById("legend").replaceChildren(...parts);
  };
})();
