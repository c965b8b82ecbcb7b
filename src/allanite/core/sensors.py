"""Names of the types of sensors in messages, by the names of their signals."""

from allanite.phrases.phrase import say

SENSORS = {
    "gyro": say("gyro"),
    "accelerometer": say("accelerometer"),
    "dimensionless": say("dimensionless"),
    "current": say("current"),
    "voltage": say("voltage"),
    "temperature": say("temperature"),
    "displacement": say("displacement"),
    "flux density": say("flux density"),
    "pressure": say("pressure"),
    "angle": say("angle"),
    "velocity": say("velocity"),
    "time": say("time"),
    "frequency": say("frequency"),
}
