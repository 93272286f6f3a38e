"""Every notebook runs from its first cell to its last, by its own kernel, and its code is typed."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "python" / "examples").glob("*.ipynb"))
#: What a notebook needs beside the package.
NEEDS = {
    "crocoddyl_warm_start": ["crocoddyl"],
    "data_set": ["mujoco", "pyarrow"],
    "margins": ["matplotlib"],
    "posture_checked_by_pinocchio": ["pinocchio"],
    "scan_read_by_open3d": ["open3d"],
    "tracking_environment": ["mujoco"],
}
#: What cells show, by notebook.
SHOWN = {"margins": "image/png", "own_robot": "text/html", "scan_to_plan": "text/html"}


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_notebook(file: Path, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="SKIPPED: no nbformat (pip install nbclient)")
    nbclient = pytest.importorskip("nbclient", reason="SKIPPED: no nbclient (pip install nbclient ipykernel)")
    for name in NEEDS.get(file.stem, []):
        try:
            importlib.import_module(name)
        except ImportError as error:
            pytest.skip(f"SKIPPED: {file.name}: no {name}: {error}")
    notebook = nbformat.read(file, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert code and not any(cell.outputs for cell in code), "outputs are not kept in the repository"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = {kind for cell in code for output in cell.outputs for kind in output.get("data", {})}
    assert SHOWN.get(file.stem) in {None, *kinds}


def test_notebooks_are_typed(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="SKIPPED: no nbformat (pip install nbclient)")
    pytest.importorskip("mypy", reason="SKIPPED: no mypy")
    for file in NOTEBOOKS:
        cells = nbformat.read(file, as_version=4).cells
        code = [cell.source for cell in cells if cell.cell_type == "code"]
        # The last expression of a cell is its value.
        (tmp_path / f"{file.stem}.py").write_text("from __future__ import annotations\n" + "\n".join(code))
    settings = ["--config-file", str(ROOT / "python" / "pyproject.toml"), "--cache-dir=/dev/null"]
    # The packages that notebooks need are not looked into: which are installed would decide.
    files = sorted(str(path) for path in tmp_path.glob("*.py"))
    done = subprocess.run([sys.executable, "-m", "mypy", *settings, *files], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
