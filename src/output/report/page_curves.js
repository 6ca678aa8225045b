// Curves of all runs, and the frame that belongs to a place on them.
"use strict";
(() => {
  const { runs, movie } = Report.data;
  const node = (id) => document.getElementById(id);
  Report.charts = [];

  // Curves of all runs over the axial strain; where none is defined over the time if it passes in
  // every run, else over the increments.
  Report.drawCurves = (pick) => {
    const strained = runs.some((run) => run.history.axial_strain?.some((x) => x !== null));
    Report.isStrained = strained;
    const passes = ({ history: { time_s } }) => time_s?.length > 1 && time_s.at(-1) > time_s[0];
    Report.isTimed = !strained && runs.every(passes);
    // Row of the initial state, at which the strain is 0: that before the first strain, which may
    // be before the history (-1).
    const initial = (run) => {
      const first = (run.history.axial_strain ?? []).findIndex((e) => e !== null);
      return first < 0 ? null : first - 1;
    };
    const x = (run) => {
      if (!strained) return run.history[Report.isTimed ? "time_s" : "increment"];
      const strains = (run.history.axial_strain ?? []).map((e) => (e === null ? null : 100 * e));
      if (initial(run) === -1) strains.unshift(0);
      else if (initial(run) !== null) strains[initial(run)] = 0;
      return strains;
    };
    // A column with its value in the initial state: 0 unless another run led there, and unknown for
    // a measure of the scene.
    const known = (run, name, values) => {
      const row = initial(run),
        counts = name.endsWith("strain");
      if (!strained || row === null || !values.length) return values;
      if (run.measures?.includes(name)) return row === -1 ? [null, ...values] : values;
      const isContinued = run.history.increment.at(-1) > run.record.increments;
      if (row === -1) return [isContinued && !counts ? null : 0, ...values];
      return values.map((y, k) => (k === row && (y === null || counts) ? 0 : y));
    };
    const span = runs.flatMap((run) => x(run).filter((value) => value !== null));
    const xName = strained ? "axial strain, %" : Report.isTimed ? "time, s" : "increment";
    const colour = (k) => `var(--series-${k % 13})`;
    const has = (name) => runs.some((run) => run.history[name]?.some((y) => y !== null));
    const scaled = (name, unit) => {
      const size = runs.reduce(
        (most, run) =>
          (run.history[name] ?? []).reduce((a, y) => Math.max(a, Math.abs(y ?? 0)), most),
        0,
      );
      const [scale, letter] = size > 0 ? Report.prefix(size) : [1, ""];
      return {
        unit: letter + unit,
        of: (y) => (y === null || y === undefined ? null : y / scale),
        size,
      };
    };
    const draw = (title, yName, columns) => {
      const series = runs.flatMap((run, r) =>
        columns
          .map(([name, of, column], k) => ({
            name:
              runs.length === 1 ? name : columns.length === 1 ? run.name : `${run.name}, ${name}`,
            colour: colour(runs.length === 1 ? k : r * columns.length + k),
            x: x(run),
            y: known(run, name, column(run) ?? []).map(of),
            first: strained && initial(run) === -1 ? 1 : 0,
          }))
          .filter((one) => one.y.some((y) => y !== null)),
      );
      if (!series.length) return;
      add({ title, xName, yName, series, onPick: pick, span });
    };
    const add = (of) => {
      // The first curve stands beside the picture, whose time it shows.
      const isBeside = movie && !Report.charts.length;
      const size = isBeside || window.innerWidth < 600 ? [400, 270] : [440, 280];
      const chart = new Report.Chart({ ...of, size });
      Report.charts.push(chart);
      node(isBeside ? "beside" : "curves").append(chart.node);
    };
    const column = (name) => (run) => run.history[name];
    if (has("axial_stress_pa")) {
      const { unit, of } = scaled("axial_stress_pa", "Pa");
      const lateral =
        runs.length === 1 && has("lateral_stress_pa")
          ? [["lateral", of, column("lateral_stress_pa")]]
          : [];
      draw("Stress", `stress, ${unit}`, [["axial", of, column("axial_stress_pa")], ...lateral]);
    }
    if (!has("axial_stress_pa")) drawDrive(add);
    if (has("volumetric_strain"))
      draw("Volume", "volumetric strain, %", [
        ["volumetric strain", (y) => (y === null ? null : 100 * y), column("volumetric_strain")],
      ]);
    const broken = ["broken_tension", "broken_shear", "broken_rolling"].filter((name) =>
      runs.some((run) => run.history[name]?.some((y) => y > 0)),
    );
    if (runs.length === 1 && broken.length) {
      draw(
        "Broken bonds",
        "number",
        broken.map((name) => [name.slice(7), (y) => y, column(name)]),
      );
    } else if (broken.length) {
      const all = (run) =>
        run.history.increment.map((_, k) =>
          broken.reduce((sum, name) => sum + (run.history[name]?.[k] ?? 0), 0),
        );
      draw("Broken bonds", "number", [["broken", (y) => y, all]]);
    }
    const energies = Object.keys(Report.ENERGIES).filter(
      (name) => name !== "energy_external_j" && name !== "energy_gravity_j",
    );
    if (runs.length === 1 && has("energy_external_j")) {
      const { unit, size } = scaled("energy_external_j", "J");
      const [scale] = size > 0 ? Report.prefix(size) : [1];
      const is = (name) =>
        (runs[0].history[name] ?? []).some((y) => Math.abs(y ?? 0) > 0.005 * size);
      draw(
        "Energies",
        `energy, ${unit}`,
        ["energy_external_j", "energy_gravity_j", ...energies]
          .filter(is)
          .map((name) => [
            Report.ENERGIES[name],
            (y) => (y === null ? null : y / scale),
            column(name),
          ]),
      );
    }
    if (!Report.charts.length && has("kinetic_energy_j")) {
      const { unit, of } = scaled("kinetic_energy_j", "J");
      draw("Kinetic energy", `energy, ${unit}`, [
        ["kinetic energy", of, column("kinetic_energy_j")],
      ]);
    }
    // Measures that the scene defines beside strain and stress, in the units of their columns.
    const measures = [...new Set(runs.flatMap((run) => run.measures ?? []))];
    for (const name of measures.filter(has)) draw(name, name, [[name, (y) => y, column(name)]]);
    if (Report.charts.length < 2)
      draw("Contacts", "number", [["contacts", (y) => y, column("contacts")]]);
  };

  // Force against displacement of the driven wall, group or particle, in the direction of the
  // drive.
  function drawDrive(add) {
    const drives = runs.flatMap((run) => (run.drives ?? []).map((drive) => ({ run, ...drive })));
    if (!drives.length) return;
    const turns = drives[0].direction.endsWith("clockwise");
    const most = (name) =>
      Math.max(...drives.flatMap(({ points }) => points.map((p) => Math.abs(p[name]))));
    const [u, f] = ["motion", "force"].map((name) => Report.prefix(most(name)));
    const one = drives.every(({ direction }) => direction === drives[0].direction);
    const way = one ? drives[0].direction.replace("-", "\u2212") : "the drive";
    const series = drives.map(({ run, probe, direction, points }, k) => ({
      name: [runs.length > 1 ? run.name : "", probe, one ? "" : direction].filter(Boolean).join(", "),
      colour: `var(--series-${k % 13})`,
      x: points.map((p) => p.motion / u[0]),
      y: points.map((p) => p.force / f[0]),
      first: 0,
    }));
    const { points } = drives[0];
    // Row of the last increment up to that of a frame.
    const rowOf = (increment) => points.findLastIndex((p) => p.increment <= increment);
    const nearest = (x) => {
      const far = (k) => Math.abs(series[0].x[k] - x);
      const k = points.reduce((best, _, k) => (far(k) < far(best) ? k : best), 0);
      Report.play(false);
      Report.show(Report.frameOf(points[k].increment));
    };
    add({
      title: turns ? "Moment and rotation" : "Force and displacement",
      xName: `${turns ? "rotation" : "displacement"} along ${way}, ${u[1]}${turns ? "rad" : "m"}`,
      yName: `${turns ? "moment" : "force"} along ${way}, ${f[1]}${turns ? "N m" : "N"}`,
      series,
      onPick: movie ? nearest : null,
      placeOf: (k) => {
        const row = rowOf(movie.frames[k].increment);
        return row < 0 ? [null, -1] : [series[0].x[row], row];
      },
    });
  }

  // The peak of the force of a run without a stress.
  Report.peakOfForce = (run) => {
    const of = (name) => run.history[name]?.some((y) => y !== null);
    return of("axial_stress_pa") ? null : (run.peak ?? null);
  };

  // The frame that is nearest to an increment, the earlier one of two.
  Report.frameOf = (increment) => {
    const far = (k) => Math.abs(movie.frames[k].increment - increment);
    return movie.frames.reduce((best, _, k) => (far(k) < far(best) ? k : best), 0);
  };

  Report.xOf = (k) => {
    const frame = movie.frames[k];
    if (Report.isTimed) return frame.time;
    if (!Report.isStrained) return frame.increment;
    return frame.strain === null ? null : 100 * frame.strain;
  };

  // The frame that is nearest to a place on a curve.
  Report.nearestFrame = (x) => {
    let best = 0;
    movie.frames.forEach((_, k) => {
      const far = (k) => (Report.xOf(k) === null ? Infinity : Math.abs(Report.xOf(k) - x));
      if (far(k) < far(best)) best = k;
    });
    return best;
  };
})();
