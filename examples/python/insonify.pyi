# Type stubs, written by make_stubs.py.
from typing import Any, Optional, Sequence, overload

import numpy as np

Vector = Sequence[float]
m: float
cm: float
mm: float
um: float
kHz: float
MHz: float
deg: float
dB_per_cm: float
background_label: int
no_level_db: float

class usage_error(ValueError):
    """A setting that is out of range, or a call out of order."""

class geometry_error(ValueError):
    """An invalid mesh or pose."""

class io_error(OSError):
    """A file that could not be read or written, or whose content is invalid."""

class variation:
    """Slow random variation of the level."""
    def __init__(self, *, deviation_db: Any = ..., size: Any = ...) -> None: ...
    deviation_db: float
    size: Vector

class sheet_layer:
    """Thin bright sheets of finite size, such as the perimysium."""
    def __init__(self, *, fill: Any = ..., lattices: Any = ..., cell: Any = ..., thickness: Any = ..., level_db: Any = ..., spread_db: Any = ..., turn: Any = ..., tilt: Any = ..., waviness: Any = ..., diffuse_db: Any = ...) -> None: ...
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
    def __init__(self, *, spacing: Any = ..., diameter: Any = ..., level_db: Any = ...) -> None: ...
    diameter: float
    level_db: float
    spacing: float

class sheath_layer:
    """The sheath of an object, such as the epimysium of a muscle."""
    def __init__(self, *, thickness: Any = ..., level_db: Any = ..., spread_db: Any = ..., waviness: Any = ..., diffuse_db: Any = ...) -> None: ...
    diffuse_db: float
    level_db: float
    spread_db: float
    thickness: float
    waviness: float

class structure:
    """What a tissue is made of above the scale of speckle."""
    def __init__(self, *, mottling: Any = ..., grain: Any = ..., wave: Any = ..., wave_length: Any = ..., sheets: Any = ..., septa: Any = ..., bundles: Any = ..., sheath: Any = ...) -> None: ...
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
    def __init__(self, *, density: Any = ..., sound_speed: Any = ..., attenuation: Any = ..., attenuation_power: Any = ..., backscatter: Any = ..., roughness: Any = ..., scatterer_density: Any = ..., structure: Any = ..., flowing: Any = ...) -> None: ...
    attenuation: float
    attenuation_power: float
    backscatter: float
    density: float
    flowing: bool
    impedance: float
    roughness: float
    scatterer_density: float
    sound_speed: float
    structure: structure

class tissue:
    """Media of the body, of instruments and of phantoms: copies, to be changed freely."""
    air: medium
    bile: medium
    bladder_wall: medium
    blood: medium
    bone: medium
    bone_cortical: medium
    bone_trabecular: medium
    brain: medium
    cartilage: medium
    eye_lens: medium
    fascia: medium
    fat: medium
    gallbladder_wall: medium
    gel: medium
    heart: medium
    kidney: medium
    lens: medium
    liver: medium
    lung: medium
    muscle: medium
    nerve: medium
    pvcp: medium
    saline: medium
    skin: medium
    soft_tissue: medium
    spleen: medium
    steel: medium
    tendon: medium
    titanium: medium
    tmm_cyst: medium
    tmm_high: medium
    tmm_low: medium
    urethane: medium
    urine: medium
    vessel_wall: medium
    water: medium

class scan_lines:
    """Real values along lines: envelope, brightness, angles."""
    def __init__(self, values: np.ndarray, depth: float) -> None: ...
    count: int
    depth: float
    samples: int
    values: np.ndarray

class iq_lines:
    """Complex baseband echoes along lines."""
    def __init__(self, values: np.ndarray, depth: float) -> None: ...
    count: int
    depth: float
    samples: int
    values: np.ndarray

class label_lines:
    """The object at each sample."""
    def __init__(self, values: np.ndarray, depth: float) -> None: ...
    count: int
    depth: float
    samples: int
    values: np.ndarray

class image:
    """A greyscale image: 0 black to 1 white."""
    pixels: np.ndarray
    size: Vector

class label_image:
    """The object at each pixel."""
    pixels: np.ndarray
    size: Vector

class scan_map:
    """Interpolation table of scan_convert, and pixel to millimetre."""
    def pixel(self, point: Vector) -> Vector: ...
    pitch: Vector
    def point(self, pixel: Vector) -> Vector: ...
    size: Vector

class pose:
    """Rigid transform from local to world coordinates."""
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, matrix: np.ndarray) -> None: ...
    def __matmul__(self, arg0: pose) -> pose: ...
    def local_point(self, p: Vector) -> Vector: ...
    matrix: np.ndarray
    def point(self, p: Vector) -> Vector: ...
    translation: Vector

class mesh:
    """Indexed triangle mesh; faces are counter-clockwise seen from outside."""
    def __init__(self, positions: np.ndarray, faces: np.ndarray) -> None: ...
    faces: np.ndarray
    positions: np.ndarray

class scene:
    """Closed surfaces, each filled with a medium, in a background."""
    def __init__(self, background: medium = ...) -> None: ...
    def add(self, mesh: mesh, medium: medium, *, priority: int = ..., at: pose = ..., name: str = ..., fibres: Vector = ..., crease_angle: float = ...) -> int: ...
    def box(self) -> tuple[Vector, Vector]: ...
    def build(self, policy: str = ...) -> Any: ...
    def find(self, name: str) -> Optional[int]: ...
    is_built: bool
    names: dict
    def object_at(self, point: Vector) -> Optional[int]: ...
    def place(self, id: int, at: pose) -> None: ...
    def positions(self, id: int) -> np.ndarray: ...
    def remove(self, id: int) -> None: ...
    def set_background_fibres(self, along: Vector, flat: Vector = ...) -> None: ...
    def set_medium(self, id: int, medium: medium) -> None: ...
    def update(self, policy: str = ...) -> None: ...

class linear_array:
    """Flat array of parallel lines: for vessels, nerves and muscles."""
    def __init__(self, *, lines: Any = ..., frequency: Any = ..., fnumber: Any = ..., focus: Any = ..., elevation_height: Any = ..., elevation_focus: Any = ..., bandwidth: Any = ..., side_lobes: Any = ..., width: Any = ...) -> None: ...
    bandwidth: float
    elevation_focus: float
    elevation_height: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    side_lobes: float
    width: float

class convex_array:
    """Curved array, its lines normal to the face: for the abdomen."""
    def __init__(self, *, lines: Any = ..., frequency: Any = ..., fnumber: Any = ..., focus: Any = ..., elevation_height: Any = ..., elevation_focus: Any = ..., bandwidth: Any = ..., side_lobes: Any = ..., radius: Any = ..., field_of_view: Any = ...) -> None: ...
    bandwidth: float
    elevation_focus: float
    elevation_height: float
    field_of_view: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    radius: float
    side_lobes: float

class phased_array:
    """Small flat array that steers its lines from its centre: for the heart."""
    def __init__(self, *, lines: Any = ..., frequency: Any = ..., fnumber: Any = ..., focus: Any = ..., elevation_height: Any = ..., elevation_focus: Any = ..., bandwidth: Any = ..., side_lobes: Any = ..., width: Any = ..., field_of_view: Any = ...) -> None: ...
    bandwidth: float
    elevation_focus: float
    elevation_height: float
    field_of_view: float
    fnumber: float
    focus: float
    frequency: float
    lines: int
    side_lobes: float
    width: float

class presets:
    """Transducers, by their names: copies, to be changed freely."""
    c5_2v: convex_array
    @overload
    @staticmethod
    def in_use(transducer: linear_array) -> linear_array: ...
    @overload
    @staticmethod
    def in_use(transducer: convex_array) -> convex_array: ...
    @overload
    @staticmethod
    def in_use(transducer: phased_array) -> phased_array: ...
    l11_5v: linear_array
    l12_3v: linear_array
    p4_2v: phased_array

class physical:
    """The pulse-echo model."""
    def __init__(self, *, texture_db: Any = ..., shadow_floor_db: Any = ..., seed: Any = ..., min_ringing: Any = ...) -> None: ...
    min_ringing: float
    seed: int
    shadow_floor_db: float
    texture_db: float

class acquisition:
    """Depth and sampling of the scan lines."""
    def __init__(self, *, depth: Any = ..., samples: Any = ..., planes: Any = ..., frame: Any = ...) -> None: ...
    depth: float
    frame: int
    planes: int
    samples: int

class tgc_point:
    """A point of a time-gain curve."""
    def __init__(self, *, depth: Any = ..., gain_db: Any = ...) -> None: ...
    depth: float
    gain_db: float

class tgc_settings:
    """Time-gain compensation."""
    def __init__(self, *, attenuation: Any = ..., max_db: Any = ..., sliders: Any = ..., curve: Any = ...) -> None: ...
    attenuation: float
    curve: list[tgc_point]
    max_db: float
    sliders: list[float[8]]

class log_compress_settings:
    """From amplitude to brightness."""
    def __init__(self, *, dynamic_range_db: Any = ..., reference_db: Any = ..., gain_db: Any = ..., reject_db: Any = ...) -> None: ...
    dynamic_range_db: float
    gain_db: float
    reference_db: float
    reject_db: float

class scan_convert_settings:
    """Size and background of the image."""
    def __init__(self, *, size: Any = ..., background: Any = ...) -> None: ...
    background: float
    size: Vector

class electronic_noise_settings:
    """Noise of the receiver."""
    def __init__(self, *, level_db: Any = ..., seed: Any = ..., frame: Any = ...) -> None: ...
    frame: int
    level_db: float
    seed: int

class label_settings:
    """Depth and sampling of labels."""
    def __init__(self, *, depth: Any = ..., samples: Any = ..., grid: Any = ...) -> None: ...
    depth: float
    grid: str
    samples: int

class grey_map:
    """Tone curve for display."""
    def __init__(self, *, gamma: Any = ..., contrast: Any = ..., reject: Any = ..., shoulder: Any = ..., softness: Any = ...) -> None: ...
    contrast: float
    gamma: float
    reject: float
    shoulder: float
    softness: float

class time_gain_settings:
    """Time-gain compensation beside `tgc`."""
    def __init__(self, *, chosen: Any = ..., max_db: Any = ..., sliders: Any = ..., curve: Any = ...) -> None: ...
    chosen: str
    curve: list[tgc_point]
    max_db: float
    sliders: list[float[8]]

class noise_level:
    """Electronic noise of a picture."""
    def __init__(self, *, level_db: Any = ..., seed: Any = ...) -> None: ...
    level_db: float
    seed: int

class near_field_settings:
    """Echoes of the probe itself."""
    def __init__(self, *, shown: Any = ..., lens_thickness: Any = ..., back_reflection: Any = ..., ring_down_db: Any = ..., ring_down: Any = ...) -> None: ...
    back_reflection: float
    lens_thickness: float
    ring_down: float
    ring_down_db: float
    shown: str

class compound_settings:
    """Looks at several angles, averaged."""
    def __init__(self, *, angles: Any = ..., spread: Any = ..., update: Any = ...) -> None: ...
    angles: int
    spread: float
    update: str

class b_mode_settings:
    """Settings of a B-mode image, as on a scanner."""
    def __init__(self, *, depth: Any = ..., samples: Any = ..., size: Any = ..., dynamic_range_db: Any = ..., reference_db: Any = ..., gain_db: Any = ..., tgc: Any = ..., planes: Any = ..., background: Any = ..., time_gain: Any = ..., reject_db: Any = ..., grey: Any = ..., persistence: Any = ..., noise: Any = ..., frame: Any = ..., near_field: Any = ..., compound: Any = ...) -> None: ...
    background: float
    compound: compound_settings
    depth: float
    dynamic_range_db: float
    frame: int
    gain_db: float
    grey: grey_map
    near_field: near_field_settings
    noise: noise_level
    persistence: float
    planes: int
    reference_db: float
    reject_db: float
    samples: int
    size: Vector
    tgc: float
    time_gain: time_gain_settings

class ground_truth_lines:
    """Ground truth of every sample, as maps on one grid."""
    depth: scan_lines
    incidence: scan_lines
    label: label_lines
    medium: label_lines
    surface: label_lines
    transmitted: scan_lines

def write_png(path: str, picture: image) -> None: ...
def inverse(pose: pose) -> pose: ...
def look_at(from_: Vector, towards: Vector, lateral: Vector) -> pose: ...
def make_box(lower: Vector, upper: Vector, subdivisions: int = ...) -> mesh: ...
def make_sphere(centre: Vector, radius: float, subdivisions: int = ...) -> mesh: ...
def make_cylinder(from_: Vector, to: Vector, radius: float, segments: int = ..., segments_along: int = ...) -> mesh: ...
def make_needle(diameter: float, length: float, bevel: float = ...) -> mesh: ...
def needle_diameter(gauge: int) -> float: ...
def load_obj(path: str, unit: float) -> mesh: ...
def validate(mesh: mesh) -> str: ...
def load_obj_scene(path: str, unit: float, background: medium = ...) -> scene: ...
def add_electronic_noise(lines: iq_lines, settings: electronic_noise_settings = ..., *, policy: str = ...) -> iq_lines: ...
def envelope(lines: iq_lines, *, policy: str = ...) -> scan_lines: ...
def tgc(lines: scan_lines, frequency: float, settings: tgc_settings = ..., *, policy: str = ...) -> scan_lines: ...
def log_compress(lines: scan_lines, settings: log_compress_settings = ..., *, policy: str = ...) -> scan_lines: ...
def map_grey(lines: scan_lines, map: grey_map, *, policy: str = ...) -> scan_lines: ...
@overload
def scan_convert(lines: scan_lines, map: scan_map, *, policy: str = ...) -> image: ...
@overload
def scan_convert(lines: label_lines, map: scan_map, *, policy: str = ...) -> label_image: ...
def scan_convert_nearest(lines: scan_lines, map: scan_map, *, policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: linear_array, pose: pose, settings: b_mode_settings = ..., model: physical = ..., *, policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: convex_array, pose: pose, settings: b_mode_settings = ..., model: physical = ..., *, policy: str = ...) -> image: ...
@overload
def b_mode(scene: scene, probe: phased_array, pose: pose, settings: b_mode_settings = ..., model: physical = ..., *, policy: str = ...) -> image: ...
@overload
def trace(scene: scene, probe: linear_array, pose: pose, model: physical, settings: acquisition, *, policy: str = ...) -> iq_lines: ...
@overload
def trace(scene: scene, probe: convex_array, pose: pose, model: physical, settings: acquisition, *, policy: str = ...) -> iq_lines: ...
@overload
def trace(scene: scene, probe: phased_array, pose: pose, model: physical, settings: acquisition, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: linear_array, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: convex_array, *, policy: str = ...) -> iq_lines: ...
@overload
def convolve(echoes: iq_lines, probe: phased_array, *, policy: str = ...) -> iq_lines: ...
@overload
def make_scan_map(probe: linear_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def make_scan_map(probe: convex_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def make_scan_map(probe: phased_array, scan: acquisition, settings: scan_convert_settings = ..., *, policy: str = ...) -> scan_map: ...
@overload
def ground_truth(scene: scene, probe: linear_array, pose: pose, settings: label_settings, model: physical = ..., *, policy: str = ...) -> ground_truth_lines: ...
@overload
def ground_truth(scene: scene, probe: convex_array, pose: pose, settings: label_settings, model: physical = ..., *, policy: str = ...) -> ground_truth_lines: ...
@overload
def ground_truth(scene: scene, probe: phased_array, pose: pose, settings: label_settings, model: physical = ..., *, policy: str = ...) -> ground_truth_lines: ...
@overload
def diagnose(scene: scene, probe: linear_array, pose: pose, scan: acquisition) -> str: ...
@overload
def diagnose(scene: scene, probe: convex_array, pose: pose, scan: acquisition) -> str: ...
@overload
def diagnose(scene: scene, probe: phased_array, pose: pose, scan: acquisition) -> str: ...
