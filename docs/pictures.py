"""Pictures of the gallery that pyplot does not know: the figures of `fefinger.view`, and films."""

from pathlib import Path
from shutil import copyfile

from sphinx_gallery.scrapers import figure_rst


def shown_figures(block, block_vars, gallery_conf):
    """Save every new figure and GIF among the variables of an example; return them as RST."""
    from matplotlib.figure import Figure

    saved = block_vars.setdefault("saved", [])
    files = []
    for value in block_vars["example_globals"].values():
        if isinstance(value, Figure) and value not in saved:
            saved.append(value)
            if value.canvas.manager is None:  # pyplot's have a manager, and are saved by others
                files.append(next(block_vars["image_path_iterator"]))
                value.savefig(files[-1], dpi=100)
        if isinstance(value, Path) and value.suffix == ".gif" and value not in saved:
            saved.append(value)
            files.append(str(Path(next(block_vars["image_path_iterator"])).with_suffix(".gif")))
            copyfile(value, files[-1])
    return figure_rst(files, gallery_conf["src_dir"])
