"""The curves of `acceptance.py`, written by `python benchmarks/acceptance.py --fit`.

Fitted on 2127 claims in the even-numbered of worlds 0 to 111 (alone: 3 points a curve at most, pull 0.3; deserted: 3
points a curve at most, pull 0.3; borne out: 6 points a curve at most, pull 3). On the odd-numbered ones: 2376 claims,
0.531 right: log-loss 0.309, expected calibration error 0.019.
"""

# Of each case the bias, and of each evidence the points of its curve: how much there is, what it adds
CURVES: dict[str, tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]] = {
    "alone": (
        -11.932,
        {
            "size": (
                (4.663, 6.116, 10.282),
                (0.000, 0.964, 3.494),
            ),
            "edge": (
                (-1.020, 0.794, 1.143),
                (0.000, 4.975, 5.845),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 3.893),
            ),
            "body": (
                (-2.000, 0.700),
                (0.000, 5.425),
            ),
            "facing": (
                (0.161, 0.600, 0.991),
                (0.000, 1.237, 1.514),
            ),
        },
    ),
    "deserted": (
        -10.238,
        {
            "size": (
                (4.798, 6.423, 9.891),
                (0.000, 0.000, 0.428),
            ),
            "edge": (
                (-1.121, 0.665, 1.072),
                (0.000, 3.819, 3.819),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 2.381),
            ),
            "body": (
                (-2.000, -1.287, 0.698),
                (0.000, 0.000, 3.700),
            ),
            "shown": (
                (0.000, 2.000),
                (0.000, 3.185),
            ),
            "others": (
                (-10.534, -3.549, 2.012),
                (0.000, 0.000, 1.479),
            ),
            "faces": (
                (-2.000, -1.401, 0.623),
                (0.000, 0.000, 1.476),
            ),
            "missing": (
                (-7.358, -3.879, -2.307),
                (0.000, 2.083, 2.094),
            ),
        },
    ),
    "borne out": (
        -6.472,
        {
            "size": (
                (5.348, 6.388, 7.002, 7.561, 8.147, 9.593),
                (0.000, 0.705, 0.757, 1.097, 1.165, 1.499),
            ),
            "edge": (
                (-0.345, 0.434, 0.667, 0.796, 0.925, 1.132),
                (0.000, 1.263, 1.838, 1.838, 2.062, 2.196),
            ),
            "shown": (
                (1.000, 2.000, 4.000, 7.000),
                (0.000, 0.801, 1.471, 1.764),
            ),
            "colour": (
                (0.520, 3.021, 3.901, 4.381, 4.736, 5.649),
                (0.000, 0.575, 1.516, 2.048, 2.048, 2.048),
            ),
            "edges": (
                (-0.732, 0.297, 0.469, 0.621, 0.757, 0.996),
                (0.000, 0.903, 1.627, 1.627, 1.739, 1.739),
            ),
            "faces": (
                (-2.000, 0.134, 0.554, 0.690),
                (0.000, 0.637, 2.603, 2.895),
            ),
            "facing": (
                (0.196, 0.570, 0.714, 0.828, 0.916, 0.994),
                (0.000, 1.320, 1.871, 2.543, 2.812, 3.550),
            ),
        },
    ),
}
# What the search takes for sure, and for likely: of the claims that it asked about no more than
# 3% above the first and 8% above the second are wrong
SURE, LIKELY = 0.845, 0.715
