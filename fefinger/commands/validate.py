"""`fefinger validate`: compare with theory and published numbers."""

import click

from fefinger import console
from fefinger.commands.options import DONE, FAILED, json_option, output_option, silent


@click.command()
@click.argument("suites", nargs=-1)
@click.option("--quick", is_flag=True, help="Leave out what takes longer than seconds.")
@click.option("--all", "every", is_flag=True, help="Run the long suites too.")
@output_option("validation.json and validation.html")
@click.option("--name", default="validation", metavar="NAME", help="Name of these files instead.")
@json_option
def validate(
    suites: tuple[str, ...],
    quick: bool,
    every: bool,
    output: str | None,
    name: str,
    as_json: bool,
) -> int:
    """Compare with theory and published numbers.

    Runs the SUITES named, or all but the long ones (--all: those too; --quick: all, in seconds).
    An index.html in the folder is brought up to date.
    """
    from fefinger.files import output_folder
    from fefinger.validation import suites as known

    folder = None if output is None else output_folder(output)
    for suite in known.left_out(suites, quick=quick, every=every):
        said = f"{suite} is left out, because it takes {known.LONG[suite]}"
        click.echo(f"{said}: name it, or give --all.", err=True)
    with console.progress() as report:
        outcomes = known.run(suites, quick=quick, every=every, progress=report or silent)
    record = known.as_json(outcomes)
    if folder is not None:
        from fefinger import validation_report
        from fefinger.validation import index
        from fefinger.validation.provenance import provenance

        pictures, findings = known.figures(record), known.findings(record)
        options = {"--quick": quick, "--all": every}
        words = ["fefinger validate", *suites, *(key for key, given in options.items() if given)]
        made = provenance(" ".join(words))
        validation_report.save(record, folder, pictures, made, name, findings)
        if (folder / "index.html").exists():
            index.write(folder)
    if as_json:
        console.print_json(record)
    else:
        click.echo(console.validation_summary(record))
    verdicts = {case["verdict"] for suite in record["suites"] for case in suite["cases"]}
    return FAILED if "fail" in verdicts else DONE
