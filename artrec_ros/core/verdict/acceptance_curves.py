"""The curves of `acceptance.py` and `parts.py`, written by `python benchmarks/acceptance.py --fit`.

Fitted on 3855 claims and 3703 components in the even-numbered of worlds 0 to 195.
Chosen: alone: 4 points a curve at most, pull 0.3; deserted: 8 points a curve at most, pull 1; borne out: 4 points a
curve at most, pull 0.3; components: 6 points a curve at most, pull 0.3.
On the odd-numbered ones: 3383 claims, 0.389 right: log-loss 0.235, expected calibration error 0.017; 4347 components,
0.944 right: log-loss 0.143, expected calibration error 0.008.
"""

Model = tuple[float, dict[str, tuple[tuple[float, ...], tuple[float, ...]]]]

# Of each case the bias, and of each evidence the points of its curve: how much there is, what it adds
CURVES: dict[str, Model] = {
    "alone": (
        -11.217,
        {
            "size": (
                (4.681, 5.465, 6.749, 10.313),
                (0.000, 0.036, 1.648, 4.338),
            ),
            "edge": (
                (-2.744, 0.479, 0.831, 1.157),
                (0.000, 5.489, 6.969, 7.282),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 1.533),
            ),
            "body": (
                (-2.000, -0.508, 0.700),
                (0.000, 0.000, 3.490),
            ),
            "facing": (
                (0.157, 0.489, 0.737, 0.995),
                (0.000, 0.181, 0.541, 1.625),
            ),
        },
    ),
    "deserted": (
        -11.030,
        {
            "size": (
                (4.899, 5.562, 5.986, 6.477, 7.113, 7.748, 8.709, 11.291),
                (0.000, 0.000, 0.387, 0.436, 1.053, 1.624, 2.241, 2.420),
            ),
            "edge": (
                (-7.209, -1.298, -0.176, 0.204, 0.496, 0.689, 0.849, 1.070),
                (0.000, 0.276, 1.603, 2.652, 2.830, 3.517, 3.517, 3.517),
            ),
            "bare": (
                (0.000, 1.000),
                (0.000, 0.841),
            ),
            "body": (
                (-2.000, -0.863, -0.200, 0.108, 0.696),
                (0.000, 0.000, 0.000, 1.904, 3.610),
            ),
            "shown": (
                (0.000, 1.000, 2.000, 3.000),
                (0.000, 1.234, 1.718, 1.892),
            ),
            "others": (
                (-10.489, -6.028, -4.644, -3.050, -1.574, -0.359, 0.000, 1.028),
                (0.000, 0.000, 0.000, 0.317, 0.965, 0.965, 1.056, 2.511),
            ),
            "missing": (
                (-12.414, -7.638, -6.079, -5.052, -4.197, -3.645, -3.147, -2.380),
                (0.000, 0.526, 1.378, 2.661, 3.230, 3.862, 3.862, 4.130),
            ),
        },
    ),
    "borne out": (
        -17.025,
        {
            "size": (
                (5.224, 6.976, 8.242, 11.274),
                (0.000, 1.083, 1.777, 3.668),
            ),
            "edge": (
                (-8.225, -0.140, 0.706, 1.131),
                (0.000, 2.378, 4.944, 5.329),
            ),
            "shown": (
                (1.000, 3.000, 16.080),
                (0.000, 2.377, 5.046),
            ),
            "edges": (
                (-7.616, -0.197, 0.499, 1.000),
                (0.000, 5.009, 7.620, 8.321),
            ),
            "faces": (
                (-2.000, -0.201, 0.680),
                (0.000, 0.000, 2.042),
            ),
            "facing": (
                (0.191, 0.660, 0.866, 0.995),
                (0.000, 1.062, 1.632, 2.629),
            ),
            "lacking": (
                (-0.935, -0.280, 0.000),
                (0.000, 2.462, 4.345),
            ),
        },
    ),
}
# The same of components besides the required one
PARTS: Model = (
    -2.785,
    {
        "own": (
            (1.438, 2.812, 3.844, 4.871, 6.019, 7.558),
            (0.000, 0.797, 0.797, 2.076, 2.076, 4.185),
        ),
        "alone": (
            (0.250, 1.000),
            (0.000, 1.155),
        ),
        "open": (
            (1.000, 2.000),
            (0.000, 0.002),
        ),
        "edge": (
            (-0.597, 0.206, 0.532, 0.740, 0.905, 1.032),
            (0.000, 0.988, 0.988, 1.111, 1.494, 1.494),
        ),
        "whole": (
            (-0.167, 2.926, 4.929, 6.775, 7.000),
            (0.000, 3.141, 3.942, 4.292, 4.430),
        ),
    },
)
# What the search takes for sure, and for likely: of the claims that it asked about no more than
# 3% above the first and 8% above the second are wrong
SURE, LIKELY = 0.855, 0.655
