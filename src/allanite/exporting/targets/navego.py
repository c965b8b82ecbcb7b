"""NaveGo: integrated navigation in MATLAB."""

from allanite.core.syntax import MATLAB
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, GYRO, WALK, Target, TargetField, pair
from allanite.phrases.phrase import say

NAVEGO = Target(
    name="navego",
    title=say("IMU errors of NaveGo, in SI"),
    fields=(
        *pair("arw", "vrw", *DENSITY),
        *pair("gb_psd", "ab_psd", *WALK),
        *pair("gb_corr", "ab_corr", TargetField("", GYRO, "", "s", time=2), "s"),
    ),
    forms={".m": LineLayout("imu.{name} = [{triple}];", syntax=MATLAB)},
    source="ins_gnss.m: kf.Q = diag([arw, vrw, gb_psd, ab_psd].^2), of continuous time; F_update.m: the bias "
    "decays with -1/gb_corr. conversions/imu_si_errors.m computes gb_psd = gb_dyn sqrt(gb_corr), or "
    "divided by it in other versions; neither drives the bias with its density, which is K",
    notes=(
        say("set these after imu_si_errors, which would overwrite gb_psd and ab_psd"),
        say("gb_dyn and ab_dyn, the standard deviations at the start, do not follow from the noise"),
    ),
    markov=True,
    each=True,
    comments=MATLAB.pattern,
)
