"""The stubs say what the module has: names, arguments and their defaults."""

import ast
import pathlib
import re
import unittest

import tandem
from tandem import _tandem


def described(name, docstring):
    """Arguments of pybind11's first line of a docstring: [(name, has a default)]."""
    inside = re.match(re.escape(name) + r"\((.*)\) -> ", docstring.split("\n")[0]).group(1)
    arguments = [a for a in re.split(r", (?=\w+:|\*,|\*$)", inside) if a]
    return [(a.split(":")[0], " = " in a) for a in arguments]


def declared(function):
    arguments = function.args
    plain = [(a.arg, False) for a in arguments.args]
    for i in range(len(arguments.defaults)):
        plain[-1 - i] = (plain[-1 - i][0], True)
    named = [(a.arg, d is not None) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    return plain + ([("*", False)] if named else []) + named


class Stubs(unittest.TestCase):
    def test_names_and_arguments(self):
        stub = ast.parse((pathlib.Path(tandem.__file__).parent / "_tandem.pyi").read_text(encoding="utf-8"))
        seen = set()
        for node in stub.body:
            if isinstance(node, ast.FunctionDef):
                seen.add(node.name)
                if not node.decorator_list:
                    self.assertEqual(
                        declared(node), described(node.name, getattr(_tandem, node.name).__doc__), node.name
                    )
            if isinstance(node, ast.ClassDef):
                seen.add(node.name)
                self.compare_class(node, getattr(_tandem, node.name))
        self.assertEqual(seen, {name for name in dir(_tandem) if not name.startswith("_")})

    def compare_class(self, node, real):
        members = {m.name: m for m in node.body if isinstance(m, ast.FunctionDef)}
        there = {
            n
            for n, m in vars(real).items()
            if not n.startswith(("__", "_pybind11_"))
            or (
                n in ("__init__", "__enter__", "__exit__", "__len__")
                and "(self: " in (m.__doc__ or "")
                or n == "__enter__"
            )
        }
        self.assertEqual(set(members), there, node.name)
        for name, member in members.items():
            method = getattr(real, name)
            if callable(method) and name not in ("__enter__", "__exit__"):
                self.assertEqual(declared(member), described(name, method.__doc__), f"{node.name}.{name}")


if __name__ == "__main__":
    unittest.main()
