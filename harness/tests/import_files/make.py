"""Writes the files of this folder by the libraries that meta.toml names, and what they hold.

    python make.py

All hold the same run: 200 samples at 2000 Hz, displacement, normal force and belt velocity. truth.csv
has the values in SI units, written by Python alone.
"""

import pathlib

import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import pyuff
import scipy.io
import scipy.io.wavfile
import soundfile
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

HERE = pathlib.Path(__file__).parent
COUNT = 200
RATE = 2000.0
t = np.arange(COUNT) / RATE
x = 4e-4 * np.sin(2 * np.pi * 80 * t) + 5e-5 * np.cos(2 * np.pi * 510 * t)
load = 60 + 2 * np.sin(2 * np.pi * 7 * t)
belt = 0.06 + 0.002 * np.cos(2 * np.pi * 3 * t)


def path(name):
    return str(HERE / name)


rows = zip(t.tolist(), x.tolist(), load.tolist(), belt.tolist())
(HERE / "truth.csv").write_text(
    "time_s,tip_displacement_m,normal_force_n,belt_velocity_m_per_s\n"
    + "".join(",".join(map(repr, row)) + "\n" for row in rows)
)

# MATLAB 5: arrays, compressed and not; a structure with units; other number types.
plain = {"t": t, "x": x, "F_N": load, "v_belt": belt}
scipy.io.savemat(path("matlab5.mat"), plain)
scipy.io.savemat(path("matlab5_compressed.mat"), plain, do_compression=True)
rig = {"laser": {"data": x * 1e3, "unit": "mm"}, "fs": RATE, "comment": "spring, rig 3"}
scipy.io.savemat(path("matlab5_struct.mat"), {"rig": rig})
scipy.io.savemat(
    path("matlab5_types.mat"),
    {"t_ms": np.arange(COUNT) * 0.5, "x_um": np.round(x * 1e6).astype(np.int16)},
)

# HDF5: groups, units and rates as attributes, chunks and compression.
with h5py.File(path("hdf5.h5"), "w") as file:
    for name, values, unit in [
        ("time", t * 1e3, "ms"),
        ("laser", x * 1e6, "um"),
        ("load", load * 1e-3, "kN"),
        ("acceleration", -x * 400.0, "m/s^2"),
    ]:
        data = file.create_dataset(f"rig/{name}", data=values, compression="gzip", shuffle=True)
        data.attrs["units"] = unit
with h5py.File(path("hdf5_rate.h5"), "w", libver="latest") as file:
    file.attrs["sample_rate"] = RATE
    file.create_dataset("x [mm]", data=x * 1e3)

# MATLAB 7.3 is HDF5 behind a head of 512 bytes.
with h5py.File(path("matlab73.mat"), "w", userblock_size=512) as file:
    for name, values in plain.items():
        data = file.create_dataset(name, data=values.reshape(1, -1))
        data.attrs["MATLAB_class"] = np.bytes_("double")
with open(path("matlab73.mat"), "r+b") as file:
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 ."
    file.write(head.ljust(116, b" ") + bytes(8) + b"\x00\x02IM")

# UFF 58, in text and binary; single, double; even and uneven.


def uff(name, kind, values, **further):
    (HERE / name).unlink(missing_ok=True)
    data = {
        "type": 58,
        "func_type": 1,
        "rsp_node": 3,
        "rsp_dir": 1,
        "ref_node": 0,
        "ref_dir": 0,
        "data": values,
        "x": t,
        "id1": "laser at the tip",
        "abscissa_spec_data_type": 17,
        "abscissa_axis_units_lab": "s",
        "ordinate_spec_data_type": 8,
        "ordinate_axis_units_lab": "mm",
        "binary": kind,
        "abscissa_spacing": 1,
        "abscissa_min": 0.0,
        "abscissa_inc": 1 / RATE,
        "orddenom_spec_data_type": 0,
        "z_axis_spec_data_type": 0,
    }
    data.update(further)
    pyuff.UFF(path(name)).write_sets([data], "add")


uff("ascii.uff", 0, x * 1e3)
uff("binary.uff", 1, x * 1e3)
uff("acceleration.uff", 0, x * 1e3, ordinate_spec_data_type=12, ordinate_axis_units_lab="m/s2")
uff("uneven.uff", 0, x * 1e3, abscissa_spacing=0)
uff("uneven_binary.uff", 1, x * 1e3, abscissa_spacing=0)

# WAV: shares of full scale, here 1 mm.
soundfile.write(path("pcm24.wav"), np.column_stack([x * 1e3, load * 1e-3]), int(RATE), "PCM_24")
soundfile.write(path("float.wav"), x * 1e3, int(RATE), "FLOAT")

# Parquet: packed by snappy and zstd; a column of texts; a missing value.
table = {"t [s]": t, "x [mm]": x * 1e3, "F_N [N]": load.astype(np.float32), "note": ["ok"] * COUNT}
pyarrow.parquet.write_table(pyarrow.table(table), path("snappy.parquet"))
pyarrow.parquet.write_table(pyarrow.table(table), path("zstd.parquet"), compression="zstd")
gap = [None if i in (50, 51) else v for i, v in enumerate(x.tolist())]
pyarrow.parquet.write_table(pyarrow.table({"t": t, "x": gap}), path("gap.parquet"))
first = 1_700_000_000_000_000_000
stamps = pyarrow.array([first + 500_000 * i for i in range(COUNT)])
stamps = stamps.cast(pyarrow.timestamp("ns"))
table = pyarrow.table({"timestamp": stamps, "x [mm]": x * 1e3})
pyarrow.parquet.write_table(table, path("instants.parquet"))

# TDMS: waveforms with units, in two segments.
root, group = RootObject({"rig": "3"}), GroupObject("rig")
with TdmsWriter(path("waveform.tdms")) as writer:
    for half in (slice(0, 120), slice(120, COUNT)):
        own = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0}
        laser = ChannelObject("rig", "laser", x[half] * 1e6, {**own, "unit_string": "um"})
        force = ChannelObject("rig", "load", load[half], {**own, "unit_string": "N"})
        slow = ChannelObject("rig", "temperature", np.array([21, 22], dtype=np.int32))
        writer.write_segment([root, group, laser, force, slow])

# TDMS: counts with a linear scale, and instants.
scale = {
    "NI_Number_Of_Scales": 1,
    "NI_Scaling_Status": "unscaled",
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 0.5,
    "NI_Scale[0]_Linear_Y_Intercept": -3.0,
    "unit_string": "um",
}
counts = np.round((x * 1e6 + 3.0) / 0.5).astype(np.int16)
instants = np.datetime64("2026-05-04T12:00:00.9", "us") + (t * 1e6).astype("timedelta64[us]")
with TdmsWriter(path("scaled.tdms")) as writer:
    channels = [ChannelObject("rig", "time", instants), ChannelObject("rig", "laser", counts, scale)]
    writer.write_segment(channels)
