// The visible part of the specimen, and when it is drawn.
"use strict";
(() => {
  const { movie } = Report.data;

  // A picture of the specimen. `drawNow` is the method of its renderer.
  class Camera {
    constructor(canvas) {
      this.canvas = canvas;
      this.showAll();
      new ResizeObserver(() => this.resize()).observe(canvas);
    }

    // The box of the run, with room around it.
    showAll() {
      const [left, bottom, right, top] = movie.view;
      this.centre = [(left + right) / 2, (bottom + top) / 2];
      this.extent = [1.06 * (right - left) || 1, 1.06 * (top - bottom) || 1];
      this.zoomed = 1;
    }

    // A canvas is blank after its size was set. It is drawn before the browser shows that, since
    // what is drawn in the next frame of the screen comes too late.
    resize() {
      const { canvas } = this,
        ratio = Math.min(2, window.devicePixelRatio || 1);
      const size = [canvas.clientWidth, canvas.clientHeight].map((pixels) =>
        Math.max(1, Math.round(pixels * ratio)),
      );
      if (canvas.width === size[0] && canvas.height === size[1]) return;
      [canvas.width, canvas.height] = size;
      if (this.isLoaded) this.drawNow();
    }

    // Metres in a pixel of the canvas.
    get metres() {
      const { canvas, extent } = this;
      return Math.max(extent[0] / canvas.width, extent[1] / canvas.height) / this.zoomed;
    }

    draw() {
      if (!this.isLoaded || this.isDue) return;
      this.isDue = true;
      requestAnimationFrame(() => {
        this.isDue = false;
        this.drawNow();
      });
    }

    // Place in the specimen of a point of the page.
    place(x, y) {
      const box = this.canvas.getBoundingClientRect(),
        { canvas, metres, centre } = this;
      const [px, py] = [(x - box.left) / box.width - 0.5, 0.5 - (y - box.top) / box.height];
      return [centre[0] + px * canvas.width * metres, centre[1] + py * canvas.height * metres];
    }

    // Point of the page of a place in the specimen.
    point(x, y) {
      const box = this.canvas.getBoundingClientRect(),
        { canvas, metres, centre } = this;
      return [
        box.left + box.width * (0.5 + (x - centre[0]) / (canvas.width * metres)),
        box.top + box.height * (0.5 - (y - centre[1]) / (canvas.height * metres)),
      ];
    }

    zoom(factor, x, y) {
      const box = this.canvas.getBoundingClientRect();
      const at = [x ?? box.left + box.width / 2, y ?? box.top + box.height / 2];
      const before = this.place(...at);
      this.zoomed = Math.min(400, Math.max(0.2, this.zoomed * factor));
      const after = this.place(...at);
      this.centre = this.centre.map((c, k) => c + before[k] - after[k]);
      this.draw();
    }

    pan(dx, dy) {
      const box = this.canvas.getBoundingClientRect(),
        ratio = this.canvas.width / box.width;
      this.centre = [
        this.centre[0] - dx * ratio * this.metres,
        this.centre[1] + dy * ratio * this.metres,
      ];
      this.draw();
    }
  }

  Report.Camera = Camera;

  // The picture on WebGL2, or without it.
  Report.openView = (canvas) => {
    try {
      return new Report.GlView(canvas);
    } catch (error) {
      // A canvas keeps the kind that it had first.
      const other = canvas.cloneNode(true);
      canvas.replaceWith(other);
      document.getElementById("message").textContent =
        `Drawn without WebGL2, more slowly: ${error.message}.`;
      return new Report.FlatView(other);
    }
  };
})();
