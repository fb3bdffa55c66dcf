"""Votes of labels in each role."""

import numpy as np
from settings import DEFAULTS
from solids import BODY, RED

from artrec_ros.core.image.codes import LABELS, OUTSIDE, OWNED, UNKNOWN
from artrec_ros.core.pose.votes import VoteRoles

OWN, HULL = (RED,), (BODY,)


def test_each_role_is_listed_once():
    roles = VoteRoles(DEFAULTS.votes, LABELS)
    asked = [roles.inside(OWN), roles.rim(OWN), roles.ring(OWN, ()), roles.ring(OWN, HULL), roles.body(HULL, OWN)]
    assert asked == [0, 1, 2, 3, 4]
    assert [roles.inside(OWN), roles.body(HULL, OWN), roles.inside((7,))] == [0, 4, 5]
    assert roles.table.shape == (6, 256) and roles.table.dtype == np.float32


def test_what_each_place_says():
    roles = VoteRoles(DEFAULTS.votes, LABELS)
    names = ("inside", "rim", "ring", "ring_on_body", "body")
    index = (roles.inside(OWN), roles.rim(OWN), roles.ring(OWN, ()), roles.ring(OWN, HULL), roles.body(HULL, OWN))
    votes = dict(zip(names, roles.table[list(index)], strict=True))
    for row in votes.values():
        assert row[OUTSIDE] == 0
        assert abs(row[OWNED]) <= 0.3 and abs(row[UNKNOWN]) < 2
        assert np.abs(row).max() <= 4.5  # no pixel decides alone
    for name in ("inside", "rim"):
        assert votes[name][RED] > 0 > votes[name][UNKNOWN] > votes[name][BODY] == votes[name][7]
    for name in ("ring", "ring_on_body"):  # one's own colour outside of an outline refutes it
        assert votes[name].argmin() == RED
    assert votes["ring"][7] >= 0 and votes["ring_on_body"][BODY] > 0 > votes["ring_on_body"][7]
    assert votes["body"][BODY] > 0 > votes["body"][RED] > votes["body"][7]


def test_a_body_of_unknown_colour_says_nothing():
    roles = VoteRoles(DEFAULTS.votes, LABELS)
    role = roles.body((), OWN)
    assert not roles.table[role].any()


def test_a_body_of_the_markers_own_colour_is_no_contradiction():
    roles = VoteRoles(DEFAULTS.votes, LABELS)
    body, ring = roles.body(OWN, OWN), roles.ring(OWN, OWN)
    assert roles.table[body, RED] > 0
    assert roles.table[ring, RED] < 0
