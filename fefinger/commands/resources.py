"""`fefinger scenes`, `mesh` and `cache`: scenes, meshes, and what is kept on this machine."""

from typing import TYPE_CHECKING

import click

from fefinger.commands import console
from fefinger.commands.console import Record, changes_option, json_option
from fefinger.support.text import percent, table


if TYPE_CHECKING:
    from fefinger.geometry.finger_mesh import FingerMesh
    from fefinger.support.cache import Entry


@click.command()
@click.argument("name", required=False)
@click.option("--schema", is_flag=True, help="Print the JSON Schema of scene files, for editors.")
@json_option
def scenes(name: str | None, schema: bool, as_json: bool) -> None:
    """List the built-in scenes, or print one.

    Prints the scene called NAME as TOML, to start a scene of your own from. With --schema it prints
    the JSON Schema by which an editor completes and checks scene files; with NAME, a scene or its
    file, the schema has the objects of its plugins too.
    """
    from fefinger.scene import builtin as library

    if schema:
        from fefinger.scene.schema import schema as scene_schema

        if name is not None:
            library.load(name)
        console.print_answer(scene_schema(), "", as_json=True)
        return
    if name is not None:
        text = library.text(name).removesuffix("\n")
        record = library.load(name).to_dict() if as_json else {}  # a text needs no library
        console.print_answer(record, text, as_json=as_json)
        return
    rows = [(each, library.summary(each)) for each in library.names()]
    listed = {"scenes": [{"name": n, "summary": summary} for n, summary in rows]}
    console.print_answer(listed, table(rows), as_json=as_json)


@click.command()
@click.argument("scene", default="flat-press")
@click.option("--whole", is_flag=True, help="Mesh the whole finger, not its symmetric half.")
@click.option("-o", "--output", metavar="FILE.vtu", help="File to write the mesh to.")
@click.option("--picture", metavar="PNG", help="Draw the mesh.")
@changes_option
@json_option
def mesh(
    scene: str,
    whole: bool,
    output: str | None,
    picture: str | None,
    changes: tuple[str, ...],
    as_json: bool,
) -> None:
    """Build, check and draw a finger mesh.

    Uses the shipped or cached mesh of the finger of SCENE if there is one.
    """
    from fefinger.mesh.mesh_record import gate, write
    from fefinger.mesh.store import load_or_build
    from fefinger.scene import builtin
    from fefinger.support.atomic_write import output_file

    finger = builtin.load(scene, builtin.settings(changes)).finger
    if output is not None:
        output_file(output, "-o", ".vtu")
    if picture is not None:
        output_file(picture, "--picture", ".png")
    built = load_or_build(finger, half=not whole, progress=console.remark)
    gate(built.quality)
    if output is not None:
        write(built, output)
    if picture is not None:
        from fefinger import view

        view.draw_mesh(built, picture)
    for file in filter(None, (output, picture)):
        console.remark(f"wrote {file}")
    console.print_answer(mesh_record(built), mesh_summary(built), as_json=as_json)


def mesh_record(mesh: "FingerMesh") -> Record:
    """Return the record of `fefinger mesh`."""
    return {
        "name": mesh.name,
        "half": mesh.half,
        "points": len(mesh.points),
        "tetrahedra": len(mesh.cells),
        "recipe": dict(mesh.recipe),
        "quality": dict(mesh.quality),
    }


def mesh_summary(mesh: "FingerMesh") -> str:
    """Return a few lines on a mesh: finger, size and quality."""
    recipe, quality = mesh.recipe, mesh.quality
    made = f"shaped from {quality['template']}" if "template" in quality else "made by the mesher"
    shape = recipe["surface"] or f"pad radius {recipe['pad_radius']:g} mm"
    volumes = ", ".join(f"{name} {value:.0f}" for name, value in quality["volumes"].items())
    off = max(abs(error) for error in quality["volume_errors"].values())
    angles = f"{quality['min_dihedral_deg']:.0f} to {quality['max_dihedral_deg']:.0f} degrees"
    along, across = quality["radii"]
    lines = [
        ("mesh", f"{mesh.name}, {'half a' if mesh.half else 'the whole'} finger, {made}"),
        ("finger", f"{recipe['width']:g} mm wide, {recipe['thickness']:g} mm thick, {shape}"),
        ("size", f"{len(mesh.points)} points, {len(mesh.cells)} tetrahedra"),
        (
            "pad",
            f"edges of {quality['pad_edge_mean']:.2g} mm (at most {quality['pad_edge_max']:.2g}), "
            f"radii {along:.3g} mm along and {across:.3g} mm across the finger",
        ),
        (
            "soft tissue",
            f"{quality['pulp_thickness']:.2g} mm from first touch at 30 degrees to bone",
        ),
        ("volumes", f"{volumes} mm³, within {percent(off)} of the smooth surfaces"),
        ("quality", f"dihedral angles of {angles}; all checks passed"),
        *(("note", note) for note in quality.get("notes", ())),
    ]
    return table(lines)


@click.command()
@click.option(
    "--prune", "days", type=float, metavar="DAYS", help="Remove entries unused for this many days."
)
@json_option
def cache(days: float | None, as_json: bool) -> None:
    """List and prune the cache.

    The cache holds meshes, operators of condensed fingers (a few hundred MB each), their modes of
    vibration (50 MB), patches (their parts under one indenter with one set of end organs) and
    presses of a calibration (small). Beyond 10 GB of operators and 2 GB of modes or patches the
    least recently used are removed automatically. Entries are built again when they are needed;
    `--prune 0` removes everything.
    """
    from fefinger.support import cache as store
    from fefinger.support.checks import number

    removed: tuple[store.Entry, ...] = ()
    if days is not None:
        removed = store.remove(store.unused(number("--prune", days, at_least=0, unit="days")))
    record: Record = {
        "folder": str(store.root()),
        "entries": [cache_record(entry) for entry in store.entries()],
        "removed": [cache_record(entry) for entry in removed],
    }
    console.print_answer(record, cache_summary(record), as_json=as_json)


def cache_record(entry: "Entry") -> Record:
    """Return the record of one entry of the cache."""
    from datetime import UTC, datetime

    return {
        "kind": entry.kind,
        "what": entry.what,
        "MB": round(entry.size / 1e6, 1),
        "used": datetime.fromtimestamp(entry.used, UTC).isoformat(timespec="seconds"),
        "paths": [str(entry.path)],
    }


def cache_summary(record: Record) -> str:
    """Return a table of the entries of the cache, and how many were removed."""
    rows = [
        (entry["kind"], f"{entry['MB']:.1f}", entry["used"][:16], entry["what"])
        for entry in record["entries"]
    ]
    total = sum(entry["MB"] for entry in record["entries"])
    lines = [f"{record['folder']}: {len(rows)} entries, {total:.0f} MB"]
    if record["removed"]:
        freed = sum(entry["MB"] for entry in record["removed"])
        lines.append(f"{len(record['removed'])} removed, {freed:.0f} MB")
    if rows:
        lines.append(table(rows, ("kind", "MB", "last used", "what")))
    return "\n".join(lines)
