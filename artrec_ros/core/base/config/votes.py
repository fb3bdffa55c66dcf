"""Room `pose`: what a pixel's label says for and against a hypothesis."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param

_WHOLE = ("space", "facing")


@dataclass(frozen=True)
class VotesConfig(Room):
    """What pixels say, in natural logarithms of how much likelier a label is on a piece of the model than elsewhere.

    Lists are votes of a piece's own label, of unknown pixels and of any other label, each of them clipped, so that no
    pixel decides alone.
    """

    inside: tuple[float, ...] = param(
        (4.0, -0.3, -3.5),
        "on a marker",
        low=-20,
        high=20,
        length=3,
        paths=_WHOLE,
        origin="unknown says little: shade and seams make a third to a half of a real surface unknown; each by a "
        "third: right between -1 and +4 of 244, unknown at 4/3: found -3; its own label at 2/3 facing: -5 of 197",
    )
    inside_empty: float = param(
        -2.0,
        "on a marker, unknown pixels that are farther from all known ones than a seam is wide",
        low=-20,
        high=20,
        paths=_WHOLE,
        origin="of markers in label images 0.001 of the pixels are such, of the images a third: ln 0.003, clipped, for "
        "a highlight or a shadow may blot out half of a marker",
    )
    rim: tuple[float, ...] = param(
        (2.0, -1.2, -1.5),
        "just inside of a marker's outline: what keeps a model from outgrowing its blob",
        low=-20,
        high=20,
        length=3,
        paths=_WHOLE,
        origin="each by a third: right between +0 and +5 of 244; its own label at 2/3: found -6, facing: right -15 "
        "of 197",
    )
    ring: tuple[float, ...] = param(
        (-4.0, 0.0, 0.3),
        "just outside of a marker whose surroundings are not declared; its own label first",
        low=-20,
        high=20,
        length=3,
        paths=_WHOLE,
        origin="its own label outside speaks as strongly as another inside; each by a third: right between -2 and +0 "
        "of 244",
    )
    ring_on_body: tuple[float, ...] = param(
        (-4.0, 0.0, -1.5),
        "just outside of a marker that lies on a declared body; its own label first",
        low=-20,
        high=20,
        length=3,
        paths=_WHOLE,
        origin="each by a third: right between -1 and +2 of 244",
    )
    ring_body_label: float = param(
        0.6,
        "the body's label just outside of a marker that lies on it",
        low=-20,
        high=20,
        paths=_WHOLE,
        origin="a little less than on the body's face; 2/3: right +0 of 244, 4/3: +1",
    )
    body: tuple[float, ...] = param(
        (0.7, -0.2, -2.0),
        "on a body's face",
        low=-20,
        high=20,
        length=3,
        paths=_WHOLE,
        origin="a third of a marker's and less: bodies are large, plain, and like other things",
    )
    body_marker_label: float = param(
        -1.0,
        "the markers' label on a body's face",
        low=-20,
        high=20,
        paths=_WHOLE,
        origin="half of what another label says; 2/3: right +1 of 244, 4/3: +0",
    )
    shared: tuple[float, ...] = param(
        (0.2, 0.7),
        "share of a marker that lies on a likelier one of its class, of the same object, from which on the rest of it "
        "must bear the class, and by which share: else the other one explains what it shows, and nothing says that it "
        "is there",
        low=0,
        high=1,
        length=2,
        paths=_WHOLE,
        origin="drawn legs of one of which no foot is seen, 120 pictures: told on the other's foot in 6; with 0.6 and "
        "0.8 in place of 0.7 8 and 5, with 0.1 and 0.4 in place of 0.2 2 and 16; puppets of 121: with 0.1 1 less right",
    )
    hidden_cost: float = param(
        0.5,
        "votes per pixel that a component costs which should be seen and is not",
        low=0,
        high=20,
        paths=_WHOLE,
        origin="low, for what hides it need not be modelled; 2/3: right +0 of 244, 4/3: +0",
    )
    ring_px: float = param(
        1.25,
        "rim and ring are looked at so far inside and outside of an outline",
        unit="px",
        low=0.1,
        high=20,
        paths=_WHOLE,
        origin="outside of the seam that a segmenter leaves between two colours; 2/3 facing: right -9 of 197, 4/3: -1",
    )
    ring_share: float = param(
        0.03,
        "of markers wider than 2 ring_px / ring_share rim and ring are looked at by this share of half their width "
        "inside and outside of the outline",
        low=0,
        high=0.3,
        paths=_WHOLE,
        origin="files, calibrations and fits are off by shares of a marker's size: a plate 200 px wide in a webcam was "
        "told in 19 of 41 pictures without, in 41 with, and right in 18 and 37",
    )
    ring_width_px: float = param(
        1.5,
        "what a point of the ring stands for across the outline",
        unit="px",
        low=0.1,
        high=20,
        paths=_WHOLE,
        origin="from the outline to a little beyond ring_px; 2/3: right +1 of 244, facing: -7 of 197; 4/3: +3 and +1",
    )
    ring_visible: float = param(
        0.5,
        "share of what its own object leaves of a marker that others must not hide for its rim and ring to vote",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="else most of the outline is not the one in the image",
    )
    point_px: float = param(
        6.0,
        "points of a large marker at which labels are looked up are about so far apart in the image; there are 36 to "
        "144",
        unit="px",
        low=1,
        high=1000,
        paths=("space",),
        origin="36 points are as far apart in a marker of 36 x 36 pixels, for which they are enough; drawn books of "
        "two panels: 90 % of places within 1.4 for 1.9 % of the range; cabinets turned wrong: 1 of 90 for 3; "
        "quadrupeds: right .965 for .965, with 144 points for every marker .959",
    )
    least_cosine: float = param(
        0.12,
        "cosine of the viewing angle below which a patch shows nothing",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="83 degrees: a marker of 16 px is then 2 px wide",
    )
    supported_agree: float = param(
        0.4,
        "least share of a marker's pixels with its label for the labels to support it",
        low=0,
        high=1,
        paths=_WHOLE,
        origin="half of a shaded marker is unknown; 2/3: right -2 of 244, 4/3: -2, found -3",
    )
