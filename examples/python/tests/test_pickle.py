"""Scenes that are pickled, and copied: the same picture bit for bit, and the same from then on."""
import copy
import multiprocessing
import pickle

import numpy as np
import pytest

import insonify as us
from insonify import mm, tissue


def anatomy():
    """Structured muscle, with fibres, around a bone, a nerve and a vein; an object was removed."""
    body = us.scene(tissue.fat)
    body.set_background_fibres((0, 1, 0), (1, 0, 1))
    gone = [body.add(us.make_sphere((0, 0, 0), 1 * mm), tissue.bone) for _ in range(3)]
    body.add(us.make_sphere((0, 0, 22 * mm), 16 * mm, 4), tissue.muscle, name="muscle", fibres=(1, 0, 0.2), layer_normal="own_surface")
    body.remove(gone[0])
    body.remove(gone[2])
    body.add(us.make_sphere((0, 0, 0), 5 * mm, 3), tissue.bone, name="bone", at=us.pose(translation=(6 * mm, 0, 30 * mm)), priority=3, crease_angle=0)
    body.add(us.make_sphere((0, 0, 0), 2 * mm), tissue.air, name="hidden by the bone", at=us.pose(translation=(6 * mm, 0, 29 * mm)))
    body.add(us.make_cylinder((-6 * mm, -30 * mm, 17 * mm), (-6 * mm, 30 * mm, 17 * mm), 3 * mm), tissue.nerve, name="nerve")
    body.remove(body.add(us.make_sphere((0, 0, 0), 1 * mm), tissue.bone))
    return body.build()


def draw(body):
    how = us.b_mode_settings(depth=45 * mm, size=(120, 0), planes=1)
    return us.b_mode(body, us.linear_array(lines=64), us.pose(), how).pixels


def write(body, name, change):
    body.positions(body.find(name))[:] += change
    body.update()


def moved(body):
    write(body, "bone", [0, 0, -2 * mm])
    write(body, "muscle", np.linspace(0, 1 * mm, len(body.positions(body.find("muscle"))))[:, None] * [1, 0, 0])
    body.place(body.find("nerve"), us.pose(translation=(1 * mm, 0, 1 * mm)))


def filled(body):
    moved(body)
    write(body, "muscle", [0, 0, 1 * mm] * (np.arange(len(body.positions(body.find("muscle")))) % 2)[:, None])
    body.set_medium(body.find("muscle"), tissue.tendon)
    body.set_medium(body.find("bone"), tissue.muscle)
    write(body, "muscle", [1 * mm, 0, 0])


def larger(body):
    """Of overlapping objects the one that was smaller when they were built gives the medium."""
    nerve = body.find("nerve")
    body.positions(nerve)[:, ::2] = (body.positions(nerve)[:, ::2] - [-6 * mm, 17 * mm]) * 3.5 + [-6 * mm, 17 * mm]
    body.update()


def returned(body):
    body.deform(us.breathing(amplitude=3 * mm, time=1))
    body.deform(us.pulsation(radius=3 * mm, amplitude=0.3 * mm, time=0.1), only=[body.find("nerve")])
    body.deform(us.compose())


def deformed_and_moved(body):
    moved(body)
    body.deform(us.breathing(amplitude=3 * mm, time=1), only=[body.find("muscle"), body.find("nerve")])
    body.deform(us.compose(), only=[body.find("nerve")])
    body.place(body.find("nerve"), us.pose(translation=(2 * mm, 0, 0)))
    write(body, "nerve", [0, 0, 1 * mm])


def held_across_build(body):
    vertices = body.positions(body.find("muscle"))
    vertices += [0, 0, 1 * mm]
    body.build()
    vertices[::2] += [1 * mm, 0, 0]
    body.update()


def built_again(body):
    returned(body)
    moved(body)
    body.deform(us.compose())
    body.remove(body.find("bone"))
    body.add(us.make_sphere((3 * mm, 0, 30 * mm), 4 * mm), tissue.air)
    body.build()
    body.set_medium(body.find("muscle"), tissue.tendon)


STATES = [lambda body: None, moved, filled, larger, returned, deformed_and_moved, held_across_build, built_again]


@pytest.mark.parametrize("copied", [lambda body: pickle.loads(pickle.dumps(body)), copy.copy, copy.deepcopy], ids=["pickle", "copy", "deepcopy"])
@pytest.mark.parametrize("state", STATES, ids=lambda state: state.__name__)
def test_a_copy_draws_the_same_picture(state, copied):
    body = anatomy()
    state(body)
    before = draw(body)
    other = copied(copied(body))  # a copy of a copy, too
    assert np.array_equal(draw(other), before) and len(np.unique(before)) > 1000
    assert other.background == body.background == tissue.fat
    assert other.names == body.names and other.media == body.media and other.is_built and other.box() == body.box()
    point = (1 * mm, 2 * mm, 20 * mm)
    assert all(other.rest_of(point, id) == body.rest_of(point, id) for id in body.names)
    for change in (lambda one: write(one, "nerve", [0, 0, 0.5 * mm]), lambda one: one.set_medium(one.find("nerve"), tissue.muscle),
                   lambda one: one.deform(us.breathing(amplitude=2 * mm, time=1)), lambda one: one.deform(us.compose()), lambda one: one.build()):
        change(body)
        change(other)
        assert np.array_equal(draw(other), draw(body))
    assert other.add(us.make_sphere((0, 0, 0), 1 * mm), tissue.bone) == body.add(us.make_sphere((0, 0, 0), 1 * mm), tissue.bone)


@pytest.mark.parametrize("layers", [(1, 0, 1), (0, 0, 1), "own_surface"], ids=str)
def test_layers_of_an_object_are_pickled(layers):
    def muscle(**given):
        body = us.scene(tissue.fat)
        body.add(us.make_sphere((0, 0, 22 * mm), 16 * mm, 4), tissue.muscle, fibres=(0, 1, 0), **given)
        return body.build()

    body = muscle(layer_normal=layers)
    assert np.array_equal(draw(pickle.loads(pickle.dumps(body))), draw(body))
    assert layers == (0, 0, 1) or not np.array_equal(draw(body), draw(muscle(layer_normal=(0, 0, 1))))


@pytest.mark.parametrize("state", [moved, filled], ids=lambda state: state.__name__)
def test_another_process_draws_the_same_picture(state):
    body = anatomy()
    state(body)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert np.array_equal(pool.apply(draw, [body]), draw(body))


def test_a_scene_that_is_not_built_yet_is_pickled():
    body = anatomy()
    write(body, "bone", [0, 0, 1 * mm])
    body.add(us.make_sphere((0, 0, 20 * mm), 2 * mm), tissue.air, name="gas")
    body.remove(body.find("nerve"))
    other = pickle.loads(pickle.dumps(body))
    assert not other.is_built and other.names == body.names
    assert np.array_equal(draw(other.build()), draw(body.build()))
    assert pickle.loads(pickle.dumps(us.scene(tissue.air))).is_built is False


def test_attributes_are_copied_and_arrays_that_are_held_are_not():
    body = anatomy()
    held, body.notes = body.positions(body.find("bone")), ["left leg"]
    for copied in (copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))):
        other = copied(body)
        assert other.notes == ["left leg"] and (other.notes is body.notes) == (copied is copy.copy)
        other.remove(other.find("bone"))
    held[:, 2] += 1 * mm
    body.update()
    with pytest.raises(us.usage_error, match="still in use"):
        body.remove(body.find("bone"))


def test_what_cannot_be_done_again_is_refused_with_what_to_do():
    body = anatomy()
    body.deform(us.breathing(amplitude=3 * mm, time=1))
    with pytest.raises(us.usage_error, match=r"deformed cannot be pickled: call deform\(compose\(\)\) first"):
        pickle.dumps(body)
    body.deform(us.compose())
    assert np.array_equal(draw(pickle.loads(pickle.dumps(body))), draw(body))
    body.deform(us.breathing(amplitude=3 * mm, time=1))
    for change in (lambda: body.set_medium(body.find("muscle"), tissue.tendon), body.build):
        change()
        body.deform(us.compose())
        with pytest.raises(us.usage_error, match=r"call deform\(compose\(\)\) and build\(\) first"):
            pickle.dumps(body)
        body.build()
        assert np.array_equal(draw(pickle.loads(pickle.dumps(body))), draw(body))
        body.deform(us.breathing(amplitude=3 * mm, time=1))
    with pytest.raises(us.usage_error, match="no object has the id 99"):
        body.deform(us.compose(), only=[99])
    with pytest.raises(us.usage_error, match="deformed cannot be pickled"):
        pickle.dumps(body)
