"""Arguments that do not fit, told in one line: which, what was expected, what was found."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

WHOLE = (int, np.integer)
MOST = 280  # characters of a message


def shortened(text: str) -> str:
    """On one line, without its middle where it is long: a name or a type may be."""
    line = " ".join(text.split())
    return line if len(line) <= MOST else f"{line[: MOST // 2]}...{line[3 - MOST // 2 :]}"


class Argument:
    """As pybind11 describes it: 'name: type = default'."""

    def __init__(self, text: str, by_name: bool) -> None:
        self.name, _, rest = text.partition(": ")
        self.expected, self.has_default, _ = rest.partition(" = ")
        self.by_name = by_name


def signature(text: str) -> list[Argument]:
    """Of the arguments between a function's brackets."""
    arguments, by_name = [], False
    for part in re.split(r", (?=\w+: |\*,|\*$)", text):
        if part == "*":
            by_name = True
        elif part:
            arguments.append(Argument(part, by_name))
    return arguments


def plain(expected: str) -> str:
    """The type without the names of modules, as a reader would say it."""
    text = re.sub(r"\b(?:tandem\._tandem|tandem|typing|collections\.abc)\.", "", expected)
    text = text.replace("SupportsFloat | SupportsIndex", "float").replace("SupportsInt | SupportsIndex", "int")
    text = re.sub(r"Optional\[(.*)\]$", r"\1 | None", text)
    return re.sub(r"(?:List|list|Sequence)\[(.*?)\]", r"sequence of \1", text).replace(" | None", ", or None")


def found(value: object) -> str:
    """A value's type, and itself where that is short."""
    kind = type(value).__name__
    if value is None:
        return "None"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    text = repr(value)
    return f"{kind} {text}" if isinstance(value, (str, bool, *WHOLE, float)) and len(text) < 40 else kind


def fits(value: object, expected: str) -> bool:
    """Whether the value is what pybind11 takes for the type; True where that is not known."""
    kind = plain(expected)
    if kind.endswith(", or None"):
        return value is None or fits(value, kind[: -len(", or None")])
    if kind.startswith("sequence of "):
        return (
            isinstance(value, Sequence)
            and not isinstance(value, (str, bytes))
            and all(fits(item, kind[len("sequence of ") :]) for item in value)
        )
    if kind == "float":
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    if kind == "int":
        return hasattr(value, "__index__")
    if kind == "bool":
        return hasattr(type(value), "__bool__")
    if kind == "str":
        return isinstance(value, (str, bytes))
    from . import _tandem

    known = getattr(_tandem, kind, None)
    return not isinstance(known, type) or isinstance(value, known)


def wrong_item(value: object, kind: str) -> str:
    """Which item of a sequence does not fit, where it is one."""
    if kind.startswith("sequence of ") and isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        for i, item in enumerate(value):
            if not fits(item, kind[len("sequence of ") :]):
                return f"a sequence whose item {i} is {found(item)}"
    return found(value)


def complaint(known: list[Argument], given: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[int, str]:
    """The first argument that does not fit, by its place, and what is said of it."""
    by_place = [argument for argument in known if not argument.by_name]
    for place, argument in enumerate(known):
        is_placed = not argument.by_name and place < len(given)
        if is_placed and argument.name in named:
            return place, f"{argument.name}: given twice, by its place and by its name"
        if not is_placed and argument.name not in named:
            if argument.has_default:
                continue
            return place, f"{argument.name}: missing, expected: {plain(argument.expected)}"
        value = given[place] if is_placed else named[argument.name]
        if not fits(value, argument.expected):
            kind = plain(argument.expected)
            return place, f"{argument.name}: {wrong_item(value, kind)}, expected: {kind}"
    if len(given) > len(by_place):
        more = [argument.name for argument in known if argument.by_name]
        by_name = f"; by name: {', '.join(more)}" if more else ""
        listed = ", ".join(a.name for a in by_place if a.name != "self")
        took = sum(a.name == "self" for a in by_place)
        return len(known), f"{len(given) - took} arguments by their places, expected: {listed or 'none'}{by_name}"
    for name in named:
        if name not in [argument.name for argument in known]:
            listed = ", ".join(a.name for a in known if a.name != "self")
            return len(known), f"{name}: no such argument, expected: {listed or 'none'}"
    return len(known) + 1, "a number out of range or a value that does not fit, expected: " + ", ".join(
        f"{a.name}: {plain(a.expected)}" for a in known if a.name != "self"
    )


def explained(text: str, given: tuple[Any, ...], named: Mapping[str, Any]) -> str:
    """One line for pybind11's lines: of several signatures by the one that fits longest."""
    called = text.partition("(")[0]
    complaints = []
    for line in text.split("\n"):
        match = re.match(r"    \d+\. ([\w.]*)\((.*)\)(?: -> .*)?$", line)
        if not match:
            continue
        known = signature(match.group(2))
        is_made = match.group(1) != ""  # an object of a class: no self is named
        if is_made:
            called = match.group(1).rpartition(".")[2]
        complaints.append(complaint(known, given[1:] if is_made else given, named))
    if not complaints:
        return text
    return shortened(f"{called}: {max(complaints, key=lambda c: c[0])[1]}")
