from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

@final
class Inverse:
    @property
    def displacement(self) -> NDArray[np.float32]: ...
    @property
    def unmet(self) -> int: ...
    @property
    def farthest(self) -> float: ...
    @property
    def at(self) -> list[int]: ...
    def warp(
        self,
        image: ArrayLike | Any,
        *,
        labels: bool = False,
        spacing: float | Sequence[float] | None = None,
        affine: ArrayLike | None = None,
    ) -> NDArray[Any]: ...
    def save(self, file: str | PathLike[str]) -> None: ...

@final
class Gradient:
    @property
    def moduli(self) -> NDArray[np.float32]: ...
    @property
    def targets(self) -> NDArray[np.float32]: ...
    @property
    def forces(self) -> NDArray[np.float32]: ...
    @property
    def converged(self) -> bool: ...

@final
class Result:
    @property
    def displacement(self) -> NDArray[np.float32]: ...
    @property
    def affine(self) -> NDArray[np.float64]: ...
    @property
    def space(self) -> str: ...
    @property
    def residuals(self) -> NDArray[np.float64]: ...
    @property
    def estimate(self) -> float | None: ...
    @property
    def met(self) -> bool | None: ...
    @property
    def outcome(self) -> str: ...
    @property
    def warnings(self) -> list[dict[str, Any]]: ...
    @property
    def timings(self) -> dict[str, float]: ...
    @property
    def scene(self) -> str: ...
    @property
    def energy(self) -> str: ...
    @property
    def method(self) -> str: ...
    @property
    def backend(self) -> str: ...
    @property
    def device(self) -> str: ...
    def inverse(self) -> Inverse: ...
    def warp(
        self,
        image: ArrayLike | Any,
        *,
        labels: bool = False,
        spacing: float | Sequence[float] | None = None,
        affine: ArrayLike | None = None,
    ) -> NDArray[Any]: ...
    def gradient(self, by_displacement: ArrayLike) -> Gradient: ...
    def save(self, file: str | PathLike[str]) -> None: ...

def solve(
    labels: ArrayLike | Any | None = None,
    tissues: Mapping[int, float | Mapping[str, Any]] | str | PathLike[str] | None = None,
    points: ArrayLike | tuple[Any, Any] | str | PathLike[str] | None = None,
    targets: ArrayLike | None = None,
    confidence: ArrayLike | None = None,
    modulus: ArrayLike | Any | None = None,
    spacing: float | Sequence[float] | None = None,
    affine: ArrayLike | None = None,
    *,
    scene: str | PathLike[str] | None = None,
    size: int | Sequence[int] | None = None,
    conditions: Iterable[Mapping[str, Any]] | None = None,
    precision: ArrayLike | None = None,
    force: ArrayLike | None = None,
    fibre: ArrayLike | None = None,
    normals: ArrayLike | None = None,
    loads: Iterable[Mapping[str, Any]] | None = None,
    resect: int | Iterable[int] | None = None,
    law: str | None = None,
    energy: str | None = None,
    method: str | None = None,
    iterations: int | None = None,
    poisson: float | None = None,
    accuracy: float | str | None = None,
    within: float | str | None = None,
    backend: str = "openmp",
    device: str = "",
    threads: int = 0,
    differentiable: bool = False,
) -> Result: ...
def register(
    source: ArrayLike | Any,
    target: ArrayLike | Any,
    labels: ArrayLike | Any,
    tissues: Mapping[int, float | Mapping[str, Any]] | str | PathLike[str],
    region: ArrayLike | Any | None = None,
    *,
    spacing: float | Sequence[float] | None = None,
    affine: ArrayLike | None = None,
    iterate: bool = False,
    energy: str | None = None,
    method: str | None = None,
    iterations: int | None = None,
    poisson: float | None = None,
    backend: str = "openmp",
    device: str = "",
    threads: int = 0,
) -> Result: ...
def bench(
    scene: str = "square",
    backends: Sequence[str] | None = None,
    *,
    size: int | Sequence[int] | None = None,
    energy: str | None = None,
    method: str | None = None,
    iterations: int | None = None,
    repeat: int = 5,
    device: str = "",
    threads: int = 0,
) -> list[dict[str, Any]]: ...
def backends() -> list[dict[str, Any]]: ...
def scenes() -> list[dict[str, Any]]: ...
def verify(
    scene: str = "square",
    backends: Sequence[str] | None = None,
    *,
    size: int | Sequence[int] | None = None,
    energy: str | None = None,
    method: str | None = None,
    iterations: int | None = None,
    device: str = "",
    threads: int = 0,
) -> list[dict[str, Any]]: ...
