"""clastic: simulation of cemented granular materials.

===========================  =================================================================
``run``, ``resume``          a scene into a directory of results, as the program does
``check``                    the mistakes of a scene
``Simulation``               a scene that Python steps and changes
``open``                     the results of a run as tables and arrays
``figures``                  figures for papers
``emission``                 acoustic emission: exponents, b-values, Kaiser effect
``loops``                    modulus and damping of cyclic tests, loop by loop
``sweep``, ``envelope``      many runs, one table
``calibrate``                parameters of grains and bonds from targets of the specimen
``stability``                the factor at which a slope slides, beside the bound of limit analysis
===========================  =================================================================

Units are SI; compression, contraction and anticlockwise rotation are positive.
"""

from . import emission, figures
from ._engine import __version__
from .calibration import Calibration, calibrate
from .errors import RunError, RunWarning, SceneError
from .frame import STATES, Fabric, Frame
from .log_spiral import LogSpiral, critical_factor, log_spiral
from .loops import loops
from .results import Run, open
from .run import check, resume, run
from .simulation import Simulation, State
from .stability import Stability, stability
from .studies import Envelope, Study, envelope, sweep
from .targets import Curve, Parameter, Target, cohesion, friction_angle, hoek_brown_m

__all__ = [
    "STATES",
    "Calibration",
    "Curve",
    "Envelope",
    "Fabric",
    "Frame",
    "LogSpiral",
    "Parameter",
    "Run",
    "RunError",
    "RunWarning",
    "SceneError",
    "Simulation",
    "Stability",
    "State",
    "Study",
    "Target",
    "__version__",
    "calibrate",
    "check",
    "cohesion",
    "critical_factor",
    "emission",
    "envelope",
    "figures",
    "friction_angle",
    "hoek_brown_m",
    "log_spiral",
    "loops",
    "open",
    "resume",
    "run",
    "stability",
    "sweep",
]
