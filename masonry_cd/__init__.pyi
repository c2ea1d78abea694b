# SPDX-License-Identifier: GPL-3.0-or-later
from masonry_cd.foundation.errors import InputError as InputError
from masonry_cd.foundation.plugins import plugins as plugins
from masonry_cd.foundation.trust import trust as trust
from masonry_cd.interface.assessing import Assessment as Assessment
from masonry_cd.interface.assessing import assess as assess
from masonry_cd.interface.calibrating import Calibration as Calibration
from masonry_cd.interface.calibrating import calibrate as calibrate
from masonry_cd.interface.comparison import Comparison as Comparison
from masonry_cd.interface.comparison import compare as compare
from masonry_cd.interface.compas import from_compas as from_compas
from masonry_cd.interface.compas_dem import from_compas_dem as from_compas_dem
from masonry_cd.interface.compas_dem import to_compas_dem as to_compas_dem
from masonry_cd.interface.hazard import Hazard as Hazard
from masonry_cd.interface.joint_law import JointLaw as JointLaw
from masonry_cd.interface.limit import LimitAnalysis as LimitAnalysis
from masonry_cd.interface.limit import limit_analysis as limit_analysis
from masonry_cd.interface.limit import macro_elements as macro_elements
from masonry_cd.interface.modal import modal as modal
from masonry_cd.interface.own_forces import Force as Force
from masonry_cd.interface.own_motions import Motion as Motion
from masonry_cd.interface.results import Run as Run
from masonry_cd.interface.results import open_run as open
from masonry_cd.interface.returned import RunWarning as RunWarning
from masonry_cd.interface.risk import risk_sheet as risk_sheet
from masonry_cd.interface.running import resume as resume
from masonry_cd.interface.running import run as run
from masonry_cd.interface.scenes import Scene as Scene
from masonry_cd.interface.scenes import scene as scene
from masonry_cd.interface.selecting import select_records as select_records
from masonry_cd.interface.simulation import Simulation as Simulation
from masonry_cd.interface.site_spectrum import Spectrum as Spectrum
from masonry_cd.interface.strengthening import Strengthening as Strengthening
from masonry_cd.interface.strengthening import strengthen as strengthen
from masonry_cd.interface.structure import Structure as Structure
from masonry_cd.interface.studies import Study as Study
from masonry_cd.interface.studies import open_study as open_study
from masonry_cd.interface.studies import study as study
from masonry_cd.interface.traces import from_traces as from_traces
from masonry_cd.mechanics.model.blocks import Block as Block
from structures.geometry.prism import box as box

__version__: str
NAMES: dict[str, str]
__all__ = [
    "Assessment",
    "Block",
    "Calibration",
    "Comparison",
    "Force",
    "Hazard",
    "InputError",
    "JointLaw",
    "LimitAnalysis",
    "Motion",
    "Run",
    "RunWarning",
    "Scene",
    "Simulation",
    "Spectrum",
    "Strengthening",
    "Structure",
    "Study",
    "assess",
    "box",
    "calibrate",
    "compare",
    "from_compas",
    "from_compas_dem",
    "from_traces",
    "limit_analysis",
    "macro_elements",
    "modal",
    "open",
    "open_study",
    "plugins",
    "resume",
    "risk_sheet",
    "run",
    "scene",
    "select_records",
    "strengthen",
    "study",
    "to_compas_dem",
    "trust",
]
