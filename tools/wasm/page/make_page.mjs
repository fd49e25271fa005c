// make_page.mjs OUTPUT VERSION SCRIPT WASM NOTICES GOBLET CAMERA SHOWN...: one HTML file of the parts in this folder, of
// the command (its script and its WebAssembly), of the npm package's modules, and of the report page's camera. SHOWN: a
// page of each kind that the command makes for the frame; the policy must allow their scripts and styles, too.
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';

const [output, version, script, wasm, notices, goblet, camera, ...shown] = process.argv.slice(2);
const here = (name) => readFileSync(new URL(name, import.meta.url), 'utf8');
function packed(id, content) {
  const bytes = Buffer.from(content);
  const data = execFileSync('xz', ['--format=lzma', '-9e', '--stdout'], { input: bytes, maxBuffer: 1 << 30 });
  data.writeBigUInt64LE(BigInt(bytes.length), 5); // which xz leaves open
  return `<script type="text/plain" id="${id}">${data.toString('base64')}</script>`;
}
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const texts = shown.map((page) => readFileSync(page, 'utf8'));
const allowed = (kind) => texts.map((text) => text.match(new RegExp(`${kind} ('sha256-[^']*')`))[1]).join(' ');
const escaped = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;');

// A page from disk may start classic workers only.
const classic = readFileSync(script, 'utf8').replaceAll('import.meta.url', 'self.location.href')
  .replace('export default planish;', '');

// The package's modules as one script, each in a function of its own.
const bundled = new Map();
function bundle(name) {
  if (bundled.has(name)) return;
  const exported = [];
  const text = readFileSync(new URL(`../js/${name}`, import.meta.url), 'utf8')
    .replace(/^import (\w+) from '\.\/planish_library\.mjs';$/m, 'const $1 = planish;')
    .replace(/^import (\{[^}]*\}) from '\.\/(\w+\.js)';$/gm, (_, what, other) => {
      bundle(other);
      return `const ${what} = modules['${other}'];`;
    })
    .replace(/^export \{ (\w+) \};$/gm, (_, what) => (exported.push(what), ''))
    .replace(/^export ((?:async function|function|class|const) (\w+))/gm, (_, what, called) => (exported.push(called), what));
  if (/^(import|export) /m.test(text)) throw new Error(`${name}: an import or export that is not understood`);
  bundled.set(name, `modules['${name}'] = (() => {\n${text}\nreturn { ${exported.join(', ')} };\n})();`);
}
bundle('index.js');
const modules = `\nconst modules = {};\n${[...bundled.values()].join('\n')}\n`;

const parts = {
  version,
  style: here('page.css'),
  script: here('lzma.js') + readFileSync(camera, 'utf8') + here('edit_view.js') + here('page.js'),
  notices: escaped(readFileSync(notices, 'utf8')),
  data: [
    packed('wasm', readFileSync(wasm)),
    packed('worker', classic + modules + here('job.js')),
    packed('goblet', readFileSync(goblet)),
  ].join('\n'),
};
// The frame's page takes this policy besides its own.
parts.security = `default-src 'none'; script-src ${hash(parts.script)} ${allowed('script-src')} 'wasm-unsafe-eval' blob:; ` +
  `worker-src blob:; style-src ${hash(parts.style)} ${allowed('style-src')}; frame-src blob:; img-src data: blob:; ` +
  "base-uri 'none'; form-action 'none'";
writeFileSync(output, here('page.html').replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]));
