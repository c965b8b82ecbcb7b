"""Words in a proposed command in whose place the user puts what no file says."""

UNIT, RATE, SCALE, COLUMN = "UNIT", "HZ", "SCALE", "COLUMN"

MEANINGS = {
    UNIT: "the unit (deg/s, rad/s, m/s^2 or g, of time s, ms, us or ns)",
    RATE: "the sampling rate in Hz",
    SCALE: "the size of one count with its unit (0.01deg/s)",
    COLUMN: "the name or number of a column",
}
"""What belongs in the place of each."""
