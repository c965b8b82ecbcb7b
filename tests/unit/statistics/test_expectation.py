"""Curves of a model without data."""

import numpy as np
from tests.commands import ends, run
from tests.rows import rows

import allanite as al
from allanite.reporting import figures
from allanite.statistics import expectation

FIVE = "Q 0.5 arcsec, N 0.02 deg/sqrt(h), B 0.3 deg/h, K 1 deg/h/sqrt(h), R 5 deg/h^2"


def texts(shown):
    figure = al.plot(shown)
    return "\n".join(text.get_text() for ax in figure.axes for text in ax.texts), figure


def test_curves_are_the_expectation_and_its_terms_add_up():
    model = al.Model(FIVE)
    found = expectation(model, ["oadev", "mdev", "tdev", "theoh"], rate=100.0, size=20_000)
    for curve in found.curves:
        exact = al.expected(model, curve.statistic, curve.tau, rate=100.0, size=20_000)
        np.testing.assert_allclose(curve.variance, exact, rtol=1e-12)
    # the bias ratio of theoh is not linear in the terms
    for curve in found.curves[:3]:
        np.testing.assert_allclose(np.sum(np.square(found.terms(curve)), axis=0), curve.variance, rtol=1e-9)


def test_the_figure_of_five_slopes():
    said, figure = texts(al.Model(FIVE))
    for label in ("Q = 0.5 arcsec", "N = 0.02 °/√h", "B = 0.3 °/h", "K = 1 °/h/√h", "R = 5 °/h²"):
        assert label in said
    assert {line.rpartition(" ")[2] for line in said.splitlines() if "slope" in line} == {"−1", "−½", "0", "+½", "+1"}
    black = next(line for line in figure.axes[0].lines if line.get_label() == "model")
    tau, deviation = np.asarray(black.get_xydata()).T
    exact = np.sqrt(al.expected(al.Model(FIVE), "oadev", tau)) / np.radians(1 / 3600)
    np.testing.assert_allclose(deviation, exact, rtol=1e-9)


def test_what_figures_of_models_say():
    shaped = al.Model("GM 0.1 deg/h 20 s, GM 0.3 deg/h 500 s, Sine 1 deg/h 3 Hz")
    for shown, words in (
        (expectation(al.Q(0.5, "arcsec"), ["mdev"], rate=100.0, size=100_000), "slope −1½"),
        (shaped, "GM = 0.1 °/h, T = 20 s\nGM = 0.3 °/h, T = 500 s"), (shaped, "Sine = 1 °/h, f = 3 Hz"),
        (al.N(0.1, "deg/sqrt(h)"), "N = 0.1 °/√h"),
    ):  # fmt: skip
        assert words in texts(shown)[0]
    both = al.plot([al.N(0.1, "deg/sqrt(h)") + al.B(1, "deg/h"), al.N(2.0, "ug/sqrt(Hz)") + al.B(1, "ug")])
    assert len(both.axes) == 2
    assert figures.facts_of(expectation(al.N(0.1, "deg/sqrt(h)")).curves[0]) == ""


@rows("arguments, words", [
    ((), "give either a recording, or the noise with --model, --sensor or --datasheet"),
    (("a.csv", "--sensor", "fog"), "give either a recording"),
    (("--sensor", "fog", "--statistic", "mdev"), "pass --rate HZ"),
    (("--sensor", "fog", "--statistic", "theoh", "--rate", "10"), "pass --duration TIME"),
    (("--sensor", "fog", "--duration", "1h"), "--rate HZ"),
    (("--sensor", "fog", "--terms", "QN"), "--terms applies to a recording"),
    (("--sensor", "fog", "--m", "1,2"), "--taus 1,10,100"), (("--sensor", "fog", "--taus", "decade"), "--rate HZ"),
    (("--sensor", "fog", "--rate", "0"), "between 1e-09 and 1e+15 Hz"),
    (("--sensor", "fog", "--rate", "10", "--samples", "1"), "too short for oadev"),
])  # fmt: skip
def test_what_cannot_be_expected_is_refused(arguments, words):
    ends(run("deviation", *arguments), 2, words)
