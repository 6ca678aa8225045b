// Delaunay triangulation of points by a sweep from the middle outwards (Sinclair 2016,
// arXiv:1602.04707). Places are whole numbers below 2^25, so that the side of a line on which a
// point lies is exact in double precision.
"use strict";
(() => {
  const CELLS = 2 ** 25 - 1;
  const NONE = -1;

  // Corners of the triangles, three indices each.
  Report.triangles = (xs, ys) => {
    const n = xs.length;
    const low = (of) => of.reduce((a, b) => Math.min(a, b), Infinity),
      high = (of) => of.reduce((a, b) => Math.max(a, b), -Infinity);
    const [left, bottom] = [low(xs), low(ys)];
    const step = Math.max(high(xs) - left, high(ys) - bottom) / CELLS || 1;
    const x = Float64Array.from(xs, (x) => Math.round((x - left) / step)),
      y = Float64Array.from(ys, (y) => Math.round((y - bottom) / step));
    return sweep(x, y, n);
  };

  function sweep(x, y, n) {
    const square = (a, b) => (x[a] - x[b]) ** 2 + (y[a] - y[b]) ** 2;
    const side = (a, b, c) => (y[a] - y[c]) * (x[b] - x[c]) - (x[a] - x[c]) * (y[b] - y[c]);
    const best = (value) => {
      let [at, smallest] = [NONE, Infinity];
      for (let i = 0; i < n; i++) {
        const v = value(i);
        if (v < smallest) [at, smallest] = [i, v];
      }
      return at;
    };
    // The middle of the circle through three points, from the first.
    const middle = (a, b, c) => {
      const [dx, dy, ex, ey] = [x[b] - x[a], y[b] - y[a], x[c] - x[a], y[c] - y[a]];
      const [bl, cl, d] = [dx * dx + dy * dy, ex * ex + ey * ey, 0.5 / (dx * ey - dy * ex)];
      return [(ey * bl - dy * cl) * d, (dx * cl - ex * bl) * d];
    };
    const within = (a, b, c, p) => {
      const [dx, dy, ex, ey] = [x[a] - x[p], y[a] - y[p], x[b] - x[p], y[b] - y[p]],
        [fx, fy] = [x[c] - x[p], y[c] - y[p]];
      const [ap, bp, cp] = [dx * dx + dy * dy, ex * ex + ey * ey, fx * fx + fy * fy];
      return dx * (ey * cp - bp * fy) - dy * (ex * cp - bp * fx) + ap * (ex * fy - ey * fx) < 0;
    };

    // The first triangle: the two nearest points in the middle, with the smallest circle.
    const [cx, cy] = [x, y].map((of) => of.reduce((a, b) => a + b, 0) / n);
    const i0 = best((i) => (x[i] - cx) ** 2 + (y[i] - cy) ** 2);
    let i1 = best((i) => (i === i0 ? Infinity : square(i, i0) || Infinity));
    if (i1 < 0) return [];
    let i2 = best((i) => {
      const [u, v] = middle(i0, i1, i);
      return i === i0 || i === i1 || Number.isNaN(u + v) ? Infinity : u * u + v * v;
    });
    // All points lie on a line.
    if (i2 < 0) return [];
    if (side(i0, i1, i2) < 0) [i1, i2] = [i2, i1];
    let [mx, my] = middle(i0, i1, i2);
    [mx, my] = [mx + x[i0], my + y[i0]];
    const far = Float64Array.from(x, (_, i) => (x[i] - mx) ** 2 + (y[i] - my) ** 2);
    const order = Uint32Array.from(x.keys()).sort((a, b) => far[a] - far[b]);

    const most = Math.max(1, 2 * n - 5);
    const corner = new Uint32Array(3 * most),
      twin = new Int32Array(3 * most);
    let length = 0;
    const [before, next, edge] = [0, 1, 2].map(() => new Uint32Array(n));
    // The outline by direction from the middle.
    const size = Math.ceil(Math.sqrt(n)),
      hash = new Int32Array(size).fill(NONE);
    const key = (i) => {
      const [dx, dy] = [x[i] - mx, y[i] - my],
        part = dx / (Math.abs(dx) + Math.abs(dy) || 1);
      return Math.floor(((dy > 0 ? 3 - part : 1 + part) / 4) * size) % size;
    };
    let first = i0;

    const link = (a, b) => {
      twin[a] = b;
      if (b !== NONE) twin[b] = a;
    };
    const add = (a, b, c, ab, bc, ca) => {
      const t = length;
      [corner[t], corner[t + 1], corner[t + 2]] = [a, b, c];
      link(t, ab);
      link(t + 1, bc);
      link(t + 2, ca);
      length += 3;
      return t;
    };
    const stack = [];
    // Turns the diagonals of quadrangles until no circle has a point within.
    const settle = (a) => {
      let right;
      stack.length = 0;
      for (;;) {
        const b = twin[a],
          a0 = a - (a % 3);
        right = a0 + ((a + 2) % 3);
        if (b !== NONE) {
          const b0 = b - (b % 3),
            al = a0 + ((a + 1) % 3),
            bl = b0 + ((b + 2) % 3);
          const [p, q] = [corner[right], corner[bl]];
          if (within(p, corner[a], corner[al], q)) {
            [corner[a], corner[b]] = [q, p];
            const outer = twin[bl];
            if (outer === NONE) {
              let e = first;
              do {
                if (edge[e] === bl) {
                  edge[e] = a;
                  break;
                }
                e = before[e];
              } while (e !== first);
            }
            link(a, outer);
            link(b, twin[right]);
            link(right, bl);
            stack.push(b0 + ((b + 1) % 3));
            continue;
          }
        }
        if (!stack.length) return right;
        a = stack.pop();
      }
    };

    [next[i0], before[i2]] = [i1, i1];
    [next[i1], before[i0]] = [i2, i2];
    [next[i2], before[i1]] = [i0, i0];
    [edge[i0], edge[i1], edge[i2]] = [0, 1, 2];
    for (const i of [i0, i1, i2]) hash[key(i)] = i;
    add(i0, i1, i2, NONE, NONE, NONE);
    let last = NONE;
    for (const i of order) {
      const isSame = last !== NONE && x[i] === x[last] && y[i] === y[last];
      last = i;
      if (isSame || i === i0 || i === i1 || i === i2) continue;
      // An edge of the outline that the point sees.
      let start = 0;
      for (let j = 0, k = key(i); j < size; j++) {
        start = hash[(k + j) % size];
        if (start !== NONE && start !== next[start]) break;
      }
      start = before[start];
      let e = start;
      while (side(i, e, next[e]) >= 0) {
        e = next[e];
        if (e === start) {
          e = NONE;
          break;
        }
      }
      if (e === NONE) continue;
      let t = add(e, i, next[e], NONE, NONE, edge[e]);
      edge[i] = settle(t + 2);
      edge[e] = t;
      // Further edges on its two sides. What leaves the outline is followed by itself.
      let m = next[e];
      for (let q; (q = next[m]), side(i, m, q) < 0; m = q) {
        t = add(m, i, q, edge[i], NONE, edge[m]);
        edge[i] = settle(t + 2);
        next[m] = m;
      }
      if (e === start)
        for (let q; (q = before[e]), side(i, q, e) < 0; e = q) {
          t = add(q, i, e, NONE, edge[e], edge[q]);
          settle(t + 2);
          edge[q] = t;
          next[e] = e;
        }
      first = before[i] = e;
      next[e] = before[m] = i;
      next[i] = m;
      hash[key(i)] = i;
      hash[key(e)] = e;
    }
    return [...corner.subarray(0, length)];
  }
})();
