"""Compares the time of exported C code of seven joints with Pinocchio's rnea, both compiled on this machine.

    python rnea.py SPRUNG FOLDER

`tools.py` must have written the robots in FOLDER. The headers of Pinocchio come from the package
pin, those of Eigen from cmeel-eigen. The script fails if torques differ, if the code without
friction is slower than rnea, or above 2 microseconds.
"""

import pathlib
import re
import subprocess
import sys

import numpy as np
import pinocchio as pin

LIMIT_NS, DIFFERENCE = 2000.0, 1e-9
FLAGS = ["-O3", "-DNDEBUG"]

# Definitions of pinocchioTargets.cmake: Pinocchio has more kinds of joints than lists of Boost by default.
BOOST = [
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
]


def prefix_of_pinocchio():
    for path in map(pathlib.Path, sys.path):
        found = path / "cmeel.prefix"
        if (found / "include/pinocchio").is_dir():
            return found
    raise SystemExit("there are no headers of Pinocchio")


def run(*words, folder=None, given=None):
    words = [str(word) for word in words]
    done = subprocess.run(words, cwd=folder, input=given, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(words)}\n{done.stdout}{done.stderr}")
    return done.stdout


def numbers_of(urdf, joints, rotors):
    """The input of rnea.cpp."""
    full = pin.buildModelFromUrdf(str(urdf))
    locked = [full.getJointId(name) for name in list(full.names)[1:] if name not in joints]
    model = pin.buildReducedModel(full, locked, pin.neutral(full))
    text = ""
    for i, name in enumerate(joints, start=1):
        is_next = model.names[i] == name and model.parents[i] == i - 1
        if not is_next or model.joints[i].shortname() != "JointModelRZ":
            raise SystemExit(f"{name} is not the next joint of a chain, about its z axis")
        place = model.jointPlacements[i]
        body = model.inertias[i].toDynamicParameters()
        numbers = np.concatenate([place.rotation.ravel(), place.translation, body, [rotors[name]]])
        text += " ".join(repr(float(number)) for number in numbers) + "\n"
    return text


def export(sprung, source, folder, friction):
    """Writes the code; returns the names of the joints and the inertias of their rotors."""
    folder.mkdir(parents=True, exist_ok=True)
    experiment = (source / "experiment.toml").read_text()
    # The program of all robots calls the same names.
    experiment = re.sub(r'(\[robot\]\nname = ).*', r'\1"arm"', experiment)
    lines = (source / "parameters.toml").read_text().splitlines()
    if not friction:
        experiment = re.sub(r"motor_friction = \[.*\]", "motor_friction = []", experiment)
        lines = [line for line in lines if "viscous" not in line and "coulomb" not in line]
    (folder / "experiment.toml").write_text(experiment)
    (folder / "parameters.toml").write_text("\n".join(lines) + "\n")
    run(sprung, "export", folder, "--quiet", "--format", "c", "--out", folder, "--force",
        "--parameters", folder / "parameters.toml")
    joints = re.findall(r'^name = "(.*)"', experiment.split("[[robot.joint]]", 1)[1], re.M)
    return joints, dict(re.findall(r'^"(.*)\.rotor_inertia" = (.*)$', "\n".join(lines), re.M))


def compile_program(folder, joints):
    """Compiles rnea.cpp beside the code of a robot; returns the object."""
    include = prefix_of_pinocchio() / "include"
    program = pathlib.Path(__file__).resolve().parent / "rnea.cpp"
    run("g++", "-std=c++17", *FLAGS, *BOOST, "-DPREFIX=arm_", f"-DJOINTS={len(joints)}", "-I.",
        "-isystem", include, "-isystem", include / "eigen3", "-c", program, "-o", "rnea.o", folder=folder)
    return folder / "rnea.o"


def measure(program, source, folder, joints, rotors):
    """Nanoseconds of the code and of rnea, and the relative difference of the torques."""
    library = prefix_of_pinocchio() / "lib"
    run("cc", "-std=c99", *FLAGS, "-c", "robot.c", folder=folder)
    run("g++", program, "robot.o", "-o", "rnea", f"-L{library}", f"-Wl,-rpath,{library}",
        f"-Wl,-rpath-link,{library}", "-lpinocchio_default", "-lm", folder=folder)
    numbers = numbers_of(source / "robot.urdf", joints, rotors)
    return [float(word) for word in run(folder / "rnea", given=numbers).split()]


def main():
    sprung, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    failed, program = False, None
    print(f"\n{'inverse dynamics of Panda, seven joints':42} code, ns  rnea, ns  ratio  difference")
    for what, source, friction in [
        ("rigid, without friction", "panda-rigid", False),
        ("rigid, viscous and Coulomb friction", "panda-rigid", True),
        ("springs, friction of links and motors", "panda", True),
    ]:
        code_folder = folder / "rnea" / what.replace(", ", "-").replace(" ", "-")
        joints, rotors = export(sprung, folder / source, code_folder, friction)
        program = program or compile_program(code_folder, joints)
        code, rnea, difference = measure(program, folder / source, code_folder, joints, rotors)
        wrong = not difference <= DIFFERENCE or code > LIMIT_NS or not friction and code > rnea
        print(
            f"{what:42} {code:8.0f}  {rnea:8.0f}  {code / rnea:5.2f}  {difference:10.1e}"
            f"{'  FAILED' if wrong else ''}"
        )
        failed |= wrong
    sys.exit(failed)


if __name__ == "__main__":
    main()
