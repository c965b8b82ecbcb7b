"""The table of targets: a line each."""

from allanite.core.errors import UsageError

from .target import Target
from .targets.ardupilot import ARDUPILOT
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
from .targets.px4 import PX4
from .targets.ros import ROBOT_LOCALIZATION, ROS_IMU
from .targets.statespace import STATESPACE
from .targets.vins import VINS_FUSION, VINS_MONO

EXPORTS: dict[str, Target] = {
    "kalibr": KALIBR,
    "openvins": OPENVINS,
    "orb-slam3": ORB_SLAM3,
    "vins-mono": VINS_MONO,
    "vins-fusion": VINS_FUSION,
    "lio-sam": LIO_SAM,
    "gtsam": GTSAM,
    "ros-imu": ROS_IMU,
    "robot-localization": ROBOT_LOCALIZATION,
    "px4": PX4,
    "ardupilot": ARDUPILOT,
    "matlab": MATLAB,
    "gnss-ins-sim": GNSS_INS_SIM,
    "gazebo": GAZEBO,
    "gazebo-classic": GAZEBO_CLASSIC,
    "pegasus": PEGASUS,
    "kf-gins": KF_GINS,
    "psins": PSINS,
    "navego": NAVEGO,
    "statespace": STATESPACE,
    "datasheet": DATASHEET,
}
"""Targets of `allanite.export` by name."""


def target_named(name: str) -> Target:
    """The row of a target; upper case and underscores do not matter.

    Raises
    ------
    UsageError
        There is no such target; the message lists the known ones.

    Examples
    --------
    >>> target_named("LIO_SAM").name
    'lio-sam'
    """
    known = str(name).lower().replace("_", "-")
    if known not in EXPORTS:
        raise UsageError(f"unknown target {name!r}; targets: {', '.join(EXPORTS)}")
    return EXPORTS[known]
