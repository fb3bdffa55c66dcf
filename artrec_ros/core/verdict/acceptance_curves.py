"""The curves of `acceptance.py`, as `python benchmarks/acceptance.py --fit` has written them.

Fitted on 2744 claims in the even-numbered of worlds 0 to 139 (alone: 4 points a curve at most, pull 1; deserted: 6
points a curve at most, pull 0.3; borne out: 3 points a curve at most, pull 1). On the odd-numbered ones: 2694 claims,
0.497 right: log-loss 0.322, expected calibration error 0.017.
"""

# Of each case the bias, and of each evidence the points of its curve: how much there is, what that adds
CURVES: dict[str, tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]] = {
    "alone": (
        -6.381,
        {
            "size": ((4.644, 5.550, 6.556, 9.995), (0.000, 0.626, 1.001, 3.215)),
            "edge": ((-0.515, 0.697, 0.893, 1.145), (0.000, 3.012, 3.012, 3.012)),
            "body": ((-1.201, 0.000, 0.700), (0.000, 1.316, 3.886)),
            "others": ((-17.378, -1.973, 0.000, 4.397), (0.000, 0.000, 0.000, 1.547)),
        },
    ),
    "deserted": (
        -9.921,
        {
            "edge": ((-0.731, 0.148, 0.515, 0.737, 0.876, 1.082), (0.000, 1.746, 1.861, 2.593, 2.593, 2.593)),
            "bodied": ((0.000, 1.000), (0.000, 1.338)),
            "body": ((-1.712, -0.200, 0.000, 0.698), (0.000, 1.209, 3.731, 4.430)),
            "shown": ((0.000, 1.000, 2.000, 3.000), (0.000, 1.865, 1.865, 1.865)),
            "colour": ((-2.355, 0.584, 1.665, 2.345, 3.120, 4.053), (0.000, 0.000, 0.000, 0.000, 0.158, 1.117)),
            "faces": ((-1.784, -0.471, 0.000, 0.646), (0.000, 0.000, 0.000, 2.334)),
            "missing": ((-7.429, -5.085, -4.179, -3.653, -3.167, -2.312), (0.000, 0.952, 1.436, 1.544, 1.544, 1.544)),
        },
    ),
    "borne out": (
        -8.890,
        {
            "size": ((5.182, 7.130, 9.853), (0.000, 0.962, 2.013)),
            "edge": ((-0.784, 0.692, 1.108), (0.000, 3.649, 4.159)),
            "bodied": ((0.000, 1.000), (0.000, 0.765)),
            "shown": ((1.000, 2.000, 8.000), (0.000, 1.008, 4.010)),
            "colour": ((-0.017, 4.036, 5.603), (0.000, 1.773, 2.250)),
            "edges": ((-0.510, 0.493, 0.985), (0.000, 3.118, 3.150)),
            "backing": ((3.651, 5.848, 8.926), (0.000, 0.000, 1.312)),
            "faces": ((-0.657, 0.000, 0.682), (0.000, 0.592, 2.921)),
        },
    ),
}
# What the search takes for sure, and for likely: of the claims that it asked about no more than
# 3% above the first and 8% above the second are wrong
SURE, LIKELY = 0.860, 0.715
