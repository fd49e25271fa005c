"""What Ninja knows of a build folder: which commands make what of a source."""

import collections
import json
import pathlib
import re
import subprocess
import threading


class BuildGraph:
    def __init__(self, build):
        self.build = pathlib.Path(build).resolve()
        if not (self.build / "build.ninja").exists():
            raise SystemExit(f"{self.build} is no build folder of Ninja: cmake -G Ninja makes one")
        entries = json.loads(self.ninja("-t", "compdb"))
        self.lock, self.known_needs = threading.Lock(), {}
        self.commands, self.uses = {}, collections.defaultdict(list)
        for entry in entries:
            if entry["command"].strip():
                self.commands[entry["output"]] = entry
                self.uses[entry["file"]].append(entry["output"])

    def ninja(self, *arguments):
        return subprocess.run(["ninja", *arguments], cwd=self.build, check=True, text=True,
                              capture_output=True).stdout

    def program(self, name):
        """The output that a program's name, mesh_test or planish, or a module's for Python, means."""
        for output, entry in self.commands.items():
            file = output.rpartition("/")[2]
            named = file == name or (file.endswith(".so") and file.split(".")[0] == name)
            if named and f" -o {output} " in entry["command"] + " ":
                return output
        raise SystemExit(f"{self.build} builds no program {name}")

    def objects(self, source):
        """[(object, the source that the compiler gets)]: a unity build has several sources in one."""
        found = [(output, str(source)) for output in self.uses[str(source)] if output.endswith(".o")]
        if found:
            return found
        for unity in self.build.glob("**/Unity/*.cxx"):
            if f'#include "{source}"' in unity.read_text():
                found += [(output, str(unity)) for output in self.uses[str(unity)]]
        return found

    def kernels(self, source):
        """Headers with the words of a shader or of whatever includes it, and what is compiled of them."""
        kernels = [output for output in self.commands
                   if output.endswith(".spv") and str(source) in self.shader_needs(output)]
        headers = [kernel + ".h" for kernel in kernels if kernel + ".h" in self.commands]
        return kernels, headers

    def shader_needs(self, kernel):
        """What a kernel was made of, by the file that its compiler wrote at the last build."""
        written = re.search(r"--depfile (\S+)", self.commands[kernel]["command"])
        file = pathlib.Path(written[1]) if written else None
        return file.read_text().replace("\\\n", " ").split() if file and file.exists() else []

    def readers(self, headers):
        """Objects that include one of these generated headers."""
        wanted = {str(self.build / header) for header in headers} | set(headers)
        return [name for name, needs in self.needs().items() if name.endswith(".o") and wanted & needs]

    def needs(self):
        """{output: files that it was made of}, as Ninja noted at the last build."""
        with self.lock:
            if not self.known_needs:
                current = set()
                for line in self.ninja("-t", "deps").split("\n"):
                    if line and not line.startswith(" "):
                        current = self.known_needs.setdefault(line.split(":")[0], set())
                    else:
                        current.add(line.strip())
        return self.known_needs

    def archives(self, object_file):
        """Static libraries that hold this object."""
        return [output for output, entry in self.commands.items() if output.endswith(".a")
                and f" {object_file} " in entry["command"] + " "]

    def seconds(self):
        """{test: how long it took}, as ctest noted: `NAME RUNS SECONDS` a line."""
        notes = self.build / "Testing" / "Temporary" / "CTestCostData.txt"
        lines = [line.split() for line in notes.read_text().split("\n")] if notes.exists() else []
        return {words[0]: float(words[2]) for words in lines if len(words) == 3}

    def link_command(self, program):
        """Its link alone, without what follows it (discovery of tests)."""
        command = self.commands[program]["command"]
        return next(part for part in re.split(r" && ", command) if f" -o {program} " in part + " ")


