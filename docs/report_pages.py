"""Pages of the reports beside the documentation, opened by links to `../reports/NAME.html`."""

import shutil
from pathlib import Path

from docutils import nodes
from sphinx.addnodes import download_reference


REPORTS = Path(__file__).parent.parent / "reports"


def link(app, document):
    """Make links to pages of reports open them, where MyST would offer a download."""
    for node in list(document.findall(download_reference)):
        folder, _, name = node["reftarget"].rpartition("/")
        if folder.endswith("reports") and name.endswith(".html"):
            node.replace_self(nodes.reference("", "", *node.children, refuri=f"reports/{name}"))


def copy(app, exception):
    """Copy the reports: pages, and the data that they link to."""
    if exception is None and app.builder.format == "html":
        unwanted = shutil.ignore_patterns("*.py", "__pycache__")
        place = Path(app.outdir, "reports")
        shutil.copytree(REPORTS, place, ignore=unwanted, dirs_exist_ok=True)
