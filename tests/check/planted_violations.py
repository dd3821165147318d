"""deploy/check finds a violation of each of its rules, and none in a tree that keeps them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

CHECK = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "check"

GOOD = {
    "README.md": "# A title\n\nSee [below](#a-title), [the page](docs/page.md#two-words) and `server/base/vec.h`.\n",
    "docs/page.md": "# Page\n\n## Two words\n",
    "server/base/vec.h": "#pragma once\n\n#include <string>\n",
    "server/base/by_vec.cpp": '#include "base/vec.h"\n\nconstexpr int kMost = 3;\nstd::string name;  // std::vector\n',
    "deploy/go": '#!/usr/bin/env bash\necho "$1"\n',
}
IS_NO, NULL_WHERE = "is " + "no", "null " + "where"  # not said here either
HOME = "/" + "home/somebody/"


def check(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, newline="")
        done = subprocess.run([sys.executable, CHECK, folder], capture_output=True, text=True)
        return done.returncode, done.stdout


class PlantedViolations(unittest.TestCase):
    def test_a_tree_that_keeps_the_rules_passes(self):
        self.assertEqual(check(GOOD), (0, "no violation\n"))

    def planted(self, name, text, place):
        status, output = check(GOOD | {name: text})
        self.assertEqual(status, 1, output)
        self.assertEqual([line for line in output.splitlines()[:-1] if not line.startswith(place)], [], output)
        self.assertIn(place, output)

    def test_each_violation_is_found_where_it_is(self):
        for name, text, place in [
            ("README.md", "[gone](docs/gone.md)\n", "README.md:1: the link"),
            ("README.md", "\n[there](docs/page.md#three-words)\n", "README.md:2: 'page.md' has no heading"),
            ("README.md", "See `server/base/matrix.h`.\n", "README.md:1: 'server/base/matrix.h' is not there"),
            ("server/base/a.cpp", f'const char* place = "{HOME}data";\n', "server/base/a.cpp:1: a path"),
            ("server/base/a.cpp", "int a; \n", "server/base/a.cpp:1: blanks"),
            ("server/base/a.cpp", "int a;\r\n", "server/base/a.cpp:1: a carriage return"),
            ("server/base/a.cpp", "int a;", "server/base/a.cpp:1: the last line"),
            ("server/base/a.cpp", f'fail(name + " {IS_NO} number");\n', f"server/base/a.cpp:1: '{IS_NO} number': say 'is not a'"),
            ("server/base/a.cpp", f"// A folder {IS_NO} file.\n", f"server/base/a.cpp:1: '{IS_NO} file': say 'is not a'"),
            ("server/base/a.cpp", f"int a;  // [n] or {NULL_WHERE} nobody asks\n", f"server/base/a.cpp:1: '{NULL_WHERE}': say 'if'"),
            ("server/base/a.py", f"a = 1  # {NULL_WHERE} nobody asks\n", f"server/base/a.py:1: '{NULL_WHERE}': say 'if'"),
            ("docs/page.md", f"# Page\n\n## Two words\n\nA folder {IS_NO} file.\n", f"docs/page.md:5: '{IS_NO} file': say 'is not a'"),
            ("server/base/a.cpp", "#include <vector>\n\nstd::string name;\n", "server/base/a.cpp:3: std::string needs <string>"),
            ("server/base/near_vec.cpp", "constexpr int kMost{4};\n", "server/base/near_vec.cpp:1: 'kMost' is a name in 'by_vec.cpp' too"),
            ("deploy/go", "#!/usr/bin/env bash\necho $1\n", "deploy/go:2: note: Double quote"),
        ]:
            with self.subTest(place):
                self.planted(name, text, place)


if __name__ == "__main__":
    unittest.main()
