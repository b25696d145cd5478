"""Pictures of the gallery that are not of pyplot: the figures of `fefinger.view`."""

from sphinx_gallery.scrapers import figure_rst


def shown_figures(block, block_vars, gallery_conf):
    """Save every new `fefinger` figure in the variables of an example; return it as RST."""
    from matplotlib import pyplot as plt
    from matplotlib.figure import Figure

    known = block_vars.setdefault("shown", set())
    paths = block_vars["image_path_iterator"]
    of_pyplot = {id(plt.figure(number)) for number in plt.get_fignums()}
    files = []
    for value in block_vars["example_globals"].values():
        if isinstance(value, Figure) and id(value) not in known | of_pyplot:
            known.add(id(value))
            if value.number if hasattr(value, "number") else False:
                continue
            file = next(paths)
            value.savefig(file, dpi=100, bbox_inches="tight")
            files.append(file)
    return figure_rst(files, gallery_conf["src_dir"])
