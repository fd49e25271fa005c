#!/usr/bin/env node
// The command, with the files of whoever runs it: npx planish fit part.obj -o part.glb
import makeCommand from './planish_node.mjs';

const command = await makeCommand();
// Also where the heap was ended by an exception that nobody took.
process.exitCode = 1;
try {
  process.exitCode = command.callMain(process.argv.slice(2));
} catch (error) {
  if (error?.name !== 'ExitStatus') throw error;
  process.exitCode = error.status;
}
