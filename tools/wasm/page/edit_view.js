// A surface and its given points, drawn by WebGL 2; points are dragged, the rest of the picture turns. The camera is the
// report page's (camera.js).

const VERTEX_SHADER = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat3 turn;
uniform float away, pull;
uniform vec4 lens;
uniform int held;
out vec3 at, upright;
flat out int isHeld;
void main() {
  at = turn * position - vec3(0, 0, away);
  upright = turn * normal;
  isHeld = gl_VertexID == held ? 1 : 0;
  gl_PointSize = isHeld == 1 ? 13.0 : 7.0;
  vec3 p = at * (1.0 - pull);
  gl_Position = vec4(lens.x * p.x, lens.y * p.y, lens.z * p.z + lens.w, -p.z);
}`;
const FRAGMENT_SHADER = `#version 300 es
precision highp float;
in vec3 at, upright;
flat in int isHeld;
uniform bool isPoint;
out vec4 color;
void main() {
  if (isPoint) {
    vec2 off = gl_PointCoord - 0.5;
    if (dot(off, off) > 0.25) discard;
    color = isHeld == 1 ? vec4(0.85, 0.35, 0.0, 1) : vec4(0.04, 0.36, 0.68, 1);
    return;
  }
  vec3 n = normalize(upright), view = normalize(-at), light = normalize(vec3(0.5, 0.8, 0.6));
  if (dot(n, view) < 0.0) n = -n;
  float shine = pow(max(dot(reflect(-light, n), view), 0.0), 40.0);
  color = vec4(vec3(0.78, 0.80, 0.83) * (0.43 + 0.11 * n.y + 0.5 * max(dot(n, light), 0.0)) + 0.18 * shine, 1);
}`;
const REACH = 14; // pixels from a point that take hold of it
const KEY_TURN = 0.1, KEY_ZOOM = 0.9, KEY_MOVE = 0.01; // radians; a factor; parts of the radius
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

class EditView {
  /** `drag(vertex, place, isFirst)`: a given point is to be there; isFirst where it was only now taken hold of. */
  constructor(canvas, drag) {
    Object.assign(this, { canvas, drag, held: -1 });
    const gl = this.gl = canvas.getContext('webgl2', { antialias: true });
    if (!gl) throw new Error('moving vertices needs WebGL 2, which is missing here');
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.at = (name) => gl.getUniformLocation(program, name);
    gl.enable(gl.DEPTH_TEST);
    this.listen();
  }

  /** What the worker's start gives. */
  show({ rows, indices, baseVertices, origin }) {
    const gl = this.gl;
    const buffer = (target, data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(target, made);
      gl.bufferData(target, data, gl.DYNAMIC_DRAW);
      return made;
    };
    Object.assign(this, { rows, indices, baseVertices, origin, buffers: {}, held: -1 });
    ['positions', 'normals'].forEach((name, i) => {
      this.buffers[name] = buffer(gl.ARRAY_BUFFER, rows[name]);
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 0, 0);
    });
    buffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    let square = 0;
    for (let i = 0; i < rows.positions.length; i += 3)
      square = Math.max(square, rows.positions[i] ** 2 + rows.positions[i + 1] ** 2 + rows.positions[i + 2] ** 2);
    this.scene = { head: { up: 'y' }, radius: Math.sqrt(square), centre: [0, 0, 0] };
    Object.assign(camera, START, { distance: 3.6 * this.scene.radius, target: [0, 0, 0] });
    this.draw();
  }

  /** What a move gives. */
  follow({ rows }) {
    const gl = this.gl;
    for (const range of rows) {
      for (const name of ['positions', 'normals']) {
        this.rows[name].set(range[name], 3 * range.first);
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
        gl.bufferSubData(gl.ARRAY_BUFFER, 12 * range.first, range[name]);
      }
    }
    this.draw();
  }

  draw() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = undefined;
      this.render();
    });
  }

  render() {
    const { gl, canvas, at } = this;
    const ratio = Math.min(devicePixelRatio, 2);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { rows, near, far, fx, fy } = projection(this.scene, width / height);
    gl.uniformMatrix3fv(at('turn'), false, [0, 1, 2].flatMap((k) => rows.map((row) => row[k])));
    gl.uniform1f(at('away'), camera.distance);
    gl.uniform4f(at('lens'), fx, fy, -(far + near) / (far - near), -2 * far * near / (far - near));
    gl.uniform1f(at('pull'), 0);
    gl.uniform1i(at('isPoint'), 0);
    gl.drawElements(gl.TRIANGLES, this.indices.length, gl.UNSIGNED_INT, 0);
    gl.uniform1f(at('pull'), 2e-3);
    gl.uniform1i(at('isPoint'), 1);
    gl.uniform1i(at('held'), this.held);
    gl.drawArrays(gl.POINTS, 0, this.baseVertices.length);
  }

  point(i) {
    return [...this.rows.positions.subarray(3 * i, 3 * i + 3)];
  }

  hold(i) {
    this.held = i;
    this.draw();
  }

  faces(i, frame) {
    return dot(transform(frame.rows, this.rows.normals.subarray(3 * i, 3 * i + 3)), frame.eye(this.point(i))) < 0;
  }

  /** The given point at a place of the picture, on the side and the sheet that is seen: its row, or -1. */
  pick(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const frame = projection(this.scene, width / height);
    const near = [];
    for (let i = 0; i < this.baseVertices.length; ++i) {
      const [u, v, depth] = frame.place(this.point(i), width, height);
      const gap = Math.hypot(u - x, v - y);
      if (gap > REACH) continue;
      if (this.faces(i, frame)) near.push({ i, gap, depth });
    }
    const front = Math.min(...near.map(({ depth }) => depth)) + 0.05 * this.scene.radius;
    const seen = near.filter(({ depth }) => depth < front).sort((a, b) => a.gap - b.gap);
    return seen[0]?.i ?? -1;
  }

  /** The place as deep as the held point, under a place of the picture; in the mesh's coordinates. */
  place(x, y) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { rows, fx, fy, eye } = projection(this.scene, width / height);
    const depth = -eye(this.point(this.held))[2];
    const p = [(2 * x / width - 1) / fx * depth, (1 - 2 * y / height) / fy * depth, camera.distance - depth];
    return [0, 1, 2].map((k) => rows[0][k] * p[0] + rows[1][k] * p[1] + rows[2][k] * p[2] + this.origin[k]);
  }

  /** The next given point that faces the eye, in the mesh's order; `step` -1: the one before. */
  next(step) {
    const frame = projection(this.scene, this.canvas.clientWidth / this.canvas.clientHeight);
    const count = this.baseVertices.length, from = this.held < 0 && step < 0 ? 0 : this.held;
    for (let k = 1; k <= count; ++k) {
      const i = (from + step * k + 2 * count) % count;
      if (this.faces(i, frame)) return i;
    }
    return -1;
  }

  turn(yaw, pitch) {
    camera.yaw += yaw;
    camera.pitch = Math.max(-1.5, Math.min(1.5, camera.pitch + pitch));
    this.draw();
  }

  zoom(factor) {
    camera.distance *= factor;
    this.draw();
  }

  /** What a key does; false: nothing. */
  press({ key, shiftKey, repeat }) {
    const arrow = ARROWS[key];
    if (arrow && shiftKey && this.held >= 0) {
      const { rows } = projection(this.scene, 1), step = KEY_MOVE * this.scene.radius;
      const place = this.point(this.held).map((x, k) => x + this.origin[k] + step * (arrow[0] * rows[0][k] + arrow[1] * rows[1][k]));
      this.drag(this.baseVertices[this.held], place, !repeat);
    } else if (arrow) {
      this.turn(arrow[0] * KEY_TURN, -arrow[1] * KEY_TURN);
    } else if (key === '+' || key === '-') {
      this.zoom(key === '+' ? KEY_ZOOM : 1 / KEY_ZOOM);
    } else if (key === 'n' || key === 'p') {
      this.hold(this.next(key === 'n' ? 1 : -1));
    } else if (key === 'Escape') {
      this.hold(-1);
    } else {
      return false;
    }
    return true;
  }

  listen() {
    const { canvas } = this;
    let last, isFirst;
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      [last, isFirst] = [event, true];
      this.hold(this.pick(event.offsetX, event.offsetY));
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      if (this.held >= 0) {
        this.drag(this.baseVertices[this.held], this.place(event.offsetX, event.offsetY), isFirst);
        isFirst = false;
      } else {
        this.turn((last.clientX - event.clientX) * 0.007, (event.clientY - last.clientY) * 0.007);
      }
      last = event;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => (last = undefined));
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (this.press(event)) event.preventDefault();
    });
    new ResizeObserver(() => this.scene && this.draw()).observe(canvas);
  }
}
