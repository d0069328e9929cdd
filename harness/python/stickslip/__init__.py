"""Stick-slip of a friction-driven beam: its FMU against measurements, and the physical effect that
the model lacks.

    import stickslip

    campaign = stickslip.Campaign("reference-data/demo")
    diagnosis = stickslip.diagnose(campaign, progress=True)
    print(diagnosis)

The functions are the commands of `stickslip`; results are objects with `to_pandas()`, `plot()` and
a display in notebooks. `stickslip.dask` runs them on a cluster.
"""

from stickslip._words import FMU
from stickslip.blind import BlindTest, blind_test
from stickslip.campaign import Campaign, Run
from stickslip.catalogue import Effect, Effects, Parameter, effects
from stickslip.comparison import Comparison, RunComparison, compare
from stickslip.diagnosis import Diagnosis, Estimate, FoundEffect, diagnose, try_effects
from stickslip.dimension import CorrelationDimension, correlation_dimension
from stickslip.errors import BadInput, FmuFailed, GateFailed, NotWritten, StickslipError, Stopped
from stickslip.observation import Observation, observe
from stickslip.quality import Quality, check
from stickslip.simulation import Simulation, simulate
from stickslip.study import Study, StudyOptions, sweep

__all__ = [
    "FMU",
    "BadInput",
    "BlindTest",
    "Campaign",
    "Comparison",
    "CorrelationDimension",
    "Diagnosis",
    "Effect",
    "Effects",
    "Estimate",
    "FmuFailed",
    "FoundEffect",
    "GateFailed",
    "NotWritten",
    "Observation",
    "Parameter",
    "Quality",
    "Run",
    "RunComparison",
    "Simulation",
    "StickslipError",
    "Stopped",
    "Study",
    "StudyOptions",
    "blind_test",
    "check",
    "compare",
    "correlation_dimension",
    "diagnose",
    "effects",
    "observe",
    "simulate",
    "sweep",
    "try_effects",
]
