// The view without WebGL: triangles into a depth buffer by the script itself, with the shading of
// gl_view.js at a third of the resolution and not more triangles than it can draw in a second.

const SOFT_STEP = 3;
const SOFT_TRIANGLES = 70000;

class SoftView {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
  }

  begin() {
    this.width = Math.ceil(this.canvas.width / SOFT_STEP);
    this.height = Math.ceil(this.canvas.height / SOFT_STEP);
    this.nearest = new Float32Array(this.width * this.height);  // one over the depth
    this.image = new ImageData(this.width, this.height);
    this.overlays = [];
  }

  /** All vertices of a level before the eye. */
  project(scene, frame, count) {
    const { width, height } = this;
    const seen = { x: new Float32Array(count), y: new Float32Array(count),
      nearness: new Float32Array(count), eye: new Float32Array(3 * count),
      normal: new Float32Array(3 * count) };
    for (let i = 0; i < count; i++) {
      const p = frame.eye(pointOf(scene, i));
      seen.x[i] = (frame.fx * p[0] / -p[2] + 1) * width / 2;
      seen.y[i] = (1 - frame.fy * p[1] / -p[2]) * height / 2;
      seen.nearness[i] = -1 / p[2];
      seen.eye.set(p, 3 * i);
      seen.normal.set(transform(frame.rows, normalOf(scene, i)), 3 * i);
    }
    return seen;
  }

  draw(scene, view, from, to) {
    const frame = projection(scene, this.width / this.height);
    const small = ({ indices }, l) => l === 0 || indices.length <= 3 * SOFT_TRIANGLES;
    const number = scene.levels.findLastIndex((level, l) => l <= view.level && small(level, l));
    const level = scene.levels[number];
    const seen = this.project(scene, frame, level.count);
    const paint = softPaint(scene, view, seen, level);
    const left = Math.round(from * this.width), right = Math.round(to * this.width);
    for (let t = 0; t < level.indices.length; t += 3) {
      this.triangle(seen, level.indices.subarray(t, t + 3), left, right,
          (corners, weights, back) => paint(corners, weights, back, t));
    }
    this.overlays.push({ scene, view, from, to });
  }

  triangle({ x, y, nearness }, [a, b, c], from, to, paint) {
    const area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a]);
    if (!area || nearness[a] <= 0 || nearness[b] <= 0 || nearness[c] <= 0) return;
    const left = Math.max(from, Math.floor(Math.min(x[a], x[b], x[c])));
    const right = Math.min(to - 1, Math.ceil(Math.max(x[a], x[b], x[c])));
    const top = Math.max(0, Math.floor(Math.min(y[a], y[b], y[c])));
    const bottom = Math.min(this.height - 1, Math.ceil(Math.max(y[a], y[b], y[c])));
    for (let row = top; row <= bottom; row++) {
      for (let column = left; column <= right; column++) {
        const dx = column + 0.5 - x[a], dy = row + 0.5 - y[a];
        const v = (dx * (y[c] - y[a]) - (x[c] - x[a]) * dy) / area;
        const w = ((x[b] - x[a]) * dy - dx * (y[b] - y[a])) / area;
        const u = 1 - v - w;
        if (u < 0 || v < 0 || w < 0) continue;
        const near = nearness[a] * u + nearness[b] * v + nearness[c] * w;
        const pixel = row * this.width + column;
        if (near <= this.nearest[pixel]) continue;
        this.nearest[pixel] = near;
        const color = paint([a, b, c], [u, v, w], area > 0);
        for (let k = 0; k < 3; k++) this.image.data[4 * pixel + k] = 255 * color[k];
        this.image.data[4 * pixel + 3] = 255;
      }
    }
  }

  end() {
    const { context, canvas } = this;
    const small = new OffscreenCanvas(this.width, this.height);
    small.getContext('2d').putImageData(this.image, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.drawImage(small, 0, 0, canvas.width, canvas.height);
    for (const overlay of this.overlays) this.drawOverlay(overlay);
  }

  /** Lines and points over the surface, without regard to what hides them. */
  drawOverlay({ scene, view, from, to }) {
    const { context, canvas } = this, { width, height } = canvas;
    const frame = projection(scene, width / height);
    context.save();
    context.beginPath();
    context.rect(from * width, 0, (to - from) * width, height);
    context.clip();
    context.globalAlpha = 0.4;
    const strokes = (lines, box, values, ink) => {
      context.strokeStyle = `rgb(${ink.map((x) => Math.round(255 * x))})`;
      context.beginPath();
      for (let i = 0; i < lines.length; i += 2) {
        const [a, b] = [0, 1].map((k) => frame.place(placeIn(box, values, lines[i + k]), width, height));
        context.moveTo(a[0], a[1]);
        context.lineTo(b[0], b[1]);
      }
      context.stroke();
    };
    const { head, levels } = scene;
    if (view.mesh) strokes(levels[0].lines, scene.givenBox, scene.given, view.wireInk);
    if (view.lines) strokes(levels[view.level].lines, head.box, scene.positions, [0.05, 0.07, 0.1]);
    if (view.cage) strokes(scene.cageLines, head.cage_box, scene.cage, view.cageInk);
    context.globalAlpha = 1;
    if (view.points) this.drawPoints(scene, view, frame);
    context.restore();
  }

  drawPoints(scene, view, frame) {
    const { context, canvas } = this, field = fieldOf(scene, 'error');
    const gain = field.limit / view.top('error');
    for (let i = 0; i < scene.head.base; i++) {
      if (dot(transform(frame.rows, normalOf(scene, i)), frame.eye(pointOf(scene, i))) > 0) continue;
      const [x, y] = frame.place(pointOf(scene, i), canvas.width, canvas.height);
      const color = colourAt(MAPS.amount, fractionOf('amount', scene.values.error[i], 65535) * gain);
      context.fillStyle = `rgb(${color.map((part) => Math.round(255 * part))})`;
      context.beginPath();
      context.arc(x, y, 3 * view.ratio, 0, 7);
      context.fill();
      context.stroke();
    }
  }
}

/** The colour of a place in a triangle: vertices, their weights, whether its back is seen. */
function softPaint(scene, view, { normal, eye }, level) {
  const field = view.map && fieldOf(scene, view.map), values = field && scene.values[view.map];
  const top = values && (values.BYTES_PER_ELEMENT === 2 ? 65535 : 255);
  const mix = (array, corners, weights) => [0, 1, 2].map((k) =>
    array[3 * corners[0] + k] * weights[0] + array[3 * corners[1] + k] * weights[1] +
    array[3 * corners[2] + k] * weights[2]);
  const checks = view.mode === 'checker' && scene.uvs;
  const shade = (n, facing, backward, corners, weights, first) => {
    const face = Math.max(facing, 0);
    if (field) {
      const step = corners.reduce((sum, v, k) => sum + values[v] * weights[k], 0);
      const fraction = fractionOf(field.kind, step, top);
      const color = colourAt(MAPS[field.kind],
          placeOnScale(field.kind, fraction, field.limit / view.top(view.map)));
      return color.map((part) => part * (0.62 + 0.38 * face));
    }
    if (checks) {
      const { low, size } = scene.head.uv_box;
      const squares = [0, 1].map((k) => Math.floor(view.stripes * weights.reduce((sum, weight, c) =>
        sum + weight * (low[k] + size[k] * checks[2 * level.uvs[first + c] + k] / 65535), 0)));
      return ((squares[0] + squares[1]) % 2 ? CHECKS_DARK : CHECKS_LIGHT)
        .map((part) => part * (0.62 + 0.38 * face));
    }
    if (view.mode === 'smooth' || view.mode === 'checker') {
      const light = Math.max(0, 0.447 * n[0] + 0.716 * n[1] + 0.537 * n[2]);
      return [0.78, 0.80, 0.83].map((part) => part * (0.43 + 0.11 * n[1] + 0.5 * light));
    }
    const t = view.mode === 'zebra'
      ? Math.acos(Math.max(-1, Math.min(1, 2 * facing * n[1] - backward[1]))) / Math.PI * view.stripes
      : (0.358 * n[0] + 0.894 * n[1] + 0.268 * n[2]) * view.stripes * 0.5;
    const light = Math.abs(t - Math.floor(t) - 0.5) > 0.25 ? 0.96 : 0.06;
    return Array(3).fill(light * (0.7 + 0.3 * face));
  };
  return (corners, weights, back, first) => {
    const long = mix(normal, corners, weights), place = mix(eye, corners, weights);
    const length = Math.hypot(...long) * (back ? -1 : 1), away = Math.hypot(...place);
    const n = long.map((x) => x / length), backward = place.map((x) => -x / away);
    const color = shade(n, dot(n, backward), backward, corners, weights, first);
    return back ? color.map((part, k) => part * 0.55 + [0.25, 0.11, 0.25][k]) : color;
  };
}
