# SPDX-License-Identifier: BSD-3-Clause
"""The type stubs and the compiled module have the same names, arguments and defaults, and everything has a docstring."""
import ast
import inspect
import pathlib
import re
import types
import unittest

import openhrp_dds
from openhrp_dds import _core

STUB = ast.parse((pathlib.Path(openhrp_dds.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))


def stub_arguments(function):
    """Names, which of them are keyword-only, and which have a default."""
    given = function.args
    names = [a.arg for a in given.args + given.kwonlyargs]
    optional = {a.arg for a in given.args[len(given.args) - len(given.defaults):]}
    optional |= {a.arg for a, default in zip(given.kwonlyargs, given.kw_defaults) if default is not None}
    return names, {a.arg for a in given.kwonlyargs}, optional


def split_arguments(text):
    """At commas outside of brackets."""
    parts, depth, part = [], 0, ""
    for c in text:
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += c
    return [p.strip() for p in parts + [part] if p.strip()]


def module_arguments(function):
    """The same from the signature that pybind11 writes at the top of a docstring."""
    first = function.__doc__.split("\n")[0]
    inner = re.match(r"\w+\((.*)\) -> ", first)[1]
    names, keyword, optional, only = [], set(), set(), False
    for part in split_arguments(inner):
        if part == "*":
            only = True
            continue
        name = part.split(":")[0].split("=")[0].strip()
        names.append(name)
        if only:
            keyword.add(name)
        if "=" in part:
            optional.add(name)
    return names, keyword, optional


class Stubs(unittest.TestCase):
    def setUp(self):
        self.classes = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
        self.functions = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}

    def test_the_module_has_the_names_of_the_stub_and_no_others(self):
        public = {name for name in vars(_core) if not name.startswith("_")}
        self.assertEqual(public, set(self.classes) | set(self.functions))

    def test_classes_have_the_members_of_the_stub_and_no_others(self):
        for name, node in self.classes.items():
            stubbed = {f.name for f in node.body if isinstance(f, ast.FunctionDef)} - {"__init__"}
            there = {m for m in vars(getattr(_core, name)) if not m.startswith("_") or m == "__deepcopy__"}
            self.assertEqual(there, stubbed, name)

    def test_arguments_are_those_of_the_stub(self):
        for name, node in self.functions.items():
            self.assertEqual(module_arguments(getattr(_core, name)), stub_arguments(node), name)
        for name, node in self.classes.items():
            for f in node.body:
                if not isinstance(f, ast.FunctionDef) or any(getattr(d, "id", "") == "property" for d in f.decorator_list):
                    continue
                # pybind11 calls an unnamed self "self" and other unnamed arguments arg0, arg1.
                self.assertEqual(module_arguments(getattr(getattr(_core, name), f.name)), stub_arguments(f), f"{name}.{f.name}")

    def test_properties_of_the_stub_are_properties(self):
        for name, node in self.classes.items():
            for f in node.body:
                if isinstance(f, ast.FunctionDef) and any(getattr(d, "id", "") == "property" for d in f.decorator_list):
                    self.assertIsInstance(inspect.getattr_static(getattr(_core, name), f.name), property, f"{name}.{f.name}")

    def test_everything_public_has_a_docstring_with_more_than_its_signature(self):
        for name, what in vars(_core).items():
            if name.startswith("_"):
                continue
            self.assertTrue(what.__doc__, name)
            for member, value in vars(what).items() if isinstance(what, type) else ():
                if member.startswith("_"):
                    continue
                lines = (value.__doc__ or "").strip().split("\n")
                wanted = 1 if isinstance(value, property) else 2
                self.assertGreaterEqual(len(lines), wanted, f"{name}.{member}")

    def test_everything_of_the_package_has_a_docstring_and_annotations(self):
        for name in openhrp_dds.__all__:
            what = getattr(openhrp_dds, name)
            self.assertTrue(what.__doc__, name)
            if isinstance(what, types.FunctionType):
                self.assertIn("return", what.__annotations__, name)
        self.assertTrue((pathlib.Path(openhrp_dds.__file__).parent / "py.typed").exists())


if __name__ == "__main__":
    unittest.main()
