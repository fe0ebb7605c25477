"""`import hdmbench` against the command line: the same bits for the same scene, whatever the array looks like."""

import importlib.util
import inspect
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np
except ImportError:
    print("NumPy (python3-numpy) is not installed")
    sys.exit(77)

import hdmbench
from files import labels_of, moduli, read_nrrd, run, solved, write_nrrd

tissues_file = "".join(f"[[tissue]]\nlabel = {label}\nmodulus = {modulus}\n" for label, modulus in moduli.items())


class InFolder(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = pathlib.Path(made.name)
        (self.folder / "tissues.toml").write_text(tissues_file)

    def command(self, labels, *words, **place):
        write_nrrd(self.folder / "labels.nrrd", labels, **place)
        return solved(self.folder, self.folder / "labels.nrrd", "--tissues", self.folder / "tissues.toml", *words)

    def points(self, rows):
        file = self.folder / "pairs.txt"
        file.write_text("".join(" ".join(repr(float(one)) for one in row) + "\n" for row in rows))
        return "--points", file

    def same(self, found, expected):
        self.assertEqual(found.shape, expected.shape)
        self.assertGreater(np.abs(expected).max(), 0.1)
        self.assertEqual(found.tobytes(), expected.tobytes())


class SameBits(InFolder):
    """Volumes and images in any memory order, of any type of number."""

    pairs = [[6.2, 7.1, 8.3, 1.5, -0.4, 0.8], [9.0, 6.0, 10.0, 0.2, 0.9, -1.1]]

    def test_volume_of_boxes(self):
        labels = labels_of((14, 12, 10))
        spacing = (1.0, 1.2, 2.0)
        expected, row = self.command(labels, *self.points(self.pairs), spacing=spacing)
        odd = np.zeros((14, 24, 30), np.int64)[:, ::2, ::-3]
        odd[...] = labels
        forms = [labels, np.asfortranarray(labels), odd, labels.astype("f4"), labels.astype("f8"), labels.astype("u1"),
                 np.ascontiguousarray(labels.T).T]
        for form in forms:
            result = hdmbench.solve(form, moduli, points=np.array(self.pairs), spacing=spacing)
            self.same(result.displacement, expected)
        self.assertEqual(result.space, "LPS")
        self.assertEqual(result.warnings, row["warnings"])
        self.assertEqual(result.estimate, row["estimated_px"])
        self.assertEqual(list(result.residuals), [point["residual_mm"] for point in row["points"]])
        np.testing.assert_array_equal(result.affine, np.diag([*spacing, 1.0]))
        before = np.array(self.pairs)[:, :3]
        after = before + np.array(self.pairs)[:, 3:]
        self.same(hdmbench.solve(labels, moduli, points=(before, after), spacing=spacing).displacement, expected)
        self.same(hdmbench.solve(labels, moduli, before, after, spacing=spacing).displacement, expected)
        paths = hdmbench.solve(str(self.folder / "labels.nrrd"), self.folder / "tissues.toml", self.folder / "pairs.txt")
        self.same(paths.displacement, expected)

    def test_image(self):
        labels = labels_of((17, 13))
        flat = [[5.5, 6.25, 0, 2.0, -1.0, 0]]
        expected, _ = self.command(labels, *self.points(flat), spacing=(0.5, 0.5))
        for form in (labels, np.asfortranarray(labels), labels.astype("f8")[::-1][::-1]):
            self.same(hdmbench.solve(form, moduli, flat, spacing=0.5).displacement, expected)
        result = hdmbench.solve(labels, moduli, ([[5.5, 6.25]], [[7.5, 5.25]]), spacing=0.5)
        self.same(result.displacement, expected)
        self.assertTrue((result.displacement[..., 2] == 0).all())

    def test_options_of_the_command(self):
        labels = labels_of((12, 11, 13))
        words = ["--poisson", 0.41, "--accuracy", "0.05mm", "--backend", "scalar"]
        expected, row = self.command(labels, *self.points(self.pairs), *words, spacing=(2, 2, 2))
        options = {"poisson": 0.41, "accuracy": "0.05mm", "backend": "scalar", "spacing": 2.0}
        result = hdmbench.solve(labels, moduli, self.pairs, **options)
        self.same(result.displacement, expected)
        self.assertEqual((result.met, result.backend), (row["plan"]["met"], "scalar"))
        expected, _ = self.command(labels, "--method", "full-multigrid", "--iterations", 3, *self.points(self.pairs),
                                   spacing=(2, 2, 2))
        same = hdmbench.solve(labels, moduli, self.pairs, method="full-multigrid", iterations=3, spacing=2)
        self.same(same.displacement, expected)

    def test_laws(self):
        labels = labels_of((12, 11, 13))
        laws = {label: {"modulus": modulus, "law": "neo-hookean"} for label, modulus in moduli.items()}
        pairs = [[12.0, 10.0, 12.0, 1.5, -0.4, 0.8]]
        linear, _ = self.command(labels, *self.points(pairs), spacing=(2, 2, 2))
        expected, row = self.command(labels, "--law", "neo-hookean", *self.points(pairs), spacing=(2, 2, 2))
        self.assertLess(row["least_volume"], 1.0)
        self.assertFalse((linear == expected).all())
        self.same(hdmbench.solve(labels, laws, pairs, spacing=2).displacement, expected)
        expected, _ = self.command(labels, "--energy", "auto", "--accuracy", "0.001px", *self.points(pairs),
                                   spacing=(2, 2, 2))
        self.same(hdmbench.solve(labels, moduli, pairs, spacing=2, energy="auto", accuracy="0.001px").displacement,
                  expected)
        self.assertFalse((linear == expected).all())

    def test_shipped_scenes(self):
        for scene, options, words in (
                ("square", {"size": 40}, ["--size", 40]),
                ("circular", {"size": (40, 40), "energy": "elastic"}, ["--size", "40x40", "--energy", "elastic"]),
                ("ball", {"size": (17, 16, 15), "accuracy": 0.01}, ["--size", "17x16x15", "--accuracy", "0.01"])):
            expected, _ = solved(self.folder, scene, *words)
            self.same(hdmbench.solve(scene=scene, **options).displacement, expected)

    def test_targets_of_pixels(self):
        """In millimetres here, and in a file that says so."""
        labels = labels_of((12, 11, 10))
        targets = np.zeros((12, 11, 10, 3), "f4")
        targets[5:8, 5, 4:6] = [1.5, -2.0, 0.75]
        confidence = (np.abs(targets).sum(-1) > 0).astype("f4") * np.float32(0.5)
        write_nrrd(self.folder / "targets.nrrd", targets, spacing=(2, 2, 3), components=True)
        write_nrrd(self.folder / "sure.nrrd", np.stack([confidence] * 3, -1), spacing=(2, 2, 3), components=True)
        write_nrrd(self.folder / "labels.nrrd", labels, spacing=(2, 2, 3))
        (self.folder / "scene.toml").write_text(
            'energy = "elastic"\n[image]\nlabels = "labels.nrrd"\ntarget = "targets.nrrd"\ntarget_unit = "mm"\n'
            f'confidence = "sure.nrrd"\n{tissues_file}[[condition]]\nwhere = "left"\ndx = 0\ndy = 0\ndz = 0.5\n')
        expected, _ = solved(self.folder, self.folder / "scene.toml")
        conditions = [{"where": "left", "dx": 0, "dy": 0, "dz": 0.5}]
        for form in (targets, np.asfortranarray(targets), targets.astype("f8")):
            result = hdmbench.solve(labels, moduli, targets=form, confidence=confidence, spacing=(2, 2, 3),
                                    conditions=conditions)
            self.same(result.displacement, expected)

    def test_modulus(self):
        modulus = np.linspace(1, 5, 14 * 12 * 10, dtype="f4").reshape(14, 12, 10)
        write_nrrd(self.folder / "modulus.nrrd", modulus, spacing=(1, 1, 1))
        (self.folder / "scene.toml").write_text(
            'energy = "elastic"\n[image]\nmodulus = "modulus.nrrd"\n[[condition]]\nwhere = "border"\noutward = 0.0\n')
        expected, _ = solved(self.folder, self.folder / "scene.toml", *self.points(self.pairs[:1]))
        self.same(hdmbench.solve(modulus=modulus, points=self.pairs[:1]).displacement, expected)


class InSpace(InFolder):
    """An affine is in RAS, the project's files are in LPS."""

    shape = (12, 11, 10)

    def affines(self):
        flipped = np.diag([-2.0, 1.5, 2.5, 1.0])
        permuted = np.array([[0, 0, 2.0, -20], [1.5, 0, 0, 30], [0, -1.8, 0, 40], [0, 0, 0, 1]])
        angle = np.deg2rad(20)
        turned = np.eye(4)
        turned[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        turned[:3, 3] = [3, -4, 5]
        return flipped, permuted, turned @ np.diag([1.0, 1.0, -1.25, 1.0])

    def test_affine(self):
        labels = labels_of(self.shape)
        for affine in self.affines():
            turn = np.diag([-1.0, -1.0, 1.0])
            before = (affine @ [[5.0, 4.25], [6.0, 3.5], [4.0, 6.75], [1.0, 1.0]])[:3].T
            moved = np.array([[1.0, -0.5, 0.25], [-0.75, 0.5, 0.5]])
            rows = np.hstack([before @ turn, moved @ turn])
            expected, _ = self.command(labels, *self.points(rows), axes=turn @ affine[:3, :3],
                                       origin=turn @ affine[:3, 3])
            result = hdmbench.solve(labels, moduli, np.hstack([before, moved]), affine=affine)
            self.assertEqual(result.space, "RAS")
            np.testing.assert_allclose(result.displacement, expected @ turn, rtol=0, atol=2e-5)
            np.testing.assert_allclose(result.affine, affine, rtol=0, atol=1e-12)
            self.assertLess(result.residuals.max(), 1e-5)
            np.testing.assert_allclose(self.moved_at(result, before), moved, rtol=0, atol=1e-4)

    def moved_at(self, result, positions):
        """The displacement there, linear between the voxels: what a user computes."""
        found = []
        for position in positions:
            at = (np.linalg.inv(result.affine) @ [*position, 1.0])[:3]
            cell = np.floor(at).astype(int)
            value = np.zeros(3)
            for corner in np.ndindex(2, 2, 2):
                share = np.prod(np.where(corner, at - cell, 1 - (at - cell)))
                value += share * result.displacement[tuple(np.minimum(cell + corner, np.array(self.shape) - 1))]
            found.append(value)
        return found

    def test_targets_turn_with_the_space(self):
        labels = labels_of(self.shape)
        targets = np.zeros((*self.shape, 3))
        targets[6, 5, 4] = [1.0, -0.5, 0.25]
        sure = (targets != 0).any(-1).astype(float)
        for affine in self.affines():
            result = hdmbench.solve(labels, moduli, targets=targets, confidence=sure, affine=affine)
            np.testing.assert_allclose(result.displacement[6, 5, 4], targets[6, 5, 4], rtol=0, atol=1e-5)

    def test_precision_and_force_turn_with_the_space(self):
        """A target across an edge, and a force, are the same ones in a file of LPS, in NIfTI's order or NRRD's."""
        try:
            import nibabel
        except ImportError:
            self.skipTest("nibabel (python3-nibabel) is not installed")
        labels = labels_of(self.shape)
        turn = np.diag([-1.0, -1.0, 1.0])
        across = np.array([0.6, 0.48, 0.64])
        targets, force = np.zeros((2, *self.shape, 3))
        precision = np.zeros((*self.shape, 3, 3))
        targets[6, 5, 4] = 1.5 * across
        precision[6, 5, 4] = 4.0 * np.outer(across, across)
        force[3, 4, 6] = [0.5, -1.0, 0.25]
        rows = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])  # NIfTI: xx, xy, yy, xz, yz, zz
        for affine in self.affines():
            found = hdmbench.solve(labels, moduli, targets=targets, precision=precision, force=force, affine=affine)
            self.assertGreater((found.displacement[6, 5, 4] * across).sum(), 0.3)
            lps = turn @ precision @ turn
            for name, values in (("labels", labels.astype("i2")), ("targets", (targets @ turn)[..., None, :]),
                                 ("precision", lps[..., rows[0], rows[1]][..., None, :]),
                                 ("force", (force @ turn)[..., None, :])):
                image = nibabel.Nifti1Image(values.astype("i2" if name == "labels" else "f4"), affine)
                if name == "precision":
                    image.header.set_intent("symmetric matrix", (3,))
                nibabel.save(image, self.folder / f"{name}.nii.gz")
            (self.folder / "scene.toml").write_text(
                'energy = "elastic"\n[image]\nlabels = "labels.nii.gz"\ntarget = "targets.nii.gz"\n'
                'target_unit = "mm"\nprecision = "precision.nii.gz"\nforce = "force.nii.gz"\n'
                f'{tissues_file}[[condition]]\nwhere = "border"\noutward = 0.0\n')
            expected, _ = solved(self.folder, self.folder / "scene.toml")
            np.testing.assert_allclose(found.displacement, expected @ turn, rtol=0, atol=2e-5)
        wrong = precision.copy()
        wrong[6, 5, 4, 0, 1] = 7.0
        for matrices, words in ((wrong, "precision: has matrices that are not symmetric"),
                                (precision[..., 0], "each with a matrix of 3 x 3")):
            with self.assertRaisesRegex(ValueError, words):
                hdmbench.solve(labels, moduli, targets=targets, precision=matrices)

    def test_fibres_turn_with_the_space(self):
        """An array of fibres is in the space of the affine, a [[tissue]]'s in LPS."""
        labels = labels_of(self.shape)
        along = np.array([0.6, -0.48, 0.64])
        conditions = [{"where": "left", "dx": 0.0, "dy": 0.0, "dz": 0.0}, {"where": "right", "dx": 1.0}]
        for affine in self.affines():
            def solved(tissue, fibre=None):
                tissues = {label: {"modulus": 3.0, "law": "neo-hookean", **tissue}
                           for label in np.unique(labels).tolist()}
                return hdmbench.solve(labels, tissues, fibre=fibre, affine=affine, conditions=conditions).displacement
            of_array = solved({"fibre_modulus": 60.0}, np.broadcast_to(along, (*self.shape, 3)))
            of_tissue = solved({"fibre_modulus": 60.0, "fibre": (along * [-1, -1, 1]).tolist()})
            np.testing.assert_allclose(of_array, of_tissue, rtol=0, atol=2e-5)
            self.assertGreater(np.abs(of_array - solved({})).max(), 0.01)

    def test_normals_turn_with_the_space(self):
        """Tissue slides along a wall whose normals are given, here across the outline of its label."""
        labels = np.ones((12, 10, 9), dtype=int)
        labels[:, :, :2] = 2
        conditions = [{"where": "labels", "labels": [2], "slide": True}, {"where": "right", "dx": 1.0, "dy": 0.0}]
        for affine in self.affines():
            def solved(normals=None, conditions=conditions):
                return hdmbench.solve(labels, {1: 3.0, 2: 300.0}, normals=normals, affine=affine, conditions=conditions,
                                      energy="elastic").displacement[1:-1, 1:-1, 2]
            axes = affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0)
            normal = axes @ [np.sin(0.4), 0.0, np.cos(0.4)]
            moved = solved(np.broadcast_to(normal, (*labels.shape, 3)))
            self.assertLess(np.abs(moved @ normal).max(), 0.02 * np.abs(moved).max())
            self.assertGreater(np.abs(solved() @ normal).max(), 0.2 * np.abs(moved).max())
            with self.assertRaisesRegex(ValueError, "has normals, and no .* slides"):
                solved(np.broadcast_to(normal, (*labels.shape, 3)), None)

    def test_loads_and_resections_are_those_of_the_program(self):
        """Gravity is in LPS whatever the affine, as in a scene file."""
        try:
            import nibabel
        except ImportError:
            self.skipTest("nibabel (python3-nibabel) is not installed")
        labels = np.zeros((14, 12, 11), dtype="i2")
        labels[2:12, 2:10, 2:9] = 1
        labels[6:9, 5:7, 4:6] = 7
        tissues = {0: 0.0, 1: {"modulus": 0.001, "density": 1040}, 7: {"modulus": 0.002, "density": 1040}}
        conditions = [{"where": "labels", "labels": [1], "centre": [0.2, 0.5, 0.5], "size": [0.1, 2.0, 2.0],
                       "dx": 0.0, "dy": 0.0, "dz": 0.0}]
        loads = [{"gravity": [1.0, 9.81, -3.0], "before": True}, {"pressure": 2e-5, "from": 0, "on": 1}]
        (self.folder / "scene.toml").write_text(
            'energy = "elastic"\n[image]\nlabels = "labels.nii.gz"\n'
            "[[tissue]]\nlabel = 0\nmodulus = 0.0\n"
            "[[tissue]]\nlabel = 1\nmodulus = 0.001\ndensity = 1040\n"
            "[[tissue]]\nlabel = 7\nmodulus = 0.002\ndensity = 1040\n"
            '[[condition]]\nwhere = "labels"\nlabels = [1]\ncentre = [0.2, 0.5, 0.5]\nsize = [0.1, 2.0, 2.0]\n'
            "dx = 0.0\ndy = 0.0\ndz = 0.0\n"
            "[[load]]\ngravity = [1.0, 9.81, -3.0]\nbefore = true\n"
            "[[load]]\npressure = 2e-5\nfrom = 0\non = 1\n[[resect]]\nlabel = 7\n")
        for affine in self.affines():
            nibabel.save(nibabel.Nifti1Image(labels, affine), self.folder / "labels.nii.gz")
            given = nibabel.load(self.folder / "labels.nii.gz")
            for law in (None, "neo-hookean"):
                expected, _ = solved(self.folder, self.folder / "scene.toml", *(["--law", law] if law else []))
                for resect in (7, [7]):
                    result = hdmbench.solve(given, tissues, conditions=conditions, loads=loads, resect=resect, law=law)
                    in_ras = expected * np.float32([-1, -1, 1]) + np.float32(0)
                    self.same(np.ascontiguousarray(result.displacement), in_ras)
        result = hdmbench.solve(labels, tissues, conditions=conditions, loads=loads, resect=7, spacing=1)
        lengths = np.abs(result.displacement)
        of_tissue = lengths[labels == 1].max() # what void does counts for nothing
        self.assertLess(of_tissue, 0.95 * lengths.max())
        self.assertIn(f"at most {of_tissue:.4g} mm", repr(result))
        for arguments, words in (({"loads": [{"gravity": [0, 9.81, 0]}], "resect": 7}, "no .* has before = true"),
                                 ({"resect": 3, "loads": loads}, "3 has no pixel"),
                                 ({"loads": [{"force": 1}]}, "force"),
                                 ({"loads": loads[0]}, "loads: is a list of dictionaries, and 'gravity' is none"),
                                 ({"law": "stiffening"}, "not \"stiffening\"")):
            with self.assertRaisesRegex(ValueError, words):
                hdmbench.solve(labels, tissues, conditions=conditions, **arguments)
        with self.assertRaisesRegex(ValueError, "loads has no effect here: the scene's files say it"):
            hdmbench.solve(scene=self.folder / "scene.toml", loads=loads)

    def test_image_of_nibabel(self):
        try:
            import nibabel
        except ImportError:
            self.skipTest("nibabel (python3-nibabel) is not installed")
        for affine in self.affines():
            image = nibabel.Nifti1Image(labels_of(self.shape), affine)
            nibabel.save(image, self.folder / "labels.nii.gz")
            loaded = nibabel.load(self.folder / "labels.nii.gz")
            before = (loaded.affine @ [5.0, 6.0, 4.0, 1.0])[:3]
            rows = [[-before[0], -before[1], before[2], -1.0, 0.5, 0.25]]
            expected, _ = solved(self.folder, self.folder / "labels.nii.gz", "--tissues",
                                 self.folder / "tissues.toml", *self.points(rows))
            result = hdmbench.solve(loaded, moduli, [[*before, 1.0, -0.5, 0.25]])
            self.same(np.ascontiguousarray(result.displacement), expected * np.float32([-1, -1, 1]) + np.float32(0))
            np.testing.assert_allclose(result.displacement[5, 6, 4], [1.0, -0.5, 0.25], rtol=0, atol=1e-5)


class Moved(InFolder):
    """inverse() and warp() against --transform and --warp."""

    def test_pictures(self):
        labels = labels_of((16, 14, 12))
        picture = np.random.default_rng(1).random((16, 14, 12), dtype="f4")
        write_nrrd(self.folder / "t1.nrrd", picture, spacing=(1, 1.5, 2))
        back = self.folder / "back.nrrd"
        words = self.points(SameBits.pairs) + ("--transform", back, "--warp", self.folder / "t1.nrrd")
        out = self.folder / "out"
        write_nrrd(self.folder / "labels.nrrd", labels, spacing=(1, 1.5, 2))
        run("run", self.folder / "labels.nrrd", "--tissues", self.folder / "tissues.toml", *words, "--no-pictures",
            "--output", out)
        written = (out / "labels.nrrd").read_bytes()
        result = hdmbench.solve(labels, moduli, SameBits.pairs, spacing=(1, 1.5, 2))
        self.same(result.inverse().displacement, read_nrrd(back))
        self.same(result.warp(np.asfortranarray(picture)), read_nrrd(out / "t1.nrrd"))
        self.same(result.inverse().warp(picture.astype("f8"), spacing=(1, 1.5, 2)), read_nrrd(out / "t1.nrrd"))
        self.assertEqual(result.inverse().unmet, 0)
        run("warp", self.folder / "labels.nrrd", "--labels", "--transform", back, "--output", out)
        moved = result.warp(labels, labels=True)
        self.assertEqual(moved.dtype, labels.dtype)
        self.same(moved, read_nrrd(out / "labels.nrrd"))
        result.inverse().save(self.folder / "again.nrrd")
        self.assertEqual((self.folder / "again.nrrd").read_bytes(), back.read_bytes())
        result.save(self.folder / "field.nrrd")
        self.assertEqual((self.folder / "field.nrrd").read_bytes(), written)


class Registered(InFolder):
    """register() against the command on the same pictures."""

    at = np.indices((48, 40)).astype(float)
    labels = np.where(np.hypot(at[0] - 22, at[1] - 20) < 9, 7, 1).astype("<i2")
    labels[:2] = labels[:, :2] = labels[-2:] = labels[:, -2:] = 0

    def picture(self, way):
        x, y = self.at[0] - way, self.at[1]
        return np.where(self.labels > 0, 100 + 60 * np.sin(x / 3) * np.cos(y / 4) + 20 * np.sin(x * y / 50), 0).astype("f4")

    def test_same_bits(self):
        source, target = self.picture(0), self.picture(1)
        region = np.zeros((48, 40), "<i2")
        region[20:26, 17:23] = 1
        for name, picture in (("labels", self.labels), ("source", source), ("target", target), ("region", region)):
            write_nrrd(self.folder / f"{name}.nrrd", picture, spacing=(1.5, 1.5))
        scene = self.folder / "scene.toml"
        scene.write_text('energy = "elastic"\n[image]\nlabels = "labels.nrrd"\n' + tissues_file)
        pictures = [self.folder / "source.nrrd", self.folder / "target.nrrd", "--scene", scene]
        ways = ({"iterate": True}, ["--iterate"]), ({"region": region}, ["--roi", self.folder / "region.nrrd"])
        for options, words in ways:
            out = self.folder / "out"
            run("register", *pictures, *words, "--output", out)
            result = hdmbench.register(source, target, self.labels, moduli, spacing=1.5, **options)
            self.same(result.displacement, read_nrrd(out / "displacement.nrrd")[:, :, 0])
            self.assertEqual(result.met, True if "iterate" in options else None)

    def test_volumes_have_the_same_bits(self):
        depth = 20
        labels, source, target = (np.stack([one] * depth, axis=2) for one in
                                  (self.labels, self.picture(0), self.picture(1)))
        for name, volume in (("labels", labels), ("source", source), ("target", target)):
            write_nrrd(self.folder / f"{name}.nrrd", volume, spacing=(1.5, 1.5, 1.5))
        scene = self.folder / "scene.toml"
        scene.write_text('energy = "elastic"\n[image]\nlabels = "labels.nrrd"\n' + tissues_file)
        out = self.folder / "out"
        run("register", self.folder / "source.nrrd", self.folder / "target.nrrd", "--scene", scene, "--iterate",
            "--output", out)
        result = hdmbench.register(source, target, labels, moduli, spacing=1.5, iterate=True)
        self.same(result.displacement, read_nrrd(out / "displacement.nrrd"))
        self.assertTrue(result.met)
        self.assertLess(np.abs(result.displacement[22, 20, 10] - (1.5, 0, 0)).max(), 0.5 * 1.5)  # half a voxel

    def test_refused(self):
        source, target = self.picture(0), self.picture(1)
        refused = [("do not overlap", (source * (self.at[0] < 20), target * (self.at[0] > 30), self.labels)),
                   ("target: has 40 x 48 pixels, the labels have 48 x 40", (source, target.T, self.labels)),
                   ("one label everywhere", (source, target, self.labels * 0)),
                   ("16 pixels a side", [np.stack([one] * 3, axis=2) for one in (source, target, self.labels)])]
        for words, arrays in refused:
            with self.assertRaisesRegex(ValueError, words):
                hdmbench.register(*arrays, moduli)
        with self.assertRaisesRegex(ValueError, "region: the region of interest is empty"):
            hdmbench.register(source, target, self.labels, moduli, self.labels * 0)


class Refused(InFolder):
    """Errors are exceptions, in the words of the command line."""

    def refuse(self, error, words, **arguments):
        with self.assertRaisesRegex(error, re.escape(words)):
            hdmbench.solve(**arguments)

    def test_same_words(self):
        said = run("run", "square", "--size", 20, "--energy", "hdm", "--accuracy", "0.1", status=2)
        self.refuse(ValueError, said, scene="square", size=20, energy="hdm", accuracy=0.1)
        said = run("run", "square", "--size", 20, "--backend", "nobody", status=2)
        self.refuse(ValueError, said, scene="square", size=20, backend="nobody")
        said = run("run", "square", "--size", 20, "--device", "nobody", status=2)
        self.refuse(RuntimeError, said, scene="square", size=20, device="nobody")
        self.refuse(ValueError, run("run", "nothing", status=2), scene="nothing")

    def test_arrays(self):
        labels = labels_of((12, 11, 10))
        some = {"labels": labels, "tissues": moduli}
        nan = labels.astype(float)
        nan[3, 4, 5] = np.nan
        self.refuse(ValueError, "the pixel at x = 3, y = 4, z = 5 is nan", labels=nan, tissues=moduli)
        self.refuse(ValueError, "labels are integers", labels=labels + 0.5, tissues=moduli)
        self.refuse(ValueError, "labels are integers", labels=labels.astype(int) + 2**24, tissues=moduli)
        self.refuse(ValueError, "[[tissue]]", labels=labels, tissues={0: 1.0})
        self.refuse(ValueError, "tissue", labels=labels)
        self.refuse(ValueError, "positive (MPa)", labels=labels, tissues={**moduli, 1: -1.0})
        self.refuse(ValueError, "of the type complex128", labels=labels * 1j, tissues=moduli)
        self.refuse(ValueError, "of the type <U1", labels=[["a", "b"]], tissues=moduli)
        self.refuse(ValueError, "has the shape (5)", labels=[1, 1, 1, 1, 1], tissues=moduli)
        self.refuse(ValueError, "1 to ", labels=np.zeros((0, 4, 4)), tissues=moduli)
        self.refuse(ValueError, "give exactly one", tissues=moduli)
        self.refuse(ValueError, "is held nowhere", **some, conditions=[])
        self.refuse(ValueError, "spacing: is one number, or 3", **some, spacing=(1, 2))
        self.refuse(ValueError, "are possible", **some, spacing=-1)
        self.refuse(ValueError, "affine: has the shape (3, 3)", **some, affine=np.eye(3))
        self.refuse(ValueError, "direction of axis 2", **some, affine=np.diag([1.0, 0, 1, 1]))
        self.refuse(ValueError, "give one of the two", **some, affine=np.eye(4), spacing=2)
        self.refuse(ValueError, "is beside the scene", **some, points=[[99, 0, 0, 1, 0, 0]])
        self.refuse(ValueError, "points: row 0 has 5 numbers", **some, points=[[1, 2, 3, 4, 5]])
        self.refuse(ValueError, "not finite", **some, points=[[1, 2, np.inf, 1, 0, 0]])
        self.refuse(ValueError, "each needs its other one", **some, points=([[1, 2, 3]], [[1, 2, 3], [4, 5, 6]]))
        self.refuse(ValueError, "give both images or none", **some, targets=np.zeros((12, 11, 10, 3)))
        wrong = np.zeros((11, 12, 10, 3))
        self.refuse(ValueError, "targets: has the shape (11, 12, 10, 3)", **some, targets=wrong, confidence=wrong)
        wrong = np.full((12, 11, 10, 3), np.nan)
        self.refuse(ValueError, "must be finite", **some, targets=wrong, confidence=labels * 0)
        self.refuse(ValueError, "no effect here", scene="square", affine=np.eye(4))
        self.refuse(ValueError, "colour is not a key", **some, conditions=[{"where": "left", "dx": 0, "colour": 3}])
        result = hdmbench.solve(**some, points=SameBits.pairs[:1])
        with self.assertRaisesRegex(ValueError, "give its affine or its spacing"):
            result.warp(np.zeros((3, 3, 3)))


class Work(unittest.TestCase):
    def test_other_threads_go_on(self):
        steps = 0
        stopped = threading.Event()

        def count():
            nonlocal steps
            while not stopped.is_set():
                steps += 1
                time.sleep(0.001)

        counter = threading.Thread(target=count)
        counter.start()
        begin = time.monotonic()
        hdmbench.solve(scene="ball", size=(64, 64, 64), energy="elastic", threads=1)
        seconds = time.monotonic() - begin
        stopped.set()
        counter.join()
        self.assertGreater(steps, 100 * seconds)

    def test_interrupt(self):
        """Ctrl-C ends a solution, or what takes many, of half a minute."""
        for call, wait in (("solve(", 0.3), ("solve(", 1.0), ("bench(backends=['scalar'], ", 1.0)):
            program = ("import hdmbench, time\nprint('begins', flush=True)\ntry:\n"
                       f"  hdmbench.{call}scene='ball', size=(96, 96, 96), energy='elastic',\n"
                       "                 method='conjugate-gradients', iterations=100000000, threads=1)\n"
                       "except KeyboardInterrupt:\n  print('ended', time.time(), flush=True)\n")
            process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
            self.assertEqual(process.stdout.readline(), "begins\n")
            time.sleep(wait)
            sent = time.time()
            process.send_signal(signal.SIGINT)
            ended = process.stdout.readline().split()
            process.communicate()
            self.assertEqual(ended[:1], ["ended"])
            self.assertLess(float(ended[1]) - sent, 1.0)

    def test_what_there_is(self):
        backends = {row["backend"]: row for row in hdmbench.backends()}
        self.assertTrue(backends["scalar"]["available"])
        self.assertTrue(backends["openmp"]["devices"])
        self.assertTrue(all(row["reason"] for row in backends.values() if not row["available"]))
        self.assertIn("head", [row["scene"] for row in hdmbench.scenes()])
        rows = hdmbench.verify("circular", ["openmp"], size=20)
        self.assertEqual({row["verdict"] for row in rows}, {"agree"})
        self.assertGreater(rows[0]["sites_compared"], 1000)

    def test_bench(self):
        """Twice in one process; the rows are those of the command."""
        for scene, size, energy in (("square", 40, None), ("ball", (12, 12, 12), "elastic")):
            rows = hdmbench.bench(scene, ["openmp"], size=size, energy=energy, repeat=2)
            self.assertEqual([row["backend"] for row in rows], ["scalar", "openmp"])
            for row in rows:
                self.assertTrue(row["valid"])
                self.assertEqual(len(row["seconds"]), 2)
            self.assertGreater(rows[1]["speed_up_over_scalar"], 0)
        with self.assertRaisesRegex(ValueError, "nobody"):
            hdmbench.bench("square", ["nobody"])
        with self.assertRaisesRegex(ValueError, "repeat: is at least 1"):
            hdmbench.bench("square", repeat=0)


class Packed(InFolder):
    def test_pip_installs_offline(self):
        if importlib.util.find_spec("pip") is None:
            self.skipTest("pip (python3-pip) is not installed")
        source = pathlib.Path(__file__).resolve().parents[2] / "harness" / "python"
        # The build folder whose module is tested: its parts are not compiled again.
        environment = {**os.environ, "HDMBENCH_BUILD_FOLDER": str(pathlib.Path(hdmbench.__file__).parents[2])}
        words = ["--quiet", "--no-build-isolation", "--no-index", "--no-deps", "--target", self.folder, source]
        subprocess.run([sys.executable, "-m", "pip", "install", *words], env=environment, check=True)
        environment["PYTHONPATH"] = str(self.folder)
        said = subprocess.run([sys.executable, "-c", "import hdmbench; print(hdmbench.__file__, hdmbench.__version__)"],
                              env=environment, capture_output=True, text=True, check=True).stdout
        self.assertEqual(said.split(), [str(self.folder / "hdmbench" / "__init__.py"), hdmbench.__version__])
        (version,) = re.findall(r'^version = "(.*)"', (source / "pyproject.toml").read_text(), re.M)
        self.assertEqual(version, hdmbench.__version__)


class Described(unittest.TestCase):
    def test_stubs(self):
        """Names, arguments and their standards are those of the module."""
        text = (pathlib.Path(hdmbench.__file__).parent / "__init__.pyi").read_text()
        self.assertTrue((pathlib.Path(hdmbench.__file__).parent / "py.typed").exists())
        self.assertEqual(described(text), found_in(hdmbench))

    def test_readme(self):
        """The examples are run word by word, one after the other."""
        text = pathlib.Path(__file__, "../../../harness/python/README.md").resolve().read_text()
        example = "".join(re.findall(r"```python\n(.*?)```", text, re.S))
        said = []
        exec(example.replace("print(", "said.append("), {"said": said})  # pylint: disable=exec-used
        expected = re.findall(r"# prints (.*)", example)
        self.assertEqual([str(one) for one in said], expected)


def described(text):
    """What stubs declare: name -> arguments; None of a property."""
    import ast

    found = {}

    def add(nodes, prefix):
        for node in nodes:
            if isinstance(node, ast.ClassDef):
                found[node.name] = "class"
                add(node.body, node.name + ".")
            elif isinstance(node, ast.FunctionDef):
                is_property = any(isinstance(one, ast.Name) for one in node.decorator_list)
                given = node.args
                required = len(given.args) - len(given.defaults)
                plain = [(one.arg, None if i < required else ast.literal_eval(given.defaults[i - required]))
                         for i, one in enumerate(given.args)]
                named = [(one.arg, ast.literal_eval(value)) for one, value in zip(given.kwonlyargs, given.kw_defaults)]
                found[prefix + node.name] = "property" if is_property else (plain, named)

    add(ast.parse(text).body, "")
    return found


def found_in(module):
    """The same of a module of pybind11's, whose docstrings begin with signatures."""
    found = {}

    def signature(thing):
        line = thing.__doc__.splitlines()[0]
        inside = line[line.index("(") + 1:line.rindex(") ->")]
        plain, named = [], []
        into = plain
        for word in re.findall(r"(?:\[[^\]]*\]|[^,\[])+", inside):
            name, _, value = word.strip().partition("=")
            if name == "*":
                into = named
            else:
                into.append((name.partition(":")[0].strip(), eval(value) if value else None))
        return plain, named

    for name in module.__all__:
        thing = getattr(module, name)
        if not inspect.isclass(thing):
            found[name] = signature(thing)
            continue
        found[name] = "class"
        for member, value in vars(thing).items():
            if not member.startswith("_"):
                found[f"{name}.{member}"] = "property" if isinstance(value, property) else signature(value)
    return found


if __name__ == "__main__":
    unittest.main()
