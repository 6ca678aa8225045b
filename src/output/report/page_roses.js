// Roses: how directions are spread, in classes of 10 degrees. A direction and its opposite are one.
"use strict";
(() => {
  const { make, format } = Report;
  const CLASSES = 18,
    SIZE = 100;

  function rose(title, note, weights, colour) {
    const largest = Math.max(...weights);
    const svg = make("svg", {
      viewBox: `${-SIZE - 6} ${-SIZE - 6} ${2 * SIZE + 12} ${2 * SIZE + 12}`,
      role: "img",
      "aria-label": `${title}: ${note}`,
    });
    for (const part of [0.5, 1]) {
      svg.append(make("circle", { r: SIZE * part, fill: "none", style: "stroke: var(--line)" }));
    }
    const point = (angle, r) =>
      `${(r * Math.cos(angle)).toFixed(1)} ${(-r * Math.sin(angle)).toFixed(1)}`;
    for (let k = 0; k < 2 * CLASSES && largest > 0; k++) {
      // The area of a class is its weight.
      const r = SIZE * Math.sqrt(weights[k % CLASSES] / largest);
      const [from, to] = [k, k + 1].map((k) => (k * Math.PI) / CLASSES);
      svg.append(
        make("path", {
          d: `M0 0L${point(from, r)}A${r} ${r} 0 0 0 ${point(to, r)}Z`,
          style: `fill: ${colour}; stroke: var(--panel); stroke-width: 0.7`,
        }),
      );
    }
    return make("figure", {}, svg, make("figcaption", {}, make("b", {}, title), make("br"), note));
  }

  Report.drawRoses = (frame) => {
    const bins = () => new Array(CLASSES).fill(0);
    const [contacts, forces, cracks] = [bins(), bins(), bins()];
    let [touching, broken] = [0, 0];
    Report.eachPair(frame, (a, b, state, p) => {
      const [x, y] = Report.otherEnd(frame, a, b);
      const angle = Math.atan2(y - frame.y[a], x - frame.x[a]);
      if (Number.isNaN(angle)) return;
      const k = Math.floor(((angle + 2 * Math.PI) / Math.PI) * CLASSES + 1e-9) % CLASSES;
      if (p > 0) {
        contacts[k] += 1;
        forces[k] += p;
        touching += 1;
      }
      if (state > 1) {
        cracks[k] += 1;
        broken += 1;
      }
    });
    const means = forces.map((f, k) => (contacts[k] ? f / contacts[k] : 0));
    document
      .getElementById("roses")
      .replaceChildren(
        rose("Normals", `${format(touching)} in compression`, contacts, "var(--series-0)"),
        rose("Mean force", "of these, by direction", means, "var(--series-5)"),
        rose("Cracks", `normals of ${format(broken)} broken bonds`, cracks, "var(--tension)"),
      );
  };
})();
