"""A displacement as a function of PyTorch's: moduli of tissues in, millimetres out, with gradients.

`displacement(moduli, labels, ...)` is differentiable by `moduli`, a tensor with one modulus (MPa) for each label
0 ... n - 1; everything else is as hdmbench.solve has it. Example: the modulus of a tumour from a displacement that
was seen.

    modulus = torch.tensor(3.0, requires_grad=True)
    moduli = torch.stack([torch.tensor(3.0), modulus])
    loss = ((displacement(moduli, labels, points=points) - seen) ** 2).mean()
    loss.backward()      # modulus.grad
"""

import numpy as np
import torch

import hdmbench


class _Displacement(torch.autograd.Function):
    @staticmethod
    def forward(ctx, moduli, labels, options):
        tissues = dict(enumerate(moduli.detach().double().tolist()))
        ctx.result = hdmbench.solve(labels, tissues, differentiable=True, **options)
        ctx.labels = np.asarray(labels)
        ctx.moduli = moduli
        return torch.from_numpy(ctx.result.displacement.copy()).to(moduli)

    @staticmethod
    def backward(ctx, by_displacement):
        gradient = ctx.result.gradient(by_displacement.cpu().numpy())
        of_tissues = np.bincount(ctx.labels.ravel(), gradient.moduli.ravel(), minlength=len(ctx.moduli))
        return torch.from_numpy(of_tissues).to(ctx.moduli), None, None


def displacement(moduli, labels, **options):
    """Millimetres, a vector for every voxel, of the dtype and device of `moduli`."""
    return _Displacement.apply(moduli, labels, options)
