"""Pages that are made from the code and from the reports: keys, commands, verdicts, front.

They are written to `docs/generated/` at the start of every build.
"""

import inspect
import json
import re
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import click


REPORTS = Path(__file__).parent.parent / "reports"
BAR = r"\|"
MARKDOWN_COLUMNS = 4
WITHIN = "95 % of them within"
QUANTITIES = {
    "force": "force",
    "pressure": "highest pressure",
    "area": "contact area",
    "strain": "strain",
}


def write(docs):
    """Write the generated pages below the folder of the documentation."""
    from fefinger.scene.schema import schema

    check_api(docs)

    pages = {"keys": keys(schema()), "commands": commands(), "verdicts": verdicts()}
    pages |= {"front": front(), "kept": kept(), "steps": steps(), "extras": extras()}
    pages |= {"scenes": scenes(), "stated": stated(), "columns": columns()}
    place = docs / "generated"
    place.mkdir(exist_ok=True)
    for name, lines in pages.items():
        text = "\n".join(lines) + "\n"
        if not (place / f"{name}.md").exists() or (place / f"{name}.md").read_text() != text:
            (place / f"{name}.md").write_text(text, encoding="utf-8")
    static = docs / "_static"
    static.mkdir(exist_ok=True)
    (static / "scene.schema.json").write_text(json.dumps(schema(), indent=1) + "\n")


def notebook(app, exception):
    """Offer the tutorial as a Jupyter notebook beside its page."""
    import nbformat
    from myst_nb.core.read import read_myst_markdown_notebook

    if exception is None and app.builder.format == "html":
        text = Path(app.srcdir, "tutorial.md").read_text(encoding="utf-8")
        book = read_myst_markdown_notebook(text, add_source_map=False)
        nbformat.write(book, Path(app.outdir, "tutorial.ipynb"))


def table(heading, rows) -> Iterator[str]:
    """Give the lines of a table: in Markdown, or in HTML where it is too wide for a phone.

    There every row of a wide table is a block, each of its cells after the name of its column.
    """
    if len(heading) > MARKDOWN_COLUMNS:
        yield from wide_table(heading, rows)
        return
    yield ""
    yield f"| {' | '.join(heading)} |"
    yield f"|{' --- |' * len(heading)}"
    for row in rows:
        yield f"| {' | '.join(str(cell).replace('|', BAR) for cell in row)} |"
    yield ""


def wide_table(heading, rows) -> Iterator[str]:
    """Give the lines of a table in HTML, whose cells know the names of their columns."""
    yield '\n<div class="table-wrapper"><table class="docutils wide"><thead><tr>'
    yield from (f"<th>{name}</th>" for name in heading)
    yield "</tr></thead><tbody>"
    for row in rows:
        yield "<tr>"
        for name, cell in zip(heading, row, strict=True):
            yield f'<td data-column="{name}"><span>{in_html(cell)}</span></td>'
        yield "</tr>"
    yield "</tbody></table></div>\n"


def in_html(cell):
    """Return a cell of a table with the marks of Markdown as those of HTML."""
    text = re.sub(r"`(.+?)`", r'<code class="docutils literal">\1</code>', str(cell))
    return re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", text)


# Keys of a scene


def keys(schema) -> Iterator[str]:
    """Give the keys of every table of a scene, from its JSON Schema."""
    parts = schema["properties"]
    yield "## The file itself"
    yield from rows({"name": parts["name"]})
    yield "## `[finger]`"
    finger = parts["finger"]["properties"]
    yield from rows(finger)
    layers = finger["skin"]["properties"]
    yield "### `[finger.skin]` and `[finger.subcutaneous]`"
    yield from rows(layers)
    yield "### `[finger.bone]` and `[finger.nail]`"
    yield from rows(finger["bone"]["anyOf"][1]["properties"])
    yield "### `prony`"
    yield "Of the finger or of a layer: `prony = {c = [0.3, 0.5, 0.2], v = [200, 10]}`."
    yield from rows(finger["prony"]["properties"])
    yield "## `[indenter]`"
    yield from forms(parts["indenter"])
    yield "## `[motion]`"
    yield from forms(parts["motion"])
    yield "## `[ask]`"
    ask = parts["ask"]["properties"]
    yield from rows({name: key for name, key in ask.items() if name != "population"})
    yield "## `[ask.population]`"
    yield from forms(ask["population"])


def forms(part) -> Iterator[str]:
    """Give a section on each kind of a table."""
    yield f"{part['description']}."
    for form in part["oneOf"]:
        yield ""
        from_file = " from a file" if "file" in form["properties"] else ""
        yield f'### `kind = "{form["title"]}"`{from_file}'
        yield "" if from_file else form["description"]
        named = {name: key for name, key in form["properties"].items() if name != "kind"}
        yield from rows(named, form.get("required", ()))


def rows(table_keys, required=()) -> Iterator[str]:
    """Give the table of some keys."""
    yield from table(
        ("key", "value", "default", "meaning"),
        (
            (f"`{name}`", value(key), default(name, key, required), key["description"])
            for name, key in table_keys.items()
        ),
    )


def default(name, key, required):
    """Return the default of a key in Markdown."""
    if name in required:
        return "needed"
    return f"`{json.dumps(key['default'])}`" if "default" in key else ""


def value(key):
    """Describe the values that a key takes."""
    if "enum" in key:
        return ", ".join(f'`"{word}"`' for word in key["enum"])
    if "anyOf" in key:
        return " or ".join(value(form) for form in key["anyOf"])
    if key["type"] == "array":
        count = f"{key['minItems']} " if "minItems" in key else ""
        return f"list of {count}{plural(key['items'])}"
    if key["type"] == "object":
        return "table"
    limits = {
        "exclusiveMinimum": "> {:g}",
        "minimum": "≥ {:g}",
        "exclusiveMaximum": "< {:g}",
        "maximum": "≤ {:g}",
    }
    words = {"number": "number", "integer": "whole number", "string": "text"}
    words["boolean"] = "true or false"
    bounds = ", ".join(text.format(key[name]) for name, text in limits.items() if name in key)
    return " ".join(filter(None, (words[key["type"]], bounds)))


def plural(items):
    """Return the items of a list in words."""
    if "enum" in items:
        return value(items)
    words = {"number": "numbers", "string": "texts", "integer": "whole numbers"}
    return words.get(items.get("type"), "lists of numbers")


# Commands


def commands() -> Iterator[str]:
    """Give a section on each command, from its help."""
    from fefinger.commands.cli import cli

    for name, command in cli.commands.items():
        context = click.Context(command, info_name=f"fefinger {name}", show_default=True)
        yield f"## `fefinger {name}`"
        yield ""
        text = inspect.cleandoc((command.help or "").replace("\b", ""))
        yield from _quoted(text).splitlines()
        yield ""
        yield f"```text\n{' '.join(command.get_usage(context).split()[1:])}\n```"
        records = [option.get_help_record(context) for option in command.params]
        options = [(f"`{record[0]}`", record[1]) for record in records if record and record[1]]
        yield from table(("option", "meaning"), options)


def _quoted(text: str) -> str:
    """Return a help text with its options in backticks, where they are not in backticks already."""
    pattern = r"`[^`]*`|(?<!\S)(--?[a-z]\w*)"
    return re.sub(pattern, lambda found: f"`{found[1]}`" if found[1] else found[0], text)


# Reports


def verdicts() -> Iterator[str]:
    """Give the counts of verdicts of every suite that has a report."""
    from fefinger.validation import suites
    from fefinger.validation.page import VERDICTS

    counted, missing = [], []
    for name, about in suites.ABOUT.items():
        record, found = judged(name)
        if not found:
            missing.append(f"`{name}`")
            continue
        page = f'<a href="reports/{name}.html">{name}</a>'
        made = record.get("provenance", {}).get("date", "")[:10]
        made = made.replace("-", "\N{NON-BREAKING HYPHEN}")
        counts = [found.count(verdict) for verdict in VERDICTS]
        counted.append((page, about, len(found), *counts, made))
    total = [sum(row[column] for row in counted) for column in range(2, 3 + len(VERDICTS))]
    heading = ("suite", "what it compares", "cases", *VERDICTS, "measured")
    yield from table(heading, [*counted, ("**all**", "", *total, "")])
    if missing:
        yield f"Without verdicts in the reports: {', '.join(missing)}."


def judged(suite):
    """Return the report of a suite and the verdicts of its cases, none where it holds none."""
    path = REPORTS / f"{suite}.json"
    record = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    cases = (each["cases"] for each in record.get("suites", ()) if each["suite"] == suite)
    return record, [case["verdict"] for group in cases for case in group]


def held_out():
    """Return the report of the held-out scenes."""
    return json.loads((REPORTS / "held-out.json").read_text(encoding="utf-8"))


def measured():
    """Return times in s and errors of every candidate by its name."""
    found, report = {}, held_out()
    for scene, taken in report["taken"].items():  # others were not timed
        for name, each in report["errors"][scene].items():
            found.setdefault(name, []).append((taken[name], each))
    return found


def front() -> Iterator[str]:
    """Give medians of time and of true errors of every candidate."""
    rows = []
    for name, each in measured().items():
        errors = [
            [errors[quantity] for _, errors in each if quantity in errors]
            for quantity in QUANTITIES
        ]
        seconds = median(seconds for seconds, _ in each)
        rows.append((seconds, name, len(each), [percent(median(x)) if x else "-" for x in errors]))
    yield from table(
        ("mechanics and mesh", "scenes", "CPU time of a first answer / s", *QUANTITIES.values()),
        ((name, count, f"{seconds:.2g}", *errors) for seconds, name, count, errors in sorted(rows)),
    )
    yield "Scenes are drawn at random from all kinds of objects, fingers and motions."


def kept() -> Iterator[str]:
    """Give how often stated errors held, and how large they were, on both sets of scenes."""
    report, rows = held_out(), []
    for whose, each in (("held out", report["summary"]), ("development", report["development"])):
        held, over = each["stated_kept_by_all_candidates"], each["stated_over_actual"]
        rows += [
            (
                f"{each['scenes']} {whose}",
                QUANTITIES.get(name, name),
                percent(share),
                f"{over[name]:.1f}",
            )
            for name, share in held.items()
        ]
    yield from table(
        ("scenes", "quantity", "stated errors that held", "median stated / actual"), rows
    )
    for whose, each in (("held-out scenes", report["summary"]), ("scenes", report["development"])):
        yield (
            f"Of the {each['scenes']} {whose} {each['answered']} were answered. "
            f"{percent(each['within_1.2'])} of the choices took at most 1.2 times the time of the "
            f"cheapest candidate that would have done, all together "
            f"{each['total_seconds_over_least']:.1f} times the least; "
            f"{percent(each['tolerance_met'])} met the tolerance."
        )


def percent(share):
    """Return a share in percent, which no line breaks apart."""
    value = float(f"{100 * share:.2g}") if share < 0.995 else round(100 * share)
    return f"{value:g}\N{NO-BREAK SPACE}%"


STEPS = {
    "`pressed`": ("pressed", "a step with 1000 end organs, {}", "99 % of them within"),
    "`condensed`": ("condensed", "strains in double precision: step, {}, wall", "99th percentile"),
    "`condensed`, a plate that rolls, half a finger": (
        *("condensed", "a plate that turns, half a finger, 1000 end organs: step, {}, processor"),
        "99th percentile",
    ),
    "`condensed`, sliding": (
        "sliding",
        "step: standard, plate, 292 vertices in contact, {}",
        WITHIN,
    ),
    "`condensed`, with friction": (
        *("sliding", "step: standard, plate with friction, 282 vertices in contact, {}", WITHIN),
    ),
    "`condensed`, with friction, coarse mesh": (
        *("sliding", "step: coarse, plate with friction, 71 vertices in contact, {}", WITHIN),
    ),
    "`modal`, a step within": (
        *("modal", "step of 0.2 ms, 81 modes, 335 contact nodes, 1000 end organs: {}", "99 %"),
    ),
}
"""Where the time of a step of each finger in a loop is reported: suite of the benchmark, name of
its figure, and how the name of the longest steps differs from that of the median."""


def steps() -> Iterator[str]:
    """Give the measured time of a step of every finger in a loop."""
    rows = []
    for finger, (suite, name, longest) in STEPS.items():
        record = json.loads((REPORTS / f"bench-{suite}.json").read_text(encoding="utf-8"))
        values = {each["name"]: each["value"] for each in record["figures"]}
        share = 0.95 if longest == WITHIN else 0.99
        times = values[name.format("median")], values[name.format(longest)]
        rows.append((finger, f"{times[0]:.2g} ms", f"{times[1]:.2g} ms ({percent(share)})"))
    yield from table(("finger on the standard mesh", "median step", "most steps within"), rows)


def stated() -> Iterator[str]:
    """Give the errors that the planner states of the standard scene."""
    import fefinger as ff

    yield f"The scene `flat-press`, for example, is answered by {ff.explain('flat-press').on}."
    yield ff.explain("flat-press").trust


# Names


def scenes() -> Iterator[str]:
    """Give the built-in scenes with the first sentence of each."""
    from fefinger.scene import builtin

    rows = ((f"`{name}`", builtin.summary(name)) for name in builtin.names())
    yield from table(("scene", "what it is"), rows)


def columns() -> Iterator[str]:
    """Give the columns of a study's table with units and meanings."""
    from fefinger.scene.schema import split
    from fefinger.studies.grid import MEANINGS, meaning

    rows = ((f"`{name}`", split(name)[1] or "-", meaning(name)) for name in MEANINGS)
    yield from table(("column", "unit", "what it holds"), rows)


BRINGS = {
    "live": "a finger to press in the browser (`fefinger live`)",
    "film": "`fefinger view --movie press.mp4`",
    "distributed": "studies on a Dask cluster (`fefinger study --scheduler`)",
    "neo": "spike trains as Neo segments (`result.spikes.to_neo()`)",
    "mujoco": "a tactile finger in a MuJoCo model (`ff.mujoco.couple`)",
    "nwb": "spike trains as NWB files (`result.spikes.to_nwb()`)",
    "parquet": "tables of studies as Parquet files",
    "docs": "this documentation, built on your machine",
    "test": "the tests",
    "ci": "tests in random order, and sdist",
    "lint": "linter and type checker, in the versions that are used here",
}
"""What each optional extra is for."""


def extras() -> Iterator[str]:
    """Give the optional extras of pyproject.toml and what they bring."""
    import tomllib

    project = tomllib.loads((REPORTS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    yield from table(
        ("extra", "what it brings"),
        ((f"`{name}`", BRINGS[name]) for name in project["project"]["optional-dependencies"]),
    )


def check_api(docs):
    """Raise ValueError for a public name that the page of the API does not list, or a wrong one."""
    import re

    import fefinger
    from fefinger import mujoco, neural, shapes

    text = (docs / "api.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^   ([A-Za-z][\w.]+)$", text, re.M))
    parts = {"mujoco": mujoco, "neural": neural, "shapes": shapes}
    public = {f"{part}.{name}" for part, module in parts.items() for name in module.__all__}
    public |= set(fefinger.__all__)
    if differing := listed ^ public:
        message = f"docs/api.md: expected every public name and no other, see {sorted(differing)}"
        raise ValueError(message)
