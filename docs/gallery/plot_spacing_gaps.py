"""
How evenly the thesis' flows leave points
==========================================

The thesis' main difference between its two flows: the area flow draws points together and opens
holes, the perimeter flow keeps them apart. Gaps between neighbours along nine ellipses, before and
after 100 iterations. `pcsmooth experiments spacing` does the same from the command line.
"""

from shipped import DATA
from showing import show

from pcsmooth_experiments.experiment import Inputs
from pcsmooth_experiments.plane import spacing_gaps

outcome = spacing_gaps.EXPERIMENT.run(Inputs(DATA / "report"))
show(outcome.draw())
