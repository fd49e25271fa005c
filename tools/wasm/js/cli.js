#!/usr/bin/env node
// The command, with the files of whoever runs it: npx planish fit part.obj -o part.glb
import { isatty } from 'node:tty';
import makeCommand from './planish_node.mjs';

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
