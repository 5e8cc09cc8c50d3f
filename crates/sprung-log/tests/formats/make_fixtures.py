"""Writes one log in every format with the writers that people use.

    pip install numpy scipy h5py pandas pyarrow zstandard mcap mcap-ros2-support rosbags
    python make_fixtures.py [FOLDER]

The numbers are the same in all files; tests/formats/same.rs reads them back. FOLDER is `fixtures` by default.
`cargo xtask test outside formats` installs the writers, writes new files and reads them.
"""

import gzip
import io
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
import zstandard

HERE = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "fixtures"
ROWS = 240
NAMES = ["t_s", "q1_rad", "q2_rad", "phi1_rad", "phi2_rad", "tau1_nm", "tau2_nm"]


def table():
    """[ROWS, 7]: time, link positions, motor positions, torques."""
    t = np.arange(ROWS) / 1000.0
    waves = [0.3 * np.sin((9 + 2 * k) * t + k) + 0.01 * k * t for k in range(6)]
    return np.column_stack([t, *waves])


def text(data, delimiter=",", header=True, decimal=".", first=""):
    lines = [delimiter.join(NAMES)] if header else []
    lines += [delimiter.join(repr(float(x)).replace(".", decimal) for x in row) for row in data]
    return first + "\n".join(lines) + "\n"


def csvs(data):
    plain = text(data)
    (HERE / "plain.csv").write_text(plain)
    (HERE / "german.csv").write_text("\ufeff" + text(data, ";", decimal=","), encoding="utf-8")
    (HERE / "bare.txt").write_text(text(data, "\t", header=False))
    (HERE / "log.csv.gz").write_bytes(gzip.compress(plain.encode(), mtime=0))
    (HERE / "log.csv.zst").write_bytes(zstandard.ZstdCompressor().compress(plain.encode()))
    buffer = io.StringIO()
    np.savetxt(buffer, data, fmt="%24.17g", header=" ".join(NAMES))
    (HERE / "savetxt.dat").write_text(buffer.getvalue())


def arrays(data):
    np.save(HERE / "plain.npy", data)
    np.save(HERE / "fortran.npy", np.asfortranarray(data))
    kinds = [("t", "<f8"), ("robot", "<U5"), ("q", "<f8", 2), ("phi", ">f8", 2), ("tau", "<f8", 2)]
    records = np.zeros(len(data), dtype=kinds)
    records["t"], records["q"], records["phi"], records["tau"] = (
        data[:, 0], data[:, 1:3], data[:, 3:5], data[:, 5:7])
    np.save(HERE / "records.npy", records)
    members = dict(t=data[:, 0], q=data[:, 1:3], phi=data[:, 3:5].T.copy(),
                   tau=np.asfortranarray(data[:, 5:7]), rate=1000.0, note="a twin")
    np.savez(HERE / "plain.npz", **members)
    np.savez_compressed(HERE / "packed.npz", **members)


def matlab(data):
    flat = dict(t=data[:, :1], q=data[:, 1:3], phi=data[:, 3:5].T, tau1=data[:, 5:6],
                tau2=data[:, 6:7].T, rate=1000.0, note="a twin")
    scipy.io.savemat(HERE / "flat.mat", flat)
    signals = np.zeros(2, dtype=[("values", object), ("label", object)])
    signals[0] = (data[:, 3:5], "motor")
    signals[1] = (data[:, 5:7], "torque")
    struct = {"data": {"time": data[:, 0], "link": {"q": data[:, 1:3]}, "signals": signals}}
    scipy.io.savemat(HERE / "struct.mat", struct, do_compression=True, oned_as="column")


MATLAB_TYPES = {"f8": "double", "f4": "single", "i8": "int64", "i4": "int32", "i2": "int16", "i1": "int8",
                "u8": "uint64", "u4": "uint32", "u2": "uint16", "u1": "uint8"}


def classed(item, name):
    """What MATLAB says of an object, as text of fixed length."""
    item.attrs["MATLAB_class"] = np.bytes_(name)
    return item


def array73(group, name, values, **how):
    """An array as MATLAB 7.3 has it: sides in reverse order, named as in MATLAB."""
    values = np.atleast_2d(values)
    if values.dtype == bool:
        item = array73(group, name, values.astype("u1"), **how)
        item.attrs["MATLAB_int_decode"] = np.int32(1)
        return classed(item, "logical")
    item = group.create_dataset(name, data=values.T, **how)
    return classed(item, MATLAB_TYPES.get(values.dtype.str[1:], "double"))


def struct73(group, name):
    return classed(group.create_group(name), "struct")


def file73(name, write):
    """MATLAB puts 512 bytes of its own before the HDF5."""
    path = HERE / name
    with h5py.File(path, "w", libver="earliest", userblock_size=512) as file:
        write(file)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  5 10:00:00 2026 HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


def matlab73(data):
    counts = np.round(data[:, 1:2] * 1e6)
    def flat(file):
        array73(file, "t", data[:, :1])
        array73(file, "q", data[:, 1:3])
        array73(file, "phi", data[:, 3:5].T)
        array73(file, "tau1", data[:, 5:6])
        array73(file, "tau2", data[:, 6:7].T.astype(">f8"))
        array73(file, "rate", 1000.0)
        array73(file, "on", data[:, 1:2] > 0)
        for kind in ["f4", "i1", "i2", "i4", "i8", "u8"]:
            array73(file, f"counts_{kind}", (counts % 100).astype(kind))
        array73(file, "stamp", 1714557600 * 10**9 + np.round(data[:, :1] * 1e9).astype("i8"))
        array73(file, "cube", np.zeros((40, 3, 2)))
        array73(file, "turning", data[:, :1] * (1 + 1j))
        note = array73(file, "note", np.frombuffer("a twin".encode("utf-16le"), "u2")[None])
        classed(note, "char").attrs["MATLAB_int_decode"] = np.int32(2)
        kept = file.create_group("#refs#")
        cells = [array73(kept, f"c{k}", data[:, k:k + 1]).ref for k in range(2)]
        classed(file.create_dataset("cells", data=np.array([cells], h5py.ref_dtype).T,
                                    dtype=h5py.ref_dtype), "cell")
        sparse = classed(file.create_group("few"), "double")
        sparse.attrs["MATLAB_sparse"] = np.uint64(240)
        sparse["data"], sparse["ir"] = np.ones(3), np.arange(3, dtype="u8")
        sparse["jc"] = np.array([0, 3], "u8")
        table = array73(file, "frame", np.arange(6, dtype="u4"))
        classed(table, "table").attrs["MATLAB_object_decode"] = np.int32(3)
        empty = array73(file, "nothing", np.zeros((1, 2), "u8"))
        empty.attrs["MATLAB_empty"] = np.uint8(1)
    def struct(file):
        packed = dict(compression="gzip", compression_opts=3, shuffle=True)
        # Chunks across all columns, along one, and a size that does not divide the length.
        whole = struct73(file, "data")
        array73(whole, "time", data[:, 0:1], chunks=(1, 77), **packed)
        array73(struct73(whole, "link"), "q", data[:, 1:3], chunks=(2, 50), **packed)
        kept = file.create_group("#refs#")
        signals = struct73(whole, "signals")
        values = [array73(kept, "a", data[:, 3:5], chunks=(1, 100), **packed).ref,
                  array73(kept, "b", data[:, 5:7], chunks=(2, 64), fletcher32=True, **packed).ref]
        signals.create_dataset("values", data=np.array([values], h5py.ref_dtype).T, dtype=h5py.ref_dtype)
        labels = [classed(array73(kept, key, np.array([[109, 111]], "u2")), "char").ref for key in "cd"]
        signals.create_dataset("label", data=np.array([labels], h5py.ref_dtype).T, dtype=h5py.ref_dtype)
    file73("flat73.mat", flat)
    file73("struct73.mat", struct)


def tables(data):
    frame = pd.DataFrame(data, columns=NAMES)
    for name, codec in [("snappy", "snappy"), ("zstd", "zstd"), ("gzip", "gzip"), ("lz4", "lz4")]:
        frame.to_parquet(HERE / f"{name}.parquet", compression=codec, row_group_size=100)
    stamped = frame.copy()
    stamped.insert(0, "stamp", pd.to_datetime("2024-05-01T10:00:00") + pd.to_timedelta(
        np.round(data[:, 0] * 1e9).astype("int64")))
    stamped["note"] = "a twin"
    stamped.to_parquet(HERE / "stamped.parquet", compression="zstd")
    whole = pa.Table.from_pandas(frame, preserve_index=False)
    with pa.OSFile(str(HERE / "file.arrow"), "wb") as sink:
        with pa.ipc.new_file(sink, whole.schema) as writer:
            writer.write_table(whole, max_chunksize=77)
    with pa.OSFile(str(HERE / "stream.arrows"), "wb") as sink:
        options = pa.ipc.IpcWriteOptions(compression="zstd")
        with pa.ipc.new_stream(sink, whole.schema, options=options) as writer:
            writer.write_table(whole, max_chunksize=77)
    whole_lists = pa.table({
        "t_s": data[:, 0],
        "q": pa.FixedSizeListArray.from_arrays(pa.array(data[:, 1:3].ravel()), 2),
        "phi": pa.array(data[:, 3:5].tolist()),
        "tau1_nm": data[:, 5], "tau2_nm": data[:, 6]})
    pq.write_table(whole_lists, HERE / "lists.parquet", compression="zstd")


def messages(data, late=0):
    """Topic, receive time [ns], names, positions and efforts, in turn.

    Names stand in another order in every other message, and a gripper speaks
    on the same topic.
    """
    for k, row in enumerate(data):
        stamp = int(round(row[0] * 1e9))
        order = [0, 1] if k % 2 == 0 else [1, 0]
        name = [["joint1", "joint2"][i] for i in order]
        yield "/joint_states", stamp, name, [row[1 + i] for i in order], []
        if k % 10 == 3:
            yield "/joint_states", stamp, ["finger"], [0.1 * k], [0.0]
        yield ("/motor_states", stamp + late, name, [row[3 + i] for i in order],
               [row[5 + i] for i in order])


def mcaps(data):
    from mcap.writer import CompressionType
    from mcap_ros2.writer import Writer
    definition = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec"""
    nested = """# Written by hand.
uint8 STATE_IDLE=0
builtin_interfaces/Time stamp
string<=20 label "none"
Motor[2] motors
float32[<=4] spare
bool ok
================================================================================
MSG: my_robot/Motor
uint16 temperature
float64[3] pqt
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec"""
    def header(stamp):
        return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "base"}
    for name, codec, epoch in [("zstd", CompressionType.ZSTD, 0), ("lz4", CompressionType.LZ4, 0),
                               ("none", CompressionType.NONE, 0),
                               ("epoch", CompressionType.ZSTD, 1714557600 * 10**9)]:
        with open(HERE / f"{name}.mcap", "wb") as sink:
            writer = Writer(sink, compression=codec, chunk_size=4096)
            schema = writer.register_msgdef("sensor_msgs/msg/JointState", definition)
            for topic, stamp, names, position, effort in messages(data):
                stamp += epoch
                message = {"header": header(stamp), "name": names, "position": position,
                           "velocity": [], "effort": effort}
                writer.write_message(topic, schema, message, stamp + 1500000, stamp)
            writer.finish()
    with open(HERE / "nested.mcap", "wb") as sink:
        writer = Writer(sink, compression=CompressionType.ZSTD)
        schema = writer.register_msgdef("my_robot/msg/State", nested)
        for row in data:
            stamp = int(round(row[0] * 1e9))
            motors = [{"temperature": 20, "pqt": [row[3 + i], row[1 + i], row[5 + i]]} for i in (0, 1)]
            message = {"stamp": header(stamp)["stamp"], "label": "run", "motors": motors,
                       "spare": [1.0], "ok": True}
            writer.write_message("/state", schema, message, stamp, stamp)
        writer.finish()
    with open(HERE / "late.mcap", "wb") as sink:
        writer = Writer(sink, compression=CompressionType.ZSTD)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", definition)
        for topic, stamp, names, position, effort in messages(data, late=400000):
            message = {"header": header(stamp), "name": names, "position": position,
                       "velocity": [], "effort": effort}
            writer.write_message(topic, schema, message, stamp, stamp)
        writer.finish()


def bags(data):
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = store.types["sensor_msgs/msg/JointState"]
    head, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    for name, version in [("plain", 8), ("defined", 9)]:
        folder = HERE / f"bag_{name}"
        shutil.rmtree(folder, ignore_errors=True)
        with Writer(folder, version=version, storage_plugin=StoragePlugin.SQLITE3) as writer:
            known = {topic: writer.add_connection(topic, kind.__msgtype__, typestore=store)
                     for topic in ["/joint_states", "/motor_states"]}
            for topic, stamp, names, position, effort in messages(data):
                message = kind(head(time(stamp // 10**9, stamp % 10**9), "base"), names,
                               np.array(position), np.array([]), np.array(effort))
                blob = store.serialize_cdr(message, kind.__msgtype__)
                writer.write(known[topic], stamp, blob)
        (next(folder.glob("*.db3"))).rename(HERE / f"{name}.db3")
        shutil.rmtree(folder)


def main():
    HERE.mkdir(parents=True, exist_ok=True)
    data = table()
    for write in [csvs, arrays, matlab, matlab73, tables, mcaps, bags]:
        write(data)
    total = sum(file.stat().st_size for file in HERE.iterdir())
    print(f"{total / 1e3:.0f} kB in {HERE}", file=sys.stderr)


if __name__ == "__main__":
    main()
