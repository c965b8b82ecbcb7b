"""ROS: the covariances of sensor_msgs/Imu, which robot_localization reads."""

from dataclasses import replace

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import GYRO, Target, TargetField, pair
from allanite.phrases.phrase import say

VARIANCE = TargetField("", GYRO, "N", "(rad/s)^2", rate=1, power=2)

ROS_IMU = Target(
    name="ros-imu",
    synonyms=("ros",),
    title=say("covariances of sensor_msgs/Imu, for the parameters of a driver"),
    fields=pair("angular_velocity_covariance", "linear_acceleration_covariance", VARIANCE, "(m/s^2)^2"),
    forms={".yaml": LineLayout("{name}: [{diagonal}]")},
    source="sensor_msgs/Imu.msg: 3 x 3 by rows, variance of a sample; all zeros mean unknown. Names of the parameters "
    "of drivers differ",
    notes=(say("the message has no place for a drift of the bias: K is not written"),),
    each=True,
)

ROBOT_LOCALIZATION = replace(
    ROS_IMU,
    name="robot-localization",
    title=say("covariances that robot_localization reads from sensor_msgs/Imu"),
    source="doc/state_estimation_nodes.rst: the noise of a measurement is that of its message; there is no state"
    " for a bias, and process_noise_covariance describes the motion of the vehicle",
    notes=(
        say("set them in the driver of the IMU; process_noise_covariance does not follow from the noise of the sensor"),
        say("robot_localization does not estimate a bias: K is not written; remove the bias before"),
    ),
)
