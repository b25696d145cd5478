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
    """Copy the pages of the reports."""
    if exception is None and app.builder.format == "html":
        place = Path(app.outdir, "reports")
        place.mkdir(exist_ok=True)
        for page in REPORTS.glob("*.html"):
            shutil.copy(page, place)
