// Runs the Khronos glTF validator on the files named; fails on any error or warning.
// Also breaks the first file on purpose: a validator that stays silent then is no test.
'use strict';
const fs = require('fs');
const path = require('path');
const validator = require('gltf-validator');

async function issuesOf(file, bytes) {
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  return report.issues;
}

async function main(files) {
  if (files.length === 0) throw new Error('no file to validate');
  let failed = 0;
  for (const file of files) {
    const issues = await issuesOf(file, fs.readFileSync(file));
    const bad = issues.messages.filter((message) => message.severity <= 1);
    console.log(`${path.basename(file)}: ${issues.numErrors} errors, ` +
                `${issues.numWarnings} warnings, ${issues.numInfos} infos`);
    for (const message of issues.messages.slice(0, 10)) {
      console.log(`  ${message.code} ${message.pointer || ''}: ${message.message}`);
    }
    failed += bad.length;
  }
  const broken = fs.readFileSync(files[0], 'latin1').replace('"mode":4', '"mode":9');
  if ((await issuesOf(files[0], Buffer.from(broken, 'latin1'))).numErrors === 0) {
    console.log('the validator accepts a primitive of mode 9');
    ++failed;
  }
  return failed === 0 ? 0 : 1;
}

main(process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(error);
  process.exit(1);
});
