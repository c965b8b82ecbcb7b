"""PSINS: strapdown inertial navigation in MATLAB."""

from allanite.core.syntax import MATLAB
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField
from allanite.phrases.phrase import say

GRAVITY = 9.80665 / 9.7803267714
"""PSINS has 9.7803267714 m/s^2 for 1 g."""

PSINS = Target(
    name="psins",
    title=say("imuerrset of PSINS"),
    fields=(
        TargetField("web", GYRO, "N", "deg/sqrt(h)"),
        TargetField("wdb", ACCELEROMETER, "N", "ug/sqrt(Hz)", weight=GRAVITY**2),
        TargetField("sqrtR0G", GYRO, "K", "deg/h/sqrt(h)"),
        TargetField("sqrtR0A", ACCELEROMETER, "K", "ug/sqrt(h)", weight=GRAVITY**2),
    ),
    forms={
        ".m": LineLayout(
            "{name} = {value};",
            syntax=MATLAB,
            start=("% constant biases are not noise", "eb = 0; db = 0;"),
            end=(
                "TauG = inf; TauA = inf;",
                "imuerr = imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA);",
            ),
        )
    },
    source="imuerrset.m: with TauG = inf, sqrtR0G is the rate random walk in deg/h/sqrt(h); wdb in ug/sqrt(Hz) "
    "with the g of glvf.m, 9.7803267714 m/s^2. imuadderr.m simulates sqg only with a finite TauG; filters"
    " of 15 states have no driving noise of the bias unless kf.Qt is given imuerr.sqg^2",
    comments=MATLAB.pattern,
)
