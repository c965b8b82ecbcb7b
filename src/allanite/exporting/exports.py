"""The table of targets: a line each."""

from allanite.core.names import row_alike
from allanite.plugins import Registry

from .target import Target
from .targets.ardupilot import ARDUPILOT, ARDUPILOT_TCAL
from .targets.datasheet import DATASHEET
from .targets.gazebo import GAZEBO, GAZEBO_CLASSIC
from .targets.gnss_ins_sim import GNSS_INS_SIM
from .targets.gtsam import GTSAM
from .targets.kalibr import KALIBR
from .targets.kf_gins import KF_GINS
from .targets.lio_sam import LIO_SAM
from .targets.matlab import MATLAB
from .targets.navego import NAVEGO
from .targets.openvins import OPENVINS
from .targets.orb_slam3 import ORB_SLAM3
from .targets.pegasus import PEGASUS
from .targets.psins import PSINS
from .targets.px4 import PX4, PX4_TC
from .targets.ros import ROBOT_LOCALIZATION, ROS_IMU
from .targets.statespace import STATESPACE
from .targets.vins import VINS_FUSION, VINS_MONO

_OWN = (
    KALIBR,
    OPENVINS,
    ORB_SLAM3,
    VINS_MONO,
    VINS_FUSION,
    LIO_SAM,
    GTSAM,
    ROS_IMU,
    ROBOT_LOCALIZATION,
    PX4,
    ARDUPILOT,
    MATLAB,
    GNSS_INS_SIM,
    GAZEBO,
    GAZEBO_CLASSIC,
    PEGASUS,
    KF_GINS,
    PSINS,
    NAVEGO,
    STATESPACE,
    DATASHEET,
)

EXPORTS = Registry({row.name: row for row in _OWN}, "allanite.targets", kind=Target, key="name")
"""Targets of `allanite.export` by name."""

TEMPERATURE = {"px4": PX4_TC, "ardupilot": ARDUPILOT_TCAL}
"""Autopilots that take temperature polynomials, of `allanite.temperature_parameters`."""


def target_named(name: str) -> Target:
    """The row of a target; upper case and underscores do not matter.

    Examples
    --------
    >>> target_named("LIO_SAM").name
    'lio-sam'
    """
    return row_alike("target", name, EXPORTS)


def row_of_file(name: str) -> Target:
    """The row of a file that was written: of a target, or of the temperature parameters of an autopilot."""
    return next((row for row in TEMPERATURE.values() if row.name == name), None) or target_named(name)
