import numpy as np
import pytest

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene
from artrec_ros.simulation.truth import measure

from .test_render import plate

FACING = np.array([[0, 1, 0], [0, 0, -1], [-1, 0, 0]], float)  # the object's x towards the camera, z up


def observe(target, camera, *distractors, at=(0.02, 0.01, 0.9)):
    placed = PlacedObject(target, Pose(FACING, np.array(at)), {"arm": 0.0})
    rendering = Renderer(camera).render(Scene((placed,), distractors, None))
    (truth,) = measure(rendering, (placed,), camera)
    return truth


def test_a_free_marker_shows_all_of_itself_where_it_projects(target, camera):
    truth = observe(target, camera)
    (front,) = truth.markers  # the arm's ribbon is seen edge on
    assert (front.component, front.marker) == ("base", "front")
    depth = 0.9 - 0.0505
    assert front.full_px == pytest.approx((camera.matrix[0, 0] * 0.08 / depth) ** 2)
    assert front.visible_share == pytest.approx(1, abs=0.05)
    np.testing.assert_allclose(front.centre, project(camera, np.array([0.02, 0.01, depth])), atol=0.2)
    np.testing.assert_allclose(front.tail, project(camera, np.array([-0.02, 0.01, depth])), atol=1e-9)
    np.testing.assert_allclose(front.head, project(camera, np.array([0.06, 0.01, depth])), atol=1e-9)
    np.testing.assert_allclose(truth.centre_px, project(camera, np.array([0.02, 0.01, 0.9])))


def test_what_stands_before_it_takes_from_what_shows_but_not_from_the_whole(target, camera):
    free = observe(target, camera).markers[0]
    half = observe(target, camera, plate(-0.09, 0.0, 0.7, 0.2, 4)).markers[0]
    assert half.full_px == free.full_px
    assert 0.2 < half.visible_share < 0.8
    assert half.centre[0] > free.centre[0] + 1


def test_a_hidden_marker_has_no_centre(target, camera):
    hidden = observe(target, camera, plate(0, 0, 0.5, 0.5, 4)).markers[0]
    assert hidden.visible_px == 0 and hidden.centre is None and hidden.bounds is None and hidden.full_px > 0


def test_the_part_outside_the_image_counts_as_not_visible(target, camera):
    edge = observe(target, camera, at=(-0.5, 0, 0.9)).markers[0]
    assert 0 < edge.visible_share < 0.9
