"""check_pages.py links ROOT: every link of the .md files leads to a file, and to a heading where it names one.
check_pages.py commands ROOT PROGRAM...: options in the pages' ```sh blocks are in the programs' --help."""

import pathlib
import re
import subprocess
import sys

SKIPPED = {"build", "results", ".git", "_deps"}


def pages(root):
    for path in sorted(root.rglob("*.md")):
        if not SKIPPED & set(path.relative_to(root).parts):
            yield path


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"```.*?```", "", text, flags=re.S))


def anchors(path):
    """As GitHub names headings."""
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.S)
    for heading in re.findall(r"^#+ +(.*)$", text, re.M):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        yield re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")


def check_links(root):
    for page in pages(root):
        text = without_code(page.read_text(encoding="utf-8"))
        for target in re.findall(r"\]\(\s*([^)\s]+)[^)]*\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            path = page.parent / name if name else page
            if not path.exists():
                yield f"{page.relative_to(root)}: {target}: no such file"
            elif anchor and anchor not in anchors(path):
                yield f"{page.relative_to(root)}: {target}: no such heading"


def commands_of(text):
    """The words of each command, without comments and what its output is piped to."""
    for block in re.findall(r"```sh\n(.*?)```", text, re.S):
        for line in re.sub(r"\\\n", " ", block).splitlines():
            line = re.sub(r"(^|\s)#.*", "", line)
            for part in line.split("|"):
                yield part.split()


def check_commands(root, programs):
    helps = {}

    def help_of(*words):
        if words not in helps:
            program = next(p for p in programs if pathlib.Path(p).name == words[0])
            done = subprocess.run([program, *words[1:], "--help"], capture_output=True, text=True, timeout=60)
            helps[words] = done.stdout if done.returncode == 0 else None
        return helps[words]

    names = {pathlib.Path(p).name for p in programs}
    seen = 0
    for page in pages(root):
        for words in commands_of(page.read_text(encoding="utf-8")):
            words = [pathlib.PurePath(w).name if pathlib.PurePath(w).name in names else w for w in words]
            if len(words) < 2 or words[0] not in names or words[1].startswith("-"):
                continue
            seen += 1
            text = help_of(words[0], words[1])
            if text is None:
                yield f"{page.relative_to(root)}: {words[0]} has no {words[1]}"
                continue
            for option in [w for w in words[2:] if re.match(r"--?[a-z]", w)]:
                if not re.search(r"(?<![\w-])" + re.escape(option) + r"(?![\w-])", text):
                    yield f"{page.relative_to(root)}: {words[0]} {words[1]} has no {option}"
    if seen < 10:
        yield f"only {seen} commands found"


def main():
    root = pathlib.Path(sys.argv[2]).resolve()
    wrong = list(check_links(root) if sys.argv[1] == "links" else check_commands(root, sys.argv[3:]))
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
