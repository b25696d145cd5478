"""Suite `fem`: the finite elements and their contact against exact solutions.

Everything is solved by the code that answers scenes (`fefinger.fem`), on meshes that are made here.
"""

from fefinger.validation.case import joined
from fefinger.validation.fem import drawings, elements, exact, hertz, history, solid


cases = joined(hertz, elements, exact, history, solid)
finding = drawings.finding
figures = drawings.figures
