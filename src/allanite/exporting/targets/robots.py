"""Robots, flight controllers, and their simulation."""

from dataclasses import replace

from allanite.core.syntax import PARAMETERS, XML
from allanite.exporting.content import JSON_COMMENT, Content, JsonLayout, LineLayout, number, spread, told

from allanite.exporting.target import (  # isort: skip
    ACCELEROMETER, DENSITY, GYRO, TIME, WALK, Target, TargetField, ThermalTarget, pair, sectioned)  # fmt: skip
from allanite.phrases.phrase import say


def sdf(content: Content) -> str:
    """The element `imu` of a sensor."""
    lines = [part for line in content.header for part in XML.comments(line)]
    lines.append("<imu>")
    for section in dict.fromkeys(entry.section for entry in content.entries):
        entries = content.of(section)
        lines += [f"  {part}" for entry in entries for part in XML.comments(f"{entry.name}: {told(entry)}")]
        lines.append(f"  <{section}>")
        for i, axis in enumerate("xyz"):
            inner = "".join(f"<{e.name}>{number(spread(e.values)[i])}</{e.name}>" for e in entries)
            lines.append(f'    <{axis}><noise type="gaussian"><mean>0.0</mean>{inner}</noise></{axis}>')
        lines.append(f"  </{section}>")
    return "\n".join([*lines, "</imu>"]) + "\n"


GAZEBO = Target(name="gazebo", synonyms=("sdf", "gz"), title=say("noise of an IMU in SDF, for Gazebo"),
                fields=sectioned("angular_velocity", "linear_acceleration",
                                 ("stddev", TargetField("", GYRO, "N", "rad/s", rate=1), "m/s^2"),
                                 ("dynamic_bias_stddev", *WALK), ("dynamic_bias_correlation_time", *TIME)),
                forms={".sdf": sdf},
                simulates=True, source="gz-sensors, src/GaussianNoiseModel.cc: white noise of stddev per sample; the "
                "bias is a Gauss-Markov process driven with the variance dynamic_bias_stddev^2 T (1 - exp(-2 dt/T))/2 "
                "per step: dynamic_bias_stddev is K, not a standard deviation. The copy of 2018 had no dynamic bias",
                notes=(say("dynamic_bias_stddev is a density, K; the steady-state sigma is K sqrt(T/2)"),
                       say("f is the update_rate of the sensor"), say("SDF 1.6 or later")),
                markov=True, each=True, comments=XML.pattern)  # fmt: skip

GAZEBO_CLASSIC = Target(
    name="gazebo-classic", title=say("IMU plugin of gazebo-classic (RotorS, PX4 SITL, UUV simulator)"),
    fields=(*pair("gyroscopeNoiseDensity", "accelerometerNoiseDensity", *DENSITY),
            *pair("gyroscopeRandomWalk", "accelerometerRandomWalk", *WALK),
            *pair("gyroscopeBiasCorrelationTime", "accelerometerBiasCorrelationTime", *TIME)),
    forms={".sdf": LineLayout("  <{name}>{value}</{name}>",
                              syntax=XML, start=('<plugin name="imu_plugin" filename="libgazebo_imu_plugin.so">',),
                              end=("</plugin>",))},
    simulates=True, source="rotors_gazebo_plugins/src/gazebo_imu_plugin.cpp: white noise density/sqrt(dt), and a "
    "Gauss-Markov bias driven with the variance walk^2 T (1 - exp(-2 dt/T))/2 per step",
    notes=(say("gyroscopeTurnOnBiasSigma and accelerometerTurnOnBiasSigma do not follow from a static recording"),),
    markov=True, comments=XML.pattern,
)  # fmt: skip

VARIANCE = TargetField("", GYRO, "N", "(rad/s)^2", rate=1, power=2)

ROS_IMU = Target(
    name="ros-imu", synonyms=("ros",), title=say("covariances of sensor_msgs/Imu, for the parameters of a driver"),
    fields=pair("angular_velocity_covariance", "linear_acceleration_covariance", VARIANCE, "(m/s^2)^2"),
    forms={".yaml": LineLayout("{name}: [{diagonal}]")}, source="sensor_msgs/Imu.msg: 3 x 3 by rows, variance of a "
    "sample; all zeros mean unknown. Names of the parameters of drivers differ",
    notes=(say("-1 in the first element means that there is no such measurement; all zeros mean an unknown covariance"),
           say("the message has no place for a drift of the bias: K is not written")),
    each=True,
)  # fmt: skip

ROBOT_LOCALIZATION = replace(
    ROS_IMU, name="robot-localization", title=say("covariances that robot_localization reads from sensor_msgs/Imu"),
    source="doc/state_estimation_nodes.rst: the noise of a measurement is that of its message; there is no state for a "
    "bias, and process_noise_covariance describes the motion of the vehicle",
    notes=(say("set them in the driver of the IMU; process_noise_covariance does not follow from the noise of the "
               "sensor"),
           say("robot_localization does not estimate a bias: K is not written; remove the bias before")),
)  # fmt: skip

STEP_NOISE = TargetField("", GYRO, "N", "rad/s", rate=1, span=(1e-4, 0.1))
PX4_WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1, span=(0.0, 0.01))

PX4 = Target(
    name="px4", synonyms=("ekf2", "px4-autopilot"), title=say("parameters of PX4's EKF2, for QGroundControl"),
    fields=(*pair("EKF2_GYR_NOISE", "EKF2_ACC_NOISE", STEP_NOISE, "m/s^2", span=(0.01, 1.0)),
            *pair("EKF2_GYR_B_NOISE", "EKF2_ACC_B_NOISE", PX4_WALK, "m/s^3")),
    forms={".params": LineLayout("1\t1\t{name}\t{value}\t9", PARAMETERS)},
    source="src/modules/ekf2/EKF/covariance.cpp: variances of a step (dt EKF2_GYR_NOISE)^2 and (dt "
    "EKF2_GYR_B_NOISE)^2 with dt = 10 ms (EKF2_PREDICT_US); ranges of the parameters",
    notes=(
        say("the defaults of PX4 are 10 to 100 times as large, since they cover vibration in flight: values of a "
            "bench are lower bounds"),
    ),
    step=0.01,
)  # fmt: skip

PX4_TC = ThermalTarget(
    name="px4-tc", title=say("thermal compensation of PX4, for QGroundControl"),
    fields=(), forms={".params": LineLayout("1\t1\t{name}\t{value}\t9", PARAMETERS)},
    source="src/modules/temperature_compensation/TemperatureCompensation.cpp (calc_thermal_offsets_3D: "
    "polynomial of the third degree, temperature limited to TMIN .. TMAX) and .h (at most 4 sensors); "
    "src/lib/sensor_calibration/Gyroscope.hpp and Accelerometer.hpp (Correct: data - thermal offset - offset, then "
    "rotation); format of the file and TREF in the middle of the range: Tools/process_sensor_caldata.py. Not verified: "
    "how a vehicle takes the file",
    notes=(say("set TC_G*_ID and TC_A*_ID to the device IDs of the sensors (as in CAL_GYRO*_ID and CAL_ACC*_ID); "
               "without them PX4 does not apply the correction"),
           say("the record must be that of sensor_gyro and sensor_accel, in their axes and without a correction"),
           say("after loading, restart and calibrate gyro and accelerometer again")),
    prefixes={n: f"TC_{{sensor}}{n}_" for n in range(4)}, letters={GYRO: "G", ACCELEROMETER: "A"},
    coefficient="X{power}_{axis}", axes=("0", "1", "2"), enable="1\t1\tTC_{sensor}_ENABLE\t1\t6",
)  # fmt: skip

ARDUPILOT_WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1, span=(1e-5, 1e-3))

ARDUPILOT = Target(name="ardupilot", synonyms=("ekf3", "arducopter"), title=say("parameters of ArduPilot's EKF3"),
                   fields=(*pair("EK3_GYRO_P_NSE", "EK3_ACC_P_NSE", STEP_NOISE, "m/s^2", span=(0.01, 1.0)),
                           *pair("EK3_GBIAS_P_NSE", "EK3_ABIAS_P_NSE", ARDUPILOT_WALK, "m/s^3", span=(1e-5, 0.02))),
                   forms={".param": LineLayout("{name},{value}", PARAMETERS)},
                   source="libraries/AP_NavEKF3/AP_NavEKF3_core.cpp: variances of a step (dt EK3_GYRO_P_NSE)^2 and, "
                   "of the bias of the angle, (dt^2 EK3_GBIAS_P_NSE)^2, with dt = 12 ms (EKF_TARGET_DT); ranges of the "
                   "parameters. The step is a whole number of samples, and so up to 2 ms shorter or longer",
                   notes=(say("the defaults are larger, since they cover vibration in flight: values of a bench are "
                              "lower bounds"),),
                   step=0.012)  # fmt: skip

ARDUPILOT_TCAL = ThermalTarget(
    name="ardupilot-tcal", title=say("IMU temperature calibration of ArduPilot"),
    fields=(), forms={".param": LineLayout("{name},{value}", PARAMETERS)},
    source="libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp (correct_sensor: polynomial of the third degree "
    "without constant in 1e-6, TEMP_REFERENCE 35 degC, temperature and calibration temperature limited to TMIN .. "
    "TMAX) and AP_InertialSensor_Backend.cpp (_rotate_and_correct_gyro: before offsets, scale and board orientation); "
    "Tools/scripts/tempcal_IMU.py. Names of instances 4 and 5: list of parameters. The fifth degree of pull request "
    "27295 is not in them. Not verified: how a vehicle takes the file",
    notes=(say("the record must be in the axes of the sensor, before AHRS_ORIENTATION, and without a correction"),
           say("the other parameters are hidden until ENABLE is 1: load the file twice, and restart"),
           say("after loading, calibrate gyro and accelerometer again: the correction is zero at the temperature of "
               "the calibration (INS_GYR*_CALTEMP, INS_ACC*_CALTEMP)")),
    prefixes={**{n: f"INS_TCAL{n}_" for n in (1, 2, 3)}, **{n: f"INS{n}_TCAL_" for n in (4, 5)}},
    letters={GYRO: "GYR", ACCELEROMETER: "ACC"}, coefficient="{sensor}{power}_{axis}", axes=("X", "Y", "Z"),
    reference=35.0, constant=False, scale=1e6, together=True, enable="{prefix}ENABLE,1",
)  # fmt: skip

PEGASUS = Target(name="pegasus", title=say("IMU of the Pegasus Simulator in Isaac Sim"),
                 fields=sectioned("gyroscope", "accelerometer", ("noise_density", *DENSITY),
                                  ("random_walk", *WALK), ("bias_correlation_time", *TIME)),
                 forms={".json": JsonLayout(rate="update_rate")}, simulates=True,
                 source="pegasus/simulator/logic/sensors/imu.py: white noise density/sqrt(dt), and a Gauss-Markov bias "
                 "driven with the variance walk^2 T (1 - exp(-2 dt/T))/2 per step. In the version that was read the "
                 "bias is not added to the samples, and the gyro has the correlation time of the accelerometer",
                 notes=("config = json.load(open(file)); config.pop('comment'); IMU(config)",
                        say("Isaac Sim itself has no noise of an IMU; in Isaac Lab the standard deviation of a step is "
                            "N sqrt(f), without drift")),
                 rated=True, comments=JSON_COMMENT)  # fmt: skip
