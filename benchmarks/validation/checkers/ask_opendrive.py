"""ASAM's checker of OpenDRIVE."""

from asking_asam import answer_by
from qc_opendrive import constants, main

answer_by(constants, main.run_checks)
