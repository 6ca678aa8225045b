// The picked grain, bond or contact, and its values.
"use strict";
(() => {
  const { make, format, si, state } = Report;
  const { movie } = Report.data;
  const node = (id) => document.getElementById(id);

  // Values of the picked grain or pair.
  Report.values = (frame, picked) => {
    const { still } = Report,
      { kind, row } = picked;
    if (kind === "grain") {
      return {
        grain: still.id[row],
        material: movie.materials[still.material[row]] ?? "",
        group: movie.groups[still.group[row]] ?? "",
        radius_m: still.radius[row],
        x_m: movie.origin[0] + frame.x[row],
        y_m: movie.origin[1] + frame.y[row],
        ux_m: frame.ux[row],
        uy_m: frame.uy[row],
        rotation_rad: frame.rotation[row],
        velocity_m_s: Math.hypot(frame.vx[row], frame.vy[row]),
        mean_stress_pa: frame.mean[row],
        shear_stress_pa: frame.shear[row],
        shear_strain: frame.strain[row],
        fragment: still.id[frame.fragment[row]],
      };
    }
    const of = kind === "bond" ? frame.bonds : frame.contacts,
      [a, b] = Report.ends(frame, picked);
    const name = (i) => (i < movie.bodies ? still.id[i] : movie.walls[i - movie.bodies]);
    return {
      bond: kind === "bond" ? still.bond[row] : null,
      a: name(a),
      b: name(b),
      b_is_wall: b >= movie.bodies,
      state: kind === "bond" ? frame.state[row] : 0,
      p_n: of.p[row],
      q_n: of.q[row],
      tau_nm: of.tau[row],
    };
  };

  Report.tellPicked = (frame) => {
    const { picked } = state;
    if (!picked) {
      node("picked").replaceChildren(
        make(
          "p",
          { class: "hint" },
          "Click a grain, a bond or a force for its values. Drag to move, wheel to zoom, " +
            "arrow keys for frames, space to play.",
        ),
      );
      return;
    }
    const v = Report.values(frame, picked),
      n = Report.numeric,
      rows = [];
    const add = (name, text) => rows.push([name, n(text)]);
    let title;
    if (picked.kind === "grain") {
      title = `Grain ${v.grain}`;
      add("Material", v.material + (v.group ? `, group ${v.group}` : ""));
      add("Radius", si(v.radius_m, "m"));
      add("Centre", `${si(v.x_m, "m")}, ${si(v.y_m, "m")}`);
      add("Displacement x, y", `${si(v.ux_m, "m", 3)}, ${si(v.uy_m, "m", 3)}`);
      add("Rotation", si(v.rotation_rad, "rad", 3));
      if (v.velocity_m_s !== 0) add("Velocity", si(v.velocity_m_s, "m/s", 3));
      add("Mean stress", si(v.mean_stress_pa, "Pa", 3));
      add("Maximum shear stress", si(v.shear_stress_pa, "Pa", 3));
      add("Local shear strain", `${format(100 * v.shear_strain, 3)} %`);
      if (movie.bonds) add("Fragment of grain", format(v.fragment));
    } else {
      title = v.bond === null ? "Contact" : `Bond ${v.bond}`;
      const states = v.state === 255 ? "not there" : movie.states[v.state];
      add(
        "Between",
        `grain ${v.a} and ${v.b_is_wall ? "wall (body " + v.b + ")" : "grain " + v.b}`,
      );
      add("State", states);
      add("Normal force p (compression +)", si(v.p_n, "N", 3));
      add("Shear force q", si(v.q_n, "N", 3));
      if (v.tau_nm !== 0) add("Rolling moment", si(v.tau_nm, "N m", 3));
    }
    node("picked").replaceChildren(make("h3", {}, title), Report.table(["", ""], rows));
  };

  // The pair whose stroke is near a place, or the grain there.
  Report.pickAt = (x, y) => {
    const { now: frame, layers } = state,
      { still } = Report;
    let best = null,
      nearest = Infinity;
    if (layers.bonds || layers.cracks || layers.chains || layers.normals) {
      Report.eachPair(frame, (a, b, s, p, q, tau, kind, row) => {
        const isShown =
          (layers.bonds && s === 1) ||
          (layers.cracks && s > 1) ||
          ((layers.chains || layers.normals) && p !== 0);
        if (
          !isShown ||
          Math.abs(frame.x[a] - x) > 3 * still.radius[a] ||
          Math.abs(frame.y[a] - y) > 3 * still.radius[a]
        )
          return;
        const [x1, y1] = Report.otherEnd(frame, a, b),
          far = Math.hypot(x1 - frame.x[a], y1 - frame.y[a]);
        const ra = still.radius[a],
          rb = b < movie.bodies ? still.radius[b] : ra;
        const arm = (b < movie.bodies ? (far + ra - rb) / 2 : far) / far;
        const away = Math.hypot(
          frame.x[a] + arm * (x1 - frame.x[a]) - x,
          frame.y[a] + arm * (y1 - frame.y[a]) - y,
        );
        if (away < 0.35 * Math.min(ra, rb) && away < nearest)
          [nearest, best] = [away, { kind, row, at: state.frame }];
      });
    }
    if (best) return best;
    for (let i = 0; i < movie.bodies; i++) {
      if (Math.hypot(frame.x[i] - x, frame.y[i] - y) <= still.radius[i])
        return { kind: "grain", row: i };
    }
    return null;
  };
  Report.pick = (picked) => {
    state.picked = picked;
    Report.paint(state.now, state.before);
  };

  Report.showBond = (id, increment) => {
    const row = Report.still.bond.indexOf(id);
    const k = movie.frames.findIndex((frame) => frame.increment >= increment);
    state.picked = row < 0 ? null : { kind: "bond", row };
    Report.show(k < 0 ? movie.frames.length - 1 : k);
    node("movie").scrollIntoView({ behavior: "smooth", block: "start" });
  };
})();
