#!/usr/bin/env python3
"""Time that a report's page takes for a frame, in a headless browser over its DevTools connection.

    python3 -m venv target/venv && target/venv/bin/pip install websocket-client
    target/venv/bin/python benches/draw.py DIR/report.html

Chromium is `chromium`, or what the environment variable CLASTIC_CHROMIUM names. It draws in
software, so the times of the whole picture are those of a machine without a GPU. Times are wall
times of the page's thread, median and 95 % quantile over up to 40
frames spread over all, ms:

- opened: until the first picture is drawn, to 100 ms;
- unpack: from opening the page until every frame is unpacked, over the number of frames;
- script: colours, strokes and upload of a frame (`paint`, then `gl.finish`), values, roses, marks;
  and the processor time of the page's thread for it, which other processes do not lengthen;
- picture: `drawNow`, then one pixel read back, so that the drawing is done.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path

import websocket

MEASURE = """(async () => {
  await Report.ready;
  const opened = performance.now();
  const { movie } = Report.data, count = movie.frames.length, { gl, canvas } = Report.view;
  for (let k = 0; k < count; k++) await Report.frame(k);
  const which = gl?.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL;
  const told = {
    opened, frames: count, disks: movie.bodies, bonds: movie.bonds, canvas: [canvas.width, canvas.height],
    renderer: which ? gl.getParameter(which) : "no WebGL2", unpack: performance.now() / count, layers: {},
  };
  const pixel = new Uint8Array(4);
  const at = (list, part) => [...list].sort((a, b) => a - b)[Math.floor(part * (list.length - 1))];
  const boxes = [...document.querySelectorAll("#layers input")];
  const first = Object.fromEntries(boxes.map((box) => [box.id.slice(6), box.checked]));
  const all = Object.fromEntries(boxes.map((box) => [box.id.slice(6), true]));
  for (const [name, layers] of [["as opened", first], ["all layers", all]]) {
    Object.assign(Report.state.layers, layers);
    const times = { script: [], picture: [] };
    let strokes = 0;
    for (let step = 0; step < Math.min(40, count); step++) {
      const k = Math.round((step * (count - 1)) / Math.max(1, Math.min(40, count) - 1));
      const [frame, before] = [await Report.frame(k), k > 0 ? await Report.frame(k - 1) : null];
      Report.state.frame = k;
      document.getElementById("slider").value = k;
      let from = performance.now();
      Report.paint(frame, before);
      gl?.finish();
      times.script.push(performance.now() - from);
      from = performance.now();
      Report.view.drawNow();
      gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      times.picture.push(performance.now() - from);
      strokes = Math.max(strokes, Report.view.number ?? 0);
    }
    const of = (list) => [at(list, 0.5), at(list, 0.95)];
    told.layers[name] = { shown: layers, strokes, script: of(times.script), picture: of(times.picture) };
  }
  return JSON.stringify(told);
})()"""

PAINT = """(async () => {
  Object.assign(Report.state.layers, LAYERS);
  let before = null, count = Report.data.movie.frames.length;
  for (let k = 0; k < count; k++) {
    const frame = await Report.frame(k);
    Report.state.frame = k;
    Report.paint(frame, before);
    before = frame;
  }
  return JSON.stringify(count);
})()"""


def page_socket(port, seconds=60):
    """The address of the page's DevTools."""
    for _ in range(2 * seconds):
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
                pages = [one for one in json.load(answer) if one["type"] == "page"]
            if pages:
                return pages[0]["webSocketDebuggerUrl"]
        except OSError:
            pass
        time.sleep(0.5)
    raise SystemExit(f"no DevTools on port {port} after {seconds} s")


class Page:
    """A page over its DevTools."""

    def __init__(self, address):
        self.socket = websocket.create_connection(address, timeout=300)
        self.number = 0

    def ask(self, method, **params):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            answer = json.loads(self.socket.recv())
            if answer.get("id") == self.number:
                return answer["result"]

    def evaluate(self, script):
        params = {"expression": script, "awaitPromise": True, "returnByValue": True}
        result = self.ask("Runtime.evaluate", **params)
        if "exceptionDetails" in result:
            raise SystemExit(json.dumps(result["exceptionDetails"], indent=1))
        return json.loads(result["result"]["value"])

    def processor_s(self):
        """Processor time of the page's thread since `Performance.enable`."""
        metrics = self.ask("Performance.getMetrics")["metrics"]
        return next(one["value"] for one in metrics if one["name"] == "TaskDuration")

    def wait(self):
        for _ in range(600):
            if self.evaluate("JSON.stringify(typeof Report === 'object' && 'ready' in Report)"):
                return
            time.sleep(0.1)
        raise SystemExit("the page did not open within a minute")


def measure(page):
    page.wait()
    told = page.evaluate(MEASURE)
    page.ask("Performance.enable", timeDomain="threadTicks")
    for name, of in told["layers"].items():
        layers = json.dumps(of["shown"])
        before = page.processor_s()
        painted = page.evaluate(PAINT.replace("LAYERS", layers))
        of["processor"] = 1e3 * (page.processor_s() - before) / painted
    return told


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("--port", type=int, default=9333)
    parser.add_argument("--size", default="1280,1000")
    given = parser.parse_args()
    flags = "--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader"
    flags += " --disable-dev-shm-usage --no-first-run --disable-background-networking"
    flags += f" --remote-debugging-port={given.port} --remote-allow-origins=*"
    program = os.environ.get("CLASTIC_CHROMIUM", "chromium")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [program, *flags.split(), f"--window-size={given.size}"]
        command += [f"--user-data-dir={profile}", given.page.resolve().as_uri()]
        quiet = subprocess.DEVNULL
        browser = subprocess.Popen(command, stdout=quiet, stderr=quiet)
        try:
            told = measure(Page(page_socket(given.port)))
        finally:
            browser.terminate()
            browser.wait()
    canvas = "{} x {}".format(*told["canvas"])
    print(f"{told['frames']} frames, {told['disks']} disks, {told['bonds']} bonds, {canvas} pixels")
    print(told["renderer"])
    print(f"opened after {told['opened']:.0f} ms; unpack {told['unpack']:.1f} ms a frame")
    print("layers      strokes  script: processor   median   95 %   picture: median   95 %")
    for name, of in told["layers"].items():
        (script, late), (picture, slow) = of["script"], of["picture"]
        script = f"{of['processor']:19.1f}{script:9.1f}{late:7.1f}"
        print(f"{name:<12}{of['strokes']:7}{script}{picture:18.1f}{slow:7.1f}")


if __name__ == "__main__":
    main()
