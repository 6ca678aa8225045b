"""A run that several tests read."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")

import clastic

#: A biaxial test of 400 bonded disks, just past the peak.
SETS = {"stages.load.increments": 24, "output.frames_every": 5, "output.energy": True}


def program(*arguments: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Calls the program, in a process of its own."""
    words = [sys.executable, "-m", "clastic", *arguments]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="session")
def biaxial(tmp_path_factory: pytest.TempPathFactory) -> clastic.Run:
    out = tmp_path_factory.mktemp("runs") / "biaxial"
    with warnings.catch_warnings():
        # Its contacts are soft, of which a run warns.
        warnings.simplefilter("ignore", clastic.RunWarning)
        return clastic.run("biaxial_small", SETS, out, progress=False)


@pytest.fixture(scope="session")
def cyclic(tmp_path_factory: pytest.TempPathFactory) -> clastic.Run:
    """A rock of 900 disks that emits."""
    out = tmp_path_factory.mktemp("runs") / "cyclic"
    with warnings.catch_warnings():
        # One contact overlaps by 3 % of a radius, of which a run warns.
        warnings.simplefilter("ignore", clastic.RunWarning)
        return clastic.run("acoustic_emission", out=out, progress=False)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A disk of 2 kg on a floor, without gravity."""
    path = tmp_path / "disk.ron"
    path.write_text(DISK)
    return path


#: Radius such that the mass is 2000 pi r^2 = 2 pi kg.
DISK = """(
    version: 1, title: "a disk on a floor",
    materials: { "m": (density: 2000.0, contact: (normal_stiffness: 1.0e6, friction: 0.5),
        bond: (normal_stiffness: 1.0e6, tangential_stiffness: 1.0e6, cohesion: 1.0e6, tensile_strength: 1.0e6)) },
    specimen: Particles([(position: (0.0, 0.0316227766), radius: 0.0316227766)]),
    walls: [(name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), probe: "floor",
        contact: (normal_stiffness: 1.0e6, friction: 0.5))],
    stages: [Load(name: "rest", increments: 50)],
)"""
