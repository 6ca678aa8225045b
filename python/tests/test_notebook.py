"""The example notebook, from its start to its end."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The kernel draws into the notebook.
    monkeypatch.delenv("MPLBACKEND")
    notebook = nbformat.read(EXAMPLES / "biaxial.ipynb", as_version=4)
    NotebookClient(
        notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = [output["data"] for output in outputs if "data" in output]
    assert sum("image/png" in data for data in shown) == 3
    ratio = float(shown[-2]["text/plain"].removeprefix("np.float64(").rstrip(")"))
    # Weaker bonds give a lower peak.
    assert 0.9 < ratio < 0.98
