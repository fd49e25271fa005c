"""One mutation: compiled beside the build folder, linked into its tests, and what they say of it.

Neither the tree nor the build folder changes. The mutated source is a file of its own in a scratch folder,
its object comes before the library in the link of each program, and takes the place of the library's. Of sources
that are compiled together the others are compiled once a run, so that each call to another source can be replaced.
"""

import dataclasses
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import threading
import time


@dataclasses.dataclass
class Outcome:
    verdict: str  # killed, timeout, survived, did-not-build, stale, untested, unfinished
    detail: str = ""
    seconds: float = 0.0


class Compiler:
    """The commands of the build folder, with other sources, outputs and flags."""

    def __init__(self, graph, folder):
        self.graph, self.folder = graph, pathlib.Path(folder)
        self.lock, self.together = threading.Lock(), {}

    def shell(self, command):
        subprocess.run(command, shell=True, cwd=self.graph.build, check=True, text=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def object(self, object_file, source, given, output, flags):
        """`given` in the place of `source`; flags come before all folders of headers."""
        command = self.graph.commands[object_file]["command"]
        command = re.sub(r"-M[DTF]+( \S+\.o(\.d)?)?(?= )", "", command)
        command = command.replace(f" -c {source}", f" -c {given}").replace(f" -o {object_file}", f" -o {output}")
        command = re.sub(r" -O[0-3g]\b", " -O1", command)
        # Places behind an array's end are found as the address sanitizer's build finds them.
        self.shell(re.sub(r" (?=-I|-c )", f" {flags} -w -D_GLIBCXX_ASSERTIONS ", command, count=1))
        return str(output)

    def replaceable(self, object_file, source):
        """The object of several sources whose functions give way to those of an object before it in the link."""
        with self.lock:
            if object_file not in self.together:
                output = self.folder / f"together_{len(self.together)}.o"
                # None is inlined or cloned into another source (the last -f of a kind holds).
                self.together[object_file] = self.object(
                    object_file, f"{source}", f"{source} -fPIC -fsemantic-interposition", output, "")
            return self.together[object_file]


class Trial:
    def __init__(self, graph, root, scratch, compiler, failing, timeout):
        self.graph, self.root, self.scratch = graph, root, pathlib.Path(scratch)
        self.compiler, self.failing, self.timeout = compiler, failing, timeout
        self.linked = {}

    def run(self, mutation, programs, tests, deadline):
        start = time.monotonic()
        outcome = self.outcome(mutation, programs, tests, deadline)
        outcome.seconds = time.monotonic() - start
        shutil.rmtree(self.scratch, ignore_errors=True)
        return outcome

    def outcome(self, mutation, programs, tests, deadline):
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir(parents=True)
        self.linked = {}
        path = self.root / mutation.path
        text = mutation.applied(path.read_text()) if path.exists() else None
        if text is None:
            return Outcome("stale", "its line is no longer there")
        try:
            self.objects = self.compile(path, text)
            if not self.objects:
                return Outcome("untested", "nothing is built of this source")
            asked = 0
            for test in tests:
                if time.monotonic() > deadline:
                    return Outcome("unfinished", f"the time was up before {test}")
                said = self.ask(test, programs)
                if said and said.verdict in ("killed", "timeout"):
                    return said
                asked += said is not None and said.verdict == "survived"
            return Outcome("survived" if asked else "untested", "; ".join(tests))
        except subprocess.CalledProcessError as error:
            reason = [line for line in (error.stderr or "").split("\n") if "error" in line.lower()]
            return Outcome("did-not-build", (reason or [str(error)])[0][:300])

    def compile(self, path, text):
        """{object of the build folder: the one that stands for it}"""
        if path.suffix != ".cpp":
            return self.compile_kernels(path, text)
        result = {}
        mutated = self.scratch / path.name
        mutated.write_text(text)
        for number, (object_file, source) in enumerate(self.graph.objects(path)):
            # A header beside the source is looked for where the source stood.
            result[object_file] = self.compiler.object(object_file, source, mutated, self.scratch / f"{number}.o",
                                                       f"-iquote {path.parent}")
            if source != str(path):
                result[object_file] += " " + self.compiler.replaceable(object_file, source)
        return result

    def compile_kernels(self, path, text):
        shaders = self.root / "shaders"
        copy = self.scratch / "shaders_copy"
        shutil.copytree(shaders, copy)
        (copy / path.relative_to(shaders)).write_text(text)
        kernels, headers = self.graph.kernels(path)
        folders = {(self.scratch / output).parent for output in kernels + headers}
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
        # The mutated words first; those of the library are included as shaders/NAME.
        includes = " ".join(f"-I{folder} -I{folder.parent}" for folder in sorted(folders))
        for output in kernels + headers:
            command = self.graph.commands[output]["command"].split(" && ")
            command = [part for part in command if "transform_depfile" not in part and not part.startswith("cd ")]
            joined = re.sub(r" --depfile \S+", "", " && ".join(command))
            for name in kernels + headers:
                joined = re.sub(rf"{re.escape(str(self.graph.build / name))}(?=[\s\"]|$)",
                                str(self.scratch / name), joined)
            self.compiler.shell(re.sub(rf"{re.escape(str(shaders))}(?=[/\s]|$)", str(copy), joined))
        result = {}
        for number, object_file in enumerate(self.graph.readers(headers)):
            source = self.graph.commands[object_file]["file"]
            result[object_file] = self.compiler.object(object_file, source, source, self.scratch / f"{number}.o",
                                                       includes)
        return result

    def link(self, program):
        """The program with the mutated objects, or None where it has none of them."""
        if program in self.linked:
            return self.linked[program]
        command = self.graph.link_command(program)
        changed = command
        for object_file, mutated in self.objects.items():
            if f" {object_file} " in changed:
                changed = changed.replace(f" {object_file} ", f" {mutated} ")
            elif any(f" {archive} " in changed + " " for archive in self.graph.archives(object_file)):
                changed = changed.replace(f" -o {program}", f" {mutated} -o {program}")
        result = None
        if changed != command:
            result = self.scratch / "programs" / program
            result.parent.mkdir(parents=True, exist_ok=True)
            # Were an inline function made elsewhere now, the library's own object would come along.
            flags = "-Wl,--allow-multiple-definition" + (" -fuse-ld=lld" if shutil.which("ld.lld") else "")
            self.compiler.shell(changed.replace(f" -o {program}", f" -o {result} {flags}"))
        self.linked[program] = result
        return result

    def ask(self, test, programs):
        """What a test says: `PROGRAM [FILTER of Google Test]`, or `ctest NAMES`. None: it has nothing of it."""
        name, _, rest = test.partition(" ")
        programs = [self.graph.program(each) for each in programs]
        if name == "ctest":
            replaced = {each: self.link(each) for each in programs}
            command = ["ctest", "--test-dir", str(self.graph.build), "--output-on-failure", "--stop-on-failure",
                       "--timeout", str(int(self.timeout)), "-R", rest]
            return self.judge(test, command, replaced)
        own = self.graph.program(name)
        replaced = {each: self.link(each) for each in [own, *programs]}
        program = replaced.pop(own)
        command = [str(program or self.graph.build / own), "--gtest_brief=0"]
        without = self.failing.get(name, [])
        if rest or without:
            chosen = rest.partition("-")[0] or "*"
            out = [part for part in [rest.partition("-")[2], *without] if part]
            command.append("--gtest_filter=" + chosen + ("-" + ":".join(out) if out else ""))
        return self.judge(test, command, replaced, program is not None)

    def judge(self, test, command, replaced, linked=False):
        replaced = {old: new for old, new in replaced.items() if new}
        if not replaced and not linked:
            return None
        if replaced:
            # Programs that tests start by their paths: mounted over, for this run alone.
            mounts = "".join(f"mount --bind {new} {self.graph.build / old} && " for old, new in replaced.items())
            who = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
            command = [*who, "sh", "-c", mounts + "exec " + shlex.join(command)]
        folder = self.scratch / "work"
        folder.mkdir(exist_ok=True)
        environment = {**os.environ, "GTEST_FAIL_FAST": "1", "TMPDIR": str(folder)}
        with open(self.scratch / "said", "w+", errors="replace") as said:
            process = subprocess.Popen(command, cwd=folder, env=environment, stdout=said, stderr=said,
                                       stdin=subprocess.DEVNULL, start_new_session=True)
            try:
                status = process.wait(self.timeout)
            except subprocess.TimeoutExpired:
                status = None
            finally:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                process.wait()
            said.seek(0)
            text = said.read()
        if status == 0 and "Running 0 tests" in text:
            return Outcome("untested", f"there is no {test}, or not in this build")
        if status == 0:
            return Outcome("survived")
        return Outcome("timeout" if status is None else "killed", f"{test.split()[0]} {first_failure(text, status)}")


def first_failure(text, status):
    failed = re.search(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", text)
    if failed:
        return failed[1]
    failed = re.search(r"The following tests FAILED:\s+\d+ - (\S+)", text)
    if failed:
        return failed[1]
    last = re.findall(r"\[ RUN      \] (\S+)", text)
    return (last[-1] if last else "*") + (f" (ended by {status})" if status is not None else "")
