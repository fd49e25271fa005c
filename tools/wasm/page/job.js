// One job of the page, in a worker: runs of the command over files in memory. Ends with the page's stop.
self.onmessage = async ({ data }) => {
  if (data.edit) return edit(data);
  const { module, files, runs } = data;
  const write = (FS) => {
    FS.mkdir('/in');
    FS.mkdir('/out');
    for (const { name, bytes } of files) FS.writeFile(`/in/${name}`, bytes);
    FS.chdir('/in');
  };
  const made = new Map();
  let status = 0, page, memory = false;
  for (const [number, run] of runs.entries()) {
    const say = (line) => self.postMessage({ line, share: [number, runs.length] });
    const command = await planish({
      print: say,
      printErr: say,
      instantiateWasm(imports, done) {
        WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
        return {};
      },
    });
    write(command.FS);
    try {
      status = command.callMain(run);
    } catch (error) {
      memory = error instanceof RangeError || /memory|OOM/.test(String(error));
      status = error?.name === 'ExitStatus' ? error.status : 1;
      if (error?.name !== 'ExitStatus') say(String(error));
    }
    const collect = (folder) => {
      for (const name of command.FS.readdir(folder)) {
        if (name === '.' || name === '..') continue;
        const path = `${folder}/${name}`;
        if (command.FS.isDir(command.FS.stat(path).mode)) collect(path);
        else made.set(path.slice('/out/'.length), command.FS.readFile(path));
      }
    };
    collect('/out');
    if (command.FS.analyzePath('/page.html').exists) page = command.FS.readFile('/page.html');
    if (status !== 0 && status !== 5) break;
  }
  const written = [...made].map(([name, bytes]) => ({ name, bytes }));
  self.postMessage({ status, files: written, page, memory },
    [...written.map((file) => file.bytes.buffer), ...(page ? [page.buffer] : [])]);
};
