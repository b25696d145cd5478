"""Films from pictures: GIF with Pillow, MP4 with the extra `film` (imageio-ffmpeg)."""

from collections.abc import Iterable
from contextlib import closing
from itertools import chain
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError


Picture = NDArray[np.uint8]


def check(path: str | PathLike[str], option: str) -> None:
    """Raise InputError of `option` unless a film can be written to `path`, a GIF or MP4 file."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".gif", ".mp4"):
        raise InputError(
            f"{option}: expected a file that ends in .gif or .mp4, received {Path(path).name!r}"
        )
    if suffix == ".mp4":
        try:
            from imageio_ffmpeg import get_ffmpeg_exe

            get_ffmpeg_exe()
        except (ImportError, RuntimeError):
            raise InputError(
                f"{option}: an MP4 needs imageio-ffmpeg, which is not there; "
                "run `pip install 'fefinger[film]'`, or name a file that ends in .gif"
            ) from None


def write(path: str | PathLike[str], pictures: Iterable[Picture], fps: float) -> None:
    """Write pictures (height, width, 3) to a GIF or MP4 file, which appears when it is complete."""
    check(path, "film")
    with moved(Path(path)) as new:
        (_gif if new.suffix.lower() == ".gif" else _mp4)(new, pictures, fps)


def _gif(path: Path, pictures: Iterable[Picture], fps: float) -> None:
    """Write a GIF with one palette for all pictures, so that colors do not change in time."""
    from PIL import Image

    every = [Image.fromarray(picture) for picture in pictures]
    some = Image.fromarray(np.concatenate([np.asarray(p)[::2, ::2] for p in every[::4]]))
    # MAXCOVERAGE keeps rare colors, such as the ends of the color bars.
    palette = some.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1)
    # Dithered: 256 colors for three color maps and their shades would show as bands.
    first, *others = [p.quantize(palette=palette) for p in every]
    duration = round(1000 / fps)
    first.save(path, save_all=True, append_images=others, duration=duration, loop=0)


def _mp4(path: Path, pictures: Iterable[Picture], fps: float) -> None:
    """Write an MP4 (H.264) that browsers play; its sides are cut to even numbers of pixels."""
    from imageio_ffmpeg import write_frames

    rest = iter(pictures)
    first = next(rest)
    height, width = (2 * (side // 2) for side in first.shape[:2])
    with closing(write_frames(str(path), (width, height), fps=fps, macro_block_size=2)) as writer:
        writer.send(None)
        for picture in chain([first], rest):
            writer.send(np.ascontiguousarray(picture[:height, :width]))
