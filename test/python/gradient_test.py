"""Derivatives of numbers of a displacement, and what PyTorch makes of them."""

import importlib.util
import pathlib
import re
import sys
import tempfile
import unittest

try:
    import numpy as np
except ImportError:
    print("NumPy (python3-numpy) is not installed")
    sys.exit(77)

import hdmbench
from files import labels_of, moduli

pairs = [[6.2, 7.1, 8.3, 1.5, -0.4, 0.8], [9.0, 6.0, 10.0, 0.2, 0.9, -1.1]]


class Gradients(unittest.TestCase):
    """Result.gradient() against differences of solutions, in spaces of all kinds."""

    labels = labels_of((9, 8, 10))
    affine = np.array([[0, -1.2, 0, 5], [0.8 * 1.5, 0, -0.6 * 2, 7], [0.6 * 1.5, 0, 0.8 * 2, -3], [0, 0, 0, 1]])

    def check(self, labels, weights, moduli_, **given):
        given = {"accuracy": "0.000001px", **given}
        number = lambda tissues, **other: (hdmbench.solve(labels, tissues, **{**given, **other}).displacement.astype(float)
                                           * weights).sum()
        gradient = hdmbench.solve(labels, moduli_, differentiable=True, **given).gradient(weights)
        self.assertTrue(gradient.converged)
        self.assertEqual(gradient.moduli.shape, labels.shape)
        self.assertEqual(gradient.targets.shape, (*labels.shape, 3))
        scale = max(abs(gradient.moduli[labels == label].sum() * moduli_[label]) for label in moduli_)
        for label, modulus in moduli_.items():
            step = 0.02 * modulus
            up, down = (number({**moduli_, label: modulus + sign * step}) for sign in (1, -1))
            by_tissue = float(gradient.moduli[labels == label].sum(dtype=float))
            self.assertLess(abs(by_tissue - (up - down) / (2 * step)) * modulus, 2e-3 * scale)
        return gradient, number

    def test_oblique_boxes(self):
        rng = np.random.default_rng(2)
        weights = rng.standard_normal((9, 8, 10, 3))
        targets = np.zeros((9, 8, 10, 3))
        confidence = np.zeros((9, 8, 10))
        targets[4, 3, 5] = [0.5, -0.3, 0.4]
        confidence[4, 3, 5] = 1
        targets[2, 5, 6] = [-0.4, 0.2, 0.1]
        confidence[2, 5, 6] = 0.5
        given = {"targets": targets, "confidence": confidence, "affine": self.affine}
        gradient, number = self.check(self.labels, weights, moduli, **given)
        for at in ((4, 3, 5), (2, 5, 6)):
            for axis in range(3):
                moved = targets.copy()
                moved[at][axis] += 1  # linear in targets
                expected = number(moduli, targets=moved) - number(moduli)
                self.assertAlmostEqual(float(gradient.targets[at][axis]), expected, delta=1e-3 * np.abs(weights).max())
        self.assertTrue((gradient.forces[4, 3, 5] == 0).all())
        self.assertTrue((gradient.targets[4, 4, 4] == 0).all())

    def test_image(self):
        labels = labels_of((14, 11))
        weights = np.random.default_rng(3).standard_normal((14, 11, 3))
        self.check(labels, weights, moduli, points=[[5.0, 3.0, 0, 1.0, -0.6, 0, 0.5]], spacing=(0.5, 0.8))

    def test_body_that_points_alone_hold(self):
        labels = np.ones((16, 15, 14), int)
        labels[5:10, 5:10, 5:10] = 2
        points = [[4, 4, 4, 1, 0, 0, 0.5], [12, 4, 4, 0, 1, 0, 0.5], [4, 11, 5, 0, 0, 1, 0.5],
                  [11, 11, 11, 0.5, 0.5, 0.5, 0.5]]
        weights = np.random.default_rng(1).standard_normal((16, 15, 14, 3))
        self.check(labels, weights, {1: 1.0, 2: 10.0}, points=points, conditions=[])

    def test_void(self):
        labels = self.labels.copy()
        labels[4:6, 3:5, 4:6] = 3
        weights = np.random.default_rng(2).standard_normal((*labels.shape, 3))
        result = hdmbench.solve(labels, {**moduli, 3: 0.0}, pairs, spacing=1.5, differentiable=True)
        gradient = result.gradient(weights)
        self.assertTrue((gradient.moduli[labels == 3] == 0).all())
        self.assertTrue(gradient.moduli[labels == 1].any())

    def test_forces(self):
        """A unit of gravity is a force on every voxel; the scene's are in LPS and newtons."""
        with tempfile.TemporaryDirectory() as folder:
            text = ('energy = "elastic"\nsize = [9, 8, 7]\nspacing = [2.0, 1.0, 1.5]\n[[tissue]]\nlabel = 1\nmodulus = 0.003\n'
                    'density = {}\n[[shape]]\nkind = "everything"\nlabel = 1\n[[condition]]\nwhere = "left"\ndx = 0.0\n'
                    'dy = 0.0\ndz = 0.0\n[[load]]\ngravity = [1.0, -2.0, 0.5]\n')
            results = []
            for density in (500, 1500):
                file = pathlib.Path(folder, "scene.toml")
                file.write_text(text.format(density))
                results.append(hdmbench.solve(scene=file, accuracy="0.000001px", differentiable=True))
        weights = np.random.default_rng(4).standard_normal((9, 8, 7, 3))
        expected = float(((results[1].displacement - results[0].displacement).astype(float) * weights).sum())
        forces = results[0].gradient(weights).forces.astype(float)
        one = np.ones((9, 8, 7))  # a voxel's share of the volume: half of it on a face
        for axis in range(3):
            one[(slice(None),) * axis + ([0, -1],)] *= 0.5
        newtons = 1000e-9 * 3.0 * one[..., None] * np.array([1.0, -2.0, 0.5])  # kg/m^3 in kg/mm^3, 3 mm^3 a voxel
        self.assertAlmostEqual(float((forces * newtons).sum()), expected, delta=1e-3 * abs(expected))

    def test_not_converged(self):
        """Nearly incompressible noise of contrast 1000 leaves float no digits for either solution, and both say so."""
        rng = np.random.default_rng(0)
        labels = 1 + (rng.random((14, 12, 10)) < 0.5)
        for poisson, converged in ((0.3, True), (0.4999, False)):
            result = hdmbench.solve(labels, {1: 1.0, 2: 1000.0}, [[4, 4, 4, 1, 0, 0]], poisson=poisson, accuracy="0.001px",
                                    differentiable=True)
            self.assertEqual(result.met, converged)
            self.assertEqual(result.gradient(rng.standard_normal((14, 12, 10, 3))).converged, converged)

    def test_refused(self):
        result = hdmbench.solve(self.labels, moduli, pairs, spacing=1.5)
        zeros = np.zeros((9, 8, 10, 3))
        with self.assertRaisesRegex(ValueError, "differentiable=True"):
            result.gradient(zeros)
        result = hdmbench.solve(self.labels, moduli, pairs, spacing=1.5, differentiable=True)
        self.assertFalse(result.gradient(zeros).moduli.any())
        with self.assertRaisesRegex(ValueError, re.escape("by_displacement: has the shape (9, 8, 10), the displacement")):
            result.gradient(zeros[..., 0])
        with self.assertRaisesRegex(ValueError, "finite"):
            result.gradient(zeros + np.inf)
        laws = {label: {"modulus": modulus, "law": "neo-hookean"} for label, modulus in moduli.items()}
        with self.assertRaisesRegex(ValueError, "differentiable: .*linear tissue"):
            hdmbench.solve(self.labels, laws, pairs, spacing=1.5, differentiable=True)

    def test_torch(self):
        """The example finds the modulus that a displacement was made with."""
        try:
            import torch
        except ImportError:
            self.skipTest("PyTorch (python3-torch) is not installed")
        spec = importlib.util.spec_from_file_location(
            "torch_function", pathlib.Path(__file__).resolve().parents[2] / "harness/python/examples/torch_function.py")
        example = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(example)
        labels = np.ones((12, 11, 10), np.int64)
        labels[4:8, 4:8, 3:7] = 2
        labels[0] = 0
        conditions = [{"where": "left", "dx": 0.0, "dy": 0.0, "dz": 0.0}, {"where": "right", "dx": 2.0}]
        options = {"conditions": conditions, "accuracy": "0.0001px"}
        seen = example.displacement(torch.tensor([1.0, 1.0, 5.0]), labels, **options)
        stiff = torch.tensor(1.0, requires_grad=True)  # logarithm of its modulus
        steps = torch.optim.LBFGS([stiff], max_iter=12, line_search_fn="strong_wolfe")

        def loss():
            steps.zero_grad()
            moduli_ = torch.stack([torch.tensor(1.0), torch.tensor(1.0), stiff.exp()])
            misfit = 1e3 * ((example.displacement(moduli_, labels, **options) - seen) ** 2).sum()
            misfit.backward()
            return misfit

        steps.step(loss)
        self.assertAlmostEqual(float(stiff.detach().exp()), 5.0, delta=0.05)


if __name__ == "__main__":
    unittest.main()
