// The specimen on WebGL2: one instance for every grain and for every stroke.
"use strict";
(() => {
  const { movie } = Report.data;

  const HEAD = `#version 300 es
    precision highp float;
    uniform vec4 camera;   // clip = (place - camera.xy) * camera.zw
    uniform vec2 pixel;    // a pixel in m, and one in clip space along x`;
  const DISK = [
    `${HEAD}
    layout(location = 0) in vec2 corner;
    layout(location = 1) in float x; layout(location = 2) in float y;
    layout(location = 3) in float radius; layout(location = 4) in float turn;
    layout(location = 5) in vec4 colour;
    out vec2 at; out vec4 tint; out vec2 mark; out float pixels;
    void main() {
      at = corner * 1.08; tint = colour;
      mark = vec2(cos(turn), sin(turn)); pixels = radius / pixel.x;
      vec2 place = vec2(x, y) + at * radius;
      bool is_there = colour.a > 0.5;
      gl_Position = vec4(is_there ? (place - camera.xy) * camera.zw : vec2(2.0), 0.0, 1.0);
    }`,
    `${HEAD}
    in vec2 at; in vec4 tint; in vec2 mark; in float pixels;
    uniform float spokes;
    out vec4 ink;
    void main() {
      float far = length(at), edge = 1.0 / max(pixels, 1.0);
      float inside = 1.0 - smoothstep(1.0 - edge, 1.0 + edge, far);
      if (inside <= 0.0) discard;
      // A dark rim, as wide as fits.
      float rim = smoothstep(1.0 - max(0.1, 1.6 * edge), 1.0, far) * smoothstep(2.0, 6.0, pixels);
      float along = dot(at, mark), across = abs(dot(at, vec2(-mark.y, mark.x)));
      float spoke = spokes * step(0.0, along) * (1.0 - smoothstep(0.06, 0.06 + edge, across));
      ink = vec4(tint.rgb * (1.0 - 0.55 * max(rim, spoke)), inside);
    }`,
  ];
  const LINE = [
    `${HEAD}
    layout(location = 0) in vec2 corner;
    layout(location = 1) in vec4 ends; layout(location = 2) in vec2 width;
    layout(location = 3) in vec4 colour;
    out vec4 tint; out float across; out float half_pixels;
    void main() {
      vec2 way = ends.zw - ends.xy;
      float far = length(way);
      vec2 along = far > 0.0 ? way / far : vec2(1.0, 0.0);
      float wide = max(width.x, 0.5 * width.y * pixel.x);
      tint = colour; half_pixels = wide / pixel.x; across = corner.y * (half_pixels + 1.0);
      vec2 place = mix(ends.xy, ends.zw, 0.5 + 0.5 * corner.x)
        + vec2(-along.y, along.x) * corner.y * (wide + pixel.x);
      gl_Position = vec4((place - camera.xy) * camera.zw, 0.0, 1.0);
    }`,
    `${HEAD}
    in vec4 tint; in float across; in float half_pixels;
    out vec4 ink;
    void main() {
      float inside = clamp(half_pixels - abs(across) + 0.5, 0.0, 1.0)
        * min(1.0, 2.0 * half_pixels + 0.3);
      ink = vec4(tint.rgb, tint.a * inside);
    }`,
  ];

  function program(gl, sources) {
    const made = gl.createProgram();
    [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, k) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, sources[k]);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    });
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    const at = (name) => gl.getUniformLocation(made, name);
    return { made, camera: at("camera"), pixel: at("pixel"), spokes: at("spokes") };
  }

  class GlView extends Report.Camera {
    constructor(canvas) {
      super(canvas);
      // Printing and the tests read the drawing.
      const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
      if (!gl) throw new Error("this browser offers none");
      this.gl = gl;
      this.programs = { disk: program(gl, DISK), line: program(gl, LINE) };
      const corners = this.filled(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
      this.disks = this.array(corners, [
        [1, 1],
        [2, 1],
        [3, 1],
        [4, 1],
        [5, 4, gl.UNSIGNED_BYTE],
      ]);
      this.lines = this.array(corners, [
        [1, 4, gl.FLOAT, 24, 0],
        [2, 2, gl.FLOAT, 24, 16, 1],
        [3, 4, gl.UNSIGNED_BYTE],
      ]);
      this.number = 0;
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      canvas.addEventListener("webglcontextlost", () => {
        document.getElementById("message").textContent = "The picture was lost. Reload the page.";
      });
    }

    filled(data) {
      const { gl } = this,
        buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      if (data) gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      return buffer;
    }

    // Corners at 0, attributes by instance: [location, size, type, stride, offset, shared buffer].
    array(corners, attributes) {
      const { gl } = this,
        made = gl.createVertexArray(),
        buffers = {};
      gl.bindVertexArray(made);
      gl.bindBuffer(gl.ARRAY_BUFFER, corners);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
      for (const [at, size, type = gl.FLOAT, stride = 0, offset = 0, shared] of attributes) {
        buffers[at] = shared ? buffers[shared] : this.filled();
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[at]);
        gl.enableVertexAttribArray(at);
        gl.vertexAttribPointer(at, size, type, type === gl.UNSIGNED_BYTE, stride, offset);
        gl.vertexAttribDivisor(at, 1);
      }
      return { made, buffers };
    }

    load({ buffers }, at, data) {
      const { gl } = this;
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[at]);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    }

    setFrame(frame, colours, strokes, spokes) {
      this.load(this.disks, 1, frame.x);
      this.load(this.disks, 2, frame.y);
      this.load(this.disks, 3, Report.still.radius);
      this.load(this.disks, 4, frame.rotation);
      this.load(this.disks, 5, colours);
      this.load(this.lines, 1, strokes.lines);
      this.load(this.lines, 3, strokes.colours);
      this.number = strokes.lines.length / 6;
      this.spokes = spokes ? 1 : 0;
      this.isLoaded = true;
      this.draw();
    }

    drawNow() {
      const { gl, canvas, centre, metres } = this;
      const paper = parseInt(Report.colour("--paper").slice(1), 16);
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...[16, 8, 0].map((bits) => ((paper >> bits) & 255) / 255), 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      const camera = [...centre, 2 / (canvas.width * metres), 2 / (canvas.height * metres)];
      const draw = (which, array, instances) => {
        gl.useProgram(which.made);
        gl.uniform4fv(which.camera, camera);
        gl.uniform2f(which.pixel, metres, 2 / canvas.width);
        if (which.spokes) gl.uniform1f(which.spokes, this.spokes);
        gl.bindVertexArray(array.made);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, instances);
      };
      draw(this.programs.disk, this.disks, movie.bodies);
      draw(this.programs.line, this.lines, this.number);
    }
  }

  Report.GlView = GlView;
})();
