"""Notes the sizes of the program and of the code.

    python run.py [--binary SPRUNG]
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benches"))

from figure import note  # noqa: E402


def output(*command):
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def lines(*patterns):
    files = output("git", "ls-files", "--", *patterns).split()
    present = (ROOT / file for file in files)
    return sum(len(file.read_text().splitlines()) for file in present if file.exists())


def settings(schema):
    """Returns the number of keys of the experiment file; a table that stands in two places counts once."""
    tables = [schema, *schema.get("$defs", {}).values()]
    return sum(len(table.get("properties", {})) for table in tables)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    args = parser.parse_args()
    binary = args.binary.resolve()
    note("program", "the program with all formats of logs", binary.stat().st_size / 2**20, "MiB")
    code = lines("crates/*/src/*.rs", "crates/*/src/**/*.rs")
    tests = lines("crates/*/tests/**/*.rs", "crates/*/tests/*.rs", "crates/*/benches/**/*.rs", "crates/*/benches/*.rs")
    note("code", "lines of Rust in `src`, with unit tests", code, "")
    note("tests", "lines of Rust in `tests` and `benches`", tests, "")
    words = sum(len((ROOT / file).read_text().split()) for file in output("git", "ls-files", "*.md").split()
                if (ROOT / file).exists())
    note("words", "words of documentation", words, "")
    names = (ROOT / "crates/sprung/tests/architecture/public_names.txt").read_text().split()
    note("names", "public names of the library", len(names), "")
    note("settings", "keys of the experiment file", settings(json.loads(output(binary, "schema"))), "")
    note("findings", "findings with an explanation", len(output(binary, "explain", "--list").splitlines()), "", better="none")
    tree = output("cargo", "tree", "--quiet", "-p", "sprung-cli", "--edges", "normal", "--prefix", "none", "--no-dedupe")
    crates = {line.split()[0] for line in tree.splitlines() if line.strip()}
    foreign = {name for name in crates if not name.startswith("sprung")}
    note("dependencies", "foreign crates in the program", len(foreign), "")


if __name__ == "__main__":
    main()
