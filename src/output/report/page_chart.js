// Curves as SVG: round ticks, a crosshair with the values there, and a mark at the frame shown.
"use strict";
(() => {
  const { make, format } = Report;
  const RIGHT = 14,
    TOP = 10,
    BOTTOM = 42,
    LETTER = 7.7;

  function ticks(low, high, number) {
    const raw = (high - low) / number,
      size = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * size).find((step) => step >= 0.8 * raw);
    const from = Math.ceil(low / step - 1e-9),
      to = Math.floor(high / step + 1e-9);
    return Array.from({ length: Math.max(0, to - from + 1) }, (_, k) => (from + k) * step);
  }

  // As many ticks as have room for their labels beside one another, on this many pixels.
  function fitting(low, high, pixels) {
    for (let number = 6; number > 1; number--) {
      const places = ticks(low, high, number);
      const widest = Math.max(...places.map((x) => format(x).length)) * LETTER + 10;
      if ((places.length - 1) * widest <= pixels) return places;
    }
    return ticks(low, high, 1);
  }

  function range(values) {
    let low = Infinity,
      high = -Infinity;
    for (const v of values)
      if (v !== null && Number.isFinite(v)) [low, high] = [Math.min(low, v), Math.max(high, v)];
    if (low > high) return [0, 1];
    if (low === high) return [low - (Math.abs(low) || 1) / 2, high + (Math.abs(high) || 1) / 2];
    return [low, high];
  }

  // `series`: {name, colour, x, y, first} with columns; null ends a stroke. `first` is the row of the
  // history's first row.
  class Chart {
    constructor({ title, xName, yName, series, onPick, size, span, placeOf }) {
      [this.width, this.height] = size;
      this.series = series;
      const all = (axis) =>
        series.flatMap((one) => one[axis].filter((_, k) => one.x[k] !== null && one.y[k] !== null));
      // Curves of one axis have one range, so that marks of one frame stand at one place.
      this.x = range(span ?? all("x"));
      this.placeOf = placeOf;
      const [low, high] = range(all("y").concat(0));
      const room = 0.05 * (high - low);
      this.y = [low < 0 ? low - room : low, high > 0 ? high + room : high];
      // The name of the axis stands beside its widest label.
      const labels = ticks(...this.y, 5).map((y) => format(y).length);
      this.left = Math.max(62, 32 + LETTER * Math.max(...labels));
      this.names = make("div", { class: "names" });
      this.svg = make("svg", {
        viewBox: `0 0 ${size.join(" ")}`,
        role: "img",
        "aria-label": `${title}: ${yName} against ${xName}`,
      });
      this.node = make("figure", { class: "chart" }, make("h3", {}, title), this.names, this.svg);
      this.axes(xName, yName);
      for (const one of series) {
        this.svg.append(
          make("path", { class: "curve", d: this.path(one), style: `stroke: ${one.colour}` }),
        );
      }
      const line = (name) =>
        make("line", { class: name, y1: TOP, y2: this.height - BOTTOM, visibility: "hidden" });
      this.now = line("now");
      this.cross = line("cross");
      this.dots = make("g");
      this.svg.append(this.now, this.cross, this.dots);
      this.svg.addEventListener("pointermove", (event) => this.hover(this.valueAt(event)));
      this.svg.addEventListener("pointerleave", () => this.hover(null));
      if (onPick) {
        this.svg.style.cursor = "pointer";
        this.svg.addEventListener("click", (event) => onPick(this.valueAt(event)));
      }
      this.hover(null);
    }

    px(x) {
      return this.left + ((x - this.x[0]) / (this.x[1] - this.x[0])) * (this.width - this.left - RIGHT);
    }
    py(y) {
      return (
        this.height -
        BOTTOM -
        ((y - this.y[0]) / (this.y[1] - this.y[0])) * (this.height - TOP - BOTTOM)
      );
    }

    valueAt(event) {
      const box = this.svg.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * this.width;
      return this.x[0] + ((x - this.left) / (this.width - this.left - RIGHT)) * (this.x[1] - this.x[0]);
    }

    path({ x, y }) {
      let text = "",
        pen = "M";
      for (let k = 0; k < x.length; k++) {
        if (x[k] === null || y[k] === null) {
          pen = "M";
          continue;
        }
        text += `${pen}${this.px(x[k]).toFixed(1)} ${this.py(y[k]).toFixed(1)}`;
        pen = "L";
      }
      return text;
    }

    axes(xName, yName) {
      const bottom = this.height - BOTTOM;
      for (const y of ticks(...this.y, 5)) {
        this.svg.append(
          make("line", {
            class: y === 0 ? "axis" : "grid",
            x1: this.left,
            x2: this.width - RIGHT,
            y1: this.py(y),
            y2: this.py(y),
          }),
          make("text", { x: this.left - 7, y: this.py(y) + 4, "text-anchor": "end" }, format(y)),
        );
      }
      for (const x of fitting(...this.x, this.width - this.left - RIGHT)) {
        this.svg.append(
          make("line", {
            class: "axis",
            x1: this.px(x),
            x2: this.px(x),
            y1: bottom,
            y2: bottom + 4,
          }),
          make("text", { x: this.px(x), y: bottom + 17, "text-anchor": "middle" }, format(x)),
        );
      }
      const middle = (TOP + bottom) / 2;
      this.svg.append(
        make("line", { class: "axis", x1: this.left, x2: this.width - RIGHT, y1: bottom, y2: bottom }),
        make("line", { class: "axis", x1: this.left, x2: this.left, y1: TOP, y2: bottom }),
        make(
          "text",
          { x: (this.left + this.width - RIGHT) / 2, y: this.height - 6, "text-anchor": "middle" },
          xName,
        ),
        make(
          "text",
          { transform: `translate(13 ${middle}) rotate(-90)`, "text-anchor": "middle" },
          yName,
        ),
      );
    }

    // Shows the values at x in the legend; those of the mark without a pointer.
    hover(x) {
      this.pointer = x;
      const at = x ?? this.marked ?? null;
      this.cross.setAttribute("visibility", x === null ? "hidden" : "visible");
      if (x !== null) ["x1", "x2"].forEach((name) => this.cross.setAttribute(name, this.px(x)));
      this.dots.replaceChildren();
      this.names.replaceChildren(
        ...this.series.map((one) => {
          const k = at === null ? -1 : nearest(one, at, x === null ? this.row : undefined);
          const value = k < 0 ? "" : ` ${format(one.y[k])}`;
          if (k >= 0) {
            const place = { cx: this.px(one.x[k]), cy: this.py(one.y[k]), r: 4 };
            this.dots.append(make("circle", { ...place, style: `fill: ${one.colour}` }));
          }
          return make(
            "span",
            {},
            make("i", { style: `background: ${one.colour}` }),
            one.name,
            make("b", {}, value),
          );
        }),
      );
    }

    // Marks the frame shown: its x, and the row of the history.
    mark(x, row) {
      [this.marked, this.row] = [x, row];
      const isWithin = x !== null && x >= this.x[0] && x <= this.x[1];
      this.now.setAttribute("visibility", isWithin ? "visible" : "hidden");
      if (isWithin) ["x1", "x2"].forEach((name) => this.now.setAttribute(name, this.px(x)));
      if (this.pointer === null) this.hover(null);
    }
  }

  function nearest({ x, y, first }, at, row) {
    const known = row >= 0 ? row + first : -1;
    if (known >= 0 && known < x.length && x[known] !== null && y[known] !== null) return known;
    let best = -1;
    for (let k = 0; k < x.length; k++) {
      if (x[k] === null || y[k] === null) continue;
      if (best < 0 || Math.abs(x[k] - at) < Math.abs(x[best] - at)) best = k;
    }
    return best;
  }

  Report.Chart = Chart;
})();
