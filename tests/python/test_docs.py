"""The code blocks of docs/python.md run, in order, and print what they should; so do those of README.md."""

import contextlib
import io
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def printed_by(page):
    """Lines that all blocks of a page print."""
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
    printed = io.StringIO()
    names = {}
    with contextlib.redirect_stdout(printed):
        for block in blocks:
            exec(compile(block, str(page), "exec"), names)
    return printed.getvalue().splitlines()


class Page(unittest.TestCase):
    def test_readme(self):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        self.assertEqual(printed_by(ROOT / "README.md"), re.findall(r"print\(.*  # (.*)$", text, re.M))

    def test_blocks_run(self):
        lines = printed_by(ROOT / "docs" / "python.md")
        self.assertEqual(lines[0], "1.0 [0.5 0.  0. ] [1.5 0.  0. ]")
        self.assertRegex(lines[1], r"^4 \[0\.1")
        self.assertRegex(lines[2], r"^1\.[45]\d+$")  # cubes within 2 and 2.1 of the middle
        self.assertRegex(lines[3], r"^1 \[\d{4,}\] 0$")
        self.assertEqual(lines[4], "80")  # the border of 20 by 20 cells
        self.assertEqual(lines[5], "9 5")
        self.assertRegex(lines[6], r"<tandem.Answer signed_distance 0\.75")
        self.assertRegex(lines[7], r"^\d+ True$")
        self.assertEqual(len(lines), 8)


if __name__ == "__main__":
    unittest.main()
