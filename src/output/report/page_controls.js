// Playing, and what mouse, fingers and keys do.
"use strict";
(() => {
  const { make, state } = Report;
  const { movie } = Report.data;
  const node = (id) => document.getElementById(id);

  // Play: the time between frames is that of the speed, or longer if drawing takes longer.
  let last = 0;
  function tick(time) {
    if (!state.isPlaying) return;
    if (!Report.isBusy && time - last >= 1000 / Number(node("speed").value)) {
      last = time;
      if (state.frame + 1 >= movie.frames.length) return Report.play(false);
      Report.show(state.frame + 1);
    }
    requestAnimationFrame(tick);
  }
  Report.play = (on = !state.isPlaying) => {
    state.isPlaying = on;
    node("play").textContent = on ? "\u275a\u275a" : "\u25b6";
    node("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return;
    if (state.frame + 1 >= movie.frames.length) Report.show(0);
    requestAnimationFrame(tick);
  };

  // Settings in a link to the page, as in `report.html#colour=material&frame=177&show=bonds`:
  // `frame` is an increment, start, peak or end, `show` the layers that are drawn.
  Report.follow = async (hash) => {
    const asked = new URLSearchParams(hash.slice(1));
    const show = asked.get("show")?.split(",");
    if (show)
      for (const box of document.querySelectorAll("#layers input"))
        if (box.checked !== show.includes(box.id.slice(6))) box.click();
    const at = asked.get("frame"),
      last = movie.frames.length - 1;
    const named = { start: movie.start, peak: Report.peakFrame, end: last }[at];
    if (at) await Report.show(named ?? Report.frameOf(Number(at) || 0));
    const options = [...node("colour").options].map((option) => option.value);
    if (options.includes(asked.get("colour"))) Report.colourBy(asked.get("colour"));
  };

  Report.listen = () => {
    const canvas = node("canvas"),
      { view } = Report,
      fingers = new Map();
    node("slider").addEventListener("input", (event) => {
      Report.play(false);
      Report.show(Number(event.target.value));
    });
    node("play").addEventListener("click", () => Report.play());
    node("closer").addEventListener("click", () => view.zoom(1.4));
    node("farther").addEventListener("click", () => view.zoom(1 / 1.4));
    node("all").addEventListener("click", () => {
      view.showAll();
      view.draw();
    });
    node("colour").addEventListener("change", (event) => Report.colourBy(event.target.value));
    node("find").addEventListener("submit", (event) => {
      event.preventDefault();
      const id = Number(node("number").value),
        kind = node("kind").value;
      const row = (kind === "grain" ? Report.still.id : Report.still.bond).indexOf(id);
      if (row < 0)
        node("picked").replaceChildren(make("p", {}, `No ${kind} ${id} in these frames.`));
      else Report.pick({ kind, row });
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        view.zoom(Math.exp(-0.0015 * event.deltaY), event.clientX, event.clientY);
      },
      { passive: false },
    );
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      if (!fingers.size) moved = 0;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture?.(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const from = fingers.get(event.pointerId),
        to = [event.clientX, event.clientY];
      if (!from) return;
      moved += Math.hypot(to[0] - from[0], to[1] - from[1]);
      const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const gap = (at) => Math.hypot(at[0] - other[0], at[1] - other[1]);
        if (gap(from) > 0)
          view.zoom(gap(to) / gap(from), (to[0] + other[0]) / 2, (to[1] + other[1]) / 2);
      } else if (moved > 4) {
        canvas.classList.add("dragged");
        view.pan(to[0] - from[0], to[1] - from[1]);
      }
      fingers.set(event.pointerId, to);
    });
    const up = (event) => {
      const isClick = event.type === "pointerup" && fingers.size === 1 && moved <= 4;
      fingers.delete(event.pointerId);
      canvas.classList.remove("dragged");
      if (isClick) Report.pick(Report.pickAt(...view.place(event.clientX, event.clientY)));
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const tag = event.target.tagName,
        type = event.target.type;
      if (tag === "SELECT" || (tag === "INPUT" && type === "number")) return;
      const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10 }[event.key];
      if (step && type !== "range" && (event.key.startsWith("Arrow") || event.target === canvas)) {
        Report.play(false);
        Report.show(state.frame + step);
      } else if (event.key === " " && tag !== "BUTTON" && type !== "checkbox" && tag !== "SUMMARY")
        Report.play();
      else if (event.key === "+" || event.key === "=") view.zoom(1.4);
      else if (event.key === "-") view.zoom(1 / 1.4);
      else if (event.key === "0") {
        view.showAll();
        view.draw();
      } else if (event.key === "Escape") Report.pick(null);
      else return;
      event.preventDefault();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", Report.restyle);
    // Paper is white. What a browser prints of WebGL is what it composed last, in the colours of the
    // screen; so a plain canvas, which only paper shows, gets the picture in light colours.
    const print = (on) => {
      document.documentElement.classList.toggle("printed", on);
      Report.restyle();
      view.drawNow();
      if (!on) return;
      const paper = node("paper");
      [paper.width, paper.height] = [view.canvas.width, view.canvas.height];
      paper.getContext("2d").drawImage(view.canvas, 0, 0);
    };
    addEventListener("beforeprint", () => print(true));
    addEventListener("afterprint", () => print(false));
    matchMedia("print").addEventListener("change", (event) => print(event.matches));
  };
})();
