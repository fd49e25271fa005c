// The numbers of a job: page_scene.h says how they are written, page_scene.h in which order.

/** The bytes of a raw deflate stream in base64. */
async function inflate(base64) {
  const text = atob(base64);
  const packed = Uint8Array.from(text, (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const unzigzag = (code) => (code >>> 1) ^ -(code & 1);

/** The whole numbers of a section, each as the sum of its differences. */
function readList(bytes, section) {
  const { count, offset } = section;
  const values = new Uint32Array(count);
  let last = 0;
  for (let i = 0, at = offset; i < count; i++, at++) {
    const code = bytes[at] | bytes[at + count] << 8 | bytes[at + 2 * count] << 16 |
        bytes[at + 3 * count] << 24;
    last += unzigzag(code);
    values[i] = last;
  }
  return values;
}

/**
 * The vectors of a section, `stride` numbers apart. Where it ends before the levels do (errors are
 * known at given vertices only), the rest are the means of their parents, for the eye.
 */
function readValues(bytes, section, levels, stride) {
  const { count, width, components, offset } = section;
  const all = levels ? levels.at(-1).count : count;
  const mask = width === 1 ? 255 : 65535;
  const values = width === 1 ? new Uint8Array(all * stride) : new Uint16Array(all * stride);
  for (let c = 0; c < components; c++) {
    const at = offset + c * count * width;
    const difference = (i) => i >= count ? 0 :
        unzigzag(width === 1 ? bytes[at + i] : bytes[at + i] | bytes[at + count + i] << 8);
    const first = levels ? levels[0].count : count;
    for (let i = 0, last = 0; i < first; i++) {
      last = last + difference(i) & mask;
      values[i * stride + c] = last;
    }
    for (let l = 1; levels && l < levels.length; l++) {
      const { parents, parentOffsets } = levels[l];
      for (let k = 0, i = levels[l - 1].count; i < levels[l].count; i++, k++) {
        const begin = parentOffsets[k], end = parentOffsets[k + 1], n = end - begin;
        let sum = 0;
        for (let p = begin; p < end; p++) sum += values[parents[p] * stride + c];
        const mean = Math.floor((2 * sum + n) / (2 * n));
        values[i * stride + c] = mean + difference(i) & mask;
      }
    }
  }
  return values;
}

// Two vertices as one key; a page has fewer than 2^26 of them.
const edgeKey = (a, b) => Math.min(a, b) * 2 ** 26 + Math.max(a, b);

/** Both ends of every edge of a level's faces. */
function edgesOf({ offsets, corners }) {
  const seen = new Set(), lines = [];
  for (let f = 0; f + 1 < offsets.length; f++) {
    const begin = offsets[f], end = offsets[f + 1];
    for (let c = begin; c < end; c++) {
      const a = corners[c], b = corners[c + 1 < end ? c + 1 : begin], key = edgeKey(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      lines.push(a, b);
    }
  }
  return Uint32Array.from(lines);
}

/** The points on a level's edges, numbered as the faces meet them; `cuts` are edges on their own. */
function splitEdges({ offsets, corners }, cuts, first) {
  const points = new Map(), own = new Set(cuts), parents = [];
  const ofCorner = new Uint32Array(corners.length);
  let next = first;
  for (let f = 0; f + 1 < offsets.length; f++) {
    const begin = offsets[f], end = offsets[f + 1];
    for (let c = begin; c < end; c++) {
      const a = corners[c], b = corners[c + 1 < end ? c + 1 : begin], key = edgeKey(a, b);
      let point = own.has(c) ? undefined : points.get(key);
      if (point === undefined) {
        point = next++;
        parents.push(a, b);
        if (!points.has(key)) points.set(key, point);
      }
      ofCorner[c] = point;
    }
  }
  return { points, parents, ofCorner, count: next };
}

/** Children of triangles: one at each corner, then the one between the edges' points. */
function splitTriangles(level, edges) {
  const corners = new Uint32Array(4 * level.corners.length);
  const offsets = Uint32Array.from({ length: 4 * (level.offsets.length - 1) + 1 }, (_, f) => 3 * f);
  for (let c = 0; c < level.corners.length; c += 3) {
    const at = 4 * c, e = edges.ofCorner.subarray(c, c + 3);
    for (let k = 0; k < 3; k++) {
      corners[at + 3 * k + k] = level.corners[c + k];
      corners[at + 3 * k + (k + 1) % 3] = e[k];
      corners[at + 3 * k + (k + 2) % 3] = e[(k + 2) % 3];
      corners[at + 9 + k] = e[(k + 1) % 3];
    }
  }
  return { corners, offsets };
}

/** Children of other faces: a quad at each corner, whose place a quad's child keeps. */
function splitQuads(level, edges, firstMiddle) {
  const corners = new Uint32Array(4 * level.corners.length);
  const offsets = Uint32Array.from({ length: level.corners.length + 1 }, (_, f) => 4 * f);
  for (let f = 0, at = 0; f + 1 < level.offsets.length; f++) {
    const begin = level.offsets[f], n = level.offsets[f + 1] - begin;
    for (let k = 0; k < n; k++, at += 4) {
      const turn = n === 4 ? k : 0;
      const child = [level.corners[begin + k], edges.ofCorner[begin + k], firstMiddle + f,
        edges.ofCorner[begin + (k + n - 1) % n]];
      for (let j = 0; j < 4; j++) corners[at + (j + turn) % 4] = child[j];
    }
  }
  return { corners, offsets };
}

/** The next level: its faces, what its new vertices lie between, the halves of the input's edges. */
function splitLevel(level, cuts, triangles) {
  const faceCount = level.offsets.length - 1, middles = triangles ? 0 : faceCount;
  const edges = splitEdges(level, cuts, level.count + middles);
  const faces = triangles ? splitTriangles(level, edges) : splitQuads(level, edges, level.count);
  const edgeCount = edges.count - level.count - middles;
  const head = triangles ? [0] : [...level.offsets];
  const base = head.at(-1);
  const parentOffsets = new Uint32Array(middles + edgeCount + 1);
  parentOffsets.set(head);
  for (let e = 1; e <= edgeCount; e++) parentOffsets[middles + e] = base + 2 * e;
  const parents = new Uint32Array(base + edges.parents.length);
  if (!triangles) parents.set(level.corners);
  parents.set(edges.parents, base);
  const lines = new Uint32Array(2 * level.lines.length);
  for (let i = 0; i < level.lines.length; i += 2) {
    const a = level.lines[i], b = level.lines[i + 1], middle = edges.points.get(edgeKey(a, b));
    lines.set([a, middle, middle, b], 2 * i);
  }
  return { ...faces, parents, parentOffsets, lines, count: edges.count };
}

/**
 * The corners of the triangles of a level's faces; those with more than four are cut as `cut` says.
 */
function trianglesOf({ offsets, corners }, cut, apart) {
  const places = [];
  for (let f = 0, at = 0; f + 1 < offsets.length; f++) {
    const begin = offsets[f], n = offsets[f + 1] - begin;
    const far = (a, b) => apart(corners[begin + a], corners[begin + b]);
    if (n === 3) {
      places.push(begin, begin + 1, begin + 2);
    } else if (n === 4) {  // along the shorter diagonal
      if (far(1, 3) < far(0, 2)) places.push(begin, begin + 1, begin + 3, begin + 1, begin + 2, begin + 3);
      else places.push(begin, begin + 1, begin + 2, begin, begin + 2, begin + 3);
    } else {
      for (let k = 3 * (n - 2); k > 0; k--) places.push(begin + cut[at++]);
    }
  }
  return Uint32Array.from(places);
}

/** Lines of the control cage: lower ends, and how far it is to the upper ones. */
function cageLines(from, along) {
  const lines = new Uint32Array(2 * from.length);
  from.forEach((a, i) => lines.set([a, a + along[i]], 2 * i));
  return lines;
}

/** A job as it is drawn, from its head and its bytes. */
async function readScene(head, base64) {
  const bytes = await inflate(base64);
  const section = (name) => head.sections.find((s) => s.name === name);
  const list = (name) => readList(bytes, section(name));
  const corners = list('corners'), sizes = list('sizes');
  const offsets = new Uint32Array(sizes.length + 1);
  sizes.forEach((n, f) => { offsets[f + 1] = offsets[f] + n; });
  const base = { offsets, corners, count: head.base };
  base.lines = edgesOf(base);
  const levels = [base];
  for (let l = 0; l < head.level; l++) {
    levels.push(splitLevel(levels[l], list(`cuts${l}`), head.split === 'triangles'));
  }
  const scene = {
    head, levels, names: list('names'),
    positions: readValues(bytes, section('position'), levels, 4),
    normals: readValues(bytes, section('normal'), levels, 2),
    cage: readValues(bytes, section('cage'), null, 4),
    cageLines: cageLines(list('cage_from'), list('cage_along')),
    values: {},
  };
  scene.given = section('given') ? readValues(bytes, section('given'), null, 4) : scene.positions;
  scene.givenBox = section('given') ? head.given_box : head.box;
  for (const field of head.fields) {
    scene.values[field.name] = readValues(bytes, section(field.name), levels, 1);
  }
  const cut = list('triangles'), apart = (a, b) => squaredDistance(scene, a, b);
  const places = levels.map((level) => trianglesOf(level, cut, apart));
  levels.forEach((level, l) => { level.indices = places[l].map((c) => level.corners[c]); });
  if (section('uv')) {
    const charts = [{ offsets, corners: list('uv_corners'), count: head.uv_base, lines: [] }];
    for (let l = 0; l < head.level; l++) {
      charts.push(splitLevel(charts[l], list(`uv_cuts${l}`), head.split === 'triangles'));
    }
    scene.uvs = readValues(bytes, section('uv'), charts, 2);
    levels.forEach((level, l) => { level.uvs = places[l].map((c) => charts[l].corners[c]); });
  }
  scene.centre = head.box.low.map((low, k) => low + head.box.size[k] / 2);
  scene.radius = Math.hypot(...head.box.size) / 2;
  return scene;
}

function squaredDistance({ positions, head }, a, b) {
  let sum = 0;
  for (let k = 0; k < 3; k++) {
    const d = (positions[4 * a + k] - positions[4 * b + k]) * head.box.size[k];
    sum += d * d;
  }
  return sum;
}

const placeIn = (box, values, i) =>
  [0, 1, 2].map((k) => box.low[k] + box.size[k] * values[4 * i + k] / 65535);
const pointOf = (scene, i) => placeIn(scene.head.box, scene.positions, i);

/** A unit normal, unfolded from its octahedron. */
function normalOf(scene, i) {
  let x = scene.normals[2 * i] / 32767.5 - 1, y = scene.normals[2 * i + 1] / 32767.5 - 1;
  const z = 1 - Math.abs(x) - Math.abs(y), under = Math.max(-z, 0);
  x -= Math.sign(x) * under;
  y -= Math.sign(y) * under;
  const length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}

const fieldOf = (scene, name) => scene.head.fields.find((field) => field.name === name);

/** A stored step of a map as a fraction of its limit: 0 to 1, or -1 to 1 with a sign. */
function fractionOf(kind, step, top) {
  if (kind === 'share') return step / top;
  if (kind === 'amount') return (step / top) ** 2;
  const root = (step - 128) / 127;
  return Math.sign(root) * root * root;
}

function valueOf(scene, name, i) {
  const field = fieldOf(scene, name), values = scene.values[name];
  return field.limit * fractionOf(field.kind, values[i], values.BYTES_PER_ELEMENT === 2 ? 65535 : 255);
}
