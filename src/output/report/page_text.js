// Words and tables: key results, credibility, ledger, ruptures, scene.
"use strict";
(() => {
  const { make, format, si } = Report;
  const percent = (x, digits = 4) =>
    x === null || x === undefined ? "\u2013" : `${format(100 * x, digits)} %`;
  const count = (n, one, several) => `${format(n)} ${n === 1 ? one : several}`;
  const row = (cells, tag = "td") =>
    make(
      "tr",
      {},
      ...cells.map((cell) => {
        const is = typeof cell === "object" && !(cell instanceof Node);
        return make(tag, is ? { class: cell.class } : {}, is ? cell.text : cell);
      }),
    );
  const n = (text) => ({ class: "n", text: String(text) });
  const table = (head, rows) =>
    make(
      "table",
      {},
      make("thead", {}, row(head, "th")),
      make("tbody", {}, ...rows.map((cells) => row(cells))),
    );
  Report.table = table;
  Report.numeric = n;

  // Key results: name, name in the record, text.
  const pascals = (x) => si(x, "Pa");
  const broken = (r) => r.bonds_broken.tension + r.bonds_broken.shear + r.bonds_broken.rolling;
  const RESULTS = [
    ["Peak stress", "peak_stress_pa", pascals],
    ["Strain at peak", "strain_at_peak", percent],
    ["Young\u2019s modulus", "youngs_modulus_pa", pascals],
    ["Secant modulus to half of the rise", "youngs_modulus_secant_half_peak_pa", pascals],
    ["Stress at first crack", "first_crack_stress_pa", pascals],
    ["Poisson\u2019s ratio", "poissons_ratio", format],
    ["Crack initiation", "crack_initiation_stress_pa", pascals],
    ["Crack damage", "crack_damage_stress_pa", pascals],
    ["Residual strength", "residual_strength_pa", pascals],
    ["Friction angle", "friction_angle_rad", (x) => `${format((x * 180) / Math.PI)}\u00b0`],
    ["Limit load", "limit_load_pa", pascals],
    ["Porosity", "porosity", format],
  ];
  // Names and texts of the results that a run has: those of earlier versions lack some.
  const resultsOf = (r) => {
    const isThere = ([, key]) => typeof r[key] === "number";
    const texts = RESULTS.filter(isThere).map(([name, key, text]) => [name, text(r[key])]);
    if (r.bonds_created > 0)
      texts.push(["Broken bonds", `${format(broken(r))} of ${format(r.bonds_created)}`]);
    if (broken(r) > 0) {
      const { tension, shear, rolling } = r.bonds_broken;
      texts.push(["Broken in tension, shear, rolling", [tension, shear, rolling].join(", ")]);
    }
    return texts;
  };

  // Peak of the force and displacement there, of a run without a stress: names and texts.
  const peakOfForce = (run) => {
    const peak = Report.peakOfForce(run);
    if (!peak) return [];
    const { probe, direction } = peak,
      turns = direction.endsWith("clockwise");
    const way = `${probe}, ${direction.replace("-", "\u2212")}`;
    return [
      [`Peak ${turns ? "moment" : "force"} (${way})`, si(peak.force, turns ? "N m" : "N")],
      [
        turns ? "Rotation at the peak" : "Displacement at the peak",
        si(peak.motion, turns ? "rad" : "m"),
      ],
    ];
  };

  const outcome = (record) => {
    const { status, increment, message } = record.outcome;
    const told =
      {
        completed: "completed",
        collapsed: "the specimen collapsed",
        interrupted: "interrupted",
        undecided: "undecided",
        running: "not finished",
        refused: "stopped: a stage cannot begin",
      }[status] ?? status;
    // The message of a completed run is about its stages.
    const where = status === "completed" ? "" : `increment ${increment}: `;
    return (
      `${told} after ${count(record.increments, "increment", "increments")}` +
      (message ? ` (${where}${message})` : "")
    );
  };

  Report.writeHeader = (runs) => {
    const [{ record }] = runs;
    document.getElementById("title").textContent =
      runs.length === 1 ? record.title : `${runs.length} runs`;
    document.getElementById("subtitle").textContent =
      runs.length === 1
        ? `${[record.scene_file, ...record.overrides].join(", ")}: ${outcome(record)}`
        : [...new Set(runs.map((run) => run.record.title))].join("; ");
    document.getElementById("footer").textContent =
      `clastic ${record.clastic_version}. Stress is positive in compression, strain in ` +
      "contraction, rotation anticlockwise.";
    const results = document.getElementById("results");
    if (runs.length > 1) {
      results.style.display = "block";
      const head = ["", ...runs.map((run) => n(run.name))];
      const row = (name, text) => [name, ...runs.map((run) => ({ class: "n", text: text(run) }))];
      const none = (x) => verdict(x === 0, format(x));
      // The first rows show which of several runs are less reliable.
      const rows = [
        row("Marks", ({ marks }) => marks.join("; ") || "\u2013"),
        row("Outcome", ({ record: { outcome: { status } } }) =>
          verdict(["completed", "collapsed", "running"].includes(status), status),
        ),
        row("Capped increments", ({ record }) => none(record.capped_increments)),
        row("Physical warnings", ({ record }) => none(record.sanity?.warnings?.length ?? 0)),
      ];
      if (runs.some(Report.peakOfForce))
        rows.push(
          row("Peak of the force", (run) => {
            const [[name, value]] = [...peakOfForce(run), ["Peak ", null]];
            return value ? `${value}, ${name.replace("Peak ", "")}` : "\u2013";
          }),
        );
      const texts = runs.map((run) => new Map(resultsOf(run.record.results)));
      const known = RESULTS.map(([name]) => name).concat(texts.flatMap((of) => [...of.keys()]));
      for (const name of new Set(known))
        if (texts.some((of) => of.has(name)))
          rows.push([name, ...texts.map((of) => n(of.get(name) ?? "\u2013"))]);
      const scrolled = make("div", { class: "scroll wide-table" }, table(head, rows));
      const cue = make("p", { class: "hint" });
      results.append(cue, scrolled);
      // A table that is wider than the window says so.
      new ResizeObserver(() => {
        const isWide = scrolled.scrollWidth > scrolled.clientWidth + 1;
        cue.textContent = isWide ? `${runs.length} runs; scroll the table sideways \u2192` : "";
      }).observe(scrolled);
      return;
    }
    const card = (value, name, isFirst = false) =>
      results[isFirst ? "prepend" : "append"](
        make("div", { class: "card" }, make("b", {}, value), make("span", {}, name)),
      );
    for (const [name, value] of resultsOf(record.results)) card(value, name);
    for (const [name, value] of peakOfForce(runs[0]).reverse()) card(value, name, true);
  };

  const panel = (title, ...content) => make("div", {}, make("h2", {}, title), ...content);
  const verdict = (good, text) => make("span", { class: good ? "good" : "warn" }, text);

  const RESIDUALS = {
    balance: "the balance",
    kinematics: "the kinematics",
    cone: "the limits",
    complementarity: "complementarity",
  };

  // Reliability of the numbers.
  Report.credibility = ({ record, history, avalanches, events }) => {
    const r = record.results,
      limit = record.settings.acceptance.residual,
      rows = [];
    const add = (name, good, text, note = "") =>
      rows.push([name, good === null ? text : verdict(good, text), note]);
    for (const kind of Object.keys(RESIDUALS)) {
      const { value, increment } = r.worst_residuals[kind];
      add(
        `Residual of ${RESIDUALS[kind]}`,
        value !== null && value <= limit,
        value === null ? "not a number" : format(value, 2),
        `maximum, increment ${increment}; tolerance ${format(limit, 2)}`,
      );
    }
    const values = (name) => history[name] ?? [];
    const all = values("increment").length;
    const shorter = values("fraction").filter((f) => f !== null && f < 1).length;
    const moved = values("motion_steps").filter((steps) => steps > 0).length;
    const capped = values("caps").filter((text) => text !== "").length;
    add(
      "Capped increments",
      record.capped_increments === 0,
      format(record.capped_increments),
      "Coulomb\u2019s law holds to 1e-4, but not to the tolerance",
    );
    add(
      "Increments at an iteration limit",
      capped === 0,
      format(capped),
      "an iteration ended before it converged; the column caps names it",
    );
    add(
      "Shorter increments",
      null,
      format(shorter),
      `of ${format(all)} increments; halved, or ended by a rupture`,
    );
    add(
      "Followed motions",
      null,
      format(moved),
      "increments in which the specimen moved to another equilibrium",
    );
    const solves = values("solves").filter((s) => s !== null);
    if (solves.length)
      add(
        "Solves per increment",
        null,
        format(solves.reduce((a, b) => a + b, 0) / solves.length, 3),
        `mean; maximum ${format(solves.reduce((a, b) => Math.max(a, b), 0))}`,
      );
    const sizes = sizesOf(avalanches, events);
    if (sizes.length) {
      const largest = sizes.at(-1),
        share = largest / r.bonds_created;
      add(
        "Bonds per event",
        share < 0.05,
        `median ${format(sizes[Math.floor(sizes.length / 2)])}, largest ${format(largest)}`,
        `${count(sizes.length, "event", "events")}; ` +
          `the largest broke ${percent(share, 3)} of all bonds`,
      );
    }
    if (r.peak_error_estimate !== null) {
      add(
        "Error of the peak",
        r.peak_error_estimate <= 0.02,
        percent(r.peak_error_estimate, 2),
        "estimated from the delay with which bonds broke before the peak",
      );
    }
    const errors = values("energy_error_j").filter((e) => e !== null);
    if (errors.length) {
      const work = Math.max(
        ...["energy_external_j", "energy_gravity_j", "energy_exchange_j"].map((name) =>
          values(name).reduce((a, b) => Math.max(a, Math.abs(b ?? 0)), 0),
        ),
      );
      const worst = errors.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
      add(
        "Error of the energy",
        worst <= 0.01 * work,
        work > 0 ? percent(worst / work, 2) : si(worst, "J"),
        "maximum error over the maximum work of loads, gravity, and added or removed bodies",
      );
    } else {
      add(
        "Error of the energy",
        null,
        "not measured",
        "set output: (energy: true) in the scene to record energies",
      );
    }
    if (record.settled)
      add(
        "Settled packing",
        null,
        `${format(record.settled.porosity_before)} to ${format(record.settled.porosity_after)}`,
        "porosity before and after the first increment: the packing was not jammed",
      );
    for (const [name, reason] of Object.entries(r.not_defined))
      rows.push([name.replace(/_(pa|rad)$/, "").replaceAll("_", " "), "not defined", reason]);
    for (const warning of record.sanity?.warnings ?? [])
      rows.push(["Warning", verdict(false, "check this"), warning]);
    return panel("Reliability", table(["", "", ""], rows));
  };

  // Bonds broken by event, ascending: by avalanche, or by increment where there is none.
  function sizesOf(avalanches, events) {
    const modes = ["broken_tension", "broken_shear", "broken_rolling"].map(
      (name) => avalanches[name] ?? [],
    );
    let sizes = modes[0].map((_, k) => modes.reduce((sum, mode) => sum + mode[k], 0));
    if (!sizes.length) {
      const by = new Map();
      for (const increment of events.increment ?? [])
        by.set(increment, (by.get(increment) ?? 0) + 1);
      sizes = [...by.values()];
    }
    return sizes.sort((a, b) => a - b);
  }

  Report.ENERGIES = {
    energy_external_j: "work of loads",
    energy_gravity_j: "work of gravity",
    energy_exchange_j: "added and removed bodies",
    energy_kinetic_change_j: "kinetic",
    energy_elastic_j: "elastic",
    energy_friction_j: "friction",
    energy_rolling_j: "rolling",
    energy_dilation_j: "dilation",
    energy_collision_j: "collisions",
    energy_rupture_j: "rupture",
    energy_motion_j: "followed motions",
    energy_turning_j: "turning normals",
    energy_numerical_j: "numerical",
    energy_error_j: "error of the ledger",
  };
  Report.ledger = ({ history }) => {
    const rows = Object.entries(Report.ENERGIES)
      .filter(([name]) => history[name]?.length)
      .map(([name, text]) => [text, n(si(history[name].at(-1), "J"))]);
    return rows.length ? panel("Energies at the end", table(["", ""], rows)) : null;
  };

  // All ruptures in their order; a button shows the bond in the picture.
  Report.ruptures = ({ events, history }, show) => {
    const number = events.increment?.length ?? 0;
    if (!number) return null;
    const strains = new Map(
      (history.increment ?? []).map((increment, k) => [increment, history.axial_strain?.[k]]),
    );
    const MOST = 500;
    const rows = [];
    for (let k = 0; k < Math.min(number, MOST); k++) {
      const increment = events.increment[k];
      const button = show
        ? make("button", { onclick: () => show(events.bond[k], increment) }, "show")
        : "";
      rows.push([
        n(k + 1),
        n(increment),
        n(percent(strains.get(increment) ?? null)),
        n(events.bond[k]),
        events.mode[k],
        n(si(events.p_n[k], "N", 3)),
        n(si(events.q_n[k], "N", 3)),
        button,
      ]);
    }
    const head = [n("#"), n("increment"), n("strain"), n("bond"), "mode", n("p"), n("q"), ""];
    const note =
      number > MOST
        ? [
            make(
              "p",
              { class: "hint" },
              `The first ${MOST} of ${format(number)}; all are in events.csv.`,
            ),
          ]
        : [];
    return panel(
      "Ruptures in order",
      make("div", { class: "scroll", id: "ruptures" }, table(head, rows)),
      ...note,
    );
  };

  Report.scene = ({ scene, record }) => {
    const summary = make("summary", {}, `Scene (${record.scene_file})`);
    return make("div", { class: "wide" }, make("details", {}, summary, make("pre", {}, scene)));
  };
})();
