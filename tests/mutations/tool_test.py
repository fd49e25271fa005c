"""tools/mutate without a compiler: what it changes in a line, what the list says, and what is drawn."""

import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "dev" / "mutation"))

from drawing import lot, mutations, sources  # noqa: E402
from listing import Module, Mutation, quick_first, read_modules  # noqa: E402
from operators import candidates  # noqa: E402

LIST = ROOT / "tests" / "mutations" / "modules.list"


def changes(line, operator):
    found = candidates("int a;\n" + line).get(1, [])
    return {new for name, new in found if name == operator}


class Operators(unittest.TestCase):
    def test_change_code_and_nothing_else(self):
        self.assertEqual(changes("if (a < b) run();", "relation"), {"if (a <= b) run();"})
        self.assertEqual(changes("std::vector<int> a = f(\"x < y\");  // a < b", "relation"), set())
        self.assertEqual(changes("x = a + 2;", "constant"), {"x = a + 3;"})
        self.assertEqual(changes("x = 0.5 * a;", "constant"), {"x = 0.625 * a;"})
        self.assertEqual(changes("if (a && !b) return c;", "logic"), {"if (a || !b) return c;"})
        self.assertEqual(changes("if (a && !b) return c;", "negation"), {"if (a && b) return c;"})
        self.assertEqual(changes("if (f(a)) return;", "condition"),
                         {"if (!(f(a))) return;", "if (false && (f(a))) return;"})
        self.assertEqual(changes("  f(b, a.c);", "arguments"), {"  f(a.c, b);"})
        self.assertEqual(changes("a = c.most - b.x;", "word"), {"a = c.most - b.y;"})

    def test_leave_out_whole_statements_only(self):
        self.assertEqual(changes("  barrier();", "statement"), {"  ;"})
        self.assertEqual(changes("  a.b[c] += 2;", "statement"), {"  ;"})
        for line in ("return a;", "const int a = f();", "int a(b);", "f(a,", "throw Error(a);"):
            self.assertEqual(changes(line, "statement"), set(), line)
        branch = candidates("if (a)\n  barrier();")
        self.assertFalse([name for name, _ in branch.get(1, []) if name == "statement"])


class Lists(unittest.TestCase):
    def test_change_one_line_each(self):
        for module in read_modules(LIST):
            for mutation in mutations(module, ROOT, 28):
                self.assertNotEqual(mutation.was, mutation.now, mutation.name)
                path = ROOT / mutation.path
                text = path.read_text() if path.exists() else ""
                after = mutation.applied(text)
                if after is None:
                    self.assertFalse(mutation.drawn, mutation.name)  # stale: what a note tells of has changed since
                    continue
                pairs = zip(text.split("\n"), after.split("\n"), strict=True)
                self.assertEqual(sum(a != b for a, b in pairs), 1, mutation.name)

    def test_name_sources_that_are_there(self):
        for module in read_modules(LIST):
            self.assertGreaterEqual(len(lot(module, ROOT, 28)), module.draw, module.name)
            for path in module.sources + module.without:
                self.assertTrue((ROOT / path).exists(), path)
        page, job = read_modules(LIST, ["page", "planish"])
        self.assertFalse({path for path, _ in sources(page, ROOT)} & {path for path, _ in sources(job, ROOT)})

    def test_say_where_they_cannot_be_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "some.list"
            for text in ("draw 3\n", "module a\nwas b;\n", "module a\nkiller b_test\n"):
                path.write_text(text)
                self.assertRaises(SystemExit, read_modules, path)
        self.assertRaises(SystemExit, read_modules, LIST, ["no_such_module"])

    def test_ask_first_what_is_named_after_the_source(self):
        def asked(*tests):
            return Module("", tests=list(tests)).tests_named_after("src/planish/fair/fold_cure.cpp")

        self.assertEqual(asked("fair_test", "pipeline_test"), ["fair_test *FoldCure*"])
        self.assertEqual(asked("cli_test -Fair*"), ["cli_test *FoldCure*-Fair*"])
        for test in ("vulkan_test Embed*", "ctest ^c$"):
            self.assertEqual(asked(test), [])

    def test_ask_what_is_quick_before_what_is_not(self):
        seconds = {"cli.Fair.A": 9, "cli.Needs.B": 3, "cli.Help.C": 0.1, "mesh.Check.D": 0.1}
        self.assertEqual(quick_first("cli_test", seconds), ["cli_test -Fair.A:Needs.B", "cli_test Fair.A:Needs.B"])
        self.assertEqual(quick_first("cli_test -Fair*", seconds),
                         ["cli_test -Fair.A:Needs.B:Fair*", "cli_test Fair.A:Needs.B-Fair*"])
        for test in ("mesh_test", "cli_test Needs*", "ctest ^cli$"):
            self.assertEqual(quick_first(test, seconds), [test])

    def test_equal_lines_are_told_apart(self):
        text = "a;\n  b;\n  b;\n"
        self.assertEqual(Mutation("", "", "b;", "c;", 2).applied(text), "a;\n  b;\n  c;\n")
        self.assertIsNone(Mutation("", "", "b;", "c;", 3).applied(text))


class Drawing(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.lines = [f"  a{i} = b{i} + {i};" for i in range(40)]

    def drawn(self, seed=28, folder="src", noted=(), draw=10):
        (self.root / folder).mkdir(exist_ok=True)
        (self.root / folder / "a.cpp").write_text("\n".join(self.lines))
        return mutations(Module("m", draw, [folder], noted=list(noted)), self.root, seed)

    def test_is_the_same_for_a_seed_wherever_the_file_lies(self):
        was = [m.was for m in self.drawn()]
        self.assertEqual(len(set(was)), 10)
        self.assertEqual([m.was for m in self.drawn(folder="moved")], was)
        self.assertEqual([m.was for m in self.drawn(draw=7)], was[:7])
        self.assertNotEqual([m.was for m in self.drawn(seed=29)], was)

    def test_is_the_same_where_another_line_has_changed(self):
        before = self.drawn()
        self.lines.remove("  " + before[2].was)
        after = self.drawn()
        self.assertEqual([(m.was, m.now) for m in after[:9]], [(m.was, m.now) for m in before[:2] + before[3:]])

    def test_knows_what_has_a_note(self):
        first, unlucky = self.drawn()[0], self.drawn(draw=40)[39]
        notes = [Mutation("src/a.cpp", "constant", m.was, "c;", name=f"note-{m.was}", notes={"survives": "so"})
                 for m in (unlucky, first)]
        found = self.drawn(noted=notes)
        self.assertEqual(len(found), 11)
        self.assertIs(found[0], notes[1])
        self.assertTrue(found[0].drawn)
        self.assertIs(found[10], notes[0])
        self.assertFalse(found[10].drawn)


if __name__ == "__main__":
    unittest.main()
