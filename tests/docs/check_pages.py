"""check_pages.py links ROOT: every link of the .md files leads to a file, and to a heading where it names one.
check_pages.py html FOLDER: so does every link of Doxygen's pages.
check_pages.py blocks ROOT: every code block of the .md files is of a kind that some test compiles, runs or reads.
check_pages.py commands ROOT PROGRAM...: what the pages' ```sh blocks call is there, presets, scripts, programs and their
options; the blocks themselves are bash."""

import json
import pathlib
import re
import shlex
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


def check_html(folder):
    """Of the pages that Doxygen made: pages and places in them."""
    places = {}

    def places_of(path):
        if path not in places:
            text = path.read_text(encoding="utf-8")
            places[path] = set(re.findall(r'(?:id|name)="([^"]+)"', text))
        return places[path]

    seen = 0
    for page in sorted(folder.glob("*.html")):
        for target in re.findall(r'href="([^"]+)"', page.read_text(encoding="utf-8")):
            if re.match(r"[a-z]+:", target) or target == "#nested-classes":  # Doxygen 1.9 names it and leaves it out
                continue
            seen += 1
            name, _, place = target.partition("#")
            path = folder / name if name else page
            if not path.exists():
                yield f"{page.name}: {target}: no such file"
            elif place and path.suffix == ".html" and place not in places_of(path):
                yield f"{page.name}: {target}: no such place"
    if seen < 1000:
        yield f"only {seen} links found in {folder}"


def blocks_of(text):
    """(kind, code) of each."""
    return re.findall(r"^ *```(.*?)\n(.*?)^ *```$", text, re.S | re.M)


def check_blocks(root):
    """Which test takes a block is told by its kind and page; the numbers of C++ blocks by tests/CMakeLists.txt and
    tests/docs/CMakeLists.txt."""
    lists = (root / "tests/CMakeLists.txt").read_text() + (root / "tests/docs/CMakeLists.txt").read_text()
    run = (root / "tests/install/run.cmake").read_text()
    for page in pages(root):
        name = str(page.relative_to(root))
        blocks = blocks_of(page.read_text(encoding="utf-8"))
        kinds = [kind for kind, _ in blocks]
        in_guide = name.startswith("docs/guide/")
        taken = {
            "cpp": 1 if in_guide else len(re.findall(r"^ *page_(?:example|fragment)\(" + re.escape(name), lists, re.M)),
            "text": 1 if in_guide else 0,  # what the program before it prints
            "log": len(kinds) if name == "docs/first-ten-minutes.md" else 0,  # of a run: nothing to run
            "python": len(kinds) if name in ("README.md", "docs/python.md") else 0,  # tests/python/test_docs.py
            "json": len(kinds) if name == "docs/scene-format.md" else 0,  # tests/engine/scene_file_test.cpp
            "cmake": len(re.findall(r"^ *page_project\(" + re.escape(name), run, re.M)),
            "sh": len(kinds),  # below
        }
        for kind in sorted(set(kinds)):
            if kind not in taken:
                yield f"{name}: a block of '{kind}', which no test reads"
            elif kinds.count(kind) > taken[kind]:
                yield f"{name}: {kinds.count(kind)} blocks of {kind}, of which tests take {taken[kind]}"


def commands_of(block):
    """The words of each command, without comments and what its output is piped to."""
    for line in re.sub(r"\\\n", " ", block).splitlines():
        words = shlex.split(line.replace(";", " ; "), comments=True)
        while words:
            end = next((i for i, word in enumerate(words) if word in ("&&", "|", ";")), len(words))
            if words[:end]:
                yield words[:end]
            words = words[end + 1 :]


class Commands:
    """What commands of the pages may be."""

    def __init__(self, root, programs):
        self.root = root
        self.programs = {pathlib.Path(p).name: p for p in programs}
        self.helps = {}
        presets = json.loads((root / "CMakePresets.json").read_text())
        self.presets = {kind: {p["name"] for p in presets[kind + "Presets"]} for kind in ("configure", "build", "test")}
        lists = [p for p in root.rglob("CMakeLists.txt") if not SKIPPED & set(p.relative_to(root).parts)]
        self.lists = "".join(p.read_text() for p in lists)
        scripts = [root / "test", *root.glob("cmake/*.sh"), root / "cmake/TandemPackages.cmake"]
        self.packages = "".join(p.read_text() for p in scripts)

    def help_of(self, *words):
        if words not in self.helps:
            program = self.programs[words[0]]
            done = subprocess.run([program, *words[1:], "--help"], capture_output=True, text=True, timeout=60)
            self.helps[words] = done.stdout if done.returncode == 0 else None
        return self.helps[words]

    def of_program(self, name, words):
        """Of ours: the subcommand, where there are some, and options."""
        sub = [words[0]] if words and re.match(r"[a-z]", words[0]) and name != "relations" else []
        text = self.help_of(name, *sub)
        if text is None:
            yield f"{name} has no {sub[0] if sub else '--help'}"
            return
        for option in [w for w in words if re.match(r"--?[a-z]", w)]:
            if not re.search(r"(?<![\w-])" + re.escape(option) + r"(?![\w-])", text):
                yield f"{' '.join([name, *sub])} has no {option}"

    def of_preset(self, program, words):
        kind = "test" if program == "ctest" else "build" if "--build" in words else "configure"
        if "--preset" in words:
            preset = words[words.index("--preset") + 1]
            if preset not in self.presets[kind]:
                yield f"{program}: no {kind} preset {preset}"
        elif not {"--build", "--install"} & set(words):
            yield f"{program}: neither a preset nor a folder: {words}"
        if "--target" in words:
            target = words[words.index("--target") + 1]
            if not re.search(r"\((?:TARGET )?" + re.escape(target) + r"[\s)]", self.lists) and target != "docs":
                yield f"{program}: no target {target}"

    def wrong(self, words):
        name = pathlib.PurePath(words[0]).name
        if words[0] == "sudo" or re.match(r"[A-Za-z_]+=", words[0]):
            if words[1:]:
                yield from self.wrong(words[1:])
        elif words[0] == "python3":
            if not (self.root / words[1]).exists():
                yield f"python3: {words[1]}: no such file"
        elif words[0] == "mpirun":
            yield from self.wrong(words[3:] if words[1] == "-n" else words[1:])
        elif name in self.programs:
            yield from self.of_program(name, words[1:])
        elif name in ("cmake", "ctest"):
            yield from self.of_preset(name, words[1:])
        elif re.match(r"build/[a-z0-9]+/bin/", words[0]) or name == "tandem-mpi":
            target = re.sub(r"_test$", "", name)
            if not re.search(r"\(" + re.escape(target) + r"\s", self.lists) and "$" not in name:
                yield f"{words[0]}: no such program is built"
        elif words[0] == "apt-get":
            for package in words[2:]:
                if re.sub(r"^.*/|_.*$", "", package) not in self.packages:
                    yield f"apt-get: {package} is not among the packages of the scripts"
        elif "/" in words[0]:
            if not (self.root / words[0]).exists():
                yield f"{words[0]}: no such file"
        elif words[0] not in ("g++", "echo", "mkdir", "for", "do", "done", "case", "esac", "pip", "cd", "git"):
            yield f"{words[0]}: a command that this test does not know"


def check_commands(root, programs):
    known, seen = Commands(root, programs), 0
    for page in pages(root):
        for kind, block in blocks_of(page.read_text(encoding="utf-8")):
            if kind != "sh":
                continue
            name = page.relative_to(root)
            bash = subprocess.run(["bash", "-n"], input=block, capture_output=True, text=True)
            if bash.returncode != 0:
                yield f"{name}: {bash.stderr}"
                continue
            for words in commands_of(block):
                seen += 1
                yield from (f"{name}: {what}" for what in known.wrong(words))
    if seen < 50:
        yield f"only {seen} commands found"


def main():
    root = pathlib.Path(sys.argv[2]).resolve()
    checks = {"links": check_links, "html": check_html, "blocks": check_blocks}
    wrong = list(check_commands(root, sys.argv[3:]) if sys.argv[1] == "commands" else checks[sys.argv[1]](root))
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
