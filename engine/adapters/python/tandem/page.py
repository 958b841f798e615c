"""Pictures for people: a page that plays steps back."""

import html
import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import Optional, Union

from . import _tandem


class Page:
    """A page as a file; a notebook shows it where it is the value of a cell."""

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path

    def __repr__(self) -> str:
        return f"<tandem.Page {self.path}>"

    def _repr_html_(self) -> str:
        page = html.escape(self.path.read_text(encoding="utf-8"), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 720px; border: 0"></iframe>'


def _program() -> str:
    beside = pathlib.Path(__file__).resolve().parents[2] / "bin" / "tandem-bench"  # in the build tree
    found = os.environ.get("TANDEM_BENCH") or (str(beside) if beside.exists() else shutil.which("tandem-bench"))
    if not found:
        raise FileNotFoundError(
            "tandem.show: the program tandem-bench is not there, allowed: install tandem-tools, or set TANDEM_BENCH to its path"
        )
    return found


def show(
    what: Union["_tandem.Scene", str, "os.PathLike[str]"],
    pipeline: Optional["_tandem.Pipeline"] = None,
    *,
    path: Union[str, "os.PathLike[str]", None] = None,
) -> Page:
    """Writes the report's replay as a page that opens offline, and returns it.

    what: a scene, with the contacts of its pipeline's last step (without: they are found); or the path of a Recording.
    path: of the page; without, it is in the folder of temporary files.
    """
    program = _program()
    if path is None:
        handle, name = tempfile.mkstemp(prefix="tandem-", suffix=".html")
        os.close(handle)
        page = pathlib.Path(name)
    else:
        page = pathlib.Path(path)
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(what, _tandem.Scene):
            if pipeline is None:
                pipeline = _tandem.Pipeline()
                pipeline.step(what)
            record = pathlib.Path(folder) / "scene.rec"
            with _tandem.Recording(record, what) as recording:
                recording.add(what, pipeline)
        else:
            record = pathlib.Path(what)
        done = subprocess.run(
            [program, "report", str(record), "-o", str(page)], capture_output=True, text=True, check=False
        )
    if done.returncode != 0:
        raise ValueError(f"tandem.show: {done.stderr.strip()}")
    return Page(page)
