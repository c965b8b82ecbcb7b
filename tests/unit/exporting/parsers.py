"""Files as their targets read them, and the propagation of their filters or simulators, written from their sources."""

import ast
import json
import math
import re
import xml.etree.ElementTree as ET

import yaml

DEG = math.pi / 180
PSINS_G = 9.7803267714


def opencv(text):
    """cv::FileStorage: YAML behind a directive that other parsers refuse."""
    first, _, rest = text.partition("\n")
    assert first == "%YAML:1.0"
    return yaml.safe_load(rest)


def assigned(text, mark):
    """Assignments of a script: name -> number or list of numbers."""
    found = {}
    for line in text.splitlines():
        match = re.fullmatch(r"([\w.]+) = ([\[\d][^;]*);", line.partition(mark)[0].strip())
        if match:
            found[match[1].removeprefix("imu.")] = ast.literal_eval(match[2])
    return found


def parameters(text, separator):
    return [line.split(separator) for line in text.splitlines() if line and not line.startswith("#")]


def calls(text):
    lines = re.findall(r"^params\.(\w+)\((\S+) \* np\.eye\(3\)\)$", text, re.MULTILINE)
    return {name: float(value) for name, value in lines}


def python(text):
    space = {}
    exec(compile(text, "imu.py", "exec"), space)  # noqa: S102 - what gnss-ins-sim does with it
    return space["imu_err"]


# step(values)(dt) -> variance of the angle, decay of the bias, variance of the bias, all of one step


def sensors(held, step, gyro, accelerometer):
    """The step of each sensor, of the values in its fields."""
    fields = {"gyro": gyro, "accelerometer": accelerometer}
    return {sensor: step(*(held[name] for name in names.split())) for sensor, names in fields.items()}


def density_step(n, k):
    return lambda dt: ((n / math.sqrt(dt)) ** 2 * dt**2, 1.0, k**2 * dt)


def sigma_step(n, w):
    return lambda dt: ((dt * n) ** 2, 1.0, (dt * w) ** 2)


DENSITIES = "gyroscope_noise_density gyroscope_random_walk", "accelerometer_noise_density accelerometer_random_walk"


def kalibr(text):
    return sensors(yaml.safe_load(text), density_step, *DENSITIES)


def openvins(text):
    step = lambda w, wb: lambda dt: (dt * w**2 / dt * dt, 1.0, dt * wb**2 / dt * dt)  # noqa: E731
    return sensors(opencv(text)["imu0"], step, *DENSITIES)


def orb_slam3(text):
    v = opencv(text)
    sf = math.sqrt(v["IMU.Frequency"])

    def step(n, w):
        return lambda dt: ((dt * n * sf) ** 2, 1.0, (w / sf) ** 2)

    return sensors(v, step, "IMU.NoiseGyro IMU.GyroWalk", "IMU.NoiseAcc IMU.AccWalk")


def vins(text):
    def step(n, w):
        return lambda dt: ((0.5 * dt * n) ** 2 + (0.5 * dt * n) ** 2, 1.0, (dt * w) ** 2)

    return sensors(opencv(text), step, "gyr_n gyr_w", "acc_n acc_w")


def lio_sam(text):
    v = yaml.safe_load(text)["lio_sam"]
    return sensors(v, density_step, "imuGyrNoise imuGyrBiasN", "imuAccNoise imuAccBiasN")


def gtsam(text):
    def step(white, bias):
        return lambda dt: (dt**2 * white / dt, 1.0, bias * dt)

    names = "setGyroscopeCovariance setBiasOmegaCovariance", "setAccelerometerCovariance setBiasAccCovariance"
    return sensors(calls(text), step, *names)


def ros(text):
    v = yaml.safe_load(text)
    assert all(len(numbers) == 9 and all(isinstance(x, float) for x in numbers) for numbers in v.values())

    def step(numbers):
        return lambda dt: (numbers[0] * dt**2, 1.0, None)

    return sensors(v, step, "angular_velocity_covariance", "linear_acceleration_covariance")


def px4(text):
    v = {row[2]: float(row[3]) for row in parameters(text, "\t")}
    assert {row[4] for row in parameters(text, "\t")} == {"9"}
    return sensors(v, sigma_step, "EKF2_GYR_NOISE EKF2_GYR_B_NOISE", "EKF2_ACC_NOISE EKF2_ACC_B_NOISE")


def ardupilot(text):
    v = {row[0]: float(row[1]) for row in parameters(text, ",")}

    def step(n, w):
        # the state is the bias of the increment
        return lambda dt: ((dt * n) ** 2, 1.0, (dt * dt * w) ** 2 / dt**2)

    return sensors(v, step, "EK3_GYRO_P_NSE EK3_GBIAS_P_NSE", "EK3_ACC_P_NSE EK3_ABIAS_P_NSE")


def matlab(text):
    def step(one):
        assert one["NoiseType"] == "single-sided"
        n, k = one["NoiseDensity"][0], one["RandomWalk"][0]
        # the bandwidth is 1 / dt; of double-sided noise half of that
        return lambda dt: ((n * math.sqrt(1 / dt) * dt) ** 2, 1.0, (k / math.sqrt(1 / dt)) ** 2)

    return sensors(json.loads(text)["IMU"], step, "Gyroscope", "Accelerometer")


def gnss_ins_sim(text):
    v = python(text)

    def step(walk, drift, corr):
        return lambda dt: ((walk / math.sqrt(dt) * dt) ** 2, 1 - dt / corr, drift**2 * (1 - math.exp(-2 * dt / corr)))

    return {
        "gyro": step(v["gyro_arw"][0] * DEG / 60, v["gyro_b_stability"][0] * DEG / 3600, v["gyro_b_corr"][0]),
        "accelerometer": step(v["accel_vrw"][0] / 60, v["accel_b_stability"][0], v["accel_b_corr"][0]),
    }


def markov(white, walk, tau):
    return lambda dt: ((white * dt) ** 2, math.exp(-dt / tau), -(walk**2) * tau / 2 * math.expm1(-2 * dt / tau))


def markov_of_density(density, walk, tau):
    return lambda dt: markov(density / math.sqrt(dt), walk, tau)(dt)


def gazebo(text):
    imu = ET.fromstring(text)
    assert [axis.tag for axis in imu.find("angular_velocity")] == ["x", "y", "z"]
    names = ("stddev", "dynamic_bias_stddev", "dynamic_bias_correlation_time")

    def step(noise):
        return markov(*(float(noise.findtext(name)) for name in names))

    held = {section: imu.find(f"{section}/x/noise") for section in ("angular_velocity", "linear_acceleration")}
    return sensors(held, step, *held)


def gazebo_classic(text):
    held = {part.tag: part.text for part in ET.fromstring(text)}
    names = [" ".join(f"{s}{name}" for name in ("NoiseDensity", "RandomWalk", "BiasCorrelationTime"))
             for s in ("gyroscope", "accelerometer")]  # fmt: skip
    return sensors(held, lambda *values: markov_of_density(*map(float, values)), *names)


def pegasus(text):
    def step(one):
        return markov_of_density(one["noise_density"], one["random_walk"], one["bias_correlation_time"])

    return sensors(json.loads(text), step, "gyroscope", "accelerometer")


def kf_gins(text):
    v = yaml.safe_load(text)["imunoise"]
    tau = v["corrtime"] * 3600

    def step(walk, std):
        return lambda dt: (walk**2 * dt, 1 - dt / tau, 2 / tau * std**2 * dt)

    return {
        "gyro": step(v["arw"][0] * DEG / 60, v["gbstd"][0] * DEG / 3600),
        "accelerometer": step(v["vrw"][0] / 60, v["abstd"][0] * 1e-5),
    }


def psins(text):
    v = assigned(text, "%")
    assert "imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA)" in text
    assert "TauG = inf; TauA = inf;" in text
    ug = 1e-6 * PSINS_G

    def step(web, sq):
        return lambda dt: ((math.sqrt(dt) * web) ** 2, 1.0, sq**2 * dt)

    return {
        "gyro": step(v["web"] * DEG / 60, v["sqrtR0G"] * DEG / 3600 / 60),
        "accelerometer": step(v["wdb"] * ug, v["sqrtR0A"] * ug / 60),
    }


def navego(text):
    def step(white, psd, corr):
        return lambda dt: (white[0] ** 2 * dt, math.exp(-dt / corr[0]), psd[0] ** 2 * dt)

    return sensors(assigned(text, "%"), step, "arw gb_psd gb_corr", "vrw ab_psd ab_corr")


PARSERS = {
    "kalibr": kalibr, "openvins": openvins, "orb-slam3": orb_slam3, "vins-mono": vins, "vins-fusion": vins,
    "lio-sam": lio_sam, "gtsam": gtsam, "ros-imu": ros, "robot-localization": ros, "px4": px4, "ardupilot": ardupilot,
    "matlab": matlab, "gnss-ins-sim": gnss_ins_sim, "gazebo": gazebo, "gazebo-classic": gazebo_classic,
    "pegasus": pegasus, "kf-gins": kf_gins, "psins": psins, "navego": navego,
}  # fmt: skip
"""Text of a file -> for each sensor, dt -> the variances of one step."""


def propagated(step, dt, duration):
    """Variance of the angle after a duration, by the steps of a filter whose bias is known at the start."""
    white, decay, walk = step(dt)
    angle = cross = bias = 0.0
    for _ in range(round(duration / dt)):
        angle, cross, bias = (
            angle + 2 * dt * cross + dt**2 * bias + white, decay * (cross + dt * bias), decay**2 * bias + (walk or 0.0)
        )  # fmt: skip
    return angle


# temperature: parameters of an autopilot -> its correction of a sample of one axis (0, 1, 2) at a temperature


def px4_thermal_offset(v, sensor, axis, temperature):
    """calc_thermal_offsets_3D of TemperatureCompensation.cpp; a sample is raw - offset."""
    prefix = {"gyro": "TC_G0_", "accelerometer": "TC_A0_"}[sensor]
    if temperature > v[prefix + "TMAX"]:
        delta_temp = v[prefix + "TMAX"] - v[prefix + "TREF"]
    elif temperature < v[prefix + "TMIN"]:
        delta_temp = v[prefix + "TMIN"] - v[prefix + "TREF"]
    else:
        delta_temp = temperature - v[prefix + "TREF"]
    delta_temp_2 = delta_temp * delta_temp
    delta_temp_3 = delta_temp_2 * delta_temp
    x0, x1, x2, x3 = (v[f"{prefix}X{k}_{axis}"] for k in range(4))
    return x0 + x1 * delta_temp + x2 * delta_temp_2 + x3 * delta_temp_3


def ardupilot_thermal_offset(v, sensor, axis, temperature, cal_temp):
    """correct_sensor and polynomial_eval of AP_InertialSensor_tempcal.cpp; a sample is raw - offset."""
    letters, axis = {"gyro": "GYR", "accelerometer": "ACC"}[sensor], "XYZ"[axis]
    c = [v[f"INS_TCAL1_{letters}{k}_{axis}"] for k in (1, 2, 3)]

    def polynomial_eval(tdiff):
        return (c[0] + (c[1] + c[2] * tdiff) * tdiff) * tdiff * 1.0e-6

    assert v["INS_TCAL1_ENABLE"] == 1
    temperature, cal_temp = (min(max(t, v["INS_TCAL1_TMIN"]), v["INS_TCAL1_TMAX"]) for t in (temperature, cal_temp))
    return polynomial_eval(temperature - 35.0) - polynomial_eval(cal_temp - 35.0)
