"""One finger in a plotter: built once, then moved through time, with parts shown or hidden."""

import textwrap
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fefinger.neural.trains import FEW
from fefinger.support.arrays import Array
from fefinger.support.checks import choice
from fefinger.view import figures, frames, quantities, surfaces
from fefinger.view.drawing import Drawing, Marks, leader_order


if TYPE_CHECKING:
    from pyvista import DataSet, DataSetMapper, Plotter, PolyData


PARTS = ("skin", "subcutaneous tissue", "bone", "pressure", "end organs", "rates", "indenter")
"""Parts that can be shown or hidden; "rates" colors the end organs by the rates of their units."""

BEHIND, BELOW = (0.5, -1.0, -0.25), (0.75, -0.6, -0.75)  # the cut and the pad are seen from there
CLEAR = 0.05  # mm between finger and indenter, else surfaces that touch flicker
RADIUS, CROWDED = 0.11, 0.1  # mm of marks of end organs, which are 0.2 mm apart in depth
WORDS = (0.015, 0.985)  # upper left corner of the text above a finger, as parts of its view
LETTER = 9.0  # pixels of a letter of this text, on average
LENGTH = 5.0  # mm of the scale line
LIT: dict[str, Any] = {"ambient": 0.68, "diffuse": 0.38}
WRITTEN: dict[str, Any] = {
    **{"font_size": 16, "text_color": figures.INK, "bold": False, "shape": None},
    **{"show_points": False, "always_visible": True, "justification_vertical": "center"},
}
"""Look of labels at points."""


class Prop(NamedTuple):
    """A VTK actor: visible if the parts that it `needs` are shown, and `without` is not."""

    actor: Any
    needs: tuple[str, ...]
    without: str | None = None


class Scales(NamedTuple):
    """Ends of the color bars: colors of the field, highest pressure in kPa, highest rate in Hz."""

    field: quantities.Span
    pressure: float
    rate: float


class FingerActor:
    """A finger in the active view of a plotter, which `at` and `show` change.

    `keys`: by the title of each color bar, the field first, its mapper and the parts that it needs.
    """

    def __init__(self, plotter: "Plotter", shown: Drawing, field: str, scales: Scales) -> None:
        self.plotter, self.shown, self.field, self.scales = plotter, shown, field, scales
        self.where = tuple(plotter.renderers.index_to_loc(plotter.renderers.active_index))
        self.props: list[Prop] = []
        self.moves: list[Callable[[int], None]] = []
        self.keys: dict[str, tuple[Any, tuple[str, ...]]] = {}
        self.hidden: set[str] = set()
        self.frame = 0
        for piece in shown.surfaces:
            self._add_surface(piece)
        if shown.lines is not None:
            self._add_lines(shown.lines)
        if shown.marks is not None:
            self._add_organs(shown.marks)
        self._add_indenter()
        self._add_length()
        self.refresh()

    def look(self) -> None:
        """Point the camera at the cut, or at the pad of a whole finger."""
        place, closer = (BELOW, 1.2) if self.shown.whole else (BEHIND, 1.35)
        self.plotter.view_vector(place, viewup=(0, 0, 1))  # type: ignore[arg-type]  # pyvista's decorator loses self
        width, height = self._size()
        # The finger fills a picture 1.35 times as wide as high.
        self.plotter.camera.zoom(closer * min(1.0, width / height / 1.35))

    def at(self, time: float) -> None:
        """Show the stored frame next to a time in s."""
        self.frame = frames.nearest_frame(self.shown.fields, time)
        for move in self.moves:
            move(self.frame)
        self._say()

    def show(self, part: str, on: bool) -> None:
        """Show or hide one of PARTS."""
        choice("part", part, PARTS)
        (self.hidden.discard if on else self.hidden.add)(part)
        self.refresh()

    def refresh(self) -> None:
        """Update which actors are visible, from the parts that are hidden."""
        for prop in self.props:
            covered = prop.without is not None and prop.without not in self.hidden
            prop.actor.SetVisibility(self.hidden.isdisjoint(prop.needs) and not covered)

    def remove(self) -> None:
        """Remove all actors from the plotter."""
        self.plotter.subplot(*self.where)
        for prop in self.props:
            self.plotter.remove_actor(prop.actor, render=False)

    @property
    def parts(self) -> list[str]:
        """Return the parts of this finger, in the order of PARTS."""
        present = {part for prop in self.props for part in prop.needs}
        return [part for part in PARTS if part in present]

    def words(self) -> str:
        """Return three lines: the title, the mechanics with the field, the time with the state."""
        result, now = self.shown.result, float(self.shown.fields.times[self.frame])
        state = [f"t = {now:.4g} s", f"depth {self._depth(now):.3g} mm"]
        if result.force is not None:
            state.append(f"force {np.interp(now, result.time, result.force):.3g} N")
        kind = f" ({quantities.measure(result)})" if quantities.unit(self.field) == "%" else ""
        state.append(self.scales.field.beyond(quantities.unit(self.field)))
        of = f"{result.plan.mechanics}: {self.field}{kind}"
        return f"{self.shown.title}\n{of}\n{',  '.join(filter(None, state))}"

    def _say(self) -> None:
        """Write `words` above the finger."""
        self.plotter.subplot(*self.where)
        letters = max(int((1 - 2 * WORDS[0]) * self._size()[0] / LETTER), 10)
        lines = [textwrap.fill(line, letters) for line in self.words().split("\n")]
        prop = self.plotter.add_text(
            "\n".join(lines), position=WORDS, font_size=9, color=figures.INK, viewport=True,
            name=f"words {self.where[1]}", render=False,
        ).prop  # fmt: skip
        prop.SetVerticalJustificationToTop()
        prop.SetLineSpacing(1.2)

    def _size(self) -> tuple[float, float]:
        """Return the width and height of this view in pixels."""
        left, low, right, high = self.plotter.renderer.GetViewport()
        width, height = self.plotter.window_size
        return (right - left) * width, (high - low) * height

    def _depth(self, time: float) -> float:
        return float(np.interp(time, self.shown.result.time, self.shown.result.depth))

    def _place(self, piece: surfaces.Piece, frame: int) -> Array:
        fields = self.shown.fields
        return piece.at(fields.points + fields.displacement[frame])

    def _add_surface(self, piece: surfaces.Piece) -> None:
        """Add a piece that moves with the finger: bone plain, other tissue colored by the field."""
        import pyvista as pv

        faces: Any = piece.triangles
        mesh = pv.PolyData.from_regular_faces(self._place(piece, 0), faces)

        def move(frame: int) -> None:
            mesh.points = self._place(piece, frame)
            mesh["field"] = piece.at(quantities.values(self.shown.result, self.field, frame))
            mesh["pressure"] = piece.at(self.shown.fields.pressure[frame])
            if piece.flat:
                return
            mesh.compute_normals(
                cell_normals=False, split_vertices=False, consistent_normals=False,
                auto_orient_normals=False, inplace=True,
            )  # fmt: skip

        move(0)
        self.moves.append(move)
        if piece.name not in surfaces.SOFT:
            how = {"lighting": False} if piece.flat else LIT
            actor = self.plotter.add_mesh(mesh, color=figures.BONE, **how)
            self.props.append(Prop(actor, (piece.name,)))
        elif piece.name == surfaces.PAD:
            self._add_colored(mesh, "field", ("skin",), "pressure")
            self._add_colored(mesh, "pressure", ("skin", "pressure"), flat=True)
        else:
            self._add_colored(mesh, "field", (piece.name,), flat=piece.flat)

    def _add_colored(
        self,
        mesh: "PolyData",
        name: str,
        needs: tuple[str, ...],
        without: str | None = None,
        *,
        flat: bool = False,
    ) -> None:
        """Add a surface colored by its scalars "field" or "pressure"; `flat`: without shades.

        It is visible as a Prop with `needs` and `without`.
        """
        span, title = self.scales.field, quantities.label(self.field)
        if name == "pressure":
            span = quantities.Span(0.0, self.scales.pressure, quantities.SKIN_DEEP, "neither")
            title = quantities.label("pressure")
        actor = self.plotter.add_mesh(
            mesh, scalars=name, cmap=span.map(), clim=span[:2], show_scalar_bar=False,
            **({"lighting": False} if flat else LIT),
        )  # fmt: skip
        actor.prop.interpolation = "Phong"
        self.props.append(Prop(actor, needs, without))
        self.keys.setdefault(title, (actor.mapper, needs if name == "pressure" else ()))

    def _add_lines(self, piece: surfaces.Piece) -> None:
        import pyvista as pv

        mesh = pv.PolyData(self._place(piece, 0), lines=np.insert(piece.triangles, 0, 2, axis=1))
        lift = np.array([0.0, -0.02, 0.0])  # mm off the cut, else surfaces hide parts of the lines

        def move(frame: int) -> None:
            mesh.points = self._place(piece, frame) + lift

        self.moves.append(move)
        actor = self.plotter.add_mesh(mesh, color="white", line_width=2, lighting=False)
        self.props.append(Prop(actor, ()))

    def _add_organs(self, shown: Marks) -> None:
        """Add a ball per end organ: colored by type, and by the rate where units fire."""
        import pyvista as pv

        fields, types, organs = self.shown.fields, shown.types, shown.followed
        radius = RADIUS if len(types) <= FEW else CROWDED
        fires = shown.trains is not None
        ball, rim = (
            pv.Sphere(radius=size * radius, theta_resolution=16, phi_resolution=16)
            for size in (1.0, 1.25)
        )
        marks = pv.PolyData(organs.moved(fields.displacement[0]))
        shades = [pv.Color(figures.COLORS.get(kind, figures.INK)).int_rgb for kind in types]
        marks["type"] = np.array(shades, np.uint8)
        balls, rims = pv.PolyData(), pv.PolyData()

        def move(frame: int) -> None:
            marks.points = organs.moved(fields.displacement[frame])
            if fires:
                marks["rate"] = shown.rates(float(fields.times[frame]))
            balls.copy_from(marks.glyph(geom=ball, scale=False, orient=False))
            rims.copy_from(marks.glyph(geom=rim, scale=False, orient=False))

        move(0)
        self.moves.append(move)
        # The far side of a larger white ball is seen as a rim, from everywhere.
        added = [
            self.plotter.add_mesh(rims, color="white", culling="front", lighting=False),
            self.plotter.add_mesh(balls, scalars="type", rgb=True),
        ]
        needs = ("end organs", "rates")
        self.props.append(Prop(added[0], needs[:1]))
        self.props.append(Prop(added[1], needs[:1], "rates" if fires else None))
        if fires:
            rated = self.plotter.add_mesh(
                balls, scalars="rate", cmap=quantities.RATES, clim=(0.0, self.scales.rate),
                show_scalar_bar=False, ambient=0.6, diffuse=0.4,
            )  # fmt: skip
            added.append(rated)
            self.props.append(Prop(rated, needs))
            self.keys["rate / Hz"] = rated.mapper, needs
        for actor in added:
            _bring_forward(actor.mapper)
        if len(types) <= FEW:
            self._add_labels(marks, shown.labels)

    def _add_labels(self, marks: "PolyData", labels: tuple[str, ...]) -> None:
        """Add the labels of a few end organs, in a column above the finger, with leader lines."""
        import pyvista as pv

        named = [i for i, label in enumerate(labels) if label]
        # In mm: distal of the marks, above the finger, and from line to line,
        aside, above, line = 2.0, 1.0, 1.1  # where the indenter never is
        distal = marks.points[:, 0].max() + aside
        level = self.shown.fields.points[:, 2].max() + above + line * np.arange(len(named))[::-1]
        column = np.column_stack([np.full(len(named), distal), np.zeros(len(named)), level])
        upright = leader_order(marks.points[named][:, [0, 2]], column[:, [0, 2]])
        order = [named[i] for i in upright]
        words = [f"  {labels[i]}" for i in order]
        pairs = np.arange(2 * len(words)).reshape(2, -1).T
        lines = pv.PolyData(
            np.concatenate([marks.points[order], column]), lines=np.insert(pairs, 0, 2, axis=1)
        )

        def move(frame: int) -> None:
            points = np.array(lines.points)
            points[: len(words)] = marks.points[order]
            lines.points = points

        self.moves.append(move)
        leaders = self.plotter.add_mesh(lines, color=figures.INK, line_width=1.5, lighting=False)
        _bring_forward(leaders.mapper)
        written = self.plotter.add_point_labels(column, words, margin=2, **WRITTEN)
        self.props += [Prop(actor, ("end organs",)) for actor in (leaders, written)]

    def _add_length(self) -> None:
        """Add a scale line of LENGTH mm below the finger, in the plane of the cut."""
        import pyvista as pv

        low, high = self.shown.fields.points.min(axis=0), self.shown.fields.points.max(axis=0)
        start = np.array([low[0] + 1.0, 0.0, low[2] - 0.12 * (high[2] - low[2])])
        end = start + np.array([LENGTH, 0.0, 0.0])
        line = self.plotter.add_mesh(
            pv.Line(start, end), lighting=False, color=figures.INK, line_width=3
        )
        words = [f"   {LENGTH:g} mm"]
        written = self.plotter.add_point_labels(end[None], words, margin=8, **WRITTEN)
        self.props += [Prop(actor, ()) for actor in (line, written)]

    def _add_indenter(self) -> None:
        """Add the indenter: transparent, or only the rim of a plate or ball before a whole pad."""
        result = self.shown.result
        touch, texture = frames.pose(result, 0.0), frames.texture(result)
        drawn = touch if texture is None else texture.first
        shape = _shape(drawn).translate(-CLEAR * touch.axis)
        if not self.shown.whole:
            shape = shape.clip("-y", origin=(0.0, 0.0, 0.0))
        added = []
        line: dict[str, Any] = {"color": "#51606e", "line_width": 2}
        if drawn.profile.plane:
            rim = shape.extract_surface(algorithm=None).extract_feature_edges(
                feature_edges=False, manifold_edges=False
            )
            added.append(self.plotter.add_mesh(rim, **line))
        elif self.shown.whole and drawn.profile.half_axes is not None:
            added.append(self.plotter.add_silhouette(shape, **line))
        if not (self.shown.whole and added):  # the colors behind it would change
            added.append(self.plotter.add_mesh(shape, color="#8fa3b5", opacity=0.15))
        self.props += [Prop(actor, ("indenter",)) for actor in added]

        def move(frame: int) -> None:
            time = float(self.shown.fields.times[frame])
            for actor in added:
                actor.position = tuple(self._depth(time) * touch.axis)
            if texture is not None:
                risen = texture.rise(time, shape.points + CLEAR * touch.axis)
                shape.points = shape.points + risen[:, None] * touch.axis

        self.moves.append(move)


def _bring_forward(mapper: "DataSetMapper") -> None:
    """Draw what a mapper draws in front of everything, so that end organs show through tissue."""
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0, -66000)
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -66000)


def _shape(pose: frames.Pose) -> "DataSet":
    """Return the surface of an indenter."""
    import pyvista as pv

    if pose.profile.plane:
        return pv.Plane(center=pose.origin, direction=pose.axis, i_size=14, j_size=14)
    half_axes = pose.profile.half_axes
    if half_axes is not None and np.isfinite(half_axes).all():
        shape = pv.ParametricEllipsoid(*half_axes, u_res=80, v_res=80)
        turn = np.eye(4)
        turn[:3, :3] = pose.frame.T
        turn[:3, 3] = pose.origin - half_axes[2] * pose.axis
        return shape.transform(turn, inplace=False)
    line = np.linspace(-7, 7, 281)
    across = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    height = pose.profile.height(across)[0]
    places = np.where((height < 4.0)[..., None], pose.places(across), np.nan)
    grid = pv.StructuredGrid(*(places[..., k] for k in range(3)))
    seen: Any = np.isfinite(grid.points).all(axis=1)
    return grid.extract_points(seen, adjacent_cells=False).extract_surface(algorithm=None)
