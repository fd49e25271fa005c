/** Codes of the C header's statuses. */
export type PlanishCode = 'INTERNAL_ERROR' | 'INVALID_ARGUMENT' | 'UNREADABLE_INPUT' | 'UNUSABLE_MESH' | 'NO_MEMORY' |
  'UNWRITABLE_OUTPUT' | 'CANCELLED';

/** `message` says what, where, the value and the remedy; `element` is the face, vertex or byte, or -1. */
export class PlanishError extends Error {
  constructor(message: string, code: PlanishCode, element?: number);
  code: PlanishCode;
  element: number;
}

/** What rides on a mesh or surface. */
export interface Riders {
  /** u, v of each texture coordinate; faceUvs: the number of one for each corner of the faces, -1: none. */
  uvs?: ArrayLike<number>;
  faceUvs?: ArrayLike<number>;
  /** Linear R, G, B, A of each vertex. */
  colors?: ArrayLike<number>;
  groups?: { name: string; material?: string }[];
  /** The group of each face. */
  faceGroups?: ArrayLike<number>;
}

/** Polygons, counter-clockwise seen from outside. One of faces, indices (triangles), faceSizes with faceVertices. */
export interface MeshArrays extends Riders {
  /** x, y, z of each vertex. */
  positions: ArrayLike<number>;
  faces?: ArrayLike<number>[];
  indices?: ArrayLike<number>;
  faceSizes?: ArrayLike<number>;
  faceVertices?: ArrayLike<number>;
  /** Pairs of vertices whose edge stays sharp. */
  creases?: ArrayLike<number> | [number, number][];
  /** Vertices that stay sharp. */
  corners?: ArrayLike<number>;
}

/** Those of `planish fit`, with the names that scene files have in snake case; defaults are the same. */
export interface FitOptions {
  /** Averaged weights and the plain iteration, as published. */
  preset?: 'paper';
  interpolation?: 'auto' | 'progressive' | 'fair';
  scheme?: 'doo-sabin' | 'catmull-clark' | 'loop';
  /** Largest error, of the bounding box's diagonal: 1e-6. */
  tolerance?: number;
  maxIterations?: number;
  repair?: 'safe' | 'none';
  weld?: number;
  weights?: 'doo-sabin' | 'averaged';
  solver?: 'chebyshev' | 'plain' | 'cg';
  boundary?: 'edge' | 'edge-and-corner';
  precision?: 'auto' | 'float' | 'double';
  polish?: number;
  /** "choose", "use", "ignore", "auto" or "auto:40"; of a file "normals", too. */
  creases?: string;
  within?: number | 'auto';
  quads?: 'auto' | 'on' | 'off';
  refine?: 'auto' | 'on' | 'off';
  /** Splits, 0 to 6, where a call names no level: 'auto' is 2, of a dense mesh 1. */
  levels?: number | number[] | 'auto';
  /** 'z' turns a Z-up mesh upright for glTF, and is told to USD. */
  up?: 'y' | 'z';
  /** What the coordinates of STEP are in: 'auto', which is mm, and metres of a glTF fitted as a file. */
  stepUnit?: 'mm' | 'cm' | 'm' | 'in' | 'auto';
  /** Most degrees by which normals jump where faces of STEP meet: 0.25. */
  stepAngle?: number;
  /** Most that faces of STEP leave the surface, of the diagonal: 1e-6. */
  stepTolerance?: number;
  /** Most quads along a face of STEP, of which one of the mesh has two: 16. */
  stepFaceSize?: number;
  /** Returning false cancels. */
  progress?: (step: string, fraction: number) => boolean | void;
  warning?: (code: string, message: string) => void;
}

/** `output` tells the format by its ending: 'surface.glb'; no .gltf, which has files beside it. */
export interface FitFileOptions extends FitOptions {
  output?: string;
  /** Of a glTF that becomes one: with 'msft' several `levels` are levels of detail in the same file (MSFT_lod). */
  lods?: 'files' | 'msft';
  /** Of a glTF that becomes one: all that it holds, or its scene as one mesh. */
  asset?: 'keep' | 'merge';
}

export interface FileFit {
  bytes: Uint8Array;
  info: FitInfo;
  warnings: { code: string; message: string }[];
}

export interface FitInfo {
  converged: boolean;
  iterations: number;
  interpolation: 'progressive' | 'fair';
  /** Of a vertex from the surface, of the diagonal. */
  maxError: number;
  rmsError: number;
  diagonal: number;
  vertexCount: number;
  faceCount: number;
  creaseDegrees: number;
  findsFeatures: boolean;
  within: number;
}

export interface Placing {
  /** Taken from positions before they become float32; "center": the middle of the box. */
  origin?: [number, number, number] | 'center';
}

export interface Surface {
  positions: Float32Array;
  origin: [number, number, number];
  normals: Float32Array;
  /** Triangles. */
  indices: Uint32Array;
  /** The corner of the faces that each index is. */
  triangleCorners: Uint32Array;
  faceVertices: Uint32Array;
  faceOffsets: Uint32Array;
  /** The first vertices are the limit points of the mesh's vertices of these numbers. */
  baseVertices: Int32Array;
  uvs?: Float64Array;
  faceUvs?: Int32Array;
  colors?: Float32Array;
  groups?: { name: string; material: string }[];
  faceGroups?: Int32Array;
}

export interface MeshCopy extends Riders {
  positions: Float64Array;
  faceSizes: Int32Array;
  faceVertices: Int32Array;
}

export interface Answers {
  /** Faces of the mesh as it was fitted, -1: none; places: u, v on each. */
  faces: Int32Array;
  places: Float64Array;
  positions: Float64Array;
  normals: Float64Array;
}

export interface Mesh {
  arrays(): MeshCopy;
  dispose(): void;
}

export interface Questions {
  closest(points: ArrayLike<number>): Answers & { distances: Float64Array };
  rays(origins: ArrayLike<number>, directions: ArrayLike<number>, range?: { tMin?: number; tMax?: number }):
    Answers & { t: Float64Array };
}

export interface Fit extends Questions {
  readonly info: FitInfo;
  readonly warnings: { code: string; message: string }[];
  /** Without a level as `levels` says, else 2, of a dense mesh 1, as write() and edit(). */
  evaluate(level?: number, placing?: Placing): Surface;
  tessellate(options: { chordError?: number; angle?: number } & Placing): Surface;
  /** glb, gltf, obj, ply, off, stl, usda or step, by the name's ending. */
  write(name: string, level?: number): Uint8Array;
  glb(level?: number): Uint8Array;
  cage(): Mesh;
  /** Moves vertices of this mesh and keeps the rows of evaluate(level) right; of a fit that has converged. */
  edit(level?: number, placing?: Placing): Editor;
  dispose(): void;
}

/** Rows `first` to `first + count - 1` of the surface's positions and normals. */
export interface Rows {
  first: number;
  count: number;
  positions: Float32Array;
  normals: Float32Array;
}

/** What a call of an Editor has changed; all other rows are as they were, to the bit. */
export interface EditChange {
  /** That moved, ascending. */
  vertices: Int32Array;
  /** Ascending. */
  rows: Rows[];
  isWhole: boolean;
}

/** Vertices are those of the mesh as it was fitted. 64 moves can be taken back. */
export interface Editor extends Questions {
  readonly origin: [number, number, number];
  /** x, y, z of each vertex, where it is now. */
  readonly points: Float64Array;
  /** errorBound: the surface is no farther from any vertex, of the diagonal. */
  readonly state: { errorBound: number; canUndo: boolean; canRedo: boolean };
  /** All of evaluate(level)'s, as they are now. */
  rows(): Rows;
  move(vertices: ArrayLike<number>, positions: ArrayLike<number>): EditChange;
  /** Vertices within `radius` along edges, and weights that fall smoothly from 1 to 0. */
  select(vertices: ArrayLike<number>, radius: number): { vertices: Int32Array; weights: Float64Array };
  /** By an affine map, three rows of four numbers, each vertex by its weight of the way. */
  transform(selection: { vertices: ArrayLike<number>; weights?: ArrayLike<number> }, matrix: ArrayLike<number>): EditChange;
  setSharp(tags: { edges?: ArrayLike<number> | [number, number][]; corners?: ArrayLike<number>; sharp?: boolean }): EditChange;
  undo(): EditChange;
  redo(): EditChange;
  /** Solves the whole mesh from where it is. */
  settle(): EditChange;
  /** Makes what a fit makes of the mesh as it is now, with all that it decides. */
  refit(): EditChange;
  /** The mesh and its surface as they are now. */
  fit(): Fit;
  dispose(): void;
}

export interface Planish {
  readonly version: string;
  mesh(arrays: MeshArrays): Mesh;
  read(bytes: Uint8Array, name: string): Mesh;
  fit(mesh: Mesh | MeshArrays, options?: FitOptions): Fit;
  /** From file to file, as the command makes them: of a glTF materials, nodes, skins and morph targets come along. */
  fitFile(bytes: Uint8Array, name: string, options?: FitFileOptions): FileFit;
}

export function load(options?: { wasm?: ArrayBuffer | Uint8Array | WebAssembly.Module }): Promise<Planish>;
