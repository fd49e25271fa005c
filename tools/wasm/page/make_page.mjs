// make_page.mjs OUTPUT VERSION SCRIPT WASM REPORT NOTICES GOBLET: one HTML file of the parts in this folder, of the
// command (its script and its WebAssembly), and of a report page, whose script and style the policy must allow, too.
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';

const [output, version, script, wasm, report, notices, goblet] = process.argv.slice(2);
const here = (name) => readFileSync(new URL(name, import.meta.url), 'utf8');
function packed(id, content) {
  const bytes = Buffer.from(content);
  const data = execFileSync('xz', ['--format=lzma', '-9e', '--stdout'], { input: bytes, maxBuffer: 1 << 30 });
  data.writeBigUInt64LE(BigInt(bytes.length), 5); // which xz leaves open
  return `<script type="text/plain" id="${id}">${data.toString('base64')}</script>`;
}
const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const allowed = (kind) => readFileSync(report, 'utf8').match(new RegExp(`${kind} ('sha256-[^']*')`))[1];
const escaped = (text) => text.replaceAll('&', '&amp;').replaceAll('<', '&lt;');

// A page from disk may start classic workers only.
const classic = readFileSync(script, 'utf8').replaceAll('import.meta.url', 'self.location.href')
  .replace('export default planish;', '');

const parts = {
  version,
  style: here('page.css'),
  script: here('lzma.js') + here('page.js'),
  notices: escaped(readFileSync(notices, 'utf8')),
  data: [
    packed('wasm', readFileSync(wasm)),
    packed('worker', classic + here('job.js')),
    packed('goblet', readFileSync(goblet)),
  ].join('\n'),
};
// The report's frame takes this policy besides its own.
parts.security = `default-src 'none'; script-src ${hash(parts.script)} ${allowed('script-src')} 'wasm-unsafe-eval' blob:; ` +
  `worker-src blob:; style-src ${hash(parts.style)} ${allowed('style-src')}; frame-src blob:; img-src data: blob:; ` +
  "base-uri 'none'; form-action 'none'";
writeFileSync(output, here('page.html').replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]));
