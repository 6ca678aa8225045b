// Runs in the page of `tests/program/report.rs`: uses it as a reader does, and leaves what it saw
// as JSON in the element `seen`.
"use strict";
(async () => {
  const seen = { errors: window.errors };
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const { data, state } = Report;
  const canvas = document.getElementById("canvas");
  const slider = document.getElementById("slider");

  // The picture is drawn, and the frame is this one.
  const shown = async (k) => {
    for (let n = 0; n < 400 && (state.frame !== k || Report.isBusy); n++) await wait(10);
    Report.view.drawNow();
  };
  const picture = () => {
    const { gl } = Report.view,
      bytes = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  };
  const differing = (a, b) =>
    a.reduce((sum, byte, i) => sum + (Math.abs(byte - b[i]) > 8), 0) / a.length;
  const slide = async (k) => {
    slider.value = k;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await shown(k);
    return picture();
  };
  const click = (x, y) => {
    const at = { clientX: x, clientY: y, pointerId: 1, bubbles: true, isPrimary: true };
    canvas.dispatchEvent(new PointerEvent("pointerdown", at));
    canvas.dispatchEvent(new PointerEvent("pointerup", at));
    Report.view.drawNow();
  };
  const key = (name) =>
    document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));

  try {
    await Report.ready;
    seen.sources = [...document.querySelectorAll("[src], link[href]")].map(
      (node) => node.src || node.href,
    );
    const last = data.movie.frames.length - 1;
    seen.frames = data.movie.frames.map((frame) => frame.increment);

    // The slider moves the picture; the same frame gives the same one.
    const end = await slide(last),
      start = await slide(0),
      again = await slide(last);
    seen.changed = differing(start, end);
    seen.unchanged = differing(again, end);
    key("ArrowLeft");
    await shown(last - 1);
    seen.arrow = state.frame;
    key("End");
    await slide(last);

    // Every 19th grain: clicked where it is drawn, with its values.
    for (const box of document.querySelectorAll("#layers input")) if (box.checked) box.click();
    const frame = await Report.frame(last),
      { still } = Report;
    const chosen = [...still.id.keys()].filter((i) => i % 19 === 7).slice(0, 20);
    seen.grains = chosen.map((i) => {
      click(...Report.view.point(frame.x[i], frame.y[i]));
      const { picked } = state;
      const text = document.getElementById("picked").textContent;
      return {
        clicked: picked?.kind === "grain" ? still.id[picked.row] : null,
        text,
        ...Report.values(frame, { kind: "grain", row: i }),
      };
    });

    // Bonds: clicked at their contact points, with the bonds shown.
    document.getElementById("layer-bonds").click();
    document.getElementById("layer-cracks").click();
    const bonds = [...still.bond.keys()]
      .filter((k) => k % 31 === 5 && still.b[k] < data.movie.bodies)
      .slice(0, 20);
    seen.bonds = bonds.map((k) => {
      const [a, b] = [still.a[k], still.b[k]],
        far = Math.hypot(frame.x[b] - frame.x[a], frame.y[b] - frame.y[a]);
      const part = (far + still.radius[a] - still.radius[b]) / 2 / far;
      click(
        ...Report.view.point(
          frame.x[a] + part * (frame.x[b] - frame.x[a]),
          frame.y[a] + part * (frame.y[b] - frame.y[a]),
        ),
      );
      const { picked } = state;
      return {
        clicked: picked?.kind === "bond" ? still.bond[picked.row] : null,
        ...Report.values(frame, { kind: "bond", row: k }),
      };
    });

    // All contacts without a bond.
    seen.contacts = [];
    Report.eachPair(frame, (a, b, of, p, q, tau, kind, row) => {
      if (kind === "contact") seen.contacts.push(Report.values(frame, { kind, row }));
    });

    // Every way to colour and every layer draws something.
    seen.colours = {};
    for (const { value } of document.getElementById("colour").options) {
      document.getElementById("colour").value = value;
      document.getElementById("colour").dispatchEvent(new Event("change"));
      for (let n = 0; n < 1000 && state.colour !== value; n++) await wait(10);
      Report.view.drawNow();
      seen.colours[value] = differing(picture(), end);
    }
    // Strains of the same grains, since the start and since the frame before.
    const strains = [frame.strain, frame.strainStep];
    seen.strains = chosen.map((i) => strains.map((of) => of[i]));
    // A resize leaves no blank picture behind.
    const box = document.getElementById("picture");
    box.style.width = "480px";
    await new Promise((done) => new ResizeObserver(() => done()).observe(canvas));
    const small = picture();
    const small_width = canvas.width;
    seen.resized = [small_width, differing(small, small.map((_, i) => small[i % 4]))];
    await wait(50);
    box.style.width = "";
    for (let n = 0; n < 1000 && canvas.width === small_width; n++) await wait(10);
    // A link asks for a frame and a colour.
    await Report.follow("#frame=start&colour=strain-step&show=bonds");
    seen.followed = [state.frame === data.movie.start, state.colour, state.layers.bonds];
    await Report.follow("#frame=end&show=cracks,bonds");
    Report.view.drawNow();

    // Zoom and back; a jump to the first rupture picks its bond.
    const before = picture();
    key("+");
    Report.view.drawNow();
    seen.zoomed = differing(picture(), before);
    key("0");
    Report.view.drawNow();
    seen.back = differing(picture(), before);
    [...document.querySelectorAll("#jumps button")]
      .find((button) => button.textContent === "first rupture")
      .click();
    await wait(300);
    seen.first = {
      bond: still.bond[state.picked.row],
      increment: data.movie.frames[state.frame].increment,
    };
    seen.curves = [...document.querySelectorAll(".chart h3")].map((title) => title.textContent);
    seen.marked = [...document.querySelectorAll(".chart .now")].map((line) =>
      line.getAttribute("visibility"),
    );
    // The browser is in dark mode; paper is light, with the same picture, and the screen stays dark.
    const corner = (bytes) => Math.max(...bytes.subarray(0, 3));
    dispatchEvent(new Event("beforeprint"));
    const paper = document.getElementById("paper");
    const { data: printed } = paper
      .getContext("2d")
      .getImageData(0, 0, paper.width, paper.height);
    dispatchEvent(new Event("afterprint"));
    seen.paper = [paper.width === canvas.width, paper.height === canvas.height];
    seen.corners = [corner(printed), corner(picture())];
    seen.inked = printed.reduce((sum, byte) => sum + (byte < 240), 0) / printed.length;
    seen.roses = document.querySelectorAll("#roses path").length;
    seen.wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  } catch (error) {
    seen.errors.push(String(error.stack));
  }
  const node = document.createElement("pre");
  node.id = "seen";
  node.textContent = JSON.stringify(seen);
  document.body.append(node);
})();
