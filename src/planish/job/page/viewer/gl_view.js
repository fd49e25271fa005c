// The view by WebGL 2: one shader for surfaces, lines and points.

const VERTEX_SHADER = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 normal;
layout(location = 2) in float value;
layout(location = 3) in vec2 uv;
uniform vec3 low, size, target;
uniform mat3 turn;
uniform float away, pull, pointSize;
uniform vec4 lens, chart;
out vec3 at, upright;
out vec2 place;
out float amount;
void main() {
  at = turn * (low + size * position - target) - vec3(0, 0, away);
  vec2 square = normal * 2.0 - 1.0;
  vec3 n = vec3(square, 1.0 - abs(square.x) - abs(square.y));
  n.xy -= sign(n.xy) * max(-n.z, 0.0);
  upright = turn * normalize(n);
  amount = value;
  place = chart.xy + chart.zw * uv;
  gl_PointSize = pointSize;
  // Lines and points lie on the surface: a little nearer, they are not hidden by it.
  vec3 p = at * (1.0 - pull);
  gl_Position = vec4(lens.x * p.x, lens.y * p.y, lens.z * p.z + lens.w, -p.z);
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
in vec3 at, upright;
in vec2 place;
in float amount;
out vec4 color;
uniform int look, kind;
uniform bool facets;
uniform float stripes, gain;
uniform vec3 map[${STOPS}];
uniform vec4 ink;
vec3 mapped() {
  float t = kind == 0 ? amount * amount * gain : amount * gain;
  if (kind == 2) t = 0.5 + 0.5 * (amount * 255.0 - 128.0) / 127.0 * gain;
  t = clamp(t, 0.0, 1.0) * float(${STOPS - 1});
  int i = min(int(t), ${STOPS - 2});
  return mix(map[i], map[i + 1], t - float(i));
}
// Black and white in turn, grey where they are finer than the picture.
float band(float t) {
  float width = min(fwidth(t), 0.5), wave = abs(fract(t) - 0.5) * 2.0;
  return mix(smoothstep(0.5 - width, 0.5 + width, wave), 0.5, smoothstep(0.25, 0.5, width));
}
vec3 smoothly(vec3 n, vec3 view) {
  vec3 light = normalize(vec3(0.5, 0.8, 0.6));
  float shine = pow(max(dot(reflect(-light, n), view), 0.0), 40.0);
  return vec3(0.78, 0.80, 0.83) * (0.43 + 0.11 * n.y + 0.5 * max(dot(n, light), 0.0)) + 0.18 * shine;
}
vec3 shaded(vec3 n, vec3 view) {
  float face = max(dot(n, view), 0.0);
  if (look == 0) return smoothly(n, view);
  if (look == 3) return mapped() * (0.62 + 0.38 * face);
  if (look == 6) {
    float a = band(place.x * stripes * 0.5 + 0.25), b = band(place.y * stripes * 0.5 + 0.25);
    return mix(vec3(${CHECKS_DARK}), vec3(${CHECKS_LIGHT}), a * b + (1.0 - a) * (1.0 - b)) * (0.62 + 0.38 * face);
  }
  float t = look == 1 ? acos(clamp(reflect(-view, n).y, -1.0, 1.0)) / 3.14159 * stripes
                      : dot(n, normalize(vec3(0.4, 1.0, 0.3))) * stripes * 0.5;
  return mix(vec3(0.06), vec3(0.96), band(t)) * (0.7 + 0.3 * face);
}
void main() {
  if (look == 4) { color = ink; return; }
  if (look == 5) {
    vec2 off = gl_PointCoord - 0.5;
    float square = dot(off, off);
    if (square > 0.25) discard;
    color = vec4(square > 0.13 ? vec3(0.1) : mapped(), 1.0);
    return;
  }
  bool back = !gl_FrontFacing;
  vec3 n = normalize(facets ? cross(dFdx(at), dFdy(at)) : upright);
  if (back && !facets) n = -n;
  vec3 seen = shaded(n, normalize(-at));
  color = vec4(back ? mix(seen, vec3(0.55, 0.25, 0.55), 0.45) : seen, 1.0);
}`;

const LOOKS = { smooth: 0, zebra: 1, isophotes: 2, map: 3, line: 4, point: 5, checker: 6 };
const KINDS = { amount: 0, share: 1, signed: 2 };

class GlView {
  constructor(canvas, redraw) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error('this browser has no WebGL 2');
    this.setUp();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => { this.setUp(); redraw(); });
  }

  setUp() {
    const gl = this.gl, program = gl.createProgram();
    this.uploaded = new Map();
    for (const [type, text] of [[gl.VERTEX_SHADER, VERTEX_SHADER],
      [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(program) || 'the shaders do not link');
    }
    gl.useProgram(program);
    this.at = {};
    for (let i = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i-- > 0;) {
      const name = gl.getActiveUniform(program, i).name.replace('[0]', '');
      this.at[name] = gl.getUniformLocation(program, name);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  buffer(target, data) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(target, buffer);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return buffer;
  }

  /** Places on a grid of 16 bits, and normals where there are any. */
  vertices(positions, normals) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.buffer(gl.ARRAY_BUFFER, positions);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, true, 8, 0);
    if (normals) {
      this.buffer(gl.ARRAY_BUFFER, normals);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 2, gl.UNSIGNED_SHORT, true, 4, 0);
    }
    return array;
  }

  upload(scene) {
    const gl = this.gl;
    const mesh = {
      surface: this.vertices(scene.positions, scene.normals),
      cage: this.vertices(scene.cage),
      given: this.vertices(scene.given),
      values: {}, charts: [],
    };
    gl.bindVertexArray(null);
    for (const [name, values] of Object.entries(scene.values)) {
      mesh.values[name] = this.buffer(gl.ARRAY_BUFFER, values);
    }
    const indices = (data) => this.buffer(gl.ELEMENT_ARRAY_BUFFER, data);
    mesh.indices = scene.levels.map((level) => indices(level.indices));
    mesh.lines = scene.levels.map((level) => indices(level.lines));
    mesh.cageLines = indices(scene.cageLines);
    this.uploaded.set(scene, mesh);
    return mesh;
  }

  /** Triangles by themselves: along seams a vertex has several places in the texture. */
  charts(scene, { indices, uvs }) {
    const gl = this.gl;
    const spread = (values, places, n) => {
      const all = new Uint16Array(n * places.length);
      for (let i = 0; i < places.length; i++) {
        for (let k = 0; k < n; k++) all[n * i + k] = values[n * places[i] + k];
      }
      return all;
    };
    const array = this.vertices(spread(scene.positions, indices, 4), spread(scene.normals, indices, 2));
    this.buffer(gl.ARRAY_BUFFER, spread(scene.uvs, uvs, 2));
    gl.enableVertexAttribArray(3);
    gl.vertexAttribPointer(3, 2, gl.UNSIGNED_SHORT, true, 0, 0);
    return array;
  }

  begin() {
    const gl = this.gl;
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /** Draws a scene between two fractions of the picture's width. */
  draw(scene, view, from, to) {
    const gl = this.gl, at = this.at, { width, height } = this.canvas;
    const mesh = this.uploaded.get(scene) ?? this.upload(scene);
    const frame = projection(scene, width / height), { near, far } = frame;
    const left = Math.round(from * width);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(left, 0, Math.round(to * width) - left, height);
    gl.uniform3fv(at.target, camera.target);
    const columns = [0, 1, 2].flatMap((k) => frame.rows.map((row) => row[k]));
    gl.uniformMatrix3fv(at.turn, false, columns);
    gl.uniform1f(at.away, camera.distance);
    gl.uniform4f(at.lens, frame.fx, frame.fy, -(far + near) / (far - near),
        -2 * far * near / (far - near));
    gl.uniform1f(at.stripes, view.stripes);
    gl.uniform1i(at.facets, view.facets);
    gl.uniform1f(at.pointSize, 7 * view.ratio);
    this.drawSurface(scene, mesh, view);
    gl.uniform1f(at.pull, 1e-3);
    this.box(scene.head.box);
    if (view.lines) this.drawLines(mesh.lines[view.level], scene.levels[view.level].lines.length,
        [0.05, 0.07, 0.1], 0);
    if (view.points) this.drawPoints(scene, mesh, view);
    gl.bindVertexArray(mesh.given);
    this.box(scene.givenBox);
    if (view.mesh) this.drawLines(mesh.lines[0], scene.levels[0].lines.length, view.wireInk, 0.1);
    gl.bindVertexArray(mesh.cage);
    this.box(scene.head.cage_box);
    if (view.cage) this.drawLines(mesh.cageLines, scene.cageLines.length, view.cageInk, 0.12);
    gl.bindVertexArray(null);
    gl.uniform1f(at.pull, 0);
  }

  box({ low, size }) {
    this.gl.uniform3fv(this.at.low, low);
    this.gl.uniform3fv(this.at.size, size);
  }

  useMap(scene, mesh, view, name) {
    const gl = this.gl, field = fieldOf(scene, name), values = scene.values[name];
    const ratio = field.limit / view.top(name);
    // Signed maps run with the root, so that gentle curvature shows beside sharp.
    gl.uniform1f(this.at.gain, field.kind === 'signed' ? Math.sqrt(ratio) : ratio);
    gl.uniform1i(this.at.kind, KINDS[field.kind]);
    gl.uniform3fv(this.at.map, MAPS[field.kind].flat());
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.values[name]);
    gl.enableVertexAttribArray(2);
    const wide = values.BYTES_PER_ELEMENT === 2;
    gl.vertexAttribPointer(2, 1, wide ? gl.UNSIGNED_SHORT : gl.UNSIGNED_BYTE, true, 0, 0);
  }

  drawSurface(scene, mesh, view) {
    const gl = this.gl, level = scene.levels[view.level];
    const checks = view.mode === 'checker' && scene.uvs;
    if (checks) {
      gl.bindVertexArray(mesh.charts[view.level] ??= this.charts(scene, level));
      const { low, size } = scene.head.uv_box;
      gl.uniform4f(this.at.chart, low[0], low[1], size[0], size[1]);
      this.box(scene.head.box);
      gl.uniform1f(this.at.pull, 0);
      gl.uniform1i(this.at.look, LOOKS.checker);
      gl.drawArrays(gl.TRIANGLES, 0, level.indices.length);
    }
    gl.bindVertexArray(mesh.surface);
    this.box(scene.head.box);
    gl.uniform1f(this.at.pull, 0);
    if (checks) return;
    if (view.map) this.useMap(scene, mesh, view, view.map);
    gl.uniform1i(this.at.look, view.map ? LOOKS.map : LOOKS[view.mode === 'checker' ? 'smooth' : view.mode]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.indices[view.level]);
    gl.drawElements(gl.TRIANGLES, level.indices.length, gl.UNSIGNED_INT, 0);
  }

  drawPoints(scene, mesh, view) {
    const gl = this.gl;
    this.useMap(scene, mesh, view, 'error');
    gl.uniform1i(this.at.look, LOOKS.point);
    gl.drawArrays(gl.POINTS, 0, scene.head.base);
  }

  /** Lines, and those that the surface hides as faintly as `hidden`. */
  drawLines(indices, count, ink, hidden) {
    const gl = this.gl;
    gl.uniform1i(this.at.look, LOOKS.line);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.enable(gl.BLEND);
    for (const [test, strength] of [[gl.GREATER, hidden], [gl.LEQUAL, 0.9]]) {
      if (strength === 0) continue;
      gl.depthFunc(test);
      gl.depthMask(test === gl.LEQUAL);
      gl.uniform4f(this.at.ink, ...ink, strength);
      gl.drawElements(gl.LINES, count, gl.UNSIGNED_INT, 0);
    }
    gl.disable(gl.BLEND);
    gl.depthFunc(gl.LESS);
    gl.depthMask(true);
  }
}
