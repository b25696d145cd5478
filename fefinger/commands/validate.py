"""`fefinger validate`: compare fefinger with theory and published numbers."""

from pathlib import Path
from typing import Any

import click

from fefinger.commands import console
from fefinger.commands.options import DONE, FAILED, json_option, output_option, silent
from fefinger.support.checks import InputError


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

    from fefinger.support import outputs

    if not name.strip() or Path(name).name != name:
        message = f"--name: expected a base name of files, such as validation, received {name!r}"
        raise InputError(message)
    written: list[str] = []
    with outputs.output(output) as folder:
        with console.progress() as report:
            outcomes = available.run(suites, quick=quick, progress=report or silent)
        record = available.as_json(outcomes)
        try:
            if folder is not None:
                words = ["fefinger validate", *suites, *["--quick"] * quick]
                written = _save(record, folder, name, " ".join(words), quick=quick)
        finally:  # print the outcome also where saving it fails
            lines = [console.validation_summary(record), *written]
            console.print_answer(record, "\n".join(lines), as_json=as_json)
    verdicts = {case["verdict"] for suite in record["suites"] for case in suite["cases"]}
    return FAILED if "fail" in verdicts else DONE


def _save(
    record: dict[str, Any], folder: Path, name: str, command: str, *, quick: bool
) -> list[str]:
    """Write the record, its page and an existing index; return a line of output per file."""
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
    return [f"file  {file}" for file in files]
