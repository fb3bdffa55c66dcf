"""What images with colours add to `acceptance_curves.py`, written by `acceptance_colour.py --fit`.

Fitted on the even-numbered of worlds 0 to 109 and 200 to 299. alone: 639 claims; of odd-numbered ones 730 claims,
0.215 right: log-loss 0.296, expected calibration error 0.036. Chosen: alone: 4 points a curve at most, pull 3.
"""

from .acceptance_curves import Model

# Of each case what the bias is more, and of further evidence the points of its curve: how much there is,
# what it adds
ADDED: dict[str, Model] = {
    "alone": (
        0.371,
        {
            "faint": (
                (-5.081, -3.325, -2.182, -0.629),
                (0.000, 0.139, 0.474, 0.560),
            ),
        },
    ),
}
