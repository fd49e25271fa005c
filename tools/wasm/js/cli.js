#!/usr/bin/env node
// The command, with the files of whoever runs it: npx planish fit part.obj -o part.glb. By the program of this system, on all
// processors and with points, where the package that has it is installed, too; else in WebAssembly.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { isatty } from 'node:tty';

// Of the same version only, so that both have the same flags and write the same bytes. A package for Linux says which glibc
// its programs want, which some have older and some have not.
function nativeProgram() {
  const require = createRequire(import.meta.url);
  let file;
  try {
    file = require.resolve(`planish-${process.platform}-${process.arch}/package.json`);
  } catch {
    return undefined;
  }
  const { version, program, glibc } = require(file);
  if (version !== require('./package.json').version) return undefined;
  if (glibc) {
    process.report.excludeNetwork = true;
    const numbers = (text) => text.split('.').map(Number);
    const [[major, minor], [least, next]] = [process.report.getReport().header.glibcVersionRuntime ?? '0.0', glibc].map(numbers);
    if (major < least || (major === least && minor < next)) return undefined;
  }
  return join(dirname(file), program);
}

// A terminal interrupts both; the program alone says how that ends.
async function runNative(program) {
  const child = spawn(program, process.argv.slice(2), { stdio: 'inherit' });
  process.on('SIGINT', () => {});
  process.on('SIGTERM', () => child.kill('SIGTERM'));
  const [code, signal] = await new Promise((resolve, reject) => {
    child.on('error', reject);
    child.on('exit', (...ending) => resolve(ending));
  });
  process.exitCode = code ?? 1;
  if (signal) {
    process.removeAllListeners(signal);
    process.kill(process.pid, signal);
  }
}

async function runWasm() {
  const { default: makeCommand } = await import('./planish_node.mjs');
  const command = await makeCommand();
  // Emscripten takes all three for terminals, and fails where one is asked for its width.
  const ops = { ioctl_tiocgwinsz: () => [process.stdout.rows, process.stdout.columns] };
  for (let file = 0; file < 3; ++file) command.FS.getStream(file).tty = isatty(file) && { ops };
  // Also where the heap was ended by an exception that nobody took.
  process.exitCode = 1;
  try {
    process.exitCode = command.callMain(process.argv.slice(2));
  } catch (error) {
    if (error?.name !== 'ExitStatus') throw error;
    process.exitCode = error.status;
  }
}

const program = nativeProgram();
await (program ? runNative(program) : runWasm());
