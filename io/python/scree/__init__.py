"""Runs of scree as arrays.

>>> import scree
>>> run = scree.Run("runs/planar_shear")
>>> run.series["shear_stress"], run.units["shear_stress"]     # a column, and "Pa"
>>> frame = run.frames.at(0.12)                               # the frame nearest to 0.12 s
>>> frame.grains["stress"]                                    # xx, yy, xy of each grain, Pa
>>> scree.coarse_grain(frame, width=3e-3)["density"]          # a field on a lattice, kg/m3
>>> scree.Sweep("runs/planar_shear_sweep").table              # a line for each run of a sweep
>>> run = scree.run("jobs/quickstart.toml", {"seed": 2}, out="runs/second")

Everything is in SI units as the files are; nothing here computes what the program does.
"""

from scree.checkpoints import Checkpoint
from scree.ensembles import Ensemble, mean_curve
from scree.fields import Fields, coarse_grain, write_images
from scree.frames import Frame, Frames
from scree.program import Failed, run
from scree.quantities import deviatoric_stress, fabric, pressure, void_ratio
from scree.runs import Run
from scree.sweeps import Sweep
from scree.units import unit_of

__all__ = [
    "Checkpoint",
    "Ensemble",
    "Failed",
    "Fields",
    "Frame",
    "Frames",
    "Run",
    "Sweep",
    "coarse_grain",
    "deviatoric_stress",
    "fabric",
    "mean_curve",
    "pressure",
    "run",
    "unit_of",
    "void_ratio",
    "write_images",
]
