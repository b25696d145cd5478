"""What is chosen by name, of the package and of its users: indenters, laws, afferents, mechanics.

A thing of a user's own gets into its registry in one of three ways: `register(thing)`; a module
that a scene names as a plugin, or the variable FEFINGER_PLUGINS of the environment; an entry point
of an installed distribution, in a group such as "fefinger.laws". Those of the package are imported
at first use.
"""

import importlib
import inspect
import os
import re
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from fefinger.support.checks import ConvergenceError, InputError, choice, shown


Thing = TypeVar("Thing")

PLUGINS = "FEFINGER_PLUGINS"
"""Variable of the environment with names of modules to load, separated as those of PATH."""

UNKNOWN = (
    "One of your own is known when its module is loaded: import it, or name it in `plugins` of the "
    f"scene or in the variable {PLUGINS} of the environment"
)
"""Advice on a name that is like no other."""

NAME = re.compile("[a-z][a-z0-9]*(-[a-z0-9]+)*")
"""Names that fit into a scene file, a command line and a table."""


class Registry(Mapping[str, Thing], Generic[Thing]):
    """Things of one kind by name: the package's first, then the user's own.

    what: the kind in messages, also of the entry points ("fefinger.laws" of "law"); mark: the
    attribute that such a thing has, and no other; shipped: "module" or "module:attribute" by name;
    key: the attribute that is its name; classes: whether the things are classes. Otherwise a class
    that is added is made into an instance, without arguments.
    """

    def __init__(
        self,
        what: str,
        mark: str,
        shipped: Mapping[str, str],
        *,
        plural: str | None = None,
        key: str = "name",
        classes: bool = False,
    ) -> None:
        self.what, self.mark, self.key, self.classes = what, mark, key, classes
        self.group = f"fefinger.{plural or what + 's'}"
        self._places = {name: EntryPoint(name, at, self.group) for name, at in shipped.items()}
        self._things: dict[str, Thing] = {}
        self.shipped = tuple(shipped)

    def __getitem__(self, name: str) -> Thing:
        if name not in self._things:
            self._things[name] = self._loaded(self._known()[name])
        return self._things[name]

    def __contains__(self, name: object) -> bool:
        return name in self._known() or name in self._things

    def __iter__(self) -> Iterator[str]:
        return iter({**self._known(), **self._things})

    def __len__(self) -> int:
        return len({**self._known(), **self._things})

    def named(self, field: str, name: object) -> Thing:
        """Return the thing of a name, or raise InputError with the nearest one."""
        return self[self.chosen(field, name)]

    def chosen(self, field: str, name: object) -> str:
        """Return the name if it is known, or raise InputError with the nearest one."""
        try:
            return choice(field, name, self)
        except InputError as error:
            if "Did you mean" in str(error):
                raise
            raise InputError(f"{error} {UNKNOWN}") from None

    def takes(self, thing: object) -> bool:
        """Return whether a thing is of this kind."""
        if isinstance(thing, type) and inspect.isabstract(thing):
            return False
        return hasattr(thing, self.mark) and (isinstance(thing, type) or not self.classes)

    def add(self, thing: object) -> None:
        """Register a thing under its name; InputError for a name that is invalid, or taken.

        A new definition of the same class or function, as by a cell of a notebook that is run
        again, takes the place of the old one.
        """
        made = thing() if isinstance(thing, type) and not self.classes else thing
        name = getattr(made, self.key, None)
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise InputError(
                f"{self.what}.{self.key}: expected lower case and digits, with hyphens between "
                f"words, such as 'my-own', received {name!r}"
            )
        there = self._things.get(name)
        again = there is not None and self.origin(there) == self.origin(made)
        if name in self and (name in self.shipped or not again):
            owner = "the package" if name in self.shipped else "another one that is registered"
            raise InputError(
                f"{self.what}.{self.key}: {name!r} is the name of {owner}; expected another name"
            )
        self._things[name] = cast(Thing, made)

    def origin(self, thing: object) -> tuple[str, str]:
        """Return the module and the name of the class or function that defines a thing."""
        definition = thing if isinstance(thing, type) else getattr(thing, self.mark)
        return getattr(definition, "__module__", ""), getattr(definition, "__qualname__", "")

    def guarded(self, name: str) -> AbstractContextManager[None]:
        """Turn what fails in a thing of a user's own into an InputError; see `own`."""
        return own(f"{self.what} {name!r}", self.origin(self[name])[0])

    def modules(self) -> set[str]:
        """Return the names of the modules that define what users have registered."""
        own = [thing for name, thing in self._things.items() if name not in self._places]
        return {self.origin(thing)[0] for thing in own}

    def _known(self) -> dict[str, EntryPoint]:
        """Return where things are imported from; loads the plugins of the environment."""
        load_of_environment()
        return self._installed

    @cached_property
    def _installed(self) -> dict[str, EntryPoint]:
        """Where things are imported from; InputError for a name that is taken."""
        for each in entry_points(group=self.group):
            if each.name in self._places:
                owner = each.dist.name if each.dist else each.value
                raise InputError(
                    f"{self.group}: {each.name!r} is an entry point of {owner}, but the name is "
                    "taken; uninstall it, or give it another name"
                )
            self._places[each.name] = each
        return self._places

    def _loaded(self, place: EntryPoint) -> Thing:
        """Import a thing; InputError where that fails or it is not of this kind."""
        if place.name in self.shipped:
            return cast(Thing, place.load())
        with own(f"{self.group}: {place.value}", place.module):
            thing = place.load()
        if not self.takes(thing):
            raise InputError(
                f"{self.group}: expected {place.value} to have {self.mark!r}, as a {self.what} "
                f"does, received {thing!r}"
            )
        return thing() if isinstance(thing, type) and not self.classes else thing


INDENTERS: Registry[Any] = Registry(
    "indenter",
    "profile",
    {
        "flat": "fefinger.scene.indenters:Flat",
        "sphere": "fefinger.scene.indenters:Sphere",
        "ellipsoid": "fefinger.scene.indenters:Ellipsoid",
        "cylinder": "fefinger.scene.indenters:Cylinder",
        "bar": "fefinger.scene.indenters:Bar",
        "pin": "fefinger.scene.indenters:Pin",
        "grating": "fefinger.scene.textured:Grating",
        "relief": "fefinger.scene.textured:Relief",
        "dots": "fefinger.scene.textured:Dots",
        "braille": "fefinger.scene.texts:Braille",
        "letters": "fefinger.scene.texts:Letters",
        "fabric": "fefinger.scene.fabric:Fabric",
    },
    key="kind",
    classes=True,
)
"""Classes of objects, `fefinger.Indenter`."""

LAWS: Registry[Any] = Registry(
    "law",
    "density",
    {
        "neo-hookean": "fefinger.laws:NEO_HOOKEAN",
        "mooney-rivlin": "fefinger.laws:MOONEY_RIVLIN",
        "demiray": "fefinger.laws:DEMIRAY",
        "veronda-westmann": "fefinger.laws:VERONDA_WESTMANN",
    },
)
"""Hyperelastic laws, `fefinger.Law`."""

LADDER = ("lumped", "hertz", "layered", "condensed", "pressed", "modal", "linear", "solid")
"""Modules of the contact models of the package, cheapest first."""

MECHANICS: Registry[Any] = Registry(
    "mechanics",
    "respond",
    {name: f"fefinger.mechanics.{name}" for name in LADDER},
    plural="mechanics",
)
"""Contact models, `fefinger.Mechanics`."""

AFFERENTS: Registry[Any] = Registry(
    "family",
    "simulate",
    {
        "recorded": "fefinger.neural.family:RECORDED",
        "thesis": "fefinger.neural.family:THESIS",
    },
    plural="afferents",
)
"""Families of afferents, `fefinger.Family`: `recorded`, the default, fitted to recorded responses,
`thesis`, the chain of Pawluk (1997), and those of users."""

REGISTRIES = (INDENTERS, LAWS, MECHANICS, AFFERENTS)


def register(thing: Thing) -> Thing:
    """Make an indenter, a law, a family of afferents or a mechanics of your own known by its name.

    Also a decorator of its class. From then on a scene can choose it by name, and lists, messages
    and the planner know it, in this process and in those that it starts, which import the module
    that defines it.

    Raises
    ------
    InputError
        A thing of no kind, or a name that is invalid or taken.
    """
    registry = next((each for each in REGISTRIES if each.takes(thing)), None)
    if registry is None:
        marks = ", ".join(f"{each.what} (with {each.mark!r})" for each in REGISTRIES)
        raise InputError(f"register: expected one of {marks}, received {thing!r}")
    registry.add(thing)
    return thing


def load_plugin(name: str, folder: Path | None = None) -> None:
    """Import a module beside a scene file, in `folder`, or on the path, and register all in it.

    Only what the module itself defines is registered. Its code is run.

    Raises InputError for no such module, one whose code fails, another module of this name, or a
    name that is taken.
    """
    if not isinstance(name, str) or not all(part.isidentifier() for part in name.split(".")):
        raise InputError(f"plugins: expected names of Python modules, received {shown(name)}")
    with own(f"plugins: {shown(name)}", name):
        _check_beside(name, folder)
        try:
            module = importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
            beside = "" if folder is None else f" in {str(folder.resolve())!r}, or"
            raise InputError(
                f"plugins: expected a module{beside} on the path of Python, received {shown(name)}"
            ) from None
        for thing in list(vars(module).values()):
            for registry in REGISTRIES:
                if registry.takes(thing) and registry.origin(thing)[0] == module.__name__:
                    registry.add(thing)


def _check_beside(name: str, folder: Path | None) -> None:
    """Put the folder of a plugin beside a scene on the path; InputError for another module."""
    if folder is None or not (file := folder.resolve() / f"{name}.py").is_file():
        return
    loaded = getattr(sys.modules.get(name), "__file__", None)
    if name in sys.modules and (loaded is None or Path(loaded).resolve() != file):
        raise InputError(
            f"plugins: {name!r} is {file}, but also the loaded module {loaded or 'of Python'}; "
            "rename the file"
        )
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))


@contextmanager
def own(who: str, module: str) -> Iterator[None]:
    """Turn what fails in a user's own code into an InputError with its name, and the line.

    who: the thing in the message; module: the one that defines it. Interrupts, a lack of memory,
    errors in a sentence, and errors of the package's own things go on.
    """
    try:
        yield
    except (KeyboardInterrupt, MemoryError, InputError, ConvergenceError):
        raise
    except BaseException as error:  # also SystemExit of a script that was meant to be run
        if module.startswith("fefinger."):
            raise
        steps = traceback.walk_tb(error.__traceback__)
        lines = [line for frame, line in steps if frame.f_globals.get("__name__") == module]
        where = f" (line {lines[-1]} of {module})" if lines else ""
        (what,) = traceback.format_exception_only(error)[-1:]
        raise InputError(f"{who} failed with {what.strip()}{where}") from error


def load_of_environment() -> None:
    """Load the plugins that the environment names, once each."""
    for name in os.environ.get(PLUGINS, "").split(os.pathsep):
        if name and name not in _LOADED:
            _LOADED.add(name)
            load_plugin(name)


_LOADED: set[str] = set()


def modules() -> set[str]:
    """Return the modules that define what users have registered, but for a script or notebook."""
    own: set[str] = set().union(*(each.modules() for each in REGISTRIES))
    return own - {"__main__"}


def hyphenated(name: str) -> str:
    """Return the `kind` for the name of a class or function: KeyEdge is "key-edge"."""
    words = re.findall("[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+", name)
    return "-".join(words).lower()
