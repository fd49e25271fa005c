import type { BufferGeometry } from 'three';
import type { MeshArrays, Surface } from './index.js';

export function fromGeometry(geometry: BufferGeometry): MeshArrays;
export function toGeometry(surface: Surface): BufferGeometry;
