"""tools/mutate without a compiler: what it changes in a line, and that the lists read as it writes them."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "mutation"))

from drawing import all_changes, draw  # noqa: E402
from listing import Module, Mutation, quick_first, read_lists, read_module  # noqa: E402
from operators import candidates  # noqa: E402

LISTS = ROOT / "tests" / "mutations"


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
    def test_are_read_as_they_are_written(self):
        for path in LISTS.glob("*.list"):
            module = read_module(path)
            with tempfile.TemporaryDirectory() as folder:
                module.write(folder)
                self.assertEqual((pathlib.Path(folder) / path.name).read_text(), path.read_text())

    def test_change_one_line_each(self):
        for module in read_lists(LISTS):
            for mutation in module.mutations:
                self.assertNotEqual(mutation.was, mutation.now, mutation.name)
                path = ROOT / mutation.path
                text = path.read_text() if path.exists() else ""
                after = mutation.applied(text)
                if after is None:
                    continue  # stale: its line has changed since
                pairs = zip(text.split("\n"), after.split("\n"), strict=True)
                self.assertEqual(sum(a != b for a, b in pairs), 1, mutation.name)

    def test_ask_first_what_is_named_after_the_source(self):
        def asked(*tests):
            return Module("", [], [], list(tests), [], []).tests_named_after("src/planish/fair/fold_cure.cpp")

        self.assertEqual(asked("fair_test", "pipeline_test"), ["fair_test *FoldCure*"])
        self.assertEqual(asked("cli_test -Fair*"), ["cli_test *FoldCure*-Fair*"])
        for test in ("vulkan_test Embed*", "ctest ^c$"):
            self.assertEqual(asked(test), [])
        self.assertEqual(asked(), [])

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

    def test_a_seed_draws_the_same_and_more(self):
        module = next(m for m in read_lists(LISTS, ["mesh"]))
        lines = all_changes(module, ROOT)
        few, more = (list(draw(lines, "mesh", 5, count)) for count in (7, 20))
        self.assertEqual(few, more[:7])
        self.assertNotEqual(few, list(draw(lines, "mesh", 6, 7)))

    def test_stale_ones_give_way_to_others(self):
        with tempfile.TemporaryDirectory() as folder:
            module = read_lists(LISTS, ["mesh"])[0]
            module.mutations = [m for m in module.mutations if m.is_applicable(ROOT)][:5]
            kept = module.mutations[1:]
            module.mutations[0] = Mutation("src/planish/mesh/check.cpp", "constant", "no such line;", ";")
            module.write(folder)
            subprocess.run([ROOT / "tools" / "mutate", "--renew", "--lists", folder], check=True,
                           stdout=subprocess.DEVNULL)
            renewed = read_lists(folder)[0].mutations
        self.assertEqual([(m.path, m.was) for m in renewed[:4]], [(m.path, m.was) for m in kept])
        self.assertEqual(len(renewed), 5)
        self.assertEqual(len({(m.path, m.was, m.place) for m in renewed}), 5)
        self.assertTrue(renewed[4].is_applicable(ROOT))


if __name__ == "__main__":
    unittest.main()
