// A turntable: the model turns about an axis that stays upright.

const FIELD_OF_VIEW = 0.6;  // radians, of the shorter side
const START = { yaw: 0.6, pitch: 0.35 };
const camera = { ...START, distance: 3, target: [0, 0, 0] };

const minus = (a, b) => a.map((x, k) => x - b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const transform = (rows, v) => rows.map((row) => dot(row, v));

/** Rows: right, up and towards the eye. `up`: the model's upright axis, y or z. */
function rotation({ yaw, pitch }, up) {
  const a = Math.cos(yaw), b = Math.sin(yaw), c = Math.cos(pitch), d = Math.sin(pitch);
  const rows = [[a, 0, -b], [-b * d, c, -a * d], [b * c, d, a * c]];
  return up === 'z' ? rows.map(([x, y, z]) => [x, -z, y]) : rows;
}

/** Angles from which the eye looks against a direction. */
function facing(direction, up) {
  const [x, y, z] = up === 'z' ? [direction[0], direction[2], -direction[1]] : direction;
  const pitch = Math.asin(Math.max(-1, Math.min(1, y / Math.hypot(x, y, z))));
  return { yaw: Math.atan2(x, z), pitch: Math.max(-1.5, Math.min(1.5, pitch)) };
}

/** What the views need to project a scene onto a picture of this aspect. */
function projection(scene, aspect) {
  const rows = rotation(camera, scene.head.up);
  const reach = 2 * scene.radius + Math.hypot(...minus(camera.target, scene.centre));
  const near = Math.max(camera.distance - reach, camera.distance / 200);
  const far = camera.distance + reach;
  const fy = Math.min(1, aspect) / Math.tan(FIELD_OF_VIEW / 2), fx = fy / aspect;
  const eye = (point) => {
    const p = transform(rows, minus(point, camera.target));
    p[2] -= camera.distance;
    return p;
  };
  /** Place in a picture of this size, and the depth before the eye. */
  const place = (point, width, height) => {
    const p = eye(point);
    return [(fx * p[0] / -p[2] + 1) * width / 2, (1 - fy * p[1] / -p[2]) * height / 2, -p[2]];
  };
  return { rows, near, far, fx, fy, eye, place };
}

/** The least distance from which every given vertex is in the picture. */
function wholeView(scene, aspect) {
  const rows = rotation(START, scene.head.up);
  const fy = Math.min(1, aspect) / Math.tan(FIELD_OF_VIEW / 2), fx = fy / aspect;
  let distance = scene.radius * 0.1;
  for (let i = 0; i < scene.head.base; i++) {
    const p = transform(rows, minus(pointOf(scene, i), scene.centre));
    const side = Math.max(Math.abs(p[0]) * fx, Math.abs(p[1]) * fy);
    distance = Math.max(distance, p[2] + 1.12 * side);
  }
  return { ...START, distance, target: [...scene.centre] };
}

/** The nearest triangle under a place of the picture: its depth before the eye, or infinity. */
function depthUnder(scene, frame, x, y, width, height) {
  const ray = [(2 * x / width - 1) / frame.fx, (1 - 2 * y / height) / frame.fy, -1];
  const level = scene.levels.at(-1), { indices, count } = level;
  const points = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) points.set(frame.eye(pointOf(scene, i)), 3 * i);
  const at = (i) => [points[3 * i], points[3 * i + 1], points[3 * i + 2]];
  let nearest = Infinity;
  for (let t = 0; t < indices.length; t += 3) {
    const a = at(indices[t]), u = minus(at(indices[t + 1]), a), v = minus(at(indices[t + 2]), a);
    // Moeller and Trumbore, 1997; the ray's z is -1, so its parameter is the depth.
    const p = cross(ray, v), determinant = dot(u, p);
    if (determinant === 0) continue;
    const s = minus([0, 0, 0], a), f = dot(s, p) / determinant;
    if (f < 0 || f > 1) continue;
    const q = cross(s, u), g = dot(ray, q) / determinant;
    if (g < 0 || f + g > 1) continue;
    const depth = dot(v, q) / determinant;
    if (depth > 0 && depth < nearest) nearest = depth;
  }
  return nearest;
}
