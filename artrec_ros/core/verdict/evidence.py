"""What speaks for a claim: numbers from which curves make a probability (acceptance.py)."""

from __future__ import annotations

from typing import NamedTuple


class Evidence(NamedTuple):
    """What speaks for a claim; the more of each, the likelier it is an object.

    :param size: logarithm of all its votes: much is seldom alike by chance.
    :param edge: how well the required marker's outline parts its class from others: 1 all around, 0 or less nowhere.
    :param bare: 1 where no body of the required component that has a class is in view: none can speak for it.
    :param body: mean vote of the required component's bodies in view, which are around its marker; -2 where it is bare.
    :param shown: other components that something shows, be it too little to confirm them.
    :param colour: mean vote of the pixels of all markers that should be in view.
    :param others: the same of the other components' alone.
    :param edges: `edge` of the confirmed other components, the longer outlines counting more; 0 without.
    :param faces: the same of all components' bodies.
    :param facing: cosine of the angle under which the required marker is seen: squeezed, much looks like it.
    :param missing: less the logarithm of the pixels of markers that should be in view and are not confirmed.
    :param lacking: less the share of the pixels of all markers that should be in view whose components are not
        confirmed.
    :param rim: mean vote of what lies along the required marker's outline: about 1 where all of it is parted.
    :param parted: share of the required marker's outline that does not lie amid its class, of several the one that it
        shows.
    :param parts: the same of the confirmed other components, the longer outlines counting more; 0 without.
    :param known: less `Claims.known`: where few scales, or distances, are possible, few false claims are.
    :param even: how even its regions' raw colours are, as of `Seen`.
    :param faint: less `colour`: where codes are soft, the plainest marker gets few votes of a pixel.
    :param spare: by how many numbers the places of the confirmed components tell more than a pose and the joints
        between them have.
    :param distinct: less the logarithm of in how many ways as many of them as fix that pose could be taken for others
        that look like them; 0: all look different.
    """

    size: float
    edge: float
    bare: float
    body: float
    shown: float
    colour: float
    others: float
    edges: float
    faces: float
    facing: float
    missing: float
    lacking: float
    rim: float
    parted: float
    parts: float
    known: float
    even: float
    faint: float
    spare: float
    distinct: float
