"""Room `learning`: constraints, classes and colours from examples. Offline: not in parameter files."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class LearningConfig(Room):
    """What `artrec train` and `artrec learn-colours` take for granted about examples."""

    least_width: float = param(
        0.02,
        "width below which a box is not resolved: radians, shares of a ratio, of a pair's greatest distance, of a "
        "sliding joint's range",
        low=0,
        high=1,
        origin="what a pixel tells of a marker of 50 px",
    )
    near_zero: float = param(
        0.15,
        "centroids closer than this share of a marker's size have no direction from one to the other",
        low=0,
        high=1,
        origin="the direction would be uncertain by more than 10 degrees at 50 px",
    )
    folded: float = param(
        0.8,
        "equal sides of a marker are told apart unless their directions fill less than this share of its symmetry's "
        "period",
        low=0,
        high=1,
        origin="a span that fills the period says nothing",
    )
    greatest_margin: float = param(
        2.0,
        "greatest margin of a box, in its widths",
        low=0,
        high=100,
        origin="examples too few for more are reported as such",
    )
    most_colours: int = param(
        8,
        "reference colours of a class at most",
        low=1,
        high=100,
        origin="a marker's own in three lights, clipped, in shade, and its glare",
    )
    most_background: int = param(
        16,
        "the same of the background",
        low=1,
        high=100,
        origin="it holds a bit of everything",
    )
    clusters: int = param(
        12,
        "clusters of a class' samples, whose centres may become reference colours",
        low=1,
        high=100,
        origin="half as many again as references",
    )
    draws: int = param(
        4,
        "draws of samples that reference colours are learned from with each weight of the background; the best is kept",
        low=1,
        high=1000,
        origin="with overhead robots two draws of six lost half of a class's pixels; a tenth of a second each",
    )
    clusters_background: int = param(
        20,
        "the same of the background",
        low=1,
        high=100,
        origin="as of a class",
    )
    least_share: float = param(
        0.02,
        "least share of the samples that such a cluster must hold",
        low=0,
        high=1,
        origin="smaller ones are wrong samples and blends",
    )
    least_gain: float = param(
        0.001,
        "cross-entropy by which a reference colour must lower the mean over all samples to be taken",
        low=0,
        high=1,
        origin="small robots in changing light: with half of it three more references, one robot in 100 more",
    )
    weights_background: tuple[float, ...] = param(
        (3.0, 1.0, 0.3),
        "weights of the background's samples that are tried, in those of a class",
        low=0.01,
        high=100,
        origin="overhead robots in changing light, learned from five pictures drawn by chance: of 1,320 in the others "
        "1,187 are right with 3 alone, 1,306 with all",
    )
    share_other_light: float = param(
        0.3,
        "share of a class' samples that are also looked at as they would be in each other light",
        low=0,
        high=1,
        origin="small robots in changing light",
    )
    least_samples: int = param(
        20,
        "pixels that a class, or a colour of the background, needs",
        low=1,
        high=100000,
        origin="fewer have no median worth the name",
    )
    margin_px: int = param(
        1,
        "pixels so near to an edge of their class are no samples",
        unit="px",
        low=0,
        high=50,
        origin="they are blends of two colours",
    )
    beside_px: float = param(
        2.0,
        "pixels of the background nearer to a marked marker are no samples of what lies beside markers",
        unit="px",
        low=0,
        high=50,
        origin="an edge's blur, and a pixel",
    )
    beside_share: float = param(
        0.33,
        "what lies beside markers reaches so far off, as a share of the width of the median one",
        low=0.01,
        high=10,
        origin="of 61 real T-shaped markers on coloured plates 44 are found with it and limits of the scale, 32 with "
        "1.0, and 9 where nothing lies beside",
    )
    sharp_px: float = param(
        0.6,
        "standard deviation of the blur of edges from which on it is undone",
        unit="px",
        low=0,
        high=10,
        origin="drawn squares of 8 to 24 px: of .5 px of blur .36 to .40 is measured, of .7 px .62 to .66, of 1 px .89 "
        "to .95; classes' outlines in JPEG files scatter by .42 px at .8 px of blur, undone by .20",
    )
    most_blur_px: float = param(
        4.0,
        "standard deviation of the blur of edges up to which it is undone",
        unit="px",
        low=0,
        high=4,
        origin="the most that image.blur_px may be",
    )
    least_edge: float = param(
        0.02,
        "gradient of an edge that blur is measured at, share of full scale a pixel",
        low=0,
        high=1,
        origin="five times that of noise of 1 in 255",
    )
    strong_edges: float = param(
        0.25,
        "share of the edges near what is marked that blur is measured at, the strongest",
        low=0,
        high=1,
        origin="markers' outlines; the rest is texture and compression",
    )
    edge_reach_px: float = param(
        3.0,
        "how far in and out of marked outlines values are compared to tell gamma",
        unit="px",
        low=1,
        high=20,
        origin="beyond the blur of an edge, short of a neighbour's",
    )
    edge_step: float = param(
        0.16,
        "values inside must be brighter by so much, share of full scale",
        low=0,
        high=1,
        origin="blends of less are told by noise",
    )
    gamma_gain_px: float = param(
        0.1,
        "by how much nearer to marked outlines edges must lie with gamma 2.2 than with 1",
        unit="px",
        low=0,
        high=10,
        origin="what marking is worth; drawn vehicles whose light is blended: .42 and .07 px off; robots drawn of "
        "blended values: .05 and .15 px; two real cameras .40 and .11, .14 and .18 px",
    )
    margin_unknown_px: int = param(
        4,
        "the same of what is not labelled",
        unit="px",
        low=0,
        high=50,
        origin="around what is labelled lie pixels of it that are not",
    )
