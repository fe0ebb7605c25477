"""Images as the command line reads and writes them: NRRD, and what `hdmbench` is called with; labels of tests."""

import json
import os
import pathlib
import subprocess
import zlib

import numpy as np

program = os.environ["HDMBENCH_PROGRAM"]
types = {"unsigned char": "u1", "short": "<i2", "int": "<i4", "float": "<f4", "double": "<f8"}
names = {np.dtype(code): name for name, code in types.items()}
moduli = {0: 2.0, 1: 3.0, 7: 0.5}  # of labels_of()


def labels_of(shape):
    """Tissues that no symmetry maps onto themselves."""
    at = np.indices(shape)
    labels = np.zeros(shape, "<i2")
    labels[(at[0] > 3) & (at[1] < shape[1] - 2)] = 1
    labels[sum(at) > 1.4 * max(shape)] = 7
    return labels


def write_nrrd(file, array, *, spacing=None, axes=None, origin=None, components=False):
    """`array` has x as index 0; `axes` are columns in LPS, millimetres; with `components` as its last index."""
    array = np.asarray(array)
    values = np.moveaxis(array, -1, 0) if components else array
    lines = ["NRRD0005", f"type: {names[values.dtype]}", f"dimension: {values.ndim}"]
    lines += [f"sizes: {' '.join(map(str, values.shape))}", "endian: little", "encoding: raw"]
    none = ["none"] if components else []
    if axes is not None:
        vectors = [f"({','.join(repr(float(one)) for one in column)})" for column in np.asarray(axes).T]
        lines += ["space: left-posterior-superior", f"space directions: {' '.join(none + vectors)}"]
        lines += [f"space origin: ({','.join(repr(float(one)) for one in origin)})"]
    elif spacing is not None:
        lines += [f"spacings: {' '.join(['nan'] * len(none) + [repr(float(one)) for one in spacing])}"]
    if components:
        lines += [f"kinds: vector{' domain' * (values.ndim - 1)}"]
    header = "\n".join(lines) + "\n\n"
    pathlib.Path(file).write_bytes(header.encode() + values.tobytes(order="F"))


def read_nrrd(file):
    """The array, x as index 0, components last; the third axis of one slice is left out."""
    header, data = pathlib.Path(file).read_bytes().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in header.decode().splitlines() if ": " in line)
    if fields["encoding"] in ("gzip", "gz"):
        data = zlib.decompress(data, 47)
    sizes = [int(size) for size in fields["sizes"].split()]
    array = np.frombuffer(data, types[fields["type"]]).reshape(sizes, order="F")
    return np.moveaxis(array, 0, -1) if "vector" in fields.get("kinds", "") else array


def run(*words, status=0):
    """What the program prints; of a refusal its sentence."""
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stderr
    return done.stdout if status == 0 else done.stderr.removeprefix("hdmbench: ").strip()


def solved(folder, scene, *words):
    """The field that `run` writes of a scene, and its row of results."""
    out = pathlib.Path(folder, "out")
    out.mkdir(exist_ok=True)
    run("run", scene, *words, "--no-pictures", "--output", out, "--json", out / "run.json")
    row = json.loads((out / "run.json").read_text())["results"][0]
    field = read_nrrd(out / row["field"])
    return (field[:, :, 0] if "depth" not in row else field), row
