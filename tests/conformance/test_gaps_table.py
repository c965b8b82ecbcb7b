"""A part of the table of records with gaps is made again."""

import numpy as np

import gaps

SEEDS = range(3)


def test_small_noise_of_the_rate_is_told_where_quantization_rules():
    found = [gaps.coefficients_of(("RLG", "1 %", i)) for i in SEEDS]
    assert all(one["N"][0] > 0 for one in found)
    assert sum(one["N"][1] for one in found) >= len(SEEDS) - 1
    assert np.sqrt(np.mean([(one["N"][0] - 1) ** 2 for one in found])) < 0.2


def test_a_third_of_the_readings_may_be_lost():
    found = [gaps.coefficients_of(("MEMS", "30 %", i)) for i in SEEDS]
    assert all(one["N"][0] > 0 for one in found)
    assert sum(one["N"][1] for one in found) >= len(SEEDS) - 1


def test_limits_of_curves_reach_what_the_whole_record_would():
    found = [gaps.curves_of(("MEMS", "1 %", i)) for i in SEEDS]
    for statistic, share in (("oadev", 0.1), ("oadev", 0.4), ("ohdev", 0.2)):
        assert sum(one[statistic, share][0] == 0 for one in found) >= len(SEEDS) - 1


def test_bursts_lose_the_share_that_is_asked_for():
    for share, length in gaps.LOSSES.values():
        gone = gaps.lost(gaps.SIZE, share, length, np.random.default_rng(1))
        assert abs(gone.mean() - share) < 0.02
