"""Measure what a scan's resolution, noise, lie and size change in a finger made of it.

Run as `python -m fefinger.validation.evidence.scans reports [resolution ...]`; some 50 CPU seconds
for each surface on the coarse mesh, as each is built ten times, by a process of its own. The
surfaces are half an ellipsoid ahead of an elliptic cylinder, 1.75 widths long, 0.8 as thick as wide
with 0.65 of it below the widest level. A plate at 20 degrees presses each 1.5 mm deep. Files and
meshes are made anew, in a cache of their own.
"""

import sys
import tempfile
import time
from hashlib import sha256
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
import trimesh
from fefinger.validation.empty_cache import empty_cache
from fefinger.validation.provenance import save

from fefinger.mesh.store import load_or_build
from fefinger.pipeline import run
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError


LENGTH, AHEAD, THICK, PALM = 1.75, 1.1, 0.8, 0.65
"""Length, length of the ellipsoid and thickness over the width; part of the thickness below."""

BUILDS = 10
"""Builds of each surface."""

SAME: dict[str, dict[str, Any]] = {
    "smooth, 17 thousand triangles": {},
    "700 triangles": {"triangles": 700},
    "2000 triangles": {"triangles": 2000},
    "noise of 0.05 mm": {"noise": 0.05},
    "noise of 0.1 mm": {"noise": 0.1},
    "700 triangles, noise of 0.05 mm": {"triangles": 700, "noise": 0.05},
    "rolled by 8 degrees": {"turn": (8, 0, 0)},
    "tilted by 15 degrees": {"turn": (0, 15, 0)},
    "turned about all axes": {"turn": (5, 10, -15)},
    "cut askew by 20 degrees": {"askew": 20},
    "150 thousand triangles": {"dense": True},
    "150 thousand triangles, noise of 0.1 mm": {"dense": True, "noise": 0.1},
}
"""Surfaces of one finger 14 mm wide: their forces should be the same."""

OTHER: dict[str, dict[str, Any]] = {
    f"{width:g} mm wide": {"width": width} for width in (9.0, 11.6, 20.8, 26.0)
}
"""Fingers of other sizes."""


def surface(
    width: float = 14.0,
    *,
    dense: bool = False,
    triangles: int | None = None,
    noise: float = 0.0,
    turn: tuple[float, float, float] = (0, 0, 0),
    askew: float = 0.0,
) -> trimesh.Trimesh:
    """Return a made scan, open behind; turn in degrees, noise in mm along the normals."""
    rings, around = (135, 278) if dense else (45, 96)
    angle = np.linspace(0.0, np.pi / 2, rings + 1)[1:]
    x = np.append(AHEAD * (np.cos(angle) - 1.0), -AHEAD - (LENGTH - AHEAD) * angle / angle[-1])
    half = np.append(np.sin(angle), np.ones(rings))
    roll = np.arange(around) * 2.0 * np.pi / around
    y, z = np.outer(half, np.sin(roll)) / 2.0, np.outer(half, np.cos(roll)) * THICK
    z *= np.where(z < 0.0, PALM, 1.0 - PALM)
    points = np.stack([np.broadcast_to(x[:, None], y.shape), y, z], axis=-1).reshape(-1, 3)
    index = 1 + np.arange(len(points)).reshape(y.shape)
    here, beside = index, np.roll(index, -1, axis=1)
    fan = np.stack([np.zeros(around, dtype=int), beside[0], here[0]], axis=1)
    strips = [
        np.stack(corners, axis=-1).reshape(-1, 3)
        for corners in (
            (here[:-1], beside[:-1], here[1:]),
            (beside[:-1], beside[1:], here[1:]),
        )
    ]
    mesh = trimesh.Trimesh(width * np.vstack([np.zeros(3), points]), np.vstack([fan, *strips]))
    if askew:
        center = mesh.triangles_center
        mesh.update_faces(
            center[:, 0] > np.tan(np.radians(askew)) * center[:, 2] - 0.93 * LENGTH * width
        )
        mesh.remove_unreferenced_vertices()
    random = np.random.default_rng(0)
    mesh.vertices += noise * random.normal(size=(len(mesh.vertices), 1)) * mesh.vertex_normals
    if triangles is not None:
        whole = pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
        few = whole.decimate(1.0 - triangles / len(mesh.faces))
        mesh = trimesh.Trimesh(few.points, few.regular_faces)
    mesh.apply_transform(trimesh.transformations.euler_matrix(*np.radians(turn)))
    return mesh


def measure(mesh: trimesh.Trimesh, resolution: str, folder: Path) -> dict[str, Any]:
    """Return what a made scan gives: size, force, and of BUILDS builds CPU seconds and failures.

    `meshes`: the number of different meshes of these builds, by a hash of points and cells.
    """
    path = folder / "scan.ply"
    mesh.export(path)
    rows: list[dict[str, Any]] = []
    for number in range(BUILDS):
        # A process forgets what another one read and fitted, and its cache is empty.
        with empty_cache(), get_context("fork").Pool(1) as pool:
            rows.append(pool.apply(built, (path, resolution, number == 0)))
    done = [row for row in rows if "failure" not in row]
    seconds = [row.pop("seconds") for row in done]
    return rows[0] | {
        "meshes": len({row.pop("hash") for row in done}),
        "failures": BUILDS - len(done),
        "seconds": round(max(seconds, default=np.nan), 1),
    }


def built(path: Path, resolution: str, pressed: bool) -> dict[str, Any]:
    """Return hash and CPU seconds of a mesh of a scan; size, force and noise if it is pressed."""
    started = time.process_time()
    try:
        finger = Finger.from_surface(path, tissue="maeno1998", resolution=resolution)
        made = load_or_build(finger, half=True)
    except (InputError, ConvergenceError) as error:
        return {"failure": str(error)}
    digest = sha256(made.points.tobytes() + made.cells.tobytes()).hexdigest()
    row = {"seconds": time.process_time() - started, "hash": digest}
    if not pressed:
        return row
    press = Scene(
        finger=finger,
        indenter=Flat(20),
        motion=Ramp(speed=10, depth=1.5),
        ask=Ask(rel_error=0.9, spikes=(), fields=False),
    )
    force = run(press, mechanics="linear").force
    assert force is not None  # of a mechanics with contact
    noise = [note for note in made.quality["notes"] if "The noise of the scan" in note]
    return row | {
        "width": round(finger.width, 3),
        "thickness": round(finger.thickness, 3),
        "force": round(float(force[-1]), 4),
        "template": made.quality.get("template"),
        "noise": noise,
    }


def main(folder: Path, resolutions: list[str]) -> None:
    """Measure all made scans and write `scans.json` into the folder, anew after each."""
    rows: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as files:
        for resolution, (name, given) in product(resolutions, (SAME | OTHER).items()):
            row = measure(surface(**given), resolution, Path(files))
            print(resolution, name, row, flush=True)
            rows[f"{resolution}: {name}"] = row
            forces = [
                rows[label]["force"]
                for label in (f"{resolution}: {same}" for same in SAME)
                if "force" in rows.get(label, {})
            ]
            report = {
                "about": "Made scans of fingertips: force, size, seconds by resolution and noise.",
                "range_over_mean": round(float(np.ptp(forces) / np.mean(forces)), 4),
                "rows": rows,
            }
            save(folder / "scans.json", report, " ".join([folder.name, *resolutions]))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:] or ["coarse"])
