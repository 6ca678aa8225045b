// The page: curves, the visible frame, and actions of the reader.
"use strict";
(() => {
  const { make, format, si, state } = Report;
  const { runs, movie } = Report.data;
  const node = (id) => document.getElementById(id);

  // Shows a frame. Calls that come while one is unpacked replace each other.
  let wanted = null;
  Report.isBusy = false;
  Report.show = async (k = state.frame) => {
    wanted = Math.max(0, Math.min(movie.frames.length - 1, k));
    node("slider").value = wanted;
    if (Report.isBusy) return;
    Report.isBusy = true;
    try {
      while (wanted !== null) {
        const at = wanted;
        wanted = null;
        const [frame, before] = await Promise.all([
          Report.frame(at),
          at > 0 ? Report.frame(at - 1) : null,
        ]);
        state.frame = at;
        if (state.picked?.kind === "contact" && state.picked.at !== at) state.picked = null;
        Report.paint(frame, before);
      }
    } finally {
      Report.isBusy = false;
    }
  };

  Report.paint = (frame, before) => {
    [state.now, state.before] = [frame, before];
    const colours = Report.grainColours(frame, before, state.colour);
    Report.view.setFrame(
      frame,
      colours,
      Report.strokes(frame, before, state.layers, state.picked),
      state.layers.spokes,
    );
    const told = movie.frames[state.frame];
    const facts = [
      ["Frame", `${state.frame + 1} of ${movie.frames.length}`],
      ["Increment", format(told.increment)],
      ["Stage", told.stage || "\u2013"],
    ];
    if (told.time !== 0) facts.push(["Time", si(told.time, "s")]);
    if (told.strain !== null) facts.push(["Axial strain", `${format(100 * told.strain)} %`]);
    if (told.stress !== null) facts.push(["Axial stress", si(told.stress, "Pa")]);
    if (movie.bonds > 0) {
      const broken = frame.state.reduce((sum, s) => sum + (s > 1 && s < 255), 0);
      const fresh = before
        ? frame.state.reduce((sum, s, k) => sum + (s > 1 && s < 255 && before.state[k] === 1), 0)
        : 0;
      facts.push([
        "Broken bonds",
        `${format(broken)}${fresh ? `, ${format(fresh)} since the frame before` : ""}`,
      ]);
    }
    node("moment").replaceChildren(
      Report.table(
        ["", ""],
        facts.map(([name, text]) => [name, Report.numeric(text)]),
      ),
    );
    node("slider").setAttribute("aria-valuetext", `increment ${told.increment}`);
    const row = runs[0].history.increment?.indexOf(told.increment) ?? -1;
    Report.charts.forEach((chart) =>
      chart.mark(...(chart.placeOf?.(state.frame) ?? [Report.xOf(state.frame), row])),
    );
    Report.tellPicked(frame);
    Report.drawRoses(frame);
  };

  Report.restyle = () => {
    Report.drawLegend(state.colour, state.layers);
    Report.paint(state.now, state.before);
  };

  // Colours grains by this.
  Report.colourBy = (key) => {
    state.colour = node("colour").value = key;
    Report.restyle();
  };

  function offer() {
    const { frames, ranges } = movie;
    const lacks = {
      velocity: ranges.velocity[1] === 0,
      fragment: movie.bonds === 0,
      material: movie.materials.length < 2,
      group: movie.groups.length === 0,
      strain: frames.length <= movie.start + 1,
      "strain-step": frames.length <= movie.start + 1,
    };
    for (const [key, way] of Object.entries(Report.COLOURS))
      if (!lacks[key]) node("colour").append(make("option", { value: key }, way.name));
    // Rotations show where a specimen that is tested shears; grains that flow move.
    state.colour = Report.isStrained ? "rotation" : "displacement";
    node("colour").value = state.colour;
    const isBonded = movie.bonds > 0,
      isWrapped = frames.some((frame) => frame.membranes.length > 0);
    const layers = [
      [isBonded, "cracks", "broken bonds", true],
      [isBonded, "bonds", "bonds", false],
      [true, "chains", "force chains", !isBonded],
      [true, "normals", "contact normals", false],
      [true, "spokes", "rotation marks", false],
      [isWrapped, "membrane", "membrane", true],
    ];
    for (const [isThere, key, name, on] of layers) {
      if (!isThere) continue;
      state.layers[key] = on;
      const box = make("input", {
        type: "checkbox",
        id: `layer-${key}`,
        checked: on,
        onchange: (event) => {
          state.layers[key] = event.target.checked;
          Report.restyle();
        },
      });
      node("layers").append(make("label", {}, box, name));
    }
    node("slider").max = frames.length - 1;
    // Frames worth a jump.
    const { record, events } = runs[0];
    const button = (text, onclick) => node("jumps").append(make("button", { onclick }, text));
    const jump = (text, k) => {
      if (k < 0) return;
      button(text, () => {
        Report.play(false);
        Report.show(k);
      });
    };
    jump("start", movie.start);
    if (events.increment?.length)
      button("first rupture", () => Report.showBond(events.bond[0], events.increment[0]));
    const stress = record.results.peak_stress_pa,
      force = Report.peakOfForce(runs[0]);
    const isPeak = (frame) => frame.stress !== null && Math.abs(frame.stress / stress - 1) < 1e-6;
    // Without a stress the frame nearest to the peak of the force.
    const ofForce = () => (force ? Report.frameOf(force.increment) : -1);
    const peak = stress === null ? ofForce() : frames.findIndex(isPeak);
    jump("peak", peak);
    jump("end", frames.length - 1);
    Report.peakFrame = peak;
  }

  async function begin() {
    Report.writeHeader(runs);
    Report.drawCurves(
      movie
        ? (x) => {
            Report.play(false);
            Report.show(Report.nearestFrame(x));
          }
        : null,
    );
    if (runs.length === 1) {
      const parts = [
        Report.credibility(runs[0]),
        Report.ledger(runs[0]),
        Report.ruptures(runs[0], movie ? Report.showBond : null),
        Report.scene(runs[0]),
      ];
      node("more").append(...parts.filter(Boolean));
    }
    if (!movie) return;
    node("movie").hidden = false;
    await Report.loadStill();
    const { radius } = Report.still;
    Report.meanRadius = radius.reduce((a, b) => a + b, 0) / Math.max(1, radius.length);
    Report.hasRolling = (runs[0].record.results.bonds_broken.rolling ?? 0) > 0;
    offer();
    Report.view = Report.openView(node("canvas"));
    Report.drawLegend(state.colour, state.layers);
    await Report.show(Report.peakFrame >= 0 ? Report.peakFrame : movie.frames.length - 1);
    Report.listen();
    await Report.follow(location.hash);
    addEventListener("hashchange", () => Report.follow(location.hash));
    // The rest is unpacked while nothing else is to be done.
    (async () => {
      for (let k = 0; k < movie.frames.length; k++) await Report.frame(k);
    })();
  }

  Report.ready = begin().catch((error) => {
    node("message").textContent = error.message;
    throw error;
  });
})();
