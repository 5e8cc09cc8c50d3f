"""Writes the simulated logs of this folder as ROS 2 bags in MCAP.

    pip install mcap-ros2-support
    python make_bags.py FOLDER

FOLDER contains run.csv and second.csv of `sprung simulate`. The topic /joint_states has the links,
/motor_states the motors.
"""

import csv
import sys
from pathlib import Path

from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

DEFINITION = """std_msgs/Header header
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
JOINTS = ["shoulder", "elbow"]
START = 1_714_557_600 * 10**9  # 2024-05-01, ns


def message(stamp, position, effort):
    header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": ""}
    return {"header": header, "name": JOINTS, "position": position, "velocity": [], "effort": effort}


def convert(source, target):
    with open(source, newline="") as text, open(target, "wb") as sink:
        writer = Writer(sink, compression=CompressionType.ZSTD)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", DEFINITION)
        for row in csv.DictReader(text):
            value = {name: float(cell) for name, cell in row.items()}
            stamp = START + round(value["t_s"] * 1e9)
            links = message(stamp, [value["q1_rad"], value["q2_rad"]], [])
            motors = message(
                stamp, [value["phi1_rad"], value["phi2_rad"]], [value["tau1_nm"], value["tau2_nm"]]
            )
            writer.write_message("/joint_states", schema, links, stamp, stamp)
            writer.write_message("/motor_states", schema, motors, stamp, stamp)
        writer.finish()


def main():
    folder = Path(sys.argv[1])
    here = Path(__file__).parent
    for name in ["run", "second"]:
        convert(folder / f"{name}.csv", here / f"{name}.mcap")


if __name__ == "__main__":
    main()
