"""004, Geng et al.: a magnetically suspended gyro."""

from tests.conformance.papers.direct import stability
from tests.conformance.papers.rows import Row, arcsec

ADC = "budget volts.npz --sense 5 --scale-factor 0.2 --stage 'ADC 12 5V' --stage 'ADC 8 5V' --csv -"
COIL = "budget coil.npz --torquer turns=100,field=0.4,span=0.05,radius=0.05,inertia=2e-3,spin=1000,sides=4"
COMPENSATE = "compensate warmed.csv --channels gx --regressors disp,temp --json -"
AXES = "budget currents.csv --scale-factor 0.2 --coupling 0.01,-1,1,0.01 --stage 'ADC 12 5A' --terms N --csv -"

ROWS = (
    Row("a gain of 10 before it", ADC.replace("12 5V", "12 5V gain=10"), "step @ bits=12", 0.0002441, 1e-3),
    Row("a line that has gone: deviation at 25.6 s", "compare line.npz clean.npz --csv -",
        ("after @ quantity=oadev & tau_s=25.6", "before @ quantity=oadev & tau_s=25.6"), 0.15, 0.15, read=lambda after,
        before: (after / before) ** 2),
    *(Row(f"share of {bits} bits, %", f"{COIL} --stage 'ADC {bits} 5A' --csv -", "share_percent", share, 0.1)
      for bits, share in ((12, 0.0037), (8, 0.95))),
    *(Row(f"two torquers: N of the rate about {axis}", AXES, f"measured @ channel=w{axis}", 0.10872, 0.03)
      for axis in "xy"),
    Row("eq. 9, of counts with their scale", "analyze turned1.npz --terms N --coefficients -",
        "value @ name=10 s stability", lambda: stability("turned1.npz", 4000) * 0.32795 * 400, 1e-6),
    *(Row(f"compensation: {name}", COMPENSATE, f"/channels/0/regression/effects/{i}/value", true, 0.15, read=arcsec)
      for i, (name, true) in enumerate((("by displacement", 40.0), ("by temperature", 20.0)))),
)  # fmt: skip
