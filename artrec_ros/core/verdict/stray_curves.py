"""What strays take from `facing_curves.py`, written by `acceptance_strays.py --fit`.

Fitted on worlds 0 to 219. Of each half of these by the other one: borne out: 8971 claims, 0.681 right: log-loss
0.139, expected calibration error 0.016; deserted: 2936 claims, 0.148 right: log-loss 0.122, expected calibration
error 0.013; borne out in colour: 8509 claims, 0.685 right: log-loss 0.220, expected calibration error 0.028; deserted
in colour: 2371 claims, 0.218 right: log-loss 0.305, expected calibration error 0.029. Chosen: borne out: 4 points a
curve at most, pull 1; deserted: 6 points a curve at most, pull 0.3; borne out in colour: 6 points a curve at most,
pull 3; deserted in colour: 4 points a curve at most, pull 3.
"""

from .facing_curves import Model

# Of each case what the bias is more, and of further evidence the points of its curve: how much there is,
# what it adds
ADDED: dict[str, Model] = {
    "borne out": (
        -5.203,
        {
            "lacking": (
                (-0.714, -0.187, 0.000),
                (0.000, 5.203, 5.203),
            ),
        },
    ),
    "deserted": (
        -5.040,
        {
            "lacking": (
                (-0.875, -0.750, -0.665, -0.508, -0.470, -0.057),
                (0.000, 2.533, 2.559, 5.040, 5.040, 5.040),
            ),
        },
    ),
    "borne out in colour": (
        -2.035,
        {
            "lacking": (
                (-0.750, -0.334, -0.050, -0.000),
                (0.000, 0.979, 2.035, 2.035),
            ),
        },
    ),
    "deserted in colour": (
        -2.361,
        {
            "lacking": (
                (-0.889, -0.666, -0.492, -0.048),
                (0.000, 1.003, 2.361, 2.361),
            ),
        },
    ),
}
