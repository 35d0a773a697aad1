# Type stubs, written by make_stubs.py.
import os
from typing import Any, Callable, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import ArrayLike

Array = np.ndarray[Any, np.dtype[Any]]
Vector = Union[Sequence[float], Array]
Path = Union[str, "os.PathLike[str]"]
velocity_field = Union["poiseuille", "velocity_samples", Sequence[Union["poiseuille", "velocity_samples"]]]
__version__: str
m: float
cm: float
mm: float
um: float
Hz: float
kHz: float
MHz: float
s: float
ms: float
us: float
rad: float
m_per_s: float
kg_per_m3: float
mmHg: float
Rayl: float
MRayl: float
dB_per_m: float
deg: float
dB_per_cm: float
background_label: int
background_object: int
no_level_db: float

class usage_error(ValueError):
    """A setting that is out of range, or a call out of order."""

class geometry_error(ValueError):
    """An invalid mesh or pose."""

class io_error(OSError):
    """A file that could not be read or written, or whose content is invalid."""

class variation:
    """Slow random variation of the level."""
    def __init__(self, *, deviation_db: float = ..., size: Vector = ...) -> None: ...
    deviation_db: float
    size: Vector

class sheet_layer:
    """Thin bright sheets of finite size, such as the perimysium."""
    def __init__(self, *, fill: float = ..., lattices: int = ..., cell: Vector = ..., thickness: float = ..., level_db: float = ..., spread_db: float = ..., turn: float = ..., tilt: float = ..., waviness: float = ..., diffuse_db: float = ...) -> None: ...
    cell: Vector
    diffuse_db: float
    fill: float
    lattices: int
    level_db: float
    spread_db: float
    thickness: float
    tilt: float
    turn: float
    waviness: float

class bundle_layer:
    """Round bundles along the fibres, such as those of a nerve."""
    def __init__(self, *, spacing: float = ..., diameter: float = ..., level_db: float = ...) -> None: ...
    diameter: float
    level_db: float
    spacing: float

class sheath_layer:
    """The sheath of an object, such as the epimysium of a muscle."""
    def __init__(self, *, thickness: float = ..., level_db: float = ..., spread_db: float = ..., waviness: float = ..., diffuse_db: float = ...) -> None: ...
    diffuse_db: float
    level_db: float
    spread_db: float
    thickness: float
    waviness: float

class structure:
    """What a tissue is made of above the scale of speckle."""
    def __init__(self, *, mottling: variation = ..., grain: variation = ..., wave: float = ..., wave_length: float = ..., sheets: sheet_layer = ..., septa: sheet_layer = ..., bundles: bundle_layer = ..., sheath: sheath_layer = ...) -> None: ...
    bundles: bundle_layer
    grain: variation
    mottling: variation
    septa: sheet_layer
    sheath: sheath_layer
    sheets: sheet_layer
    wave: float
    wave_length: float

class medium:
    """Acoustic properties of an object; by default lossless water without echoes."""
    def __init__(self, *, density: float = ..., sound_speed: float = ..., attenuation: float = ..., attenuation_power: float = ..., backscatter: float = ..., roughness: float = ..., scatterer_density: float = ..., structure: structure = ..., flowing: bool = ...) -> None: ...
    attenuation: float
    attenuation_power: float
    backscatter: float
    density: float
    flowing: bool
    @property
    def impedance(self) -> float: ...
    roughness: float
    scatterer_density: float
    sound_speed: float
    structure: structure

class tissue:
    """Media of the body, of instruments and of phantoms: constants; copy.copy makes one that can be changed."""
    adventitia: medium
    air: medium
    bile: medium
    bladder_wall: medium
    blood: medium
    bone: medium
    bone_cortical: medium
    bone_trabecular: medium
    brain: medium
    capsule: medium
    cartilage: medium
    connective_tissue: medium
    epineurium: medium
    eye_lens: medium
    fascia: medium
    fat: medium
    @staticmethod
    def find(name: str) -> Optional[medium]: ...
    gallbladder_wall: medium
    gel: medium
    heart: medium
    intima: medium
    kidney: medium
    lens: medium
    liver: medium
    lung: medium
    mucosa: medium
    muscle: medium
    muscularis: medium
    names: tuple[str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str, str]
    nerve: medium
    nerve_fascicle: medium
    pvcp: medium
    saline: medium
    skin: medium
    soft_tissue: medium
    spleen: medium
    steel: medium
    tendon: medium
    thin_muscle: medium
    thyroid: medium
    titanium: medium
    tmm_cyst: medium
    tmm_high: medium
    tmm_low: medium
    tunica_media: medium
    urethane: medium
    urine: medium
    vein_wall: medium
    vessel_wall: medium
    water: medium

class scan_lines:
    """Real values along lines: envelope, brightness, angles."""
    def __init__(self, values: ArrayLike, depth: float) -> None: ...
    @property
    def count(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def samples(self) -> int: ...
    @property
    def values(self) -> Array: ...

class iq_lines:
    """Complex baseband echoes along lines."""
    def __init__(self, values: ArrayLike, depth: float) -> None: ...
    @property
    def count(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def samples(self) -> int: ...
    @property
    def values(self) -> Array: ...

class label_lines:
    """The object at each sample."""
    def __init__(self, values: ArrayLike, depth: float) -> None: ...
    @property
    def count(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def samples(self) -> int: ...
    @property
    def values(self) -> Array: ...

class image:
    """A greyscale image: 0 black to 1 white."""
    def __init__(self, pixels: ArrayLike) -> None: ...
    @property
    def pixels(self) -> Array: ...
    @property
    def size(self) -> Vector: ...

class label_image:
    """The object at each pixel."""
    @property
    def pixels(self) -> Array: ...
    @property
    def size(self) -> Vector: ...

class colour_image:
    """A colour image: red, green and blue from 0 to 1."""
    def __init__(self, pixels: ArrayLike) -> None: ...
    @property
    def pixels(self) -> Array: ...
    @property
    def size(self) -> Vector: ...

class scan_map:
    """Interpolation table of scan_convert, and pixel to millimetre."""
    @property
    def pitch(self) -> Vector: ...
    def pixel(self, point: Vector) -> Vector: ...
    def point(self, pixel: Vector) -> Vector: ...
    @property
    def size(self) -> Vector: ...

class pose:
    """Rigid transform from local to world coordinates."""
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, matrix: ArrayLike) -> None: ...
    @overload
    def __init__(self, rotation: Optional[Array] = ..., translation: Vector = ...) -> None: ...
    def __matmul__(self, arg0: pose) -> pose: ...
    def local_point(self, p: Vector) -> Vector: ...
    @property
    def matrix(self) -> Array: ...
    def point(self, p: Vector) -> Vector: ...
    @property
    def rotation(self) -> Array: ...
    @property
    def translation(self) -> Vector: ...

class mesh:
    """Indexed triangle mesh; faces are counter-clockwise seen from outside."""
    def __init__(self, positions: ArrayLike, faces: ArrayLike) -> None: ...
    @property
    def faces(self) -> Array: ...
    @property
    def positions(self) -> Array: ...

class scene:
    """Closed surfaces, each filled with a medium, in a background."""
    def __init__(self, background: medium = ...) -> None: ...
    def add(self, mesh: mesh, medium: medium, *, priority: int = ..., at: pose = ..., name: str = ..., fibres: Vector = ..., crease_angle: float = ...) -> int: ...
    @property
    def background(self) -> medium: ...
    def box(self, id: Optional[int] = ...) -> tuple[Vector, Vector]: ...
    def build(self, policy: str = ...) -> Any: ...
    @overload
    def deform(self, map: indentation, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: pulsation, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: collapse, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: breathing, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: needle_drag, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: pressed_face, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: displacement_grid, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: tetrahedra, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    @overload
    def deform(self, map: composed, only: Optional[Sequence[int]] = ..., *, policy: str = ...) -> None: ...
    def displayed_depth(self, origin: Vector, direction: Vector, depth: float) -> float: ...
    def find(self, name: str) -> Optional[int]: ...
    def first_surface(self, origin: Vector, direction: Vector, only: Optional[Sequence[int]] = ...) -> Optional[surface_point]: ...
    @property
    def is_built(self) -> bool: ...
    def is_inside_out(self, id: int) -> bool: ...
    @property
    def media(self) -> Any: ...
    def medium_at(self, point: Vector) -> medium: ...
    @property
    def names(self) -> Any: ...
    def nearest_surface(self, id: int, point: Vector) -> Optional[surface_point]: ...
    def object_at(self, point: Vector) -> Optional[int]: ...
    def place(self, id: int, at: pose) -> None: ...
    def positions(self, id: int) -> Array: ...
    def remove(self, id: int) -> None: ...
    def rest_of(self, now: Vector, of: Optional[int] = ...) -> Vector: ...
    def rest_positions(self, id: int) -> Array: ...
    def set_background_fibres(self, along: Vector, flat: Vector = ...) -> None: ...
    def set_medium(self, id: int, medium: medium) -> None: ...
    def true_depth(self, origin: Vector, direction: Vector, shown: float) -> float: ...
    def update(self, policy: str = ...) -> None: ...

class surface_point:
    """A point on the surface of an object."""
    @property
    def distance(self) -> float: ...
    @property
    def face(self) -> int: ...
    @property
    def normal(self) -> Vector: ...
    @property
    def object(self) -> int: ...
    @property
    def point(self) -> Vector: ...

class indentation:
    """A flat face pressed into flat skin: a map for deform."""
    def __init__(self, *, at: pose = ..., depth: float = ..., face: Vector = ..., decay: float = ..., recovery: float = ...) -> None: ...
    def __call__(self, rest: ArrayLike) -> Array: ...
    at: pose
    decay: float
    depth: float
    face: Vector
    recovery: float

class pulsation:
    """A vessel that pulses, and the tissue around it: a map."""
    def __init__(self, *, from_: Vector = ..., to: Vector = ..., radius: float = ..., amplitude: float = ..., rate: float = ..., time: float = ...) -> None: ...
    def __call__(self, rest: ArrayLike) -> Array: ...
    amplitude: float
    from_: Vector
    radius: float
    rate: float
    time: float
    to: Vector

class collapse:
    """A vessel that the pressure around it closes: a map for deform."""
    def __init__(self, *, from_: Vector = ..., to: Vector = ..., direction: Vector = ..., radius: float = ..., outside: float = ..., inside: float = ..., stiffness: float = ..., residual: float = ..., beside: float = ..., above: float = ...) -> None: ...
    def __call__(self, rest: ArrayLike) -> Array: ...
    above: float
    beside: float
    direction: Vector
    from_: Vector
    inside: float
    @property
    def opening(self) -> float: ...
    outside: float
    radius: float
    residual: float
    stiffness: float
    to: Vector

class breathing:
    """A region that moves back and forth: a map for deform."""
    def __init__(self, *, direction: Vector = ..., amplitude: float = ..., centre: Vector = ..., extent: float = ..., rate: float = ..., time: float = ...) -> None: ...
    def __call__(self, rest: ArrayLike) -> Array: ...
    amplitude: float
    centre: Vector
    direction: Vector
    extent: float
    rate: float
    time: float

class needle_drag:
    """Tissue that moves with the shaft of a needle: a map."""
    def __init__(self, *, entry: Vector = ..., tip: Vector = ..., drag: float = ..., extent: float = ...) -> None: ...
    def __call__(self, rest: ArrayLike) -> Array: ...
    drag: float
    entry: Vector
    extent: float
    tip: Vector

class press_settings:
    """How a body yields to a probe."""
    def __init__(self, *, stiffness: float = ..., gel: float = ..., decay: float = ..., recovery: float = ...) -> None: ...
    decay: float
    gel: float
    recovery: float
    stiffness: float

class pressed_face:
    """A face pressed into any skin: a map, made by press."""
    def __call__(self, rest: ArrayLike) -> Array: ...

class contact:
    """How a probe touches a body."""
    @property
    def deformation(self) -> pressed_face: ...
    @property
    def depth(self) -> float: ...
    @property
    def force(self) -> float: ...
    @property
    def lines(self) -> Array: ...
    @property
    def mean_depth(self) -> float: ...
    @property
    def pressure(self) -> float: ...
    @property
    def touching(self) -> int: ...

class displacement_grid:
    """Displacements on a regular grid: a map."""
    def __call__(self, rest: ArrayLike) -> Array: ...
    def __init__(self, displacements: ArrayLike, origin: Vector, spacing: Vector) -> None: ...
    @property
    def displacements(self) -> Array: ...
    @property
    def origin(self) -> Vector: ...
    @property
    def size(self) -> Vector: ...
    @property
    def spacing(self) -> Vector: ...

class tetrahedra:
    """The tetrahedra of a finite-element engine: a map for deform."""
    def __call__(self, rest: ArrayLike) -> Array: ...
    def __init__(self, nodes: ArrayLike, cells: ArrayLike) -> None: ...
    @property
    def nodes(self) -> Array: ...

class composed:
    """Several maps, one after the other: made by compose."""
    def __call__(self, rest: ArrayLike) -> Array: ...

class pulsatile:
    """Velocity over the heart beat, relative to its peak."""
    def __init__(self, *, heart_rate: float = ..., resistive_index: float = ..., systole: float = ..., delay: float = ...) -> None: ...
    def __call__(self, time: float) -> float: ...
    delay: float
    heart_rate: float
    def mean(self) -> float: ...
    resistive_index: float
    systole: float

class poiseuille:
    """Laminar flow in a straight tube: a velocity field."""
    def __init__(self, *, object: int = ..., from_: Vector = ..., to: Vector = ..., radius: float = ..., peak_velocity: float = ..., waveform: pulsatile = ...) -> None: ...
    from_: Vector
    object: int
    peak_velocity: float
    radius: float
    to: Vector
    def volume_flow(self, time: float) -> float: ...
    waveform: pulsatile

class velocity_samples:
    """Velocities on a regular grid: a velocity field."""
    def __init__(self, velocities: ArrayLike, *, object: int, lower: Vector, spacing: Vector, interval: float = ...) -> None: ...
    @property
    def interval(self) -> float: ...
    @property
    def lower(self) -> Vector: ...
    object: int
    @property
    def size(self) -> Vector: ...
    @property
    def spacing(self) -> Vector: ...
    @property
    def steps(self) -> int: ...
    @property
    def velocities(self) -> Array: ...

class colour_box:
    """Where velocities are measured: by default everywhere."""
    def __init__(self, *, from_: float = ..., to: float = ..., first_line: int = ..., lines: int = ...) -> None: ...
    first_line: int
    from_: float
    lines: int
    to: float

class wall_filter:
    """Removes the echoes of tissue from an ensemble."""
    def __init__(self, *, type: str = ..., order: int = ..., cutoff: float = ...) -> None: ...
    cutoff: float
    order: int
    type: str

class doppler_settings:
    """Settings of colour and power Doppler."""
    def __init__(self, *, depth: float = ..., prf: float = ..., ensemble: int = ..., box: colour_box = ..., wall: wall_filter = ..., average_length: float = ..., average_lines: float = ..., burst: float = ..., planes: int = ..., time: float = ..., noise_db: float = ..., seed: int = ...) -> None: ...
    average_length: float
    average_lines: float
    box: colour_box
    burst: float
    depth: float
    ensemble: int
    noise_db: float
    planes: int
    prf: float
    seed: int
    time: float
    wall: wall_filter

class ensemble_settings:
    """How doppler_ensemble acquires a pulse train."""
    def __init__(self, *, depth: float = ..., samples: int = ..., prf: float = ..., pulses: int = ..., first: int = ..., from_: float = ..., burst: float = ..., planes: int = ..., time: float = ..., noise_db: float = ..., seed: int = ...) -> None: ...
    burst: float
    depth: float
    first: int
    from_: float
    noise_db: float
    planes: int
    prf: float
    pulses: int
    samples: int
    seed: int
    time: float

class spectrum_settings:
    """From a series of echoes to a spectrum."""
    def __init__(self, *, window: int = ..., overlap: float = ..., baseline: float = ..., angle: float = ..., wall_order: int = ...) -> None: ...
    angle: float
    baseline: float
    overlap: float
    wall_order: int
    window: int

class pulsed_doppler_settings:
    """Settings of pulsed Doppler."""
    def __init__(self, *, line: int = ..., gate: float = ..., gate_length: float = ..., prf: float = ..., duration: float = ..., spectrum: spectrum_settings = ..., burst: float = ..., depth: float = ..., planes: int = ..., time: float = ..., noise_db: float = ..., seed: int = ...) -> None: ...
    burst: float
    depth: float
    duration: float
    gate: float
    gate_length: float
    line: int
    noise_db: float
    planes: int
    prf: float
    seed: int
    spectrum: spectrum_settings
    time: float

class doppler_picture_settings:
    """What counts as flow."""
    def __init__(self, *, size: Vector = ..., min_power_db: float = ..., min_velocity: float = ...) -> None: ...
    min_power_db: float
    min_velocity: float
    size: Vector

class colour_overlay_settings:
    """Colours of flow, and where they are shown."""
    def __init__(self, *, map: str = ..., max_velocity: float = ..., power_range_db: float = ..., min_power_db: float = ..., min_velocity: float = ..., max_grey: float = ...) -> None: ...
    map: str
    max_grey: float
    max_velocity: float
    min_power_db: float
    min_velocity: float
    power_range_db: float

class flow_lines:
    """Velocity, power and variance along the lines of a probe."""
    @property
    def count(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def max_velocity(self) -> float: ...
    @property
    def power(self) -> Array: ...
    @property
    def samples(self) -> int: ...
    @property
    def variance(self) -> Array: ...
    @property
    def velocity(self) -> Array: ...

class iq_ensemble:
    """Echoes of successive pulses along the same lines."""
    @property
    def prf(self) -> float: ...
    @property
    def pulses(self) -> Any: ...

class doppler_spectrum:
    """Power by velocity, window after window."""
    @property
    def bins(self) -> int: ...
    @property
    def first_time(self) -> float: ...
    @property
    def interval(self) -> float: ...
    @property
    def lowest_velocity(self) -> float: ...
    def mean_velocity(self, window: int) -> float: ...
    @property
    def power(self) -> Array: ...
    @property
    def step(self) -> float: ...
    def velocity(self, bin: int) -> float: ...
    @property
    def windows(self) -> int: ...

class physical:
    """The pulse-echo model."""
    def __init__(self, *, texture_db: float = ..., shadow_floor_db: float = ..., seed: int = ..., min_ringing: float = ...) -> None: ...
    min_ringing: float
    seed: int
    shadow_floor_db: float
    texture_db: float

class acquisition:
    """Depth and sampling of the scan lines."""
    def __init__(self, *, depth: float = ..., samples: int = ..., planes: int = ..., frame: int = ...) -> None: ...
    depth: float
    frame: int
    planes: int
    samples: int

class tgc_point:
    """A point of a time-gain curve."""
    def __init__(self, *, depth: float = ..., gain_db: float = ...) -> None: ...
    depth: float
    gain_db: float

class tgc_settings:
    """Time-gain compensation."""
    def __init__(self, *, attenuation: float = ..., max_db: float = ..., sliders: Sequence[float] = ..., curve: Sequence[tgc_point] = ..., bandwidth: float = ...) -> None: ...
    attenuation: float
    bandwidth: float
    curve: Sequence[tgc_point]
    max_db: float
    sliders: Sequence[float]

class log_compress_settings:
    """From amplitude to brightness."""
    def __init__(self, *, dynamic_range_db: float = ..., reference_db: float = ..., gain_db: float = ..., reject_db: float = ...) -> None: ...
    dynamic_range_db: float
    gain_db: float
    reference_db: float
    reject_db: float

class scan_convert_settings:
    """Size and background of the image."""
    def __init__(self, *, size: Vector = ..., background: float = ...) -> None: ...
    background: float
    size: Vector

class electronic_noise_settings:
    """Noise of the receiver."""
    def __init__(self, *, level_db: float = ..., seed: int = ..., frame: int = ...) -> None: ...
    frame: int
    level_db: float
    seed: int

class label_settings:
    """Depth and sampling of labels."""
    def __init__(self, *, depth: float = ..., samples: int = ..., grid: str = ...) -> None: ...
    depth: float
    grid: str
    samples: int

class grey_map:
    """Tone curve for display."""
    def __init__(self, *, gamma: float = ..., contrast: float = ..., reject: float = ..., shoulder: float = ..., softness: float = ...) -> None: ...
    contrast: float
    gamma: float
    reject: float
    shoulder: float
    softness: float

class time_gain_settings:
    """Time-gain compensation beside `tgc`."""
    def __init__(self, *, chosen: str = ..., max_db: float = ..., sliders: Sequence[float] = ..., curve: Sequence[tgc_point] = ...) -> None: ...
    chosen: str
    curve: Sequence[tgc_point]
    max_db: float
    sliders: Sequence[float]

class noise_level:
    """Electronic noise of a picture."""
    def __init__(self, *, level_db: float = ..., seed: int = ...) -> None: ...
    level_db: float
    seed: int

class near_field_settings:
    """Echoes of the probe itself."""
    def __init__(self, *, shown: str = ..., lens_thickness: float = ..., back_reflection: float = ..., ring_down_db: float = ..., ring_down: float = ...) -> None: ...
    back_reflection: float
    lens_thickness: float
    ring_down: float
    ring_down_db: float
    shown: str

class compound_settings:
    """Looks at several angles, averaged."""
    def __init__(self, *, angles: int = ..., spread: float = ..., update: str = ...) -> None: ...
    angles: int
    spread: float
    update: str

class b_mode_settings:
    """Settings of a B-mode image, as on a scanner."""
    def __init__(self, *, depth: float = ..., samples: int = ..., size: Vector = ..., dynamic_range_db: float = ..., reference_db: float = ..., gain_db: float = ..., tgc: float = ..., planes: int = ..., background: float = ..., time_gain: time_gain_settings = ..., reject_db: float = ..., grey: grey_map = ..., persistence: float = ..., noise: noise_level = ..., frame: int = ..., near_field: near_field_settings = ..., compound: compound_settings = ..., max_motion: float = ..., interpolates_lines: bool = ..., quality: str = ...) -> None: ...
    background: float
    compound: compound_settings
    depth: float
    dynamic_range_db: float
    frame: int
    gain_db: float
    grey: grey_map
    interpolates_lines: bool
    max_motion: float
    near_field: near_field_settings
    noise: noise_level
    persistence: float
    planes: int
    quality: str
    reference_db: float
    reject_db: float
    samples: int
    size: Vector
    tgc: float
    time_gain: time_gain_settings

class b_mode_sampling:
    """What is traced for a picture."""
    @property
    def lines(self) -> int: ...
    @property
    def looks(self) -> int: ...
    @property
    def planes(self) -> int: ...
    @property
    def samples(self) -> int: ...

class straight_lines:
    """Sound that travels straight: the usual tracer."""
    def __init__(self, *, search: str = ..., directions: int = ...) -> None: ...
    directions: int
    search: str

class path_settings:
    """How far sound is followed."""
    def __init__(self, *, bounces: int = ..., min_amplitude: float = ..., face_reflection: float = ..., pairs: bool = ...) -> None: ...
    bounces: int
    face_reflection: float
    min_amplitude: float
    pairs: bool

class paths:
    """Sound that is refracted, and reflected several times: a tracer."""
    def __init__(self, *, settings: path_settings = ...) -> None: ...
    settings: path_settings

class line_frame:
    """Where a line runs, in the world."""
    @property
    def along(self) -> Vector: ...
    def at(self, distance: float) -> Vector: ...
    @property
    def elevation(self) -> Vector: ...
    @property
    def origin(self) -> Vector: ...
    @property
    def path(self) -> Vector: ...
    @property
    def tilt(self) -> float: ...

class line_layers:
    """What lies along every line of every elevation plane. A value: the scene may change afterwards."""
    def __call__(self, line: int, plane: int = ...) -> Array: ...
    def frame(self, line: int, plane: int = ...) -> line_frame: ...
    @property
    def lines(self) -> int: ...
    @property
    def media(self) -> Any: ...
    @property
    def planes(self) -> int: ...

class linear_array:
    """Flat array of parallel lines: for vessels, nerves and muscles."""
    def __init__(self, *, lines: int = ..., frequency: float = ..., fnumber: float = ..., focus: float = ..., elevation_height: float = ..., elevation_focus: float = ..., bandwidth: float = ..., side_lobes: float = ..., width: float = ...) -> None: ...
    @property
    def aperture(self) -> float: ...
    bandwidth: float
    def beam(self, line: float) -> tuple[Vector, Vector]: ...
    elevation_focus: float
    elevation_height: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    def locate(self, point: Vector) -> Vector: ...
    side_lobes: float
    width: float

class convex_array:
    """Curved array, its lines normal to the face: for the abdomen."""
    def __init__(self, *, lines: int = ..., frequency: float = ..., fnumber: float = ..., focus: float = ..., elevation_height: float = ..., elevation_focus: float = ..., bandwidth: float = ..., side_lobes: float = ..., radius: float = ..., field_of_view: float = ...) -> None: ...
    @property
    def aperture(self) -> float: ...
    bandwidth: float
    def beam(self, line: float) -> tuple[Vector, Vector]: ...
    elevation_focus: float
    elevation_height: float
    field_of_view: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    def locate(self, point: Vector) -> Vector: ...
    radius: float
    side_lobes: float

class phased_array:
    """Small flat array that steers its lines from its centre: for the heart."""
    def __init__(self, *, lines: int = ..., frequency: float = ..., fnumber: float = ..., focus: float = ..., elevation_height: float = ..., elevation_focus: float = ..., bandwidth: float = ..., side_lobes: float = ..., width: float = ..., field_of_view: float = ...) -> None: ...
    @property
    def aperture(self) -> float: ...
    bandwidth: float
    def beam(self, line: float) -> tuple[Vector, Vector]: ...
    elevation_focus: float
    elevation_height: float
    field_of_view: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    def locate(self, point: Vector) -> Vector: ...
    side_lobes: float
    width: float

class radial_array:
    """Catheter that scans a full circle: for vessels, from inside."""
    def __init__(self, *, lines: int = ..., frequency: float = ..., fnumber: float = ..., focus: float = ..., elevation_height: float = ..., elevation_focus: float = ..., bandwidth: float = ..., side_lobes: float = ..., radius: float = ...) -> None: ...
    @property
    def aperture(self) -> float: ...
    bandwidth: float
    def beam(self, line: float) -> tuple[Vector, Vector]: ...
    elevation_focus: float
    elevation_height: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    def locate(self, point: Vector) -> Vector: ...
    radius: float
    side_lobes: float

class presets:
    """Transducers, which are constants: copy.copy makes one that can be changed. Pairs of a probe and its settings for an examination: copies."""
    abdomen: tuple[convex_array, b_mode_settings]
    c5_2v: convex_array
    clinical_grey: grey_map
    heart: tuple[phased_array, b_mode_settings]
    @overload
    @staticmethod
    def in_use(transducer: linear_array) -> linear_array: ...
    @overload
    @staticmethod
    def in_use(transducer: convex_array) -> convex_array: ...
    @overload
    @staticmethod
    def in_use(transducer: phased_array) -> phased_array: ...
    intravascular: tuple[radial_array, b_mode_settings]
    l11_5v: linear_array
    l12_3v: linear_array
    nerve_block: tuple[linear_array, b_mode_settings]
    p4_2v: phased_array
    @overload
    @staticmethod
    def settings_for(probe: linear_array) -> b_mode_settings: ...
    @overload
    @staticmethod
    def settings_for(probe: convex_array) -> b_mode_settings: ...
    @overload
    @staticmethod
    def settings_for(probe: phased_array) -> b_mode_settings: ...
    @overload
    @staticmethod
    def settings_for(probe: radial_array) -> b_mode_settings: ...

class ground_truth_lines:
    """Ground truth of every sample, as maps on one grid."""
    @property
    def depth(self) -> scan_lines: ...
    @property
    def incidence(self) -> scan_lines: ...
    @property
    def label(self) -> label_lines: ...
    @property
    def medium(self) -> label_lines: ...
    @property
    def surface(self) -> label_lines: ...
    @property
    def transmitted(self) -> scan_lines: ...

class stored_frame:
    """A frame of the cine loop: amplitudes, before they are displayed."""
    @property
    def amplitudes(self) -> scan_lines: ...
    @property
    def at(self) -> pose: ...
    @property
    def time(self) -> float: ...

class cine_loop:
    """The stored frames of a scanner, the newest first."""
    def __getitem__(self, back: int) -> stored_frame: ...
    def __len__(self) -> int: ...

class stage_times:
    """How long the stages of a frame took, seconds."""
    @property
    def convolve(self) -> float: ...
    @property
    def detect(self) -> float: ...
    @property
    def display(self) -> float: ...
    @property
    def total(self) -> float: ...
    @property
    def trace(self) -> float: ...

class m_mode_settings:
    """Size of an M-mode image."""
    def __init__(self, *, columns: int = ..., rows: int = ..., background: float = ...) -> None: ...
    background: float
    columns: int
    rows: int

class m_mode:
    """One line against time."""
    def __init__(self, settings: m_mode_settings = ...) -> None: ...
    def add(self, lines: scan_lines, line: int) -> None: ...
    @property
    def count(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def picture(self) -> image: ...

class outline_measure:
    """What is measured of an outline."""
    @property
    def area(self) -> float: ...
    @property
    def centroid(self) -> Vector: ...
    @property
    def circumference(self) -> float: ...

class scanner:
    """What an application holds: probe, settings and model, which may change between frames, and the memory of pictures. Not for two threads at once."""
    @overload
    def __init__(self, probe: linear_array, settings: b_mode_settings = ..., model: physical = ..., how: Union[straight_lines, paths] = ...) -> None: ...
    @overload
    def __init__(self, probe: convex_array, settings: b_mode_settings = ..., model: physical = ..., how: Union[straight_lines, paths] = ...) -> None: ...
    @overload
    def __init__(self, probe: phased_array, settings: b_mode_settings = ..., model: physical = ..., how: Union[straight_lines, paths] = ...) -> None: ...
    @overload
    def __init__(self, probe: radial_array, settings: b_mode_settings = ..., model: physical = ..., how: Union[straight_lines, paths] = ...) -> None: ...
    @property
    def at(self) -> pose: ...
    @property
    def cine(self) -> cine_loop: ...
    cine_length: int
    def colour(self, scene: scene, field: velocity_field, settings: doppler_settings = ..., *, policy: str = ...) -> flow_lines: ...
    @property
    def echo_beams(self) -> Array: ...
    @property
    def echoes(self) -> iq_lines: ...
    def forget(self) -> None: ...
    def freeze(self) -> None: ...
    @property
    def frozen(self) -> bool: ...
    how: Any
    def labels(self, scene: scene, *, policy: str = ...) -> label_image: ...
    @property
    def layers(self) -> line_layers: ...
    @property
    def lines(self) -> scan_lines: ...
    @property
    def map(self) -> scan_map: ...
    model: physical
    @property
    def picture(self) -> image: ...
    def pixel(self, point: Vector) -> Vector: ...
    def point(self, pixel: Vector) -> Vector: ...
    probe: Any
    def scan(self, scene: scene, pose: pose, *, policy: str = ...) -> image: ...
    settings: b_mode_settings
    def show(self, back: int = ..., *, policy: str = ...) -> image: ...
    def spectrum(self, scene: scene, field: velocity_field, settings: pulsed_doppler_settings = ..., *, policy: str = ...) -> doppler_spectrum: ...
    time: float
    @property
    def times(self) -> stage_times: ...
    def unfreeze(self) -> None: ...

@overload
def write_png(path: Path, picture: image) -> None: ...
@overload
def write_png(path: Path, picture: colour_image) -> None: ...
@overload
def write_png(path: Path, picture: ArrayLike) -> None: ...
def inverse(pose: pose) -> pose: ...
@overload
def orthonormalised(pose: pose) -> pose: ...
@overload
def orthonormalised(matrix: ArrayLike) -> pose: ...
def needle_pose(tip: Vector, direction: Vector, bevel: Vector) -> pose: ...
def look_at(from_: Vector, towards: Vector, lateral: Vector) -> pose: ...
def make_box(lower: Vector, upper: Vector, subdivisions: int = ...) -> mesh: ...
def make_sphere(centre: Vector, radius: float, subdivisions: int = ...) -> mesh: ...
def make_cylinder(from_: Vector, to: Vector, radius: float, segments: int = ..., segments_along: int = ...) -> mesh: ...
def make_needle(diameter: float, length: float, bevel: float = ...) -> mesh: ...
def needle_diameter(gauge: int) -> float: ...
def validate(mesh: mesh) -> str: ...
def load_obj(path: Path, unit: float) -> mesh: ...
def load_obj_scene(path: Path, unit: float, background: medium = ...) -> scene: ...
def sample_map(map: Callable[[Array], Array], lower: Vector, upper: Vector, spacing: float) -> displacement_grid: ...
def compose(*args: Any) -> composed: ...
def filter_walls(echoes: iq_ensemble, filter: wall_filter = ..., *, policy: str = ...) -> iq_ensemble: ...
def add_electronic_noise(lines: iq_lines, settings: electronic_noise_settings = ..., *, policy: str = ...) -> iq_lines: ...
def to_rf(lines: iq_lines, frequency: float, *, policy: str = ...) -> scan_lines: ...
def envelope(lines: iq_lines, *, policy: str = ...) -> scan_lines: ...
def tgc(lines: scan_lines, frequency: float, settings: tgc_settings = ..., *, policy: str = ...) -> scan_lines: ...
def log_compress(lines: scan_lines, settings: log_compress_settings = ..., *, policy: str = ...) -> scan_lines: ...
def map_grey(lines: scan_lines, map: grey_map, *, policy: str = ...) -> scan_lines: ...
@overload
def scan_convert(lines: scan_lines, map: scan_map, *, policy: str = ...) -> image: ...
@overload
def scan_convert(lines: label_lines, map: scan_map, *, policy: str = ...) -> label_image: ...
def scan_convert_nearest(lines: scan_lines, map: scan_map, *, policy: str = ...) -> image: ...
def distance(map: scan_map, from_: Vector, to: Vector) -> float: ...
def measure_outline(map: scan_map, outline: Sequence[Vector]) -> outline_measure: ...
@overload
def b_mode(scene: scene, probe: linear_array, pose: pose, settings: b_mode_settings = ..., *, model: physical = ..., how: Union[straight_lines, paths] = ..., policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: convex_array, pose: pose, settings: b_mode_settings = ..., *, model: physical = ..., how: Union[straight_lines, paths] = ..., policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: phased_array, pose: pose, settings: b_mode_settings = ..., *, model: physical = ..., how: Union[straight_lines, paths] = ..., policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: radial_array, pose: pose, settings: b_mode_settings = ..., *, model: physical = ..., how: Union[straight_lines, paths] = ..., policy: str = ...) -> image: ...
@overload
def sampling_of(probe: linear_array, settings: b_mode_settings) -> b_mode_sampling: ...
@overload
def sampling_of(probe: convex_array, settings: b_mode_settings) -> b_mode_sampling: ...
@overload
def sampling_of(probe: phased_array, settings: b_mode_settings) -> b_mode_sampling: ...
@overload
def sampling_of(probe: radial_array, settings: b_mode_settings) -> b_mode_sampling: ...
@overload
def trace(scene: scene, probe: linear_array, pose: pose, model: physical, settings: acquisition, how: Union[straight_lines, paths] = ..., *, policy: str = ...) -> iq_lines: ...
@overload
def trace(scene: scene, probe: convex_array, pose: pose, model: physical, settings: acquisition, how: Union[straight_lines, paths] = ..., *, policy: str = ...) -> iq_lines: ...
@overload
def trace(scene: scene, probe: phased_array, pose: pose, model: physical, settings: acquisition, how: Union[straight_lines, paths] = ..., *, policy: str = ...) -> iq_lines: ...
@overload
def trace(scene: scene, probe: radial_array, pose: pose, model: physical, settings: acquisition, how: Union[straight_lines, paths] = ..., *, policy: str = ...) -> iq_lines: ...
@overload
def find_layers(scene: scene, probe: linear_array, pose: pose, scan: acquisition, *, policy: str = ...) -> line_layers: ...
@overload
def find_layers(scene: scene, probe: convex_array, pose: pose, scan: acquisition, *, policy: str = ...) -> line_layers: ...
@overload
def find_layers(scene: scene, probe: phased_array, pose: pose, scan: acquisition, *, policy: str = ...) -> line_layers: ...
@overload
def find_layers(scene: scene, probe: radial_array, pose: pose, scan: acquisition, *, policy: str = ...) -> line_layers: ...
@overload
def convolve(echoes: iq_lines, probe: linear_array, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: convex_array, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: phased_array, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: radial_array, *, policy: str = ...) -> iq_lines: ...
@overload
def make_scan_map(probe: linear_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def make_scan_map(probe: convex_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def make_scan_map(probe: phased_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def make_scan_map(probe: radial_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def ground_truth(scene: scene, probe: linear_array, pose: pose, settings: label_settings, *, model: physical = ..., policy: str = ...) -> ground_truth_lines: ...
@overload
def ground_truth(scene: scene, probe: convex_array, pose: pose, settings: label_settings, *, model: physical = ..., policy: str = ...) -> ground_truth_lines: ...
@overload
def ground_truth(scene: scene, probe: phased_array, pose: pose, settings: label_settings, *, model: physical = ..., policy: str = ...) -> ground_truth_lines: ...
@overload
def ground_truth(scene: scene, probe: radial_array, pose: pose, settings: label_settings, *, model: physical = ..., policy: str = ...) -> ground_truth_lines: ...
@overload
def diagnose(scene: scene, probe: linear_array, pose: pose, scan: acquisition) -> str: ...
@overload
def diagnose(scene: scene, probe: convex_array, pose: pose, scan: acquisition) -> str: ...
@overload
def diagnose(scene: scene, probe: phased_array, pose: pose, scan: acquisition) -> str: ...
@overload
def diagnose(scene: scene, probe: radial_array, pose: pose, scan: acquisition) -> str: ...
@overload
def press(scene: scene, probe: linear_array, pose: pose, settings: press_settings = ..., only: Optional[Sequence[int]] = ...) -> contact: ...
@overload
def press(scene: scene, probe: convex_array, pose: pose, settings: press_settings = ..., only: Optional[Sequence[int]] = ...) -> contact: ...
@overload
def press(scene: scene, probe: phased_array, pose: pose, settings: press_settings = ..., only: Optional[Sequence[int]] = ...) -> contact: ...
@overload
def colour_doppler(scene: scene, probe: linear_array, pose: pose, field: velocity_field, settings: doppler_settings = ..., *, model: physical = ..., policy: str = ...) -> flow_lines: ...
@overload
def colour_doppler(scene: scene, probe: convex_array, pose: pose, field: velocity_field, settings: doppler_settings = ..., *, model: physical = ..., policy: str = ...) -> flow_lines: ...
@overload
def colour_doppler(scene: scene, probe: phased_array, pose: pose, field: velocity_field, settings: doppler_settings = ..., *, model: physical = ..., policy: str = ...) -> flow_lines: ...
@overload
def colour_doppler(scene: scene, probe: radial_array, pose: pose, field: velocity_field, settings: doppler_settings = ..., *, model: physical = ..., policy: str = ...) -> flow_lines: ...
@overload
def pulsed_doppler(scene: scene, probe: linear_array, pose: pose, field: velocity_field, settings: pulsed_doppler_settings, *, model: physical = ..., policy: str = ...) -> doppler_spectrum: ...
@overload
def pulsed_doppler(scene: scene, probe: convex_array, pose: pose, field: velocity_field, settings: pulsed_doppler_settings, *, model: physical = ..., policy: str = ...) -> doppler_spectrum: ...
@overload
def pulsed_doppler(scene: scene, probe: phased_array, pose: pose, field: velocity_field, settings: pulsed_doppler_settings, *, model: physical = ..., policy: str = ...) -> doppler_spectrum: ...
@overload
def pulsed_doppler(scene: scene, probe: radial_array, pose: pose, field: velocity_field, settings: pulsed_doppler_settings, *, model: physical = ..., policy: str = ...) -> doppler_spectrum: ...
@overload
def doppler_ensemble(scene: scene, probe: linear_array, pose: pose, field: velocity_field, settings: ensemble_settings = ..., *, model: physical = ..., policy: str = ...) -> iq_ensemble: ...
@overload
def doppler_ensemble(scene: scene, probe: convex_array, pose: pose, field: velocity_field, settings: ensemble_settings = ..., *, model: physical = ..., policy: str = ...) -> iq_ensemble: ...
@overload
def doppler_ensemble(scene: scene, probe: phased_array, pose: pose, field: velocity_field, settings: ensemble_settings = ..., *, model: physical = ..., policy: str = ...) -> iq_ensemble: ...
@overload
def doppler_ensemble(scene: scene, probe: radial_array, pose: pose, field: velocity_field, settings: ensemble_settings = ..., *, model: physical = ..., policy: str = ...) -> iq_ensemble: ...
@overload
def doppler_picture(lines: flow_lines, probe: linear_array, settings: doppler_picture_settings = ..., *, policy: str = ...) -> image: ...
@overload
def doppler_picture(lines: flow_lines, probe: convex_array, settings: doppler_picture_settings = ..., *, policy: str = ...) -> image: ...
@overload
def doppler_picture(lines: flow_lines, probe: phased_array, settings: doppler_picture_settings = ..., *, policy: str = ...) -> image: ...
@overload
def doppler_picture(lines: flow_lines, probe: radial_array, settings: doppler_picture_settings = ..., *, policy: str = ...) -> image: ...
@overload
def colour_overlay(grey: image, lines: flow_lines, probe: linear_array, settings: colour_overlay_settings = ..., *, policy: str = ...) -> colour_image: ...
@overload
def colour_overlay(grey: image, lines: flow_lines, probe: convex_array, settings: colour_overlay_settings = ..., *, policy: str = ...) -> colour_image: ...
@overload
def colour_overlay(grey: image, lines: flow_lines, probe: phased_array, settings: colour_overlay_settings = ..., *, policy: str = ...) -> colour_image: ...
@overload
def colour_overlay(grey: image, lines: flow_lines, probe: radial_array, settings: colour_overlay_settings = ..., *, policy: str = ...) -> colour_image: ...
