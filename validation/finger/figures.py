"""Figures of suite `finger`: effects that Hertz neglects, by subject and by cause."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.finger.split import (
    AT,
    apart,
    factors,
    force,
    other_order,
    part,
    printed,
    row,
    steepness,
    subjects,
    texts,
    together,
    unexplained,
)
from fefinger.validation.panels import panels
from fefinger.validation.problems.chain import CHAIN, PRESSES, SUBJECTS, models

from fefinger.view.figures import INK, STEEL, WIDE, figure


COLORS = {
    "hertz": STEEL,
    "bone": "#E69F00",
    "layered": "#009E73",
    "level": "#56B4E9",
    "linear": "#0072B2",
    "solid": "#D55E00",
}
SUBJECT_COLORS = ("#0072B2", "#D55E00", "#009E73", "#AA4499")
LEGEND = {
    "hertz": "half-space (Hertz)",
    "bone": "+ bone",
    "layered": "+ layers",
    "level": "+ shape",
    "linear": "+ angle",
    "solid": "+ finite strain",
}
NAMES = {
    "flat-30": "plate at 30 degrees",
    "sphere-5": "ball of 5 mm",
    "sphere-2": "ball of 2 mm",
}
ORDER = "; then ".join(CHAIN.values())

RATES = (
    "Stiffening under the plate: m of the spring (b / m) (exp(m x) - 1) through the forces at "
    "the deepest press and at half its depth, model after model, and m of the thesis (line: "
    "Table 2.1; dashed: Table 3.2). The step to the finger is shape and angle together; "
    "the last is tissue that itself stiffens, by Demiray's law with the exponent 3. Only an "
    "exponential has one m: that of the others falls with depth."
)


def finding() -> dict[str, Any]:
    """Return the sentences of the finding, and the table of factors."""
    table = {"caption": _table_caption(), "heading": ["factor of", *SUBJECTS], "rows": _table()}
    return {"texts": texts(), "tables": [table]}


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: force ratios, factors, stiffening."""
    yield _over("flat-30"), _ratios("flat-30")
    yield _over("sphere-5"), _ratios("sphere-5")
    yield _split(), _factors()
    yield RATES, _rates()


def _over(press: str) -> str:
    caption = (
        f"Ratio of the force to that of Hertz under a {NAMES[press]}, against the ratio of depth "
        "to the thickness of the finger. Each model adds one effect to the one before."
    )
    if press == "flat-30":
        return f"{caption} A plate along the bone reaches the proximal cut at small depths."
    return (
        f"{caption} A ball has no angle: the effect of shape is the whole step from the flat "
        "layers to the finger."
    )


def _ratios(press: str) -> Any:
    drawn, axes = panels(WIDE, 2.9, 1, len(subjects(press)), sharey=True)
    for axis, subject in zip(axes, subjects(press), strict=True):
        below = force(subject, press, "hertz")
        for model in models(press):
            ratio = force(subject, press, model) / below
            axis.plot(part(subject, press), ratio, color=COLORS[model], label=_label(press, model))
        axis.set(yscale="log", title=subject, xlabel="depth / thickness")
        axis.set_yticks([0.5, 1, 2, 3, 4, 6], labels=["0.5", "1", "2", "3", "4", "6"], minor=False)
        axis.minorticks_off()
    axes[0].set_ylabel("force / Hertz")
    drawn.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=6)
    return drawn


def _label(press: str, model: str) -> str:
    if model == "linear" and press != "flat-30":
        return "+ shape"
    return LEGEND[model]


def _split() -> str:
    return (
        "Factor of the force that each cause adds to the model before it, at a depth of a tenth of "
        f"the thickness (0.6 mm under the ball of 2 mm). The order of the split: {ORDER}. "
        f"{_meshes()}, from which the coarse one differs by {100 * apart():.1f} % at most where "
        "both were solved. Where the factor of shape or angle is missing, a plate "
        "along the bone reaches the cut of the finger before that depth."
    )


def _meshes() -> str:
    """Sentence on the mesh of each row."""
    coarse = [
        f"{subject} under the {NAMES[press]}"
        for press in PRESSES
        for subject in subjects(press)
        if row(subject, press)["resolution"] != "standard"
    ]
    but = f", but {', '.join(coarse)} on the coarse one" if coarse else ""
    return f"On the standard mesh{but}"


def _factors() -> Any:
    presses = tuple(PRESSES)
    drawn = figure(WIDE, 3.0)
    axes = drawn.subplots(1, len(presses), sharey=True, squeeze=False)[0]
    for axis, press in zip(axes, presses, strict=True):
        causes = models(press)[1:]
        for number, subject in enumerate(SUBJECTS):
            by_cause = factors(subject, press)
            place = np.arange(len(causes)) + 0.2 * (number - 1.5)
            height = np.array([by_cause[cause] for cause in causes])
            axis.bar(place, height - 1, 0.18, bottom=1, color=SUBJECT_COLORS[number], label=subject)
        names = [_label(press, cause).removeprefix("+ ") for cause in causes]
        axis.set_xticks(range(len(causes)), names, rotation=30, ha="right")
        axis.axhline(1, color=INK, lw=0.8)
        axis.set(yscale="log", title=NAMES[press])
        axis.set_yticks([0.4, 0.6, 0.8, 1, 1.5, 2, 3, 4], labels="0.4 0.6 0.8 1 1.5 2 3 4".split())
        axis.minorticks_off()
    axes[0].set_ylabel("factor of the force")
    axes[-1].legend()
    return drawn


def _table_caption() -> str:
    swapped = [other_order(subject, "flat-30") for subject in SUBJECTS]
    low, high = (f(each["layered"] for each in swapped) for f in (min, max))
    mine = [factors(subject, "flat-30")["layered"] for subject in SUBJECTS]
    more = unexplained("a.h.", "flat-30", "solid")
    return (
        "Factor of the force that each cause adds to the model before it, at a tenth of the "
        "thickness (0.6 mm under the ball of 2 mm), and their product: finite strain on the finger "
        "over Hertz. The split depends on its order: put on the finger instead of on the flat "
        f"stack, the layers are a factor of {low:.2f} to {high:.2f} under the plate, not "
        f"{min(mine):.2f} to {max(mine):.2f}. All forces are of relaxed tissue. With one "
        "G small strain keeps these ratios at any pace; at finite strain, where the stress of the "
        "deformed tissue relaxes, a ramp at 60 mm/s to a fifth of the thickness of a.h. takes "
        f"{more:.3f} times the integral of G over the relaxed force."
    )


def _table() -> list[list[str]]:
    cells = []
    for press in PRESSES:
        cells.append([NAMES[press]])
        split = {subject: factors(subject, press) for subject in SUBJECTS}
        for cause in models(press)[1:]:
            values = [split[subject][cause] for subject in SUBJECTS]
            cells.append([_label(press, cause), *(_two(value) for value in values)])
        if press == "flat-30":
            both = [together(subject) for subject in SUBJECTS]
            cells.append(["shape and angle together", *(_two(value) for value in both)])
        ends = [
            force(subject, press, "solid")[AT[press] - 1]
            / force(subject, press, "hertz")[AT[press] - 1]
            for subject in SUBJECTS
        ]
        cells.append(["product", *(_two(value) for value in ends)])
    return cells


def _two(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.2f}"


def _rates() -> Any:
    chain = [model for model in models("flat-30") if model != "level"]
    drawn, axes = panels(WIDE, 2.7, 1, len(SUBJECTS), sharey=True)
    for axis, subject in zip(axes, SUBJECTS, strict=True):
        rates = [steepness(subject, model) for model in chain]
        rates.append(steepness(subject, "solid", "demiray"))
        colors = [*(COLORS[model] for model in chain), "#AA4499"]
        bottoms = [0.0, *rates[:-1]]
        for place, (color, low, high) in enumerate(zip(colors, bottoms, rates, strict=True)):
            axis.bar(place, high - low, 0.8, bottom=low, color=color)
            box = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.5}
            top = (place, max(low, high) + 0.06)
            axis.annotate(f"{high:.2f}", top, ha="center", va="bottom", fontsize=8, bbox=box)
        for value, line in zip(printed(subject), ("-", "--"), strict=True):
            axis.axhline(value, color=INK, lw=1, ls=line)
        names = ["Hertz", "bone", "layers", "shape, angle", "finite strain", "tissue"]
        axis.set_xticks(range(len(names)), names, rotation=40, ha="right")
        axis.set(title=subject, ylim=(0, 3.4))
    axes[0].set_ylabel("m / 1/mm")
    return drawn
