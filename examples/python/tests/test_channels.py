"""Channel data: arrays, transmits, what elements receive, lines from it, and the truth beside it."""
import copy
import gc
import pickle

import numpy as np
import pytest

import insonify as us
from insonify import MHz, deg, mm, tissue

ARRAY = us.element_array(elements=48)
BENT = us.convex_element_array(elements=48, pitch=0.3 * mm, radius=40 * mm, element_width=0.27 * mm)
TARGET = np.array([2, 0, 18]) * mm
LINES = us.linear_array(lines=97, width=9.7 * mm, frequency=7.6 * MHz)
SECTOR = us.convex_array(lines=97, radius=40 * mm, field_of_view=14 * deg)


def receive(array, sent, depth=25 * mm, **changed):
    """What comes back from a point in water."""
    settings = us.channel_settings(depth=depth, points=([TARGET], [1 * mm]), **changed)
    return us.trace_channels(us.scene(us.medium(density=1000, sound_speed=1540)).build(), array, us.pose(), us.physical(), sent, settings)


@pytest.fixture(scope="module")
def plane():
    return receive(ARRAY, us.plane_waves(ARRAY, 5, 10 * deg))


def test_channel_data_equal_those_of_cpp_bit_for_bit(phantom, equals_cpp):
    body, array, bent = phantom(), us.element_array(elements=24), us.convex_element_array(elements=12)
    settings = us.channel_settings(depth=30 * mm, noise_level_db=-60, points=([(1 * mm, 0, 12 * mm)], [0.1 * mm]))
    received = us.trace_channels(body, array, us.pose(), us.physical(), us.plane_waves(array, 3, 10 * deg), settings)
    of_bent = us.trace_channels(body, bent, us.pose(), us.physical(), us.full_synthetic_aperture(bent), us.channel_settings(depth=30 * mm, wave_fronts=True))
    lines = us.beamform(received, us.linear_array(lines=32), us.acquisition(depth=28 * mm), us.beamform_settings(fnumber=1.5, window="hann"))
    truth = us.map_tissue(body, us.pose(), us.map_grid(size=(40, 60), spacing=0.5 * mm))
    equals_cpp("channels", [received.values, us.demodulate(received).values, of_bent.values, lines.values, truth.sound_speed, truth.labels])


@pytest.mark.parametrize("transmits", [lambda array: us.plane_waves(array, 5, 10 * deg), us.full_synthetic_aperture,
                                       lambda array: us.diverging_waves(array, [(0, 0, -10 * mm), (3 * mm, 0, -10 * mm)]),
                                       lambda array: us.focused(array, [TARGET], fnumber=2)], ids=["plane", "synthetic", "diverging", "focused"])
@pytest.mark.parametrize("array, probe", [(ARRAY, LINES), (BENT, SECTOR)], ids=["flat", "convex"])
def test_a_point_is_beamformed_where_it_is(array, probe, transmits):
    received = receive(array, transmits(array))
    grid = us.acquisition(depth=25 * mm, samples=1250)
    echoes = us.beamform(received, probe, grid, us.beamform_settings(fnumber=1.5))
    assert echoes == us.beamform(us.demodulate(received), probe, grid, us.beamform_settings(fnumber=1.5), policy="seq")
    line, sample = np.unravel_index(np.abs(echoes.values).argmax(), echoes.values.shape)
    origin, direction = map(np.array, probe.beam(line))
    found = origin + (sample + 0.5) * 25 * mm / 1250 * direction
    print(f"found at {found / mm} mm")
    assert found == pytest.approx(TARGET, abs=0.15 * mm)


def test_a_point_is_where_it_is_by_numpy(plane):
    """Delay and sum of the arrays alone."""
    iq = us.demodulate(plane)
    speed, centres = iq.sound_speed, iq.places[:, 0].astype(float)
    assert np.array_equal(centres, [ARRAY.element(i)[0] for i in range(48)]) and np.array_equal(iq.places[:, 1], [(0, 0, 1)] * 48)
    x, z = np.arange(0.5, 3.5, 0.05) * mm, np.arange(17, 19, 0.02) * mm
    points = np.stack(np.meshgrid(x, 0, z, indexing="ij"), axis=-1)[:, 0]
    back = np.linalg.norm(points[:, :, None] - centres, axis=-1) / speed
    total = np.zeros(back.shape[:2], complex)
    for values, one in zip(iq.values, iq.sent):
        direction = np.array([np.sin(one.angle), 0, np.cos(one.angle)])
        assert one.delays == pytest.approx((centres - centres[np.argmin(centres @ direction)]) @ direction / speed, abs=1e-11)
        time = (points @ direction - (centres @ direction).min())[..., None] / speed + back
        place = (time - iq.start) * iq.sampling_frequency
        below = place.astype(int)
        part = place - below
        element = np.arange(48)
        value = (1 - part) * values[element, below] + part * values[element, below + 1]
        total += (value * np.exp(2j * np.pi * iq.frequency * time)).sum(axis=-1)
    i, k = np.unravel_index(np.abs(total).argmax(), total.shape)
    print(f"found at {x[i] / mm:.2f}, {z[k] / mm:.2f} mm")
    assert (x[i], z[k]) == pytest.approx((TARGET[0], TARGET[2]), abs=0.06 * mm)


def test_rf_arrives_after_the_travel_time():
    received = receive(ARRAY, us.full_synthetic_aperture(ARRAY)[20:21])
    envelope = np.abs(us.demodulate(received).values[0])
    peaks = received.start + envelope.argmax(axis=1) / received.sampling_frequency
    there, *back = np.linalg.norm(TARGET - np.array([ARRAY.element(i)[0] for i in [20, *range(48)]]), axis=1)
    assert peaks == pytest.approx((there + np.array(back)) / 1540, abs=1 / received.sampling_frequency)


def test_elements_can_change_places(phantom):
    array = us.element_array(elements=12)
    received = us.trace_channels(phantom(), array, us.pose(), us.physical(), us.full_synthetic_aperture(array), us.channel_settings(depth=30 * mm))
    assert np.abs(received.values).max() > 0 and np.array_equal(received.values, received.values.swapaxes(0, 1))


def test_a_plane_wave_is_the_sum_of_delayed_elements():
    array = us.element_array(elements=16)
    each = receive(array, us.full_synthetic_aperture(array), sampling_frequency=60.8 * MHz)
    sent = us.plane_waves(array, 3, 20 * deg)[2]
    steered = receive(array, [sent], sampling_frequency=60.8 * MHz)
    assert each.start == steered.start
    frequencies = np.fft.rfftfreq(2 * each.samples, 1 / each.sampling_frequency)
    spectra = np.fft.rfft(each.values, 2 * each.samples) * np.exp(-2j * np.pi * frequencies * np.array(sent.delays)[:, None, None])
    summed = np.fft.irfft(spectra.sum(axis=0))[:, : each.samples]
    shared = slice(0, min(each.samples, steered.samples))
    error = np.abs(summed[:, shared] - steered.values[0][:, shared]).max() / np.abs(steered.values).max()
    print(f"differs by {error:.1e}")
    assert error < 1e-4


def test_arrays_share_memory_and_keep_their_owner(plane):
    received = copy.copy(plane)
    values, places, sent = received.values, received.places, received.sent
    assert values.shape == (received.transmits, received.elements, received.samples) == (5, 48, received.samples) and values.dtype == np.float32
    assert np.shares_memory(values, received.values) and np.shares_memory(values, np.asarray(received)) and not np.shares_memory(values, plane.values)
    assert places.shape == (48, 2, 3) and np.shares_memory(places, received.places)
    iq = us.demodulate(received)
    baseband = iq.values
    assert baseband.dtype == np.complex64 and baseband.shape == values.shape and np.shares_memory(baseband, iq.values)
    grid = us.acquisition(depth=20 * mm, samples=500)
    before = us.beamform(received, LINES, grid).values.copy()
    values *= 2
    assert np.allclose(us.beamform(received, LINES, grid).values, 2 * before, rtol=1e-4, atol=1e-9)
    sent[1].weights = [0] * 47 + [1]  # of the data, not of a copy
    assert received.sent[1].weights == sent[1].weights and plane.sent[1].weights == ()
    kept, of_iq = values.copy(), baseband.copy()
    del received, iq
    gc.collect()
    assert np.array_equal(values, kept) and np.array_equal(baseband, of_iq) and places[0, 0, 0] == ARRAY.element(0)[0][0] and len(sent[4].delays) == 48


def test_data_are_made_of_arrays_copied_and_pickled(plane):
    numbers = {name: getattr(plane, name) for name in ("sampling_frequency", "frequency", "start", "bandwidth", "sound_speed", "pitch", "element_width", "height", "elevation_focus")}
    made = us.channel_data(plane.values, plane.sent, plane.places, **numbers)
    of_iq = us.demodulate(plane)
    assert made == plane and us.iq_channel_data(of_iq.values, plane.sent, plane.places, **numbers) == of_iq
    grid = us.acquisition(depth=25 * mm, samples=500)
    lines = us.beamform(plane, LINES, grid)
    for one in (made, *(change(each) for each in (plane, of_iq) for change in (copy.copy, copy.deepcopy, lambda data: pickle.loads(pickle.dumps(data))))):
        assert us.beamform(one, LINES, grid) == lines and one.sent == plane.sent and np.array_equal(one.places, plane.places)
        assert {name: getattr(one, name) for name in numbers} == numbers
    for sent in us.focused(ARRAY, [TARGET], 2) + us.plane_waves(ARRAY, 2, 0.1):
        assert pickle.loads(pickle.dumps(sent)) == sent == copy.copy(sent)
    for array in (ARRAY, BENT, us.presets.l12_3v_elements, us.presets.c5_2v_elements):
        assert pickle.loads(pickle.dumps(array)) == array
    assert us.presets.l11_5v_elements == us.element_array() and us.presets.p4_2v_elements.elements == 64
    with pytest.raises(AttributeError, match="copy.copy"):
        us.presets.l11_5v_elements.elements = 4


def as_custom(array, **changed):
    """The same elements, as arrays."""
    places = [array.element(i) for i in range(array.elements)]
    numbers = {name: getattr(array, name) for name in ("element_width", "height", "elevation_focus", "frequency", "bandwidth", "sound_speed", "fnumber")}
    return us.custom_element_array(**{"positions": [p for p, _ in places], "directions": [d for _, d in places], **numbers, **changed})


@pytest.mark.parametrize("array, probe", [(ARRAY, LINES), (BENT, SECTOR)], ids=["flat", "convex"])
@pytest.mark.parametrize("transmits", [lambda array: us.plane_waves(array, 3, 10 * deg), us.full_synthetic_aperture,
                                       lambda array: us.diverging_waves(array, [(0, 0, -10 * mm)]), lambda array: us.focused(array, [TARGET], fnumber=2)],
                         ids=["plane", "synthetic", "diverging", "focused"])
def test_a_custom_array_of_the_same_elements_receives_the_same_bits(phantom, array, probe, transmits):
    custom = as_custom(array)
    assert custom.elements == 48 and [custom.element(i) for i in range(48)] == [array.element(i) for i in range(48)]
    body, settings, grid = phantom(), us.channel_settings(depth=20 * mm), us.acquisition(depth=18 * mm, samples=600)
    sent = transmits(array)
    assert transmits(custom) == sent
    built_in, own = (us.trace_channels(body, each, us.pose(), us.physical(), sent, settings) for each in (array, custom))
    assert np.abs(own.values).max() > 0 and own == built_in and np.array_equal(own.places, built_in.places) and own.pitch == built_in.pitch
    assert us.beamform(own, probe, grid) == us.beamform(built_in, probe, grid)


def test_a_matrix_array_receives_points_out_of_the_slice_after_their_travel_time():
    columns, rows = 0.3 * mm * (np.arange(8) - 3.5), 0.3 * mm * (np.arange(4) - 1.5)
    x, y = (each.ravel() for each in np.meshgrid(columns, rows, indexing="ij"))  # column after column
    array = us.custom_element_array(positions=np.stack([x, y, 0 * x], axis=1), element_width=0.27 * mm, height=0.27 * mm, elevation_focus=1, frequency=5 * MHz, bandwidth=0.6)
    assert array.elements == 32 and array.element(5) == (pytest.approx((x[5], y[5], 0)), (0, 0, 1))
    point = np.array([1, 1.5, 10]) * mm
    settings = us.channel_settings(depth=15 * mm, points=([point], [1 * mm]), sampling_frequency=40 * MHz)
    received = us.trace_channels(us.scene(us.medium(density=1000, sound_speed=1540)).build(), array, us.pose(), us.physical(), us.full_synthetic_aperture(array), settings)
    energy = received.values.astype(float) ** 2
    middle = (energy * np.arange(received.samples)).sum(axis=-1) / energy.sum(axis=-1) / 40e6
    way = np.linalg.norm(np.stack([x, y, 0 * x], axis=1) - point, axis=1)
    off = np.abs(middle - (way[:, None] + way) / 1540).max()
    print(f"within {1e9 * off:.2f} ns of the travel time")
    assert off < 5e-9


def test_custom_arrays_are_values_and_name_what_is_wrong():
    array = as_custom(BENT)
    assert pickle.loads(pickle.dumps(array)) == array == copy.copy(array) != as_custom(BENT, height=4 * mm)
    assert array.positions.shape == array.directions.shape == (48, 3) and us.custom_element_array(positions=array.positions).directions.shape == (0, 3)
    with pytest.raises(ValueError, match="read-only"):
        array.positions[0] = 0
    places = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0)]) * mm
    body = us.scene(tissue.gel).build()
    trace = lambda array: us.trace_channels(body, array, us.pose(), us.physical(), us.full_synthetic_aperture(array), us.channel_settings(depth=5 * mm))
    for changed, sentence in (({"positions": places[0]}, "`positions` must be an array of N x 3"), ({"positions": places, "directions": places[:, :2]}, "`directions` must be an array of N x 3"),
                              ({"positions": places * 1j}, "real numbers, not of complex"), ({}, "there are no elements; state `positions`"),
                              ({"positions": places, "directions": [(0, 0, 1)]}, "`directions` are 1, but `positions` are 3"), ({"positions": 0.1 * places}, "elements 0 and 1 overlap; move them apart"),
                              ({"positions": places, "frequency": 0}, "custom_element_array: frequency is 0"), ({"positions": np.zeros((4097, 3))}, "elements is 4097; it must be 1 to 4096"),
                              ({"positions": places[::-1]}, "element 1 lies left of the one before"), ({"positions": places, "directions": [(0, 0, -1)] * 3}, "element 0 looks back"),
                              ({"positions": places, "directions": [(0, 0, 2)] * 3}, "element 0: its normal must have length 1"), ({"positions": places * np.nan}, "custom_element_array: element 0 is not finite; check `positions`")):
        with pytest.raises(us.usage_error, match=sentence):
            trace(us.custom_element_array(**changed))
    for changed, sentence in (({"element_width": [1, 2]}, r"`element_width` of custom_element_array cannot be \[1, 2\]; it is of the kind of"), ({"positions": "left"}, "`positions` of custom_element_array cannot be 'left'"),
                              ({"pitch": 1}, "custom_element_array has no setting 'pitch'; it has positions, directions")):
        with pytest.raises(TypeError, match=sentence):
            us.custom_element_array(**changed)


def test_points_are_arrays():
    how = us.channel_settings(points=(np.arange(6).reshape(2, 3) * mm, [1e-3, -1e-3]))
    positions, lengths = how.points
    assert positions == pytest.approx(np.arange(6).reshape(2, 3) * mm) and lengths == pytest.approx([1e-3, -1e-3])
    with pytest.raises(ValueError, match="read-only"):
        lengths[0] = 1
    assert pickle.loads(pickle.dumps(how)) == how == copy.copy(how) != us.channel_settings()
    assert [each.shape for each in us.channel_settings().points] == [(0, 3), (0,)]
    for wrong, sentence in ((([TARGET], [1, 2]), "are 1 positions; state as many scattering lengths"), (([1, 2, 3], [1]), "positions of `points` must be an array of N x 3")):
        with pytest.raises(us.usage_error, match=sentence):
            how.points = wrong
    with pytest.raises(TypeError, match="`points` of channel_settings cannot be 3"):
        how.points = 3


def test_errors_keep_their_sentences(plane, phantom):
    body, sent = phantom(), us.plane_waves(ARRAY, 1, 0)
    trace = lambda array=ARRAY, sent=sent, **changed: us.trace_channels(body, array, us.pose(), us.physical(), sent, us.channel_settings(**changed))
    short = copy.copy(sent[0])
    short.delays = short.delays[1:]
    broken = copy.copy(plane)
    broken.sampling_frequency = 0
    numbers = {"sampling_frequency": 30 * MHz, "frequency": 7.5 * MHz}
    for call, sentence in ((lambda: trace(sent=[]), "trace_channels: there are no transmits"), (lambda: trace(sent=[short]), "transmit 0: it has 47 delays for 48 elements"),
                           (lambda: trace(us.element_array(elements=0)), "element_array: elements is 0"), (lambda: trace(max_memory=1000), "max_memory"),
                           (lambda: trace(depth=40), "depth"), (lambda: us.plane_waves(ARRAY, 3, 20), "plane_waves: spread is 20 rad"),
                           (lambda: us.diverging_waves(ARRAY, [TARGET]), "diverging_waves: a source lies in front of an element"),
                           (lambda: us.focused(ARRAY, TARGET), "focused: the points must be an array of N x 3"), (lambda: us.focused(ARRAY, [-TARGET]), "lies behind the face"),
                           (lambda: us.demodulate(broken), "demodulate: `sampling_frequency`, `frequency` and `start`"),
                           (lambda: us.beamform(plane, LINES, us.acquisition(), us.beamform_settings(fnumber=0)), "beamform: `fnumber` must be above 0.05"),
                           (lambda: us.beamform_settings(window="gauss"), "one of rectangular, hann, hamming, tukey"), (lambda: us.transmit(front="round"), "one of any, plane"),
                           (lambda: us.map_tissue(body, us.pose(), us.map_grid(size=(0, 4))), "map_tissue: the grid has no pixels"),
                           (lambda: us.channel_data(plane.values[0], plane.sent, plane.places, **numbers), "transmits x elements x samples, not of 2 dimensions"),
                           (lambda: us.channel_data(plane.values, plane.sent[1:], plane.places, **numbers), "`sent` are 4 transmits, but `values` are of 5"),
                           (lambda: us.channel_data(plane.values, plane.sent, plane.places[1:], **numbers), "`places` must be an array of elements x 2 x 3"),
                           (lambda: us.channel_data(plane.values * 1j, plane.sent, plane.places, **numbers), "real numbers")):
        with pytest.raises(us.usage_error, match=sentence):
            call()
    with pytest.raises(IndexError, match="element 48 is not one of the 48, counted from 0"):
        ARRAY.element(48)
    arrays = "it must be an element_array, a convex_element_array or a custom_element_array"
    at, model, grid = us.pose(), us.physical(), us.acquisition()
    for call, sentence in ((lambda: trace(array=us.radial_array()), "trace_channels: `array` is of the type radial_array; " + arrays),
                           (lambda: us.trace_channels(body, ARRAY, at, model), "trace_channels: `sent` is missing; it must be a list of transmits"),
                           (lambda: us.trace_channels(body, ARRAY, (0, 0, 0), model, sent), "trace_channels: `pose` is of the type tuple; it must be a pose"),
                           (lambda: us.trace_channels(None, ARRAY, at, model, sent), "trace_channels: `scene` is of the type NoneType; it must be a scene"),
                           (lambda: us.trace_channels(body, ARRAY, at, at, sent), "trace_channels: `model` is of the type pose; it must be physical"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, sent[0]), "trace_channels: `sent` is of the type transmit; it must be a list of transmits"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, sent, grid), "trace_channels: `settings` is of the type acquisition"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, sent, policy=4), "trace_channels: `policy` is of the type int"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, sent, us.channel_settings(), "seq"), "trace_channels: it takes 6 arguments without a name, but 7 were given"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, transmits=sent), "trace_channels: there is no argument `transmits`; they are scene, array, pose"),
                           (lambda: us.trace_channels(body, ARRAY, at, model, sent, pose=at), "trace_channels: `pose` is given twice"),
                           (lambda: us.beamform(plane, ARRAY, grid), "beamform: `probe` is of the type element_array; it must be the probe of the lines"),
                           (lambda: us.beamform(plane.values, LINES, grid), "beamform: `received` is of the type ndarray; it must be channel_data or iq_channel_data"),
                           (lambda: us.beamform(plane, LINES, 25 * mm), "beamform: `grid` is of the type float"),
                           (lambda: us.plane_waves(us.linear_array(), 3, 0.1), "plane_waves: `array` is of the type linear_array; " + arrays),
                           (lambda: us.plane_waves(ARRAY, 2.5, 0.1), "plane_waves: `count` is of the type float; it must be a whole number"),
                           (lambda: us.focused(ARRAY, "deep"), "focused: `points` is of the type str"), (lambda: us.full_synthetic_aperture(), "full_synthetic_aperture: `array` is missing"),
                           (lambda: us.diverging_waves(ARRAY, None), "diverging_waves: `sources` is of the type NoneType")):
        with pytest.raises(TypeError, match="^" + sentence):
            call()


def test_the_truth_beside_channel_data(phantom):
    body = phantom()
    grid = us.map_grid(from_=(-15 * mm, 5 * mm), spacing=0.25 * mm, size=(120, 140))
    truth = us.map_tissue(body, us.pose(), grid)
    labels, shape = truth.labels, (140, 120)
    assert labels.shape == shape and labels.dtype == np.uint32 and repr(truth.grid) == repr(grid)
    rows, columns = np.indices(shape)
    x, z = (-15 + 0.25 * columns) * mm, (5 + 0.25 * rows) * mm
    assert grid.at(7, 9) == pytest.approx((x[9, 7], 0, z[9, 7]))
    for name, centre, radius in (("bone", (6, 30), 8 * mm), ("vein", (-9, 17), 4 * mm)):
        away = np.hypot(x - centre[0] * mm, z - centre[1] * mm)
        assert (labels[away < radius - 0.1 * mm] == body.find(name)).all() and (labels[away > radius + 0.01 * mm] != body.find(name)).all()
    of_bone, outside = labels == body.find("bone"), labels == us.background_label
    for name in ("sound_speed", "density", "attenuation", "attenuation_power"):
        values = getattr(truth, name)
        assert values.shape == shape and np.shares_memory(values, getattr(truth, name))
        assert (values[of_bone] == np.float32(getattr(tissue.bone, name))).all() and (values[outside] == np.float32(getattr(tissue.muscle, name))).all()
    again = pickle.loads(pickle.dumps(truth))
    assert all(np.array_equal(getattr(again, name), getattr(truth, name)) for name in ("labels", "sound_speed", "displacement", "strain"))
    before = labels.copy()
    del truth
    gc.collect()
    assert np.array_equal(labels, before)


def test_displacement_and_strain():
    body = us.scene(tissue.fat)
    body.add(us.make_sphere((0, 0, 20 * mm), 8 * mm, 4), tissue.muscle)
    lower, upper = np.array([(-50, -50, -20), (50, 50, 60)]) * mm
    pressed = us.sample_map(lambda rest: rest * [1.005, 1, 0.98], lower, upper, spacing=10 * mm)
    body.build()
    body.deform(pressed)
    truth = us.map_tissue(body, us.pose(), us.map_grid(from_=(-5 * mm, 15 * mm), spacing=0.5 * mm, size=(20, 20)))
    rows, columns = np.indices((20, 20))
    x, z = (-5 + 0.5 * columns) * mm, (15 + 0.5 * rows) * mm
    assert truth.displacement == pytest.approx(np.stack([x - x / 1.005, z - z / 0.98], axis=-1), abs=2e-6)
    for name, expected in (("lateral", 0.005), ("axial", -0.02), ("shear", 0)):
        assert truth.strain[name] == pytest.approx(expected, abs=1e-3)


def test_memory_does_not_grow(plane, resident):
    for turn in range(40):
        us.demodulate(plane).values
        [one.delays for one in copy.copy(plane).sent]
        if turn == 15:
            before = resident()
    assert resident() - before < 4 << 20
