"""Beamforms a file of `channels`, or any in the layout of zea, by delay and sum with NumPy.

    python3 beamform.py channels.hdf5 image.png
"""
import sys

import h5py
import numpy as np


def baseband(raw, rate, carrier, bandwidth):
    """IQ, (4 n_ax, n_el), four times as dense, of the band of RF or IQ, (n_ax, n_el, n_ch)."""
    samples, is_iq = len(raw), raw.shape[-1] == 2
    spectrum = np.fft.fft(raw[..., 0] + 1j * raw[..., 1] if is_iq else 2 * raw[..., 0], axis=0)
    from_carrier = np.fft.fftfreq(samples, 1 / rate) - (0 if is_iq else carrier)
    place = np.clip(np.abs(from_carrier) / (bandwidth * carrier), 0.5, 1)  # within the band of -6 dB: 0.5
    spectrum *= np.sin(np.pi * place)[:, None] ** 2  # without negative frequencies of RF, and noise beyond the band
    half = samples // 2
    spectrum = np.concatenate([spectrum[:half], np.zeros((3 * samples, raw.shape[1])), spectrum[half:]])
    signal = 4 * np.fft.ifft(spectrum, axis=0)
    time = np.arange(4 * samples) / (4 * rate)
    return signal if is_iq else signal * np.exp(-2j * np.pi * carrier * time)[:, None]


def arrival(points, elements, delays, weights, focus, angle, origin, speed):
    """When a transmit arrives at points, (..., 3), in seconds after the first element fires."""
    fires = weights != 0
    if np.isfinite(focus) and focus > 0:  # towards the focus, through it, and away from it
        direction = np.array([np.sin(angle), 0, np.cos(angle)])
        source = origin + focus * direction
        reached = np.mean(delays[fires] + np.linalg.norm(elements[fires] - source, axis=-1) / speed)
        beyond = np.sign((points - source) @ direction)
        return reached + beyond * np.linalg.norm(points - source, axis=-1) / speed
    first = np.full(points.shape[:-1], np.inf)  # the first of the elements' waves
    for element, delay in zip(elements[fires], delays[fires]):
        first = np.minimum(first, delay + np.linalg.norm(points - element, axis=-1) / speed)
    return first


def beamform(file, x, z, fnumber=1.5, frame=0, sound_speed=None):
    """Complex image, (z, x), of a file in the layout of zea, at depths z and places x, metres."""
    raw, scan = file["tracks/track_0/data/raw_data"], {k: v[()] for k, v in file["tracks/track_0/scan"].items()}
    elements, rate, carrier = file["probe/probe_geometry"][:], scan["sampling_frequency"], scan["center_frequency"]
    speed = sound_speed or scan["sound_speed"]
    bandwidth = file["probe/probe_bandwidth_percent"][()] / 100
    points = np.stack(np.broadcast_arrays(x[None, :], 0.0, z[:, None]), axis=-1)
    away = [np.linalg.norm(points - element, axis=-1) for element in elements]
    image = np.zeros(points.shape[:-1], complex)
    for t in range(raw.shape[1]):
        signals = baseband(raw[frame, t], rate, carrier, bandwidth)
        sent = arrival(points, elements, scan["t0_delays"][t], scan["tx_apodizations"][t], scan["focus_distances"][t],
                       scan["polar_angles"][t], scan["transmit_origins"][t], speed)
        for e, element in enumerate(elements):
            time = sent + away[e] / speed - scan["initial_times"][t]
            signal = np.interp(4 * rate * time, np.arange(len(signals)), signals[:, e], left=0, right=0)
            receives = np.abs(points[..., 0] - element[0]) <= 0.5 * points[..., 2] / fnumber
            image += receives * signal * np.exp(2j * np.pi * carrier * time)
    return image


if __name__ == "__main__":
    import matplotlib.pyplot as plt

    with h5py.File(sys.argv[1]) as file:
        truth = file["tracks/track_0/data/sos_map/coordinates"]
        width, depth = np.abs(file["probe/probe_geometry"][:, 0]).max(), float(truth[0, -1, 0, 2])
        x, z = np.linspace(-width, width, 256), np.linspace(1e-3, depth, 768)
        level = 20 * np.log10(np.abs(beamform(file, x, z)) + 1e-30)
    plt.imshow(level - level.max(), "gray", vmin=-60, vmax=0, extent=[1e3 * x[0], 1e3 * x[-1], 1e3 * z[-1], 1e3 * z[0]])
    plt.xlabel("mm")
    plt.ylabel("mm")
    plt.savefig(sys.argv[2], dpi=150, bbox_inches="tight")
