"""The rooms' own numbers reach what they are for, whole numbers too, and lists that make no sense are refused."""

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import RED, camera_of, jolted, pose, render, sign

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.climb_kernels import climb, votes_of
from artrec_ros.core.pose.climber import Climb
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.fit_kernels import fit_each
from artrec_ros.core.pose.ranked import Ranked

CAMERA = camera_of((96, 72), 90.0)
TRUTH = pose(0, 0, 0.5, 0.2, model=sign())
FRAME = ImageFrame(LabelField(render(CAMERA, [(sign(), TRUTH, RED)])), CAMERA)


@pytest.mark.parametrize(
    "values, words",
    [
        ({"inside": (4.0, -3.5)}, ("expert.votes.inside", "2 numbers", "3")),
        ({"climb_rounds": (11, 13)}, ("climb_rounds", "3, 2 and 3 numbers")),
        ({"climb_rounds": (), "climb_hypotheses": (), "climb_first_steps": ()}, ("climb_rounds", "0, 0 and 0")),
        ({"turns_rad": ()}, ("expert.guesses.turns_rad", "none is given")),
        ({"fine_reach_px": ()}, ("expert.fit.fine_reach_px", "none is given")),
        ({"stretches": 0}, ("expert.covariance.stretches", "below its least value 1")),
        ({"turn": 0.5}, ("expert.search.turn", "above its greatest value")),
    ],
)
def test_lists_that_make_no_sense_are_refused(values, words):
    with pytest.raises(ConfigError) as error:
        settings(**values)
    assert all(word in str(error.value) for word in words)


def specialisations():
    return [len(kernel.signatures) for kernel in (votes_of, climb, fit_each)]


def run(config):
    """Votes before and after a climb, and a fit, of some poses near the truth."""
    finder = WholeObjectFinder(Target("sign", sign(), RED), config)
    near = jolted(np.random.default_rng(0), TRUTH, 3, 0.02, 0.08, 0.0)
    found = Ranked(near, finder.voter.votes(FRAME, near, occlusion=True))
    moved = finder.climber.climb(FRAME, found, Climb(3, 4, config.search.climb_first_steps[0]))
    used = np.ones((3, 1), bool)
    return found.votes, moved.votes, finder.rest._fitted(FRAME, near, used).t


@pytest.mark.skipif(not hasattr(climb, "signatures"), reason="nothing is compiled in this run")
def test_no_value_is_compiled_for_anew():
    """A whole number in place of a fraction, too."""
    run(DEFAULTS)
    before = specialisations()
    whole = {"step_px": 2, "step_depth": 1, "lengthen": 2, "turn": -1, "least_step": 0, "climb_first_steps": (1, 1, 1)}
    run(settings(**whole, hidden_cost=1, ring_px=1, ring_width_px=2, ring_visible=0, least_cosine=0))
    run(settings(edge_vote=2, seam_vote=0, edge_beyond=1, border_px=1, point_sigma_px=1, joint_sigma=1, shift_sigma=1))
    assert specialisations() == before


@pytest.mark.uncompiled
@pytest.mark.parametrize(
    "values, which",
    [
        ({"inside": (2.0, -0.3, -3.5)}, 0),
        ({"rim": (0.0, 0.0, 0.0)}, 0),
        ({"ring": (-1.0, 0.0, 0.1)}, 0),
        ({"ring_width_px": 3.0}, 0),
        ({"step_px": 4.0}, 1),
        ({"turn": -0.2}, 1),
        ({"lengthen": 3.0}, 1),
        ({"least_step": 0.9}, 1),
        ({"fine_reach_px": (2,)}, 2),
        ({"most_shift": 0.001}, 2),
        ({"edge_vote": 0.3}, 2),
        ({"edge_prior_width": 0.2}, 2),
        ({"edge_beyond": 0.02}, 2),
    ],
    ids=str,
)
def test_each_value_reaches_what_it_is_for(values, which):
    usual, changed = run(DEFAULTS), run(settings(**values))
    assert not np.array_equal(usual[which], changed[which])
    for before in range(which if which < 2 else 0):
        np.testing.assert_array_equal(usual[before], changed[before])
