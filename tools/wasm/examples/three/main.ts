// Two surfaces drawn by three.js: a file fitted in a worker, and a cube whose vertices can be dragged.
import { load, type EditChange } from 'planish';
import { fromGeometry, toGeometry } from 'planish/three';
import { PlanishWorker } from 'planish/worker';
import {
  AmbientLight, BoxGeometry, type BufferAttribute, BufferGeometry, Color, DirectionalLight, Float32BufferAttribute, Mesh,
  MeshStandardMaterial, PerspectiveCamera, Plane, Points, PointsMaterial, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from 'three';
import gobletUrl from './goblet.obj?url';

const said = document.getElementById('said')!;
const renderer = new WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);
const scene = new Scene();
scene.background = new Color(0xf4f1ec);
const camera = new PerspectiveCamera(40, 1, 0.1, 100);
camera.position.set(0, 0, 9);
const light = new DirectionalLight(0xffffff, 2.5);
light.position.set(2, 3, 4);
scene.add(light, new AmbientLight(0xffffff, 0.6));

function draw() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
}
addEventListener('resize', draw);

// Here, since each move takes less than a frame.
const planish = await load();
const box = fromGeometry(new BoxGeometry(2, 2, 2, 3, 3, 3));
const fit = planish.fit({ positions: box.positions, indices: box.indices }, { quads: 'on', creases: 'ignore' });
const editor = fit.edit(3);
const geometry = toGeometry(fit.evaluate(3));
const dragged = new Mesh(geometry, new MeshStandardMaterial({
  color: 0xc98b5a, roughness: 0.4, polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 4, // behind its points
}));
const given = new Points(new BufferGeometry(), new PointsMaterial({ color: 0x1b4f8f, size: 8, sizeAttenuation: false }));
const showPoints = () => given.geometry.setAttribute('position', new Float32BufferAttribute(editor.points, 3));
showPoints();
dragged.position.x = given.position.x = 1.8;
dragged.rotation.set(0.4, 0.5, 0);
given.rotation.copy(dragged.rotation);
scene.add(dragged, given);

function show({ rows }: EditChange) {
  for (const name of ['positions', 'normals'] as const) {
    const attribute = geometry.getAttribute(name === 'positions' ? 'position' : 'normal') as BufferAttribute;
    for (const range of rows) attribute.array.set(range[name], 3 * range.first);
    attribute.needsUpdate = true;
  }
  showPoints();
  draw();
}

const caster = new Raycaster();
caster.params.Points.threshold = 0.15;
let vertex = -1;
const plane = new Plane();
function aim(event: PointerEvent) {
  caster.setFromCamera(new Vector2((event.clientX / innerWidth) * 2 - 1, 1 - (event.clientY / innerHeight) * 2), camera);
}
addEventListener('pointerdown', (event) => {
  aim(event);
  const [hit] = caster.intersectObject(given);
  vertex = hit?.index ?? -1;
  if (hit) plane.setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), given.localToWorld(
    new Vector3().fromArray(editor.points, 3 * vertex)));
});
addEventListener('pointermove', (event) => {
  if (vertex < 0) return;
  aim(event);
  const place = caster.ray.intersectPlane(plane, new Vector3());
  if (!place) return;
  show(editor.move([vertex], given.worldToLocal(place).toArray()));
  said.textContent = `vertex ${vertex} moved; the surface is off by at most ` +
    `${editor.state.errorBound.toExponential(0)} of the diagonal`;
});
addEventListener('pointerup', () => (vertex = -1));
addEventListener('keydown', (event) => {
  if (event.key === 'z' && (event.ctrlKey || event.metaKey)) show(event.shiftKey ? editor.redo() : editor.undo());
});
draw();

// In a thread of its own, so that the page goes on; stop() would end it.
const worker = await PlanishWorker.create();
const bytes = new Uint8Array(await (await fetch(gobletUrl)).arrayBuffer());
const goblet = await worker.fit({ bytes, name: 'goblet.obj' }, {
  progress: (step, part) => void (said.textContent = `${step}: ${Math.round(100 * part)} %`),
});
const surface = await goblet.evaluate(1, { origin: 'center' });
const cup = new Mesh(toGeometry(surface), new MeshStandardMaterial({ color: 0x8fa8c8, roughness: 0.3 }));
cup.geometry.computeBoundingSphere();
cup.scale.setScalar(1.8 / cup.geometry.boundingSphere!.radius);
cup.position.x = -1.8;
scene.add(cup);
said.textContent = `${goblet.info.faceCount} faces fitted; drag a blue point`;
draw();
