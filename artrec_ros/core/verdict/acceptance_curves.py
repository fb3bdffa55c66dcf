"""The curves of `acceptance.py`, written by `python benchmarks/acceptance.py --fit`.

Fitted on 3891 claims in the even-numbered of worlds 0 to 195 (alone: 4 points a curve at most, pull 0.3; deserted: 4
points a curve at most, pull 0.3; borne out: 4 points a curve at most, pull 0.3). On the odd-numbered ones: 4128
claims, 0.561 right: log-loss 0.297, expected calibration error 0.012.
"""

Model = tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]

# Of each case the bias, and of each evidence the points of its curve: how much there is, what it adds
CURVES: dict[str, Model] = {
    "alone": (
        -9.391,
        {
            "size": (
                (4.650, 5.688, 7.004, 10.120),
                (0.000, 0.032, 1.372, 2.968),
            ),
            "edge": (
                (-0.871, 0.666, 0.862, 1.148),
                (0.000, 4.689, 4.952, 5.573),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 1.989),
            ),
            "body": (
                (-2.000, -0.070, 0.700),
                (0.000, 0.015, 4.293),
            ),
            "facing": (
                (0.157, 0.505, 0.770, 0.997),
                (0.000, 0.703, 1.339, 1.628),
            ),
        },
    ),
    "deserted": (
        -10.330,
        {
            "size": (
                (4.753, 5.890, 6.816, 9.461),
                (0.000, 0.000, 0.146, 1.042),
            ),
            "edge": (
                (-0.856, 0.432, 0.780, 1.090),
                (0.000, 3.544, 4.517, 4.517),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 1.569),
            ),
            "body": (
                (-2.000, -0.042, 0.700),
                (0.000, 0.935, 3.499),
            ),
            "shown": (
                (0.000, 1.000, 2.000, 3.000),
                (0.000, 1.695, 3.729, 4.424),
            ),
            "others": (
                (-10.079, -4.689, -1.630, 1.904),
                (0.000, 0.000, 0.257, 2.411),
            ),
            "faces": (
                (-2.000, -0.219, 0.622),
                (0.000, 0.000, 1.186),
            ),
            "missing": (
                (-7.238, -4.265, -3.447, -2.308),
                (0.000, 1.856, 2.689, 2.689),
            ),
        },
    ),
    "borne out": (
        -8.636,
        {
            "size": (
                (5.357, 6.808, 7.742, 9.722),
                (0.000, 0.495, 0.707, 1.908),
            ),
            "edge": (
                (-0.329, 0.588, 0.830, 1.134),
                (0.000, 2.159, 2.159, 2.159),
            ),
            "shown": (
                (1.000, 3.000, 8.000),
                (0.000, 1.521, 3.210),
            ),
            "colour": (
                (0.087, 3.676, 4.478, 5.772),
                (0.000, 1.949, 2.871, 2.871),
            ),
            "edges": (
                (-0.735, 0.405, 0.667, 1.018),
                (0.000, 3.079, 3.707, 4.137),
            ),
            "faces": (
                (-2.000, 0.332, 0.686),
                (0.000, 0.627, 6.054),
            ),
            "facing": (
                (0.203, 0.676, 0.863, 0.995),
                (0.000, 1.664, 1.965, 3.122),
            ),
        },
    ),
}
# What the search takes for sure, and for likely: of the claims that it asked about no more than
# 3% above the first and 8% above the second are wrong
SURE, LIKELY = 0.870, 0.715
# The same of components
PARTS: Model = (
    0.0,
    {},
)
