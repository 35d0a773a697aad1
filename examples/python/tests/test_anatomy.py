"""Regions of the body by code."""
import copy
import pickle

import numpy as np
import pytest

import insonify as us
from insonify import anatomy, kHz, mm


@pytest.fixture(scope="module")
def neck():
    """A neck of coarse meshes, built. Tests that press it put it to rest again."""
    made = anatomy.make("neck", resolution=0.5, side=1)
    made.scene.build()
    return made


def draw(body, view, at):
    return us.b_mode(body.scene, view.probe, at, view.settings).pixels


def first_view(body):
    """Of few lines."""
    view = next(iter(body.views.values()))
    view.probe.lines, view.settings.size, view.settings.planes = 64, (96, 0), 1
    return view


def coarse(region):
    return {"resolution": 0.5} if any(one.name == "resolution" for one in anatomy.parameters(region)) else {}


def test_pictures_of_all_regions_equal_those_of_cpp_bit_for_bit(equals_cpp):
    pictures = []
    for region in anatomy.regions():
        body = anatomy.make(region, seed=5, **coarse(region))
        body.scene.build()
        view = first_view(body)
        pictures.append(draw(body, view, body.press(view)))
        assert pictures[-1].shape[1] == 96 and pictures[-1].std() > 0.05
    equals_cpp("regions", pictures)


def test_regions_and_what_varies_in_them():
    assert list(anatomy.regions()) == ["neck", "leg", "right_upper_quadrant", "lumbar", "nerve_block"] and anatomy.regions()["neck"] == "Neck, C5 to T1"
    found = {one.name: one for one in anatomy.parameters("neck")}
    fat, side = found["fat"], found["side"]
    assert (fat.unit, fat.min, fat.max) == ("m", np.float32(1.5 * mm), np.float32(8 * mm)) and fat.min < fat.default < fat.max and not fat.is_choice
    assert side.is_choice and (side.unit, side.min, side.max) == ("", 0, 1) and "0 left, 1 right" in side.description
    assert repr(fat) == "<fat: 0.0015 to 0.008 m (0.0028): thickness of the subcutaneous fat>"
    for region in anatomy.regions():
        titles = {name: view.title for name, view in anatomy.make(region, **coarse(region)).views.items()}
        assert list(anatomy.views(region).items()) == list(titles.items()) and titles


def test_values_are_given_and_drawn():
    drawn = [anatomy.make("neck", seed=seed, fat=6 * mm, resolution=0.3).values for seed in (7, 7, 8)]
    assert drawn[0] == drawn[1] != drawn[2]
    limits = {one.name: one for one in anatomy.parameters("neck")}
    for values in drawn:
        assert values.keys() == limits.keys() and values["fat"] == np.float32(6 * mm)
        assert all(limits[name].min <= value <= limits[name].max for name, value in values.items())
        assert values["side"] in (0, 1) and values["carotid"] != limits["carotid"].default
    usual = anatomy.make("neck", side=np.int64(1), resolution=0.3).values
    assert usual["side"] == 1 and usual["carotid"] == limits["carotid"].default
    assert anatomy.make("neck", seed=3).values["resolution"] == 1  # is not drawn


def test_errors_keep_their_sentences(neck):
    for call, sentence in ((lambda: anatomy.make("tail"), "there is no region 'tail'; known are neck, leg, right_upper_quadrant, lumbar, nerve_block"),
                           (lambda: anatomy.parameters("tail"), "there is no region 'tail'"), (lambda: anatomy.views("tail"), "there is no region 'tail'"),
                           (lambda: anatomy.make("neck", flavour=1), "neck: there is no parameter 'flavour'; known are side, "),
                           (lambda: anatomy.make("neck", fat=6), "neck: `fat` is 6 m; it must be from 0.0015 m to 0.008 m: thickness of the"),
                           (lambda: anatomy.make("neck", fat=float("nan")), "it must be from 0.0015 m"),
                           (lambda: anatomy.make("neck", side=0.5), "`side` is 0.5; it must be a whole number from 0 to 1"),
                           (lambda: neck.press("knee"), "there is no view 'knee'; known are carotid_transverse, ")):
        with pytest.raises(us.usage_error, match=sentence):
            call()
    with pytest.raises(TypeError, match="`fat` cannot be 'thick'; it is a number"):
        anatomy.make("neck", fat="thick")
    with pytest.raises(us.usage_error, match="build"):
        anatomy.make("nerve_block").press("nerve_block")
    with pytest.raises(TypeError):
        neck.views["mine"] = neck.views["thyroid"]


def test_the_probe_is_pressed_and_bone_stays(neck):
    view, skin = neck.views["thyroid"], neck.scene.find("skin")
    at = neck.press("thyroid")
    into = at.rotation[:, 2]
    assert view.pressed > 0 and np.allclose(np.subtract(at.translation, view.at.translation), view.pressed * into, atol=1e-7)
    assert np.array_equal(at.rotation, view.at.rotation)
    before = neck.scene.first_surface(tuple(np.add(at.translation, -20 * mm * into)), tuple(into), only=[skin])
    assert before.distance == pytest.approx(20 * mm, abs=0.2 * mm)  # the skin lies on the face
    moves = lambda one: np.linalg.norm(neck.scene.positions(one) - neck.scene.rest_positions(one), axis=1)
    pressed = {one: neck.scene.positions(one).copy() for one in neck.scene.names}
    rings = neck.scene.find("tracheal cartilages")
    of_skin, of_rings = moves(skin).max(), moves(rings).mean()
    body = [one for one, name in neck.scene.names.items() if name != "gel"]
    cartilage = us.tissue.cartilage
    stiff = [one for one, made_of in neck.scene.media.items()
             if made_of.sound_speed >= cartilage.sound_speed and made_of.attenuation >= cartilage.attenuation]
    neck.scene.deform(us.press(neck.scene, view.probe, at, only=body, is_stiff=stiff).deformation)
    assert len(stiff) > 5 and all(np.array_equal(neck.scene.positions(one), place) for one, place in pressed.items())
    neck.scene.deform(us.press(neck.scene, view.probe, at, only=body).deformation)
    print(f"skin moves by {of_skin / mm:.2f} mm, cartilage by {of_rings / mm:.2f} mm on average, if soft by {moves(rings).mean() / mm:.2f} mm")
    assert of_skin > 0.7 * view.pressed and of_rings < 0.75 * moves(rings).mean()
    view.pressed, old = 0, view.pressed
    assert neck.press(view) == view.at and neck.press("thyroid") == view.at  # it is the same view
    view.pressed = old
    neck.scene.deform(us.compose())
    assert not moves(skin).any()


def test_labels_name_what_is_seen(neck):
    assert neck.labels[neck.scene.find("skin")] == "skin" and neck.labels[us.background_label] == "background"
    assert len(set(neck.labels.values())) == len(neck.labels) == len(neck.scene.names) + 1
    view = copy.deepcopy(neck.views["carotid_transverse"])
    view.probe.lines = 96
    truth = us.ground_truth(neck.scene, view.probe, view.at, us.label_settings(depth=view.settings.depth, samples=300))
    seen = {neck.labels[label] for label in np.unique(truth.label.values)}
    print(sorted(seen))
    assert {"skin", "fat", "gel", "right common carotid artery", "right internal jugular vein"} <= seen
    artery = neck.vessels[0]
    count = len(artery.line)
    for point in artery.line[count // 4 : 3 * count // 4, :3]:  # it begins and ends within others
        assert neck.labels[neck.scene.object_at(tuple(point))] == artery.name


def test_vessels_have_lines_with_flow(neck):
    kinds = {one.name: one.kind for one in neck.vessels}
    assert kinds["right common carotid artery"] == "artery" and kinds["right internal jugular vein"] == "vein"
    assert set(kinds) <= set(neck.scene.names.values())
    for one in neck.vessels:
        assert one.line.shape[1] == 6 and len(one.line) > 2 and (one.line[:, 3:5] > 0).all() and one.peak_velocity != 0
    artery = neck.vessels[0]
    assert artery.line[0, 1] > artery.line[-1, 1]  # y points to the feet
    assert np.median(artery.line[:, 3]) == pytest.approx(neck.values["carotid"] / 2, rel=0.1)


def test_colour_of_a_carotid_artery(neck):
    artery = neck.vessels[0]
    stream = neck.flow(heart_rate=0)[0]
    assert stream.object == neck.scene.find(artery.name) and stream.peak_velocity == artery.peak_velocity
    middle = artery.line[np.abs(artery.line[:, 1]).argmin(), :3]  # where y is 0
    towards = middle + [0, -15 * mm, 0] - neck.views["carotid_transverse"].at.translation
    probe = copy.copy(neck.views["carotid_transverse"].probe)
    probe.lines = 96
    start = neck.views["carotid_transverse"].at.translation
    at = us.look_at(start, tuple(start + towards), (1, 0, 0))  # tilted to the head
    seen = us.colour_doppler(neck.scene, probe, at, neck.flow(heart_rate=0), us.doppler_settings(depth=40 * mm, prf=14 * kHz, ensemble=8))
    truth = us.ground_truth(neck.scene, probe, at, us.label_settings(depth=40 * mm, samples=seen.samples))
    blood, line = truth.label.values == stream.object, us.centre_line(artery.line)
    expected, found = [], []
    for row, column in np.argwhere(blood):
        origin, direction = (np.array(each) for each in probe.beam(row))
        point = at.rotation @ (origin + direction * (column + 0.5) / seen.samples * 40 * mm) + at.translation
        place = line.place(tuple(point))
        if place.squared(tuple(point)) < 0.1:  # on the axis
            speed = artery.peak_velocity * (1 - place.squared(tuple(point)))
            expected.append(-speed * np.dot(place.along, at.rotation @ direction) * 1540 / us.tissue.blood.sound_speed)
            found.append(seen.velocity[row, column])
    print(f"{len(found)} samples on the axis: {np.median(found):.3f} m/s, expected {np.median(expected):.3f}")
    assert len(found) > 20 and abs(np.median(expected)) > 0.1 and abs(np.median(expected)) < seen.max_velocity
    assert np.median(found) == pytest.approx(np.median(expected), rel=0.15)


def test_flow_and_motion_of_all_vessels(neck):
    flow = neck.flow(heart_rate=1)
    assert [neck.scene.names[one.object] for one in flow] == [one.name for one in neck.vessels]
    for one, vessel in zip(flow, neck.vessels):
        is_artery = vessel.kind == "artery"
        assert one.waveform.heart_rate == (1 if is_artery else 0) and np.allclose(vessel.line, one.line.sections, atol=1e-6)
        assert one.side_branches == 1 and one.peak_velocity == vessel.peak_velocity
        assert not is_artery or one.waveform.resistive_index == vessel.resistive_index
    vein = next(one for one in neck.vessels if one.name == "right internal jugular vein")
    middle = vein.line[len(vein.line) // 2, :3]
    points = (middle + np.array([[0, 0, 0], [0, 0, 0.1 * mm]])).astype(np.float32)
    still = pulsation_at(0)
    assert np.array_equal(neck.motion(still)(points), points)  # at rest
    assert np.array_equal(neck.motion(still, vein.pressure - 1, [middle])(points), points)
    closed = neck.motion(still, 30 * us.mmHg, [middle])(points)
    assert closed[1, 2] - closed[0, 2] < 0.02 * mm  # a tenth of its height
    artery = neck.vessels[0]
    axis = artery.line[len(artery.line) // 2, :3]
    wall = axis + [0, 0, np.float32(artery.line[len(artery.line) // 2, 3])]
    moved = neck.motion(pulsation_at(0.15))(wall[None])[0]
    assert np.linalg.norm(moved - wall) == pytest.approx(0.1 * np.linalg.norm(wall - axis), rel=0.1)  # 0.3 of 3 mm
    neck.scene.deform(neck.motion(pulsation_at(0.15), 20 * us.mmHg, [middle]))
    neck.scene.deform(us.compose())
    closing = neck.flow(pressure=20 * us.mmHg, face=[middle])
    assert [abs(one.peak_velocity) < 0.5 * abs(vessel.peak_velocity) for one, vessel in zip(closing, neck.vessels)].count(True) == 2  # both jugular veins
    with pytest.raises(ValueError, match="pressure"):
        neck.motion(still, float("nan"), [middle])
    with pytest.raises(ValueError, match="pulsation: "):
        neck.motion(us.pulsation(amplitude=5 * mm))


def pulsation_at(time):
    return us.pulsation(radius=3 * mm, amplitude=0.3 * mm, rate=1, time=time)


def test_views_for_a_needle():
    body = anatomy.make("nerve_block")
    view = body.views["nerve_block"]
    entry, target = np.array(view.needle[0]), np.array(view.needle[1])
    needle = body.scene.add(us.make_needle(us.needle_diameter(22), 60 * mm), us.tissue.steel, priority=9, name="needle",
                            at=us.needle_pose(tuple(target), tuple(target - entry), (0, 0, -1)))
    body.scene.build()
    assert body.labels[needle] == "needle" and body.scene.object_at(tuple(target - 2 * mm * (target - entry) / np.linalg.norm(target - entry))) == needle
    assert anatomy.make("neck", resolution=0.3).views["thyroid"].needle is None


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda body: pickle.loads(pickle.dumps(body))], ids=["copied", "pickled"])
@pytest.mark.parametrize("region", ["neck", "leg", "right_upper_quadrant", "lumbar", "nerve_block"])
def test_bodies_are_copied_and_pickled(copied, region):
    body = anatomy.make(region, seed=2, **coarse(region))
    body.scene.build()
    view = first_view(body)
    again = copied(body)
    seen = again.views[view.name]
    assert (again.region, again.values, again.labels, list(again.views)) == (body.region, body.values, body.labels, list(body.views))
    assert again.scene is not body.scene and seen.settings == view.settings and seen.probe == view.probe and seen.needle == view.needle
    assert np.array_equal(draw(again, seen, seen.at), draw(body, view, view.at))
    assert [(one.name, one.kind) for one in again.vessels] == [(one.name, one.kind) for one in body.vessels]
    assert all(np.array_equal(one.line, other.line) for one, other in zip(again.vessels, body.vessels))
    ball = us.make_sphere((0, 0, 0), 1 * mm)
    assert again.scene.add(ball, us.tissue.bone) == body.scene.add(ball, us.tissue.bone)
