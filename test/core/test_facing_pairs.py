"""Objects whose markers lie many radii from a small one that is required: its own pixels tell no scale that is good
enough to find them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scene import disc
from settings import settings
from squares import TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.range_limits import ScaleLimits
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.directions import Directions
from artrec_ros.core.pose.facing_guesses import FacingGuesser
from artrec_ros.core.pose.facing_pairs import FacingPairs
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer

BALL = disc("ball", 0.043)
GLOW = 1.25  # so much larger balls look than they are: by a pixel all around
NEAR = {"left": (-0.273, 0.075), "right": (0.259, -0.036)}
FAR = {"shoulder": (-0.217, 1.113), "neck": (0.197, 0.979), "other": (0.501, 1.052)}


def balls(others):
    """One amid others, all of one class."""
    at = {"hip": (0.0, 0.0), **others}
    markers = {n: replace(BALL, T_component_marker=Pose(np.eye(3), np.array([*xy, 0.0]))) for n, xy in at.items()}
    return ObjectModel("walker", tuple(Component(n, (m,), required=n == "hip") for n, m in markers.items()))


class Walker(Placing):
    """Beside other balls, which are nobody's."""

    def patches(self):
        places = [(0.0, 0.0), *NEAR.values(), *FAR.values(), (-0.5, -0.44), (0.13, -0.54), (-0.22, -1.19), (0.4, -1.0)]
        return [(self.at(GLOW * BALL.outline + at), TEAM) for at in places]


@pytest.mark.parametrize("scale", [75.0, 92.0])
def test_balls_many_radii_away_are_found(scale):
    """Of 3 and 4 px: the farthest is 27 radii away."""
    rng = np.random.default_rng(int(scale))
    engine = Recognizer(
        (Target("walker", balls({**NEAR, **FAR}), TEAM),),
        settings(time_budget_ms=60000, min_scale=45.0, max_scale=155.0),
        Segmenter(ImageConfig()),
    )
    for turn in rng.uniform(-np.pi, np.pi, 6):
        walker = Walker(160 + rng.uniform(), 150 + rng.uniform(), turn, scale)
        found = engine.recognize(rendered(walker, size=(320, 300), fine=4)).detections
        best = max(found, key=lambda d: d.score)
        parts = {part.component: np.array([part.x, part.y]) for part in best.components}
        for name, at in {**NEAR, **FAR}.items():
            assert np.linalg.norm(parts[name] - walker.at([at])[0]) < BALL.radius * scale, (walker, name)


CARD = {"left": (0.0, 0.43), "right": (0.0, -0.43), "tail": (-1.27, 0.0)}
SQUARE, BAR = ([(-x, -y), (x, -y), (x, y), (-x, y)] for x, y in ((0.04, 0.04), (0.06, 0.03)))


def card(outline):
    """Three like patches far apart."""
    poses = {name: Pose(np.eye(3), np.array([*at, 0.0])) for name, at in CARD.items()}
    return ObjectModel(
        "card", tuple(Component(n, (patch(n, outline, T),), required=n == "left") for n, T in poses.items())
    )


@dataclass(frozen=True)
class Card(Placing):
    outline: object = None

    def patches(self):
        return [(self.at(np.array(self.outline) + at), TEAM) for at in CARD.values()]


@pytest.mark.parametrize("outline", [SQUARE, BAR])
@pytest.mark.parametrize("limits", [{"min_scale": 90.0, "max_scale": 111.0}, {}])
def test_small_patches_far_apart_are_found_whatever_their_outline(outline, limits):
    """Of 8 px, and of 12 by 6, as a camera would show them: exact outlines, nothing else in view."""
    rng = np.random.default_rng(3)
    config = settings(time_budget_ms=60000, **limits)
    engine = Recognizer((Target("card", card(outline), TEAM),), config, Segmenter(ImageConfig()))
    for turn in rng.uniform(-np.pi, np.pi, 8):
        placed = Card(180 + rng.uniform(), 170 + rng.uniform(), turn, 100.0, outline=outline)
        best = max(engine.recognize(rendered(placed, size=(360, 340), fine=4)).detections, key=lambda d: d.score)
        assert best.score > 0.9
        parts = {part.component: np.array([part.x, part.y]) for part in best.components}
        for name, at in CARD.items():
            assert np.linalg.norm(parts[name] - placed.at([at])[0]) < 1.0, (placed, name)


def pairs_of(model, **values):
    config = settings(**values)
    finder = WholeObjectFinder(Target("walker", model, TEAM), config, facing=True)
    directions = Directions.about_required(finder, config)
    guesser = FacingGuesser(model, finder.surface, config, finder.root, directions.laid)
    return FacingPairs(finder, guesser, config, directions.kept)


def test_only_those_are_paired_that_half_a_step_of_the_scale_would_miss():
    pairs = pairs_of(balls({**NEAR, **FAR}))
    assert np.allclose(np.linalg.norm(pairs._arms, axis=1), [np.hypot(*at) for at in FAR.values()])
    assert not len(pairs_of(balls(NEAR))._arms)


def test_larger_ones_are_paired_too():
    """A fit to the contour of a square of 32 px is as exact as the file's outline, no more."""
    pairs, limits = pairs_of(card(SQUARE)), ScaleLimits(20.0, 1000.0)
    for scale in (100.0, 400.0):
        picture = rendered(Card(600, 250, 0.3, scale, outline=SQUARE), size=(800, 600), fine=2)
        frame = ImageFrame(LabelField(picture)).faced()
        blobs = find_blobs(picture, {TEAM}, settings())
        _, of = pairs.guess(frame, blobs, blobs, limits)
        assert len(blobs) == len(CARD)
        assert set(of.tolist()) == {0, 1, 2}


def test_amid_too_many_like_blobs_what_has_an_outline_is_not_paired():
    picture = rendered(Card(600, 250, 0.3, 100.0, outline=SQUARE), size=(800, 600), fine=2)
    frame, blobs = ImageFrame(LabelField(picture)).faced(), find_blobs(picture, {TEAM}, settings())
    limits = ScaleLimits(20.0, 1000.0)
    assert len(pairs_of(card(SQUARE), most_pairs=30).guess(frame, blobs, blobs, limits)[0])
    assert not len(pairs_of(card(SQUARE), most_pairs=1).guess(frame, blobs, blobs, limits)[0])


BOARD = {"nw": (-1.9, 2.7), "n": (0.0, 2.8), "ne": (1.8, 2.8), "sw": (-1.8, -2.3), "s": (0.1, -2.3), "se": (1.9, -2.3)}
PATCH, GLOWING, LARGER = (
    [(-x, -y), (x, -y), (x, y), (-x, y)] for x, y in ((0.11, 0.08), (0.115, 0.085), (0.115, 0.095))
)


def board():
    """Seven like patches, ten widths and more apart."""
    poses = {name: Pose(np.eye(3), np.array([*at, 0.0])) for name, at in {"mid": (0.0, 0.0), **BOARD}.items()}
    return ObjectModel(
        "board", tuple(Component(n, (patch(n, PATCH, T),), required=n == "mid") for n, T in poses.items())
    )


@dataclass(frozen=True)
class Board(Placing):
    """As it looks: half a pixel larger all around, the required patch two pixels higher than that."""

    strays: object = ()

    def patches(self):
        own = [np.array(LARGER), *(np.array(GLOWING) + at for at in BOARD.values())]
        return [*((self.at(outline), TEAM) for outline in own), *((np.array(stray), TEAM) for stray in self.strays)]


@pytest.mark.parametrize("limits", [{"min_scale": 85.0, "max_scale": 115.0}, {}])
def test_a_required_outline_that_is_off_by_a_tenth_loses_nothing(limits):
    """22 by 16 px in the file, 23 by 19 in the image: by that scale the others lie 30 px beside their pixels."""
    config = settings(time_budget_ms=60000, **limits)
    engine = Recognizer((Target("board", board(), TEAM),), config, Segmenter(ImageConfig()))
    for turn in (0.0, 0.35, -0.9):
        placed = Board(340.0, 340.0, turn, 100.0)
        (found,) = engine.recognize(rendered(placed, size=(680, 680), fine=2)).detections
        parts = {part.component: np.array([part.x, part.y]) for part in found.components}
        assert found.score > 0.9 and set(parts) == {"mid", *BOARD}
        for name, at in BOARD.items():
            assert np.linalg.norm(parts[name] - placed.at([at])[0]) < 2.0, (turn, name)


def test_where_no_other_component_is_met_it_is_said_that_limits_may_be_off():
    config = settings(time_budget_ms=60000, min_scale=112.0, max_scale=130.0)
    engine = Recognizer((Target("board", board(), TEAM),), config, Segmenter(ImageConfig()))
    result = engine.recognize(rendered(Board(340.0, 340.0, 0.35, 100.0), size=(680, 680), fine=2))
    assert not result.detections
    assert any("limits of the scale, or the outline of mid, may be off" in r.reason for r in result.rejected)


def test_amid_many_like_blobs_those_pairs_go_on_under_which_others_are_where_they_should_be():
    """A hundred strays make thousands of pairs; under the right ones five more patches lie on their pixels."""
    rng, placed = np.random.default_rng(5), Board(340.3, 340.6, 0.4, 100.0)
    corners = 100 * np.array(PATCH)
    grid = np.stack(np.meshgrid(np.arange(20, 680, 64), np.arange(20, 680, 64)), axis=-1).reshape(-1, 2)
    own = placed.at(np.array([(0.0, 0.0), *BOARD.values()]))
    strays = grid + rng.uniform(-15, 15, grid.shape)
    strays = strays[(np.linalg.norm(strays[:, None] - own, axis=2) > 40).all(axis=1)]
    picture = rendered(replace(placed, strays=[corners + at for at in strays]), size=(680, 680), fine=2)
    frame, blobs = ImageFrame(LabelField(picture)).faced(), find_blobs(picture, {TEAM}, settings())
    limits = ScaleLimits(50.0, 200.0)
    every = pairs_of(board(), most_pairs=1000000).guess(frame, blobs, blobs, limits)[0]
    few, of = pairs_of(board(), most_pairs=100).guess(frame, blobs, blobs, limits)
    assert len(blobs) > 80 and 0 < len(few) < len(every) / 10
    mine = int(np.argmin([np.linalg.norm(b.box.mean(axis=0) - own[0]) for b in blobs]))
    scale = frame.camera.focal_px / few.t[of == mine, 2]
    assert (abs(scale - placed.scale) < 2.0).any()
