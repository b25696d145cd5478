"""`fefinger validate` and `fefinger bench`: comparison with theory and numbers, and speed."""

from pathlib import Path

import click

from fefinger.commands import console
from fefinger.commands.console import DONE, FAILED, Record, json_option, output_option, silent
from fefinger.support.checks import InputError
from fefinger.support.text import table, unit_suffix


@click.command()
@click.argument("suites", nargs=-1)
@click.option(
    "--quick",
    is_flag=True,
    help="Leave out cases that take more than a few seconds, and the figures.",
)
@output_option("validation.json and validation.html")
@click.option("--name", default="validation", metavar="NAME", help="Base name of these files.")
@json_option
def validate(
    suites: tuple[str, ...],
    quick: bool,
    output: str | None,
    name: str,
    as_json: bool,
) -> int:
    """Compare fefinger with theory and published numbers.

    Runs the SUITES named, or all of the package. One of your own is the name of a module with a
    function cases(quick), in this folder or on the path of Python; its code is run. If DIR has an
    index.html of validations, it is updated.
    """
    from fefinger.validation import suites as available

    from fefinger.support import atomic_write

    if not name.strip() or Path(name).name != name:
        message = f"--name: expected a base name of files, such as validation, received {name!r}"
        raise InputError(message)
    with atomic_write.output(output) as folder:
        if folder is not None:
            atomic_write.output_file(folder / f"{name}.html", "--name")
        with console.progress() as report:
            outcomes = available.run(suites, quick=quick, progress=report or silent)
        record = available.as_json(outcomes)
        command = " ".join(["fefinger validate", *suites, *["--quick"] * quick])
        console.save_and_print(
            lambda: [] if folder is None else _save(record, folder, name, command, quick=quick),
            lambda files: {**record, "files": files},
            lambda record: console.with_files(validation_summary(record), record),
            as_json=as_json,
        )
    verdicts = {case["verdict"] for suite in record["suites"] for case in suite["cases"]}
    return FAILED if "fail" in verdicts else DONE


def _save(
    record: dict[str, object], folder: Path, name: str, command: str, *, quick: bool
) -> list[str]:
    """Write the record, its page and an existing index; return the paths."""
    from fefinger.validation import index as pages
    from fefinger.validation import page, suites
    from fefinger.validation.provenance import provenance

    pictures = {} if quick else suites.figures(record)
    findings = suites.subjects(record) if quick else suites.findings(record)
    made = provenance(command)
    page.save(record, folder, pictures, made, name, findings)
    files = [folder / f"{name}.json", folder / f"{name}.html"]
    if (folder / "index.html").exists():
        files.append(pages.write(folder))
    return list(map(str, files))


@click.command()
@click.argument("suites", nargs=-1)
@output_option("bench-SUITE.json")
@json_option
def bench(suites: tuple[str, ...], output: str | None, as_json: bool) -> None:
    """Measure speed and accuracy.

    Runs all suites, or the SUITES named, each against a baseline in the same run.
    """
    from fefinger.validation.bench import suites as benchmarks

    from fefinger.support.atomic_write import output_folder

    folder = None if output is None else output_folder(output)
    with console.progress() as report:
        measured = benchmarks.run(suites, progress=report or silent)
    if folder is not None:
        for suite, figures in measured.items():
            benchmarks.write(suite, figures, folder)
    record = benchmarks.as_json(figure for figures in measured.values() for figure in figures)
    console.print_answer(record, bench_summary(record), as_json=as_json)


def validation_summary(record: Record) -> str:
    """Return a table of the cases of validation suites, and the count of each verdict."""
    rows = [
        (
            suite["suite"],
            case["name"],
            "none" if case["failure"] else f"{case['value']:.6g}",
            f"{case['expected']:.6g} +- {case['tolerance']:.3g} {unit_suffix(case['unit'])}",
            " ".join(filter(None, (case["verdict"], case["failure"]))),
        )
        for suite in record["suites"]
        for case in suite["cases"]
    ]
    verdicts = [case["verdict"] for suite in record["suites"] for case in suite["cases"]]
    counts = ((verdicts.count(name), meaning) for name, meaning in VERDICTS.items())
    total = ", ".join(f"{count} {meaning}" for count, meaning in counts if count)
    return f"{table(rows, ('suite', 'case', 'value', 'expected', 'verdict'))}\n{total}"


VERDICTS = {
    "pass": "pass",
    "documented": "documented (the published number is wrong, for a documented reason)",
    "short": "short (within its known error, but not within the wanted one)",
    "fail": "FAIL",
}
"""Verdicts of cases, with their meanings."""


def bench_summary(record: Record) -> str:
    """Return a table of the figures of a benchmark."""
    rows = []
    for figure in record["figures"]:
        beside = ((figure["baseline"], ".4g"), (figure["ratio"], ".3g"))
        texts = ("" if value is None else f"{value:{digits}}" for value, digits in beside)
        rows.append((figure["name"], f"{figure['value']:.4g} {figure['unit']}", *texts))
    return table(rows, ("figure", "value", "baseline", "ratio"))
