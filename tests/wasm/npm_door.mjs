// npm_door.mjs PACKAGE: answers lines of JSON, {source, output, options}, with {refused} or {}: the package's fitFile()
// of the file, by options as the tables name them.
import { readFileSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { createInterface } from 'node:readline';
import { pathToFileURL } from 'node:url';

const { load, PlanishError } = await import(pathToFileURL(join(process.argv[2], 'index.js')));
const planish = await load();
const keyOf = (name) => name.replace(/_[a-z]/g, (pair) => pair[1].toUpperCase());

for await (const line of createInterface({ input: process.stdin })) {
  const { source, output, options } = JSON.parse(line);
  const given = Object.fromEntries(Object.entries(options).map(([name, value]) => [keyOf(name), value]));
  let answer = {};
  try {
    writeFileSync(output, planish.fitFile(readFileSync(source), basename(source), { ...given, output: basename(output) }).bytes);
  } catch (error) {
    if (!(error instanceof PlanishError)) throw error;
    answer = { refused: error.message };
  }
  console.log(JSON.stringify(answer));
}
