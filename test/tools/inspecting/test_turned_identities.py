"""Identities of which one, turned, shows what the other does."""

import pytest

from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.inspecting.turned_identities import turned_identities

FOUR = """
format: artrec_object/1
name: plate
markers:
  hub: {{disc: {{radius: 0.02}}}}
  dot: {{disc: {{radius: 0.01}}}}
components:
  hub: {{required: true, label: 1, markers: {{hub: {{pose: {{xyz: [0, 0, 0]}}}}}}}}
  e: {{classes: {{g: 2, r: 3}}, markers: {{dot: {{pose: {{xyz: [0.05, 0, 0]}}}}}}}}
  n: {{classes: {{g: 2, r: 3}}, markers: {{dot: {{pose: {{xyz: [0, 0.05, 0]}}}}}}}}
  w: {{classes: {{g: 2, r: 3}}, markers: {{dot: {{pose: {{xyz: [-0.05, 0, 0]}}}}}}}}
  s: {{classes: {{g: 2, r: 3}}, markers: {{dot: {{pose: {{xyz: [0, {south}, 0]}}}}}}}}
identities:
  one: {{e: g, n: r, w: r, s: r}}
  two: {{e: r, n: g, w: r, s: r}}
  three: {{e: g, n: g, w: g, s: r}}
"""


@pytest.mark.parametrize(("south", "turned"), [(-0.05, True), (-0.09, False)])
def test_one_that_is_another_turned_is_told(tmp_path, south, turned):
    path = tmp_path / "plate.yaml"
    path.write_text(FOUR.format(south=south), encoding="utf-8")
    lines = list(turned_identities(load_object(path)))
    assert len(lines) == turned
    assert not turned or ("'one'" in lines[0] and "'two'" in lines[0] and "degrees" in lines[0])


@pytest.mark.parametrize(("south", "said"), [(-0.05, "nothing tells"), (-0.054, "places that differ by 3 mm")])
def test_places_that_differ_a_little_tell_which_it_is(tmp_path, south, said):
    path = tmp_path / "plate.yaml"
    path.write_text(FOUR.format(south=south), encoding="utf-8")
    (line,) = turned_identities(load_object(path))
    assert said in line
