"""`fefinger validate`: compare with theory and published numbers."""

import click

from fefinger import console
from fefinger.commands.options import DONE, FAILED, json_option, output_option, silent


@click.command()
@click.argument("suites", nargs=-1)
@click.option("--quick", is_flag=True, help="Leave out what takes longer than seconds.")
@output_option("validation.json and validation.html")
@click.option("--name", default="validation", metavar="NAME", help="Name of these files instead.")
@json_option
def validate(
    suites: tuple[str, ...], quick: bool, output: str | None, name: str, as_json: bool
) -> int:
    """Compare with theory and published numbers.

    Runs all suites, or the SUITES named. An index.html in the folder is brought up to date.
    """
    from fefinger.files import output_folder
    from fefinger.validation import suites as every

    folder = None if output is None else output_folder(output)
    with console.progress() as report:
        record = every.as_json(every.run(suites, quick=quick, progress=report or silent))
    if folder is not None:
        from fefinger import validation_report
        from fefinger.validation import index
        from fefinger.validation.provenance import provenance

        names = [suite["suite"] for suite in record["suites"]]
        pictures, findings = every.figures(names), every.findings(names)
        words = ["fefinger validate", *suites, *(["--quick"] if quick else [])]
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
