"""A target of export."""

from allanite.exporting.content import LineLayout
from allanite.exporting.target import DENSITY, Target, pair
from allanite.phrases.phrase import say

PILOT = Target(
    name="pilot",
    title=say("settings of Pilot"),
    fields=pair("gyro_noise", "accel_noise", *DENSITY),
    forms={".cfg": LineLayout("{name} = {value}")},
    source="manual of Pilot, section 3: two-sided densities",
)
