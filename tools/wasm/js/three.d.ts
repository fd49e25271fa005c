import type { BufferGeometry } from 'three';
import type { MeshArrays, Surface } from './index.js';

export function fromGeometry(geometry: BufferGeometry): MeshArrays & { indices: number[] };
export function toGeometry(surface: Surface): BufferGeometry;
