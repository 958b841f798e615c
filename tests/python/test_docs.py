"""The code blocks of docs/python.md run, in order, and print what they should."""

import contextlib
import io
import pathlib
import re
import unittest

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "python.md"


class Page(unittest.TestCase):
    def test_blocks_run(self):
        blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
        printed = io.StringIO()
        names = {}
        with contextlib.redirect_stdout(printed):
            for block in blocks:
                exec(compile(block, str(PAGE), "exec"), names)
        lines = printed.getvalue().splitlines()
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
