"""The fingertip: size, surfaces, tissues, relaxation and mesh resolution."""

import math
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from fefinger.scene import library
from fefinger.scene.key import Key, check
from fefinger.scene.tissue import Hard, Ridges, Tissue
from fefinger.support.checks import InputError, choice, number
from fefinger.support.inputs import check_input
from fefinger.support.units import FINGER, MESHED
from fefinger.theory.relaxation import Prony


RIGID = "rigid"
RESOLUTIONS = ("coarse", "standard", "fine")
LAYERS = ("skin", "subcutaneous")
AUTO = "auto"
STANDARD = "standard"
FILES = ("tissue", "surface", "bone_surface")
"""Fields that may name a file."""
FROM_TISSUE = ("pad_radius", *LAYERS, "prony")
"""Fields that every finger has, by default those of its tissue set."""
PULP = 0.5
"""Soft tissue under the pad over the thickness of the finger, about."""
BONE = 0.47
"""Soft tissue between first touch (30 degree plate) and bone, over the thickness of the finger."""

LENGTH = Key(unit="mm", above=0)
Length = Annotated[float, LENGTH]

_FROM_LIBRARY: Any = None


@dataclass(frozen=True)
class Finger:
    """The distal phalanx of a finger.

    Parameters
    ----------
    width
        Size of the fingertip in mm across, along y.
    thickness
        Size of the fingertip in mm from pad to nail, along z.
    pad_radius
        Effective radius R of the pad in mm, as in Table 3.2 of Pawluk (1997); by default as in
        the finger that the tissue was fitted to, in proportion to the width. The transverse radius
        follows from width and thickness.
    subject_name
        Subject of Pawluk (1997): sizes, and the tissue fitted to its measured curves; or None.
    surface
        File with the outer skin of the distal phalanx in mm (STL, OBJ, PLY, VTK), or None for the
        parametric shape. Width and thickness then scale the bone inside;
        `from_surface` takes them from the file.
    axes
        Of a surface: "shape" finds its axes from its shape and turns it, "file" keeps those of the
        file, x distal, y radial and z dorsal.
    bone_surface
        File with the surface of the bone, placed as in `surface`, or None for a parametric bone.
    tip_tissue
        Soft tissue in mm ahead of the parametric bone, along x from its end to the tip of the
        finger, as in a radiograph; by default that of the finger that the tissue was fitted to, in
        proportion to the thickness (6.2 mm for a.h.); with other tissue 0.42 of the thickness or
        more, as far as the pulp under the 30 degree plate stays 0.47 of it.
    tip_radius
        Radius in mm of the palmar profile at the tip of a parametric finger; by default that of the
        finger that the tissue was fitted to, in proportion to the thickness (2.5 mm for a.h.); with
        other tissue 0.2 of the thickness or more, as far as the tip lies 0.65 of it above the
        lowest point.
    tissue
        Name of the tissue set of the library, or a file (.toml) of `fefinger calibrate`, that gives
        the defaults of `skin` and `subcutaneous`; a set that was fitted to a finger also gives its
        pad radius, its tip and its relaxation. By default that of the subject, of other fingers
        that of the means of Table 2.1.
    skin, subcutaneous
        The skin, and the tissue between it and the bone; keys left out are those of the tissue set.
    prony
        Relaxation of all soft tissues; by default Table 3.1, of the subject or the means.
    relaxation
        Part of the stress that relaxes: "whole", or "deviatoric" alone (`solid` only).
    bone
        "rigid", or a Hard bone that is held at its cut ([finger.bone] modulus in kPa, 17e6 along
        the shaft of a long bone); `linear` and `solid` only.
    nail
        None: fixed with the bone, as glued in the experiment. "free": no nail, the skin under it is
        free. A Hard nail stiffens that skin ([finger.nail] modulus in kPa, some 2e6), which then
        floats on its bed; `linear` and `solid` only.
    cut
        Boundary condition of the proximal cut: "fixed", or "nail", where only nail and bone hold
        the finger.
    ridges
        None: a smooth pad. Fingerprint ridges, [finger.ridges], are of `layered` alone, where they
        are finer than any mesh.
    resolution
        Mesh: "coarse", "standard" or "fine"; "auto" lets the planner choose the coarsest one that
        is accurate enough, and is "standard" where nothing is planned.

    Raises
    ------
    InputError
        An invalid field; the message has its name in a scene file.
    """

    table: ClassVar[str] = "finger"

    width: Length
    thickness: Length
    _: KW_ONLY
    pad_radius: Length = _FROM_LIBRARY
    subject_name: Annotated[str | None, Key(words=library.subjects())] = None
    surface: str | None = None
    bone_surface: str | None = None
    tip_tissue: Annotated[float | None, LENGTH] = None
    tip_radius: Annotated[float | None, LENGTH] = None
    tissue: str = _FROM_LIBRARY
    skin: Tissue = _FROM_LIBRARY
    subcutaneous: Tissue = _FROM_LIBRARY
    prony: Prony = _FROM_LIBRARY
    relaxation: Annotated[str, Key(words=("whole", "deviatoric"))] = "whole"
    bone: Annotated[str | Hard, Key(words=(RIGID,))] = RIGID
    nail: Annotated[str | Hard | None, Key(words=("free",))] = None
    cut: Annotated[str, Key(words=("fixed", "nail"))] = "fixed"
    resolution: Annotated[str, Key(words=(AUTO, *RESOLUTIONS))] = AUTO
    ridges: Ridges | None = None
    axes: Annotated[str, Key(words=("shape", "file"), written=False)] = "shape"

    def __post_init__(self) -> None:
        """Fill in defaults of the library, then check every field."""
        name = self.subject_name or "means"
        if self.subject_name is not None:
            choice("finger.subject", self.subject_name, library.subjects())
        self._default("tissue", library.default_tissue(self.subject_name))
        # A finger that was saved has all values, and the file of its tissue may have moved since.
        whole = all(getattr(self, given) is not None for given in FROM_TISSUE)
        tissues = None if whole and library.gone(self.tissue) else library.tissue_set(self.tissue)
        for size in ("width", "thickness"):
            check(self, size)
            value = getattr(self, size)
            if not FINGER.low <= value <= FINGER.high:
                raise InputError(
                    f"finger.{size}: expected mm, {MESHED[0]:g} to {MESHED[1]:g} for a mesh, "
                    f"received {value:g}{FINGER.hint(value)}; a fingertip is some 15 mm wide and "
                    "12 mm thick"
                )
        if tissues is not None:
            self._fill(tissues, name)
        for name in ("surface", "bone_surface"):
            self._set_file(name)
        check(self)
        if self.bone_surface is not None and self.surface is None:
            msg = "finger.bone_surface: expected finger.surface beside it, received none"
            raise InputError(msg)
        if self.axes != "shape" and self.surface is None:
            msg = f"finger.axes: expected finger.surface beside {self.axes!r}, received none"
            raise InputError(msg)
        self._check_tip()
        self._check_layers()

    def _fill(self, tissues: library.TissueSet, row: str) -> None:
        """Fill in what a tissue set gives, or the row of the thesis's tables."""
        lengths = tissues.lengths(self.width, self.thickness)
        radius = lengths["pad_radius"] or library.quasistatic()[row].radius
        self._default("pad_radius", radius)
        self._default("skin", tissues.skin)
        self._default("subcutaneous", tissues.subcutaneous)
        self._default("prony", tissues.prony or library.relaxation()[row])
        if self.bone_surface is None:
            self._default("tip_tissue", lengths["tip_tissue"])
        if self.surface is None:
            self._default("tip_radius", lengths["tip_radius"])

    def _default(self, name: str, value: object) -> None:
        """Set a field that was left out."""
        if getattr(self, name) is None:
            object.__setattr__(self, name, value)

    def _set_file(self, name: str) -> None:
        """Check a surface file; its path becomes text, as in a scene file."""
        given: Any = getattr(self, name)
        if given is None:
            return
        check_input(f"finger.{name}", given, "a surface file")
        object.__setattr__(self, name, str(given))

    def _check_tip(self) -> None:
        """Check the tip: only a parametric bone has tissue ahead, a parametric skin a radius."""
        for name, file, says in (
            ("tip_tissue", "bone_surface", "where the bone ends"),
            ("tip_radius", "surface", "how round the tip is"),
        ):
            if getattr(self, name) is None:
                continue
            if getattr(self, file) is not None:
                raise InputError(
                    f"finger.{name}: expected none beside finger.{file}, which says {says}, "
                    f"received {getattr(self, name):g} mm; leave one of them out"
                )

    def _check_layers(self) -> None:
        """Check the tissues, the hard parts and the relaxation."""
        for name, part in (("bone", self.bone), ("nail", self.nail)):
            if isinstance(part, Hard) and part.modulus < self.skin.modulus:
                raise InputError(
                    f"finger.{name}.modulus: expected at least that of the skin, "
                    f"{self.skin.modulus:g} kPa, received {part.modulus:g} kPa; a GPa is 1e6 kPa"
                )
        skin = number("finger.skin.thickness", self.skin.thickness, above=0, unit="mm")
        if not skin < self.pulp:
            raise InputError(
                f"finger.skin.thickness: expected less than {self.pulp:g} mm, half of "
                f"finger.thickness, received {skin:g} mm; check whether the finger is in mm"
            )
        if self.subcutaneous.thickness is not None:
            raise InputError(
                f"finger.subcutaneous.thickness: expected none, because this tissue fills the rest "
                f"of the pulp, received {self.subcutaneous.thickness!r}; leave it out"
            )

    @property
    def mesh(self) -> str:
        """Resolution of the mesh; "standard" while the choice is left to the planner."""
        return STANDARD if self.resolution == AUTO else self.resolution

    @property
    def pulp(self) -> float:
        """Thickness of soft tissue under the pad in mm, about: 0.44 to 0.58 of the finger's."""
        return PULP * self.thickness

    @property
    def raised_ridges(self) -> Ridges | None:
        """Ridges of the skin that rise from the pad; None for a smooth one, as at a height of 0."""
        return self.ridges if self.ridges is not None and self.ridges.height > 0 else None

    @classmethod
    def from_surface(cls, file: str | Path, **overrides: Any) -> Self:
        """Return the finger with the shape of a closed surface file (STL, OBJ, PLY, VTK).

        The surface gives width and thickness (`read_surface`); `overrides` replace fields.
        """
        from fefinger.geometry.surface_file import read_surface

        axes = overrides.get("axes", "shape")
        choice("finger.axes", axes, ("shape", "file"))
        outline = read_surface(file, field="finger.surface", axes=axes)
        size = {"width": outline.width, "thickness": outline.thickness}
        return cls(**(size | overrides | {"surface": str(file)}))

    @classmethod
    def stored(cls, **values: Any) -> Self:
        """Return a finger with all values given, without reading the files that it names.

        A stored result is read this way: the files of tissue and surface may have moved since.
        """
        named = {name: values.pop(name) for name in FILES if name in values}
        # A set that gives no lengths: those that were left out stay so.
        finger = cls(tissue=library.PUBLISHED, **values)
        for name, value in named.items():
            object.__setattr__(finger, name, value)
        return finger

    @classmethod
    def subject(cls, name: str, **overrides: Any) -> Self:
        """Return the finger of a subject of Pawluk (1997): Tables 2.1 (w, t), 3.1 (G) and 3.2 (R).

        `overrides` replace single fields; f.c., who was not measured, needs width and thickness.
        """
        choice("finger.subject", name, library.subjects())
        row = library.lumped().get(name)
        size = {} if row is None else {"width": row.width, "thickness": row.thickness}
        values = size | overrides
        missing = [key for key in ("width", "thickness") if values.get(key) is None]
        if missing:
            raise InputError(
                f"finger.{missing[0]}: missing; expected a number in mm, because Pawluk (1997) "
                f"gives no size of subject {name!r}: give width and thickness"
            )
        return cls(**(values | {"subject_name": name}))


def origin_notes(finger: Finger) -> tuple[str, ...]:
    """Describe how a finger mixes sources: tissue fitted to another subject, or changed sizes."""
    if library.gone(finger.tissue):
        kept = f"The file of the tissue, {finger.tissue}, is gone; this scene has kept its values."
        return (kept, *_resized(finger))
    source = library.fitted_to(finger.tissue) or finger.subject_name
    tissues = library.tissue_set(finger.tissue)
    given = [layer for layer in LAYERS if getattr(finger, layer) != getattr(tissues, layer)]
    notes = []
    if source != finger.subject_name and len(given) < len(LAYERS):
        whose = f"subject {source}, another finger"
        if source == library.MEANS:
            whose = "the mean curves of the subjects, not to this finger"
        notes.append(f"The tissue was fitted to {whose} ({finger.tissue}).")
    if given:
        layers = " and ".join(f"finger.{layer}" for layer in given)
        notes.append(f"The tissue differs from {finger.tissue}: {layers} as given in the scene.")
    return (*notes, *_resized(finger))


def _resized(finger: Finger) -> tuple[str, ...]:
    """Note on sizes and relaxation that differ from the named subject's."""
    row = library.lumped().get(str(finger.subject_name))
    if row is None or finger.surface is not None:
        return ()
    size = {"width": finger.width, "thickness": finger.thickness}
    tissue = None if library.gone(finger.tissue) else finger.tissue
    measured = Finger.subject(str(finger.subject_name), tissue=tissue, **size)
    wanted = {"width": row.width, "thickness": row.thickness, "pad_radius": measured.pad_radius}
    changed = [
        f"{name} {getattr(finger, name):g} mm instead of {value:g} mm"
        for name, value in wanted.items()
        if getattr(finger, name) != value
    ]
    if finger.prony != measured.prony:
        changed.append("another relaxation")
    if finger.tip_tissue not in (None, measured.tip_tissue):
        changed.append(f"its bone ends {finger.tip_tissue:g} mm before the tip")
    if finger.tip_radius not in (None, measured.tip_radius):
        changed.append(f"its tip has a radius of {finger.tip_radius:g} mm")
    if not changed:
        return ()
    return (f"The finger differs from subject {finger.subject_name}: {', '.join(changed)}.",)


def other_size(finger: Finger) -> tuple[str, ...]:
    """Return the note where the file of the tissue has another width or thickness.

    None where the file is gone, as it may be of a result that was saved.
    """
    if not finger.tissue.endswith(library.TISSUE_FILE):
        return ()
    try:
        fitted = library.tissue_set(finger.tissue)
    except InputError:
        return ()
    sizes = ((fitted.width, finger.width), (fitted.thickness, finger.thickness))
    same = 1e-6  # relative difference of two sizes that is rounding
    if all(was is None or math.isclose(was, now, rel_tol=same) for was, now in sizes):
        return ()
    words = zip(sizes, ("wide", "thick"), strict=True)
    was = " and ".join(f"{each:g} mm {word}" for (each, _), word in words if each is not None)
    return (
        f"The tissue of {finger.tissue} was fitted to a finger of another size, {was}; this one is "
        f"{finger.width:g} mm wide and {finger.thickness:g} mm thick. For the fitted finger set "
        "finger.width and finger.thickness.",
    )
