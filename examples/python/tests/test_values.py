"""Values as Python handles them: pictures of arrays, poses, tissues, queries, files, copies."""
import copy
import pathlib
import pickle
import re
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

import insonify as us
from insonify import deg, mm, tissue

CUBE = """o block
usemtl bone
v 0 0 0
v 2 0 0
v 0 2 0
v 0 0 2
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def read_png(path):
    """Pixels of an 8-bit PNG file; rows of bytes. Filters: none, sub, up, average, Paeth."""
    data, packed, at = path.read_bytes(), b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        chunk = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            columns, rows, bits, colour = struct.unpack(">IIBB", chunk[:10])
        packed += chunk if kind == b"IDAT" else b""
        at += length + 12
    assert bits == 8
    count = {0: 1, 2: 3}[colour]
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(rows, 1 + count * columns)
    made = np.zeros((rows + 1, count * (columns + 1)), int)  # a row above and a pixel at the left, black
    for y, line in enumerate(raw, 1):
        for x, value in enumerate(line[1:].astype(int), count):
            left, up, corner = made[y, x - count], made[y - 1, x], made[y - 1, x - count]
            paeth = min((left, up, corner), key=lambda each: abs(left + up - corner - each))
            made[y, x] = (value + [0, left, up, (left + up) // 2, paeth][line[0]]) % 256
    made = made[1:, count:]
    return made if count == 1 else made.reshape(rows, columns, 3)


def test_images_are_made_of_arrays(tmp_path):
    values = np.random.default_rng(1).random((5, 7))
    picture = us.image(values)
    assert picture.size == (7, 5) and np.array_equal(picture.pixels, values.astype(np.float32))
    values[0, 0] = -1
    assert picture.pixels[0, 0] >= 0  # a copy
    bytes_of = np.arange(35, dtype=np.uint8).reshape(5, 7) * 7
    assert np.array_equal(us.image(bytes_of[:, ::-1]).pixels, bytes_of[:, ::-1] / np.float32(255))
    colours = us.colour_image(np.dstack([bytes_of / 255] * 3))
    assert colours.size == (7, 5) and np.array_equal(colours.pixels[..., 1], us.image(bytes_of).pixels)
    assert us.image(np.zeros((0, 3))).size == (3, 0)
    with pytest.raises(us.usage_error, match="rows x columns, not of 3 dimensions"):
        us.image(np.zeros((5, 7, 3)))
    with pytest.raises(us.usage_error, match="rows x columns x 3, not of 2 dimensions"):
        us.colour_image(np.zeros((5, 7)))
    with pytest.raises(us.usage_error, match="or rows x columns x 3 in colour"):
        us.colour_image(np.zeros((5, 7, 4)))


def test_arrays_are_written_as_png(tmp_path):
    path = tmp_path / "of an array.png"
    grey = np.random.default_rng(2).integers(0, 256, (13, 9)).astype(np.uint8)
    for values in (grey, grey / 255, (grey / 255).astype(np.float32), us.image(grey)):
        us.write_png(path, values)
        assert np.array_equal(read_png(path), grey)
    colours = np.random.default_rng(3).integers(0, 256, (6, 4, 3)).astype(np.uint8)
    for values in (colours, colours / 255, us.colour_image(colours)):
        us.write_png(str(path), values)
        assert np.array_equal(read_png(path), colours)
    us.write_png(path, grey > 99)
    assert np.array_equal(read_png(path), np.where(grey > 99, 255, 0))
    for wrong, sentence in ((np.zeros((4, 4), int), "not of int64; for labels"), (np.zeros(4), "rows x columns"), (np.zeros((4, 4, 2)), "x 3"),
                            (np.zeros((0, 4)), "pixels"), (np.broadcast_to(0.0, (2, 20000)), "16384 pixels a side")):
        with pytest.raises(us.usage_error, match=sentence):
            us.write_png(path, wrong)


def test_labels_are_saved_as_the_page_says(phantom, tmp_path):
    body, machine = phantom(), us.scanner(us.linear_array(lines=64), us.b_mode_settings(depth=50 * mm, size=(40, 0), planes=1))
    machine.scan(body, us.pose())
    labels = machine.labels(body).pixels
    assert labels.dtype == np.uint32 and us.background_label in labels
    np.save(tmp_path / "labels.npy", labels)
    assert np.array_equal(np.load(tmp_path / "labels.npy"), labels)
    us.write_png(tmp_path / "labels.png", labels.astype(np.uint8))
    seen = read_png(tmp_path / "labels.png")
    assert np.array_equal(seen == 255, labels == us.background_label) and np.array_equal(seen == body.find("bone"), labels == body.find("bone"))


def test_poses_of_parts():
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    at = us.pose(rotation=turn, translation=(1 * mm, 2 * mm, 3 * mm))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, (1 * mm, 2 * mm, 3 * mm)
    assert at == us.pose(matrix) and np.array_equal(at.rotation, turn.astype(np.float32))
    assert us.pose(rotation=at.rotation, translation=at.translation) == at
    assert us.pose(translation=(0, 0, 1)).point((1, 0, 0)) == (1, 0, 1)
    assert us.pose(rotation=turn.tolist()).translation == (0, 0, 0) and us.pose(at.rotation, at.translation) == at
    assert us.pose(matrix.tolist()) == at and us.pose(matrix=matrix) == at
    with pytest.raises(us.usage_error, match="3 x 3"):
        us.pose(rotation=np.eye(4))
    for wrong in (2 * np.eye(3), np.diag([1, 1, -1]), np.full((3, 3), np.nan)):
        with pytest.raises(us.geometry_error, match="orthonormal"):
            us.pose(rotation=wrong)


def test_a_pose_that_drifted_is_mended():
    step = us.look_at((0, 0, 0), (0.1, 0.2, 1), (1, 0.3, 0))
    at = us.pose()
    for _ in range(5000):
        at = at @ step
    drift = lambda pose: np.abs(pose.rotation.T.astype(float) @ pose.rotation - np.eye(3)).max()
    mended = us.orthonormalised(at)
    print(f"after 5000 products {drift(at):.1e} off, mended {drift(mended):.1e}")
    assert drift(at) > 1e-5 and drift(mended) < 1e-6 and np.allclose(mended.rotation, at.rotation, atol=1e-3) and mended.translation == at.translation
    assert pickle.loads(pickle.dumps(at)) == at
    skewed = us.pose().matrix
    skewed[0, 1] = 0.01
    with pytest.raises(us.geometry_error, match="orthonormalised"):
        us.pose(skewed)
    nearest, _, other = np.linalg.svd(skewed[:3, :3])
    assert np.allclose(us.orthonormalised(skewed).rotation, nearest @ other, atol=1e-6)
    with pytest.raises(us.geometry_error, match="orthonormalised"):
        us.orthonormalised(2 * np.eye(4))


def test_a_needle_is_placed_by_its_tip():
    tip, direction = (1 * mm, 2 * mm, 20 * mm), np.array([3.0, 0, 4])
    at = us.needle_pose(tip, direction, (0, 0, -1))
    needle = us.make_needle(1 * mm, 80 * mm)
    along = (needle.positions @ at.rotation.T + at.translation - tip) @ (direction / 5)
    assert at.point((0, 0, 0)) == pytest.approx(tip) and np.abs(along).max() == pytest.approx(80 * mm) and along.max() < 1e-6
    assert np.allclose(at.rotation[:, 0], [0.8, 0, -0.6], atol=1e-6)  # (0, 0, -1), across the needle
    with pytest.raises(us.geometry_error, match="needle_pose"):
        us.needle_pose(tip, direction, direction)


def test_displayed_and_true_depth(phantom):
    body = phantom()  # muscle; a vein of blood from 13 to 21 mm below (-9, 0, 0) mm
    line = (-9 * mm, 0, 0), (0, 0, 2)
    expected = 1540 * (22 * mm / tissue.muscle.sound_speed + 8 * mm / tissue.blood.sound_speed)
    shown = body.displayed_depth(*line, 30 * mm)
    assert shown == pytest.approx(expected, abs=1e-6) and body.true_depth(*line, shown) == pytest.approx(30 * mm, abs=1e-7)
    with pytest.raises(us.usage_error, match="displayed_depth"):
        body.displayed_depth((0, 0, 0), (0, 0, 0), 30 * mm)
    probe = us.convex_array(lines=64)
    origin, direction = probe.beam(20)
    assert np.linalg.norm(direction) == pytest.approx(1) and probe.aperture > 0
    point = np.add(origin, 30 * mm * np.array(direction))
    assert probe.locate((point[0], point[2])) == pytest.approx((20, 30 * mm), abs=1e-4)


def test_tissues_by_name():
    assert tissue.find("bone") == tissue.bone and tissue.find("chalk") is None
    assert len(set(tissue.names)) == len(tissue.names) > 30
    for name in tissue.names:
        assert tissue.find(name) == getattr(tissue, name)


def test_queries(phantom):
    body = phantom()  # a ball of bone, radius 8 mm, around (6, 0, 30) mm; a vein
    bone, vein = body.find("bone"), body.find("vein")
    assert body.medium_at((6 * mm, 0, 30 * mm)) == tissue.bone and body.medium_at((0, 0, 0)) == tissue.muscle
    assert body.object_at((6 * mm, 0, 30 * mm)) == bone and body.object_at((0, 0, 0)) is None
    hit = body.first_surface((6 * mm, 0, 0), (0, 0, 2))
    assert hit.object == bone and hit.distance == pytest.approx(11 * mm, rel=2e-3)  # facets lie inside of the sphere
    assert hit.point == pytest.approx((6 * mm, 0, 22 * mm), abs=0.03 * mm) and hit.normal[2] < -0.99
    assert body.first_surface((6 * mm, 0, 0), (0, 0, -1)) is None
    assert body.first_surface((6 * mm, 0, 0), (0, 0, 1), only=[vein]) is None
    across = (-30 * mm, 0, 17 * mm), (1, 0, 0)
    assert body.first_surface(*across).object == vein and body.first_surface(*across, only=[bone]) is None
    near = body.nearest_surface(bone, (6 * mm, 0, 10 * mm))
    assert near.distance == pytest.approx(12 * mm, rel=2e-3) and near.object == bone and near.face >= 0
    with pytest.raises(us.usage_error, match="not zero"):
        body.first_surface((0, 0, 0), (0, 0, 0))


def test_obj_files(tmp_path):
    path = tmp_path / "block.obj"
    path.write_text(CUBE)
    for given in (path, str(path)):
        assert np.allclose(us.load_obj(given, unit=mm).positions.max(axis=0), 2 * mm)
        body = us.load_obj_scene(given, unit=np.float64(mm), background=tissue.fat).build()
        assert body.find("block") is not None and body.medium_at((1, 1, 1)) == tissue.fat
        assert body.medium_at((0.2 * mm, 0.2 * mm, 0.2 * mm)) == tissue.bone
    for load in (us.load_obj, us.load_obj_scene):
        sentence = "unit: give the length of 1 in the file in metres, such as mm"
        with pytest.raises(ValueError, match=f"^{sentence}$"):
            load(path)
        for wrong in ("mm", 0, -1, float("nan"), float("inf"), (1, 2)):
            with pytest.raises(ValueError, match=re.escape(f"{sentence}, not {wrong!r}")):
                load(path, unit=wrong)
        with pytest.raises(us.io_error, match="nowhere.obj"):
            load(pathlib.Path("nowhere.obj"), unit=mm)


def test_obj_files_give_fibres_and_are_repaired(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl muscle\nfibres 0 1 0\nstiffness 3\n")
    path = tmp_path / "open.obj"
    path.write_text("mtllib a.mtl\n" + CUBE.replace("usemtl bone", "usemtl muscle") + "v 90 90 90\nv 91 90 90\nv 90 91 90\nv 90 90 91\n"
                    "o ball\nusemtl muscle\nf 5 7 6\nf 5 6 8\nf 5 8 7\n")
    with pytest.warns(UserWarning) as told:
        body = us.load_obj_scene(path, unit=mm, repair=True)
    said = [str(each.message) for each in told]
    assert said[0].endswith("a.mtl:3: the key 'stiffness' is unknown and is ignored")
    assert any("object 'ball': Closed 1 hole along 3 edges with 1 face" in each for each in said)
    with pytest.warns(UserWarning, match="'stiffness' is unknown"):
        us.load_obj_scene(path, unit=mm, pennation=20 * us.deg)
    with pytest.warns(UserWarning, match="`pennation` has turned nothing"):
        us.load_obj_scene(path, unit=mm, pennation=20 * us.deg)
    with pytest.raises(us.usage_error, match="`pennation` is 20 radians; it must be from -pi/2"):
        us.load_obj_scene(path, unit=mm, pennation=20)
    with pytest.warns(UserWarning, match="Closed 1 hole"):
        assert us.validate(us.load_obj(path, unit=mm, repair=True)) == ""
    assert "open along 3 edges" in us.validate(us.load_obj(path, unit=mm))


def test_meshes_are_repaired():
    ball = us.make_sphere((0, 0, 0), 10 * mm, 3)
    holed = us.mesh(ball.positions, ball.faces[5:])
    closed, notes = us.repair(holed)
    assert us.validate(closed) == "" and len(closed.faces) == len(ball.faces)
    assert len(notes) == 1 and notes[0].startswith("Closed ")
    assert us.repair(ball)[1] == []
    soup = us.mesh(ball.positions[ball.faces].reshape(-1, 3), np.arange(3 * len(ball.faces)).reshape(-1, 3))
    assert len(us.repair(soup, weld_distance=0)[0].positions) == len(ball.positions)
    with pytest.raises(us.usage_error, match="`weld_distance` is -1 m"):
        us.repair(ball, weld_distance=-1)
    with pytest.raises(us.geometry_error, match="vertex 3 is not finite"):
        broken = ball.positions.copy()
        broken[3, 1] = np.nan
        us.repair(us.mesh(broken, ball.faces))


def test_signatures_are_short(phantom):
    wrong = [lambda: us.b_mode("scene"), lambda: phantom().add("mesh"), lambda: us.load_obj_scene("a.obj", unit=mm, background="fat"),
             lambda: us.scanner("probe"), lambda: us.tgc("lines"), lambda: us.colour_doppler("scene"), lambda: us.scene("fat")]
    for call in wrong:
        with pytest.raises(TypeError) as caught:
            call()
        longest = max(map(len, str(caught.value).splitlines()))
        assert longest < 300, str(caught.value)
    assert "settings: insonify.b_mode_settings = b_mode_settings()" in us.b_mode.__doc__
    assert "background: insonify.medium = tissue.water" in us.load_obj_scene.__doc__


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_scenes_are_copied(copied, phantom):
    body, probe, how = phantom(), us.linear_array(lines=64), us.b_mode_settings(depth=50 * mm, size=(40, 0), planes=1)
    before = us.b_mode(body, probe, us.pose(), how)
    held = body.positions(body.find("bone"))
    other = copied(body)
    assert type(other) is us.scene and other.names == body.names and other.is_built
    assert us.b_mode(other, probe, us.pose(), how) == before
    other.positions(other.find("bone"))[:, 2] -= 8 * mm
    other.update()
    other.set_medium(other.find("vein"), tissue.air)
    assert us.b_mode(other, probe, us.pose(), how) != before and us.b_mode(body, probe, us.pose(), how) == before
    other.remove(other.find("bone"))  # `held` is of the other scene
    assert held.shape[1] == 3 and len(body.names) == 2


def test_arrays_and_poses_are_copied(phantom):
    picture = us.b_mode(phantom(), us.linear_array(lines=16), us.pose(), us.b_mode_settings(depth=20 * mm, size=(16, 0), planes=1))
    for one in (picture, us.scan_lines(np.ones((2, 3)), depth=1 * mm), us.pose(translation=(1, 2, 3)), us.colour_image(np.ones((2, 2, 3)))):
        assert copy.copy(one) == one and copy.deepcopy([one])[0] == one
    other = copy.deepcopy(picture)
    other.pixels[:] = 0.5
    assert other != picture
    ball = us.make_sphere((0, 0, 0), 1 * mm)
    assert not np.shares_memory(copy.copy(ball).positions, ball.positions)


def test_settings_and_poses_are_pickled():
    how = us.b_mode_settings(depth=42 * mm, size=(160, 0))
    how.compound.update, how.time_gain.curve = "one", [us.tgc_point(depth=1 * mm, gain_db=3)]
    steered = us.look_at((1, 2, 3), (2, 2, 5), (1, 0, 0))
    for one in (how, us.convex_array(field_of_view=50 * deg), tissue.muscle, steered, us.indentation(at=steered, depth=2 * mm), us.physical(seed=3)):
        again = pickle.loads(pickle.dumps(one))
        assert type(again) is type(one) and repr(again) == repr(one)
    assert pickle.loads(pickle.dumps(how)) == how


def test_version():
    number = int(re.search(r"INSONIFY_VERSION (\d+)", (pathlib.Path(__file__).parents[3] / "include/insonify/core/version.hpp").read_text())[1])
    assert us.__version__ == f"{number // 10000}.{number // 100 % 100}.{number % 100}"


def test_the_page_lists_what_python_lacks():
    """Each public name of the pages that the table names is either in the module or in the table."""
    folder = pathlib.Path(__file__).resolve().parent.parent
    rows = re.findall(r"^\| \[\w+\]\((.+)#public-names\) \| (.+) \|$", (folder / "README.md").read_text(), re.M)
    assert len(rows) == 11
    for page, listed in rows:
        names = (folder / page).read_text().split("## Public names")[1].split("\n## ")[0]
        names = [name for name in re.findall(r"`(\w+)`", names) if name not in dir(us.scene)]
        assert re.findall(r"`(\w+)`", listed) == [name for name in dict.fromkeys(names) if not hasattr(us, name)], page


def test_the_lines_of_the_page_run(tmp_path):
    """All of its blocks, one after the other, as a program."""
    (tmp_path / "calf.obj").write_text(CUBE)
    page = (pathlib.Path(__file__).resolve().parent.parent / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.S)
    program, others = blocks[:-1], [blocks[0], blocks[-1]]
    assert len(program) == 12 and "multiprocessing" in others[1]
    for number, part in enumerate((program, others)):
        (tmp_path / f"page{number}.py").write_text("\n".join(part))
        subprocess.run([sys.executable, tmp_path / f"page{number}.py"], cwd=tmp_path, check=True)
    labels = np.load(tmp_path / "labels.npy")
    assert np.array_equal(read_png(tmp_path / "labels.png"), labels.astype(np.uint8)) and set(np.unique(labels)) == {0, 1, us.background_label}
    assert len(read_png(tmp_path / "duplex.png")) > 100


def test_bodies_get_skin():
    limb, bone = us.make_sphere((0, 0, 30 * mm), 30 * mm, 4), us.make_sphere((0, 0, 40 * mm), 8 * mm, 3)
    at, probe = us.pose(translation=(0, 0, -1 * mm)), us.linear_array()
    body = us.scene(us.tissue.air)
    outer = body.add(limb, us.tissue.muscle, name="limb")
    inner = body.add(bone, us.tissue.bone, name="bone")
    body.build()
    held, replaced = body.positions(inner), body.positions(outer)
    with pytest.raises(us.usage_error, match=r"add_skin: an array of positions\(%d\) is still in use" % outer):
        us.add_skin(body, probe, at)
    del replaced
    assert us.add_skin(body, probe, at, thickness=2 * mm) == "surface"
    assert set(body.names.values()) == {"limb", "skin", "bone"} and outer not in body.names
    assert us.add_skin(body, probe, at) == "none"
    again = pickle.loads(pickle.dumps(body.build()))
    assert (us.b_mode(again, probe, at).pixels == us.b_mode(body, probe, at).pixels).all()
    assert body.medium_at((0, 0, 1 * mm)) == us.tissue.skin and body.medium_at((0, 0, 4 * mm)) == us.tissue.muscle

    muscle = us.scene(us.tissue.muscle)
    assert us.add_skin(muscle, probe, us.pose(), fat=3 * mm) == "face"
    assert set(muscle.names.values()) == {"gel", "skin", "subcutaneous fat"}
    with pytest.raises(us.usage_error, match="thickness"):
        us.add_skin(us.scene(), probe, at, thickness=1)
