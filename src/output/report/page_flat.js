// The specimen on a plain canvas, for browsers without WebGL2.
"use strict";
(() => {
  const { movie } = Report.data;

  class FlatView extends Report.Camera {
    setFrame(frame, colours, strokes, spokes) {
      Object.assign(this, { frame, colours, strokes, spokes });
      this.isLoaded = true;
      this.draw();
    }

    drawNow() {
      const { canvas, centre, metres } = this,
        { width, height } = canvas,
        ink = canvas.getContext("2d");
      ink.fillStyle = Report.colour("--paper");
      ink.fillRect(0, 0, width, height);
      const px = (x) => width / 2 + (x - centre[0]) / metres,
        py = (y) => height / 2 - (y - centre[1]) / metres;
      this.drawDisks(ink, px, py);
      this.drawStrokes(ink, px, py);
    }

    drawDisks(ink, px, py) {
      const { frame, colours, metres, canvas } = this,
        { radius } = Report.still;
      ink.lineWidth = 1;
      for (let i = 0; i < movie.bodies; i++) {
        const [x, y, r] = [px(frame.x[i]), py(frame.y[i]), radius[i] / metres];
        const isSeen = x > -r && x < canvas.width + r && y > -r && y < canvas.height + r;
        if (!isSeen || colours[4 * i + 3] === 0) continue;
        const [red, green, blue] = colours.subarray(4 * i, 4 * i + 3);
        ink.fillStyle = `rgb(${red} ${green} ${blue})`;
        ink.beginPath();
        ink.arc(x, y, r, 0, 2 * Math.PI);
        ink.fill();
        if (r < 3) continue;
        const dark = [red, green, blue].map((part) => Math.round(0.45 * part));
        ink.strokeStyle = `rgb(${dark.join(" ")})`;
        if (this.spokes) {
          const turn = frame.rotation[i];
          ink.moveTo(x, y);
          ink.lineTo(x + r * Math.cos(turn), y - r * Math.sin(turn));
        }
        ink.stroke();
      }
    }

    drawStrokes(ink, px, py) {
      const { lines, colours } = this.strokes;
      ink.lineCap = "butt";
      for (let k = 0; 6 * k < lines.length; k++) {
        const [x0, y0, x1, y1, half, pixels] = lines.subarray(6 * k, 6 * k + 6);
        const [red, green, blue, alpha] = colours.subarray(4 * k, 4 * k + 4);
        ink.strokeStyle = `rgb(${red} ${green} ${blue} / ${alpha / 255})`;
        ink.lineWidth = Math.max((2 * half) / this.metres, pixels);
        ink.beginPath();
        ink.moveTo(px(x0), py(y0));
        ink.lineTo(px(x1), py(y1));
        ink.stroke();
      }
    }
  }

  Report.FlatView = FlatView;
})();
