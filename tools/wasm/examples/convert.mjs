// node convert.mjs MESH SURFACE: what `planish fit` does, in a program: a mesh's file to a surface's.
import { readFileSync, writeFileSync } from 'node:fs';
import { load, PlanishError } from 'planish';

const [mesh, surface] = process.argv.slice(2);
const planish = await load();
try {
  const { bytes, info, warnings } = planish.fitFile(readFileSync(mesh), mesh, { output: surface, levels: 2 });
  for (const { message } of warnings) console.error(message);
  writeFileSync(surface, bytes);
  console.log(`${surface}: ${info.interpolation}, the vertices are off by at most ${info.maxError.toExponential(1)} of the diagonal`);
} catch (error) {
  if (!(error instanceof PlanishError)) throw error;
  console.error(error.message);
  process.exitCode = 1;
}
