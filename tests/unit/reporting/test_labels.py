"""Where the labels of lines stand."""

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.reporting import first_screen, page, plot
from allanite.reporting.figures import drawing
from allanite.reporting.figures.drawing import LabelBox, crossings, freedom, place
from allanite.reporting.printing import encode

NOTHING = np.empty((0, 2))


def test_points_are_outside_of_a_label_and_labels_keep_a_wider_distance_from_each_other():
    """1 is the edge of a label."""
    label, far = LabelBox(0.5, 0.5, 0.2, 0.1), drawing.ENOUGH_DISTANCE
    distances = {(0.5, 0.5): 0.0, (0.5, 0.56): 1.2, (0.5, 0.44): 1.2, (0.61, 0.52): 1.1, (0.9, 0.9): far}
    for obstacle, wanted in distances.items():
        assert freedom(label, np.array([(0.95, 0.05), obstacle]), ()) == pytest.approx(wanted), obstacle
    touching = LabelBox(0.5, 0.6, 0.2, 0.1)
    assert freedom(label, NOTHING, ()) == far
    assert freedom(label, NOTHING, [touching]) == pytest.approx(1.0)
    assert freedom(label, NOTHING, [touching._replace(y=0.55)]) == pytest.approx(-0.5)


@rows("side", [1, -1], ids=["above", "below"])
def test_a_label_stands_on_the_side_of_its_line_where_nothing_is(side):
    x = np.linspace(0.1, 0.9, 81)
    points = np.concatenate([np.column_stack([x, np.full(x.size, y)]) for y in (0.5, 0.5 + 0.05 * side)])
    label = place(np.array([(0.5, 0.5)]), (0.2, 0.06), points, ())
    assert side * (label.y - 0.5) < -0.03
    assert label.x == pytest.approx(0.5)


@rows("seed", [1, 2, 3, 4, 5, 6])
def test_no_place_of_a_label_is_better_than_the_one_that_is_taken(seed):
    """Against all places, each judged by itself."""
    rng, x = np.random.default_rng(seed), np.linspace(0, 1, 60)
    lines = drawing.together(np.column_stack([x, a + b * x]) for a, b in rng.uniform(-0.5, 1, (4, 2)))
    anchors, size = rng.uniform(0.1, 0.9, (5, 2)), (0.25, 0.06)
    taken = [LabelBox(*rng.uniform(0.2, 0.8, 2), *size, tuple(rng.uniform(0.1, 0.9, 2).tolist())) for _ in range(3)]
    margin = drawing.MARGIN + np.array(size) / 2

    def worth(centre, near):
        free = freedom(LabelBox(*centre, *size), lines, taken)
        crossed = crossings(centre[None], near[None], np.array(size), lines, taken)[0]
        return free - (free < 1) - np.hypot(*(near - centre)) - 0.7 * min(crossed, 3)

    best = -np.inf
    near = (anchors[:, None] + drawing.NEAR * size).reshape(-1, 2)
    for centre in np.clip([*near, *drawing.GRID], margin, 1 - margin):
        away = np.hypot(*(anchors - centre).T) + 0.002 * np.arange(len(anchors))
        best = max(best, worth(centre, anchors[away.argmin()]))
    label = place(anchors, size, lines, taken)
    assert worth(np.array([label.x, label.y]), np.array(label.anchor)) == pytest.approx(best)


@pytest.mark.slow("seconds of analyses")
@rows("model", [
    "Q 0.3 arcsec*s, N 3 arcsec*sqrt(s), B 1 arcsec, K 0.1 arcsec/sqrt(s), R 0.002 arcsec/s",
    "N 0.1 deg/sqrt(h), B 1 deg/h, K 5 deg/h/sqrt(h)",
    "Q 1 arcsec, N 0.01 deg/sqrt(h), B 0.1 deg/h, R 1 deg/h^2, GM 1 deg/h 20 s",
])  # fmt: skip
def test_lines_to_labels_are_short_and_do_not_run_across_the_curve(model):
    figure = al.plot(al.statistics.expectation(al.Model(model), rate=40.0, size=1_440_000))
    figure.draw_without_rendering()
    (ax,) = figure.axes
    tau, whole = np.log(next(line for line in ax.lines if line.get_label() == "model").get_xydata()).T
    low, high = np.log(np.array([ax.get_xlim(), ax.get_ylim()]).T)
    leaders = [text for text in ax.texts if getattr(text, "arrowprops", None)]
    assert len(leaders) == len(tuple(al.Model(model)))
    for text in leaders:
        ends = np.array([text.xy, text.xyann])
        assert np.hypot(*(ends[1] - ends[0])) < 0.35, text
        # the label is where its anchor is: above or below the curve
        x, y = (low + ends * (high - low)).T
        side = y - np.interp(x, tau, whole)
        assert side[0] * side[1] > 0 or abs(side[0]) < 0.2, text


@pytest.mark.slow("seconds of analyses")
def test_a_minimum_of_zero_has_no_label_and_no_place():
    """As of a record that alternates between two numbers."""
    study = al.analyze(al.Record(np.resize([2.0, 3.0], 2400), rate=50.0, unit="deg/s"))
    assert al.minimum(study[0].curve).deviation == 0
    assert b"minimum" not in encode(plot(study), "svg")
    assert "<svg" in page(study)


@rows("show", [lambda value: value._repr_html_(), plot, first_screen, page])
def test_a_stored_curve_of_a_statistic_that_is_not_known_is_refused_by_its_name(show):
    curve = al.deviation(al.Record(np.random.default_rng(1).normal(size=200), rate=10.0, unit="deg/h"))
    stored = type(curve).from_dict(curve.to_dict() | {"statistic": "__class__"})
    refused(al.UsageError, "unknown statistic '__class__'", lambda: show(stored))


def test_a_deviation_that_falls_by_many_decades_leaves_room_beside_the_axis():
    record = al.Record(np.sin(0.4 * np.pi * np.arange(500)), 100.0, "deg/s")
    figure = plot(al.deviation(record, "oadev", taus="log"))
    encode(figure, "svg")  # a layout without room warns, which is an error here
    assert figure.axes[0].get_position().width * figure.get_figwidth() > 2.5
