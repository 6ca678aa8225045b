// Strains of the neighbourhoods of grains between two frames, as `docs/python.md` defines them.
"use strict";
(() => {
  const { movie } = Report.data;
  // Frames of which the colour scale of strains is measured.
  const MEASURED = 40;
  // Part of the values within a colour scale.
  const WITHIN = 0.99;

  // Strains are linear in the triangles of the Delaunay triangulation of the centres in `from`.
  // Triangles with a side across a gap wider than the mean diameter do not count.
  function meshOf(from) {
    const rows = [...from.ux.keys()].filter((i) => !Number.isNaN(from.ux[i])),
      { radius } = Report.still,
      widest = 2 * Report.meanRadius;
    const corners = Report.triangles(
      rows.map((i) => from.x[i]),
      rows.map((i) => from.y[i]),
    ).map((k) => rows[k]);
    const apart = (a, b) =>
      Math.hypot(from.x[a] - from.x[b], from.y[a] - from.y[b]) - radius[a] - radius[b];
    const kept = [];
    for (let t = 0; t < corners.length; t += 3) {
      const [a, b, c] = corners.slice(t, t + 3);
      if (Math.max(apart(a, b), apart(b, c), apart(c, a)) <= widest) kept.push(a, b, c);
    }
    return kept;
  }

  // Maximum shear strain of every grain of `now` since `from`; not a number where it has none.
  Report.shearStrains = (now, from) => {
    const n = movie.bodies,
      mesh = (from.mesh ??= meshOf(from));
    const [xx, yy, xy, area] = [0, 1, 2, 3].map(() => new Float64Array(n));
    for (let t = 0; t < mesh.length; t += 3) {
      const [a, b, c] = [mesh[t], mesh[t + 1], mesh[t + 2]];
      const [x1, y1] = [from.x[b] - from.x[a], from.y[b] - from.y[a]],
        [x2, y2] = [from.x[c] - from.x[a], from.y[c] - from.y[a]];
      const twice = x1 * y2 - x2 * y1;
      const u = (i) => now.ux[i] - from.ux[i],
        v = (i) => now.uy[i] - from.uy[i];
      const [u1, v1, u2, v2] = [u(b) - u(a), v(b) - v(a), u(c) - u(a), v(c) - v(a)];
      // Area times the gradient of the displacement; a grain that is gone has none.
      const sign = 0.5 * Math.sign(twice);
      const [ux, uy, vx, vy] = [
        sign * (u1 * y2 - u2 * y1),
        sign * (u2 * x1 - u1 * x2),
        sign * (v1 * y2 - v2 * y1),
        sign * (v2 * x1 - v1 * x2),
      ];
      if (!Number.isFinite(ux + uy + vx + vy) || twice === 0) continue;
      for (const i of [a, b, c]) {
        xx[i] += ux;
        yy[i] += vy;
        xy[i] += 0.5 * (uy + vx);
        area[i] += Math.abs(0.5 * twice);
      }
    }
    // Without a triangle that is 0 / 0.
    return Float32Array.from(xx, (_, i) => Math.hypot(xx[i] - yy[i], 2 * xy[i]) / area[i]);
  };

  // A strain is computed once for each frame.
  Report.totalStrains = (frame) => (frame.strain ??= Report.shearStrains(frame, Report.startFrame));
  Report.strainSteps = (frame, before) =>
    (frame.strainStep ??= before ? Report.shearStrains(frame, before) : new Float32Array(movie.bodies));

  // The end of a colour scale of strains: the value that 99 % do not exceed, over frames that are
  // spread evenly from the start of the test on.
  Report.strainRange = async (field) => {
    const [first, last] = [movie.start + 1, movie.frames.length - 1],
      number = Math.min(MEASURED, last - first + 1),
      values = [];
    for (let k = 0; k < number; k++) {
      const at = number > 1 ? first + Math.round((k * (last - first)) / (number - 1)) : first;
      const [frame, before] = await Promise.all([Report.frame(at), Report.frame(at - 1)]);
      for (const value of field(frame, before)) if (Number.isFinite(value)) values.push(value);
      // The page stays alive meanwhile.
      await new Promise((done) => setTimeout(done));
    }
    const sorted = Float32Array.from(values).sort();
    return [0, sorted[Math.round(WITHIN * (sorted.length - 1))] || 1];
  };
})();
