"""ASAM's checker of OpenSCENARIO XML."""

from asking_asam import answer_by
from qc_openscenario import constants, main

answer_by(constants, main.run_checks)
