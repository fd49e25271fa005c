import type { FileFit, FilesFit, Fit, FitFileOptions, FitFilesOptions, FitInfo, FitOptions, MeshArrays, MeshCopy } from './index.js';

type Later<F> = F extends (...given: infer Given) => infer Result ? (...given: Given) => Promise<Result> : never;

export type LaterFit = { info: FitInfo; warnings: { code: string; message: string }[]; cage(): Promise<MeshCopy> } &
  { [Name in 'evaluate' | 'tessellate' | 'write' | 'glb' | 'closest' | 'rays' | 'dispose']: Later<Fit[Name]> };

export class PlanishWorker {
  static create(options?: { wasm?: ArrayBuffer | Uint8Array | WebAssembly.Module }): Promise<PlanishWorker>;
  fit(mesh: MeshArrays | { bytes: Uint8Array; name: string }, options?: FitOptions): Promise<LaterFit>;
  fitFile(bytes: Uint8Array, name: string, options?: FitFileOptions): Promise<FileFit>;
  fitFiles(files: { bytes: Uint8Array; name: string }[], options?: FitFilesOptions): Promise<FilesFit>;
  stop(): void;
}
