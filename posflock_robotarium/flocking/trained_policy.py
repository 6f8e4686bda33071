"""A small network that drives robots, as numbers in a file: numpy is all that it takes.

A policy is trained on a large machine and acts on a small one. What goes along are its weights: the
testbed takes `.npy`, but no `.npz`, and no library of networks is needed for a few hundred numbers.
They lie in the file by name, one record of arrays, and without pickles: nothing in it is executed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from posflock_robotarium.flocking.errors import ParameterError

__all__ = ["TrainedPolicy"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TrainedPolicy:
    """Layers of weights with tanh after each: what is seen in, actions from -1 to 1 out.

    Attributes
    ----------
    weights : tuple of (inputs, outputs) array
        A matrix a layer.
    biases : tuple of (outputs,) array
        And what is added.

    Raises
    ------
    ParameterError
        Where shapes do not fit together, or a number is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> policy = TrainedPolicy.from_vector(np.zeros(8), (3, 2))
    >>> policy.act(np.ones((5, 3))).shape
    (5, 2)
    """

    weights: tuple[Floats, ...]
    biases: tuple[Floats, ...]

    def __post_init__(self) -> None:
        pairs = list(zip(self.weights, self.biases, strict=False))
        if not pairs or len(self.weights) != len(self.biases):
            raise ParameterError(
                f"a policy needs a bias for each matrix: got {len(self.weights)} matrices and"
                f" {len(self.biases)} biases"
            )
        inputs = self.weights[0].shape[0]
        for layer, (weight, bias) in enumerate(pairs):
            if weight.ndim != 2 or bias.shape != weight.shape[1:] or weight.shape[0] != inputs:
                raise ParameterError(
                    f"layer {layer}: expected a matrix ({inputs}, outputs) and a bias (outputs,),"
                    f" got {weight.shape} and {bias.shape}"
                )
            if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
                raise ParameterError(f"layer {layer}: expected finite numbers")
            inputs = weight.shape[1]

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many numbers go in, are between the layers, and come out."""
        return (self.weights[0].shape[0], *(weight.shape[1] for weight in self.weights))

    @classmethod
    def from_vector(cls, vector: Floats, sizes: Sequence[int]) -> TrainedPolicy:
        """Return the policy that a vector of all its numbers is, as a search for one has it.

        Parameters
        ----------
        vector : (P,) array
            Matrix and bias of a layer after the other.
        sizes : sequence of int
            As `sizes` has them.

        Raises
        ------
        ParameterError
            Where there are more or fewer numbers than that takes.
        """
        expected = cls.numbers(sizes)
        numbers = np.asarray(vector, dtype=float)
        if numbers.shape != (expected,):
            raise ParameterError(
                f"layers {tuple(sizes)} take {expected} numbers, got an array of shape"
                f" {numbers.shape}"
            )
        layers, first = [], 0
        for inputs, outputs in itertools.pairwise(sizes):
            last = first + inputs * outputs
            layers.append((numbers[first:last].reshape(inputs, outputs), numbers[last:][:outputs]))
            first = last + outputs
        return cls(tuple(w for w, _ in layers), tuple(b for _, b in layers))

    @staticmethod
    def numbers(sizes: Sequence[int]) -> int:
        """Return how many numbers a policy of these sizes has.

        Parameters
        ----------
        sizes : sequence of int
            As `sizes` has them.
        """
        return sum((inputs + 1) * outputs for inputs, outputs in itertools.pairwise(sizes))

    @classmethod
    def of(cls, stored: Mapping[str, Any] | NDArray[Any]) -> TrainedPolicy:
        """Return the policy of a file, as `numpy.load` opens it.

        Parameters
        ----------
        stored : (...) array or mapping
            A record with fields ``weight_0``, ``bias_0``, ``weight_1``, …, from `.npy`; or
            arrays of these names, from `.npz`.

        Raises
        ------
        ParameterError
            Where it holds no policy.
        """
        if isinstance(stored, np.ndarray):
            names, values = stored.dtype.names or (), stored.reshape(-1)
            stored = {name: values[name][0] for name in names} if values.size == 1 else {}
        layers = sum(name.startswith("weight_") for name in stored)
        try:
            weights = [np.asarray(stored[f"weight_{k}"], dtype=float) for k in range(layers)]
            biases = [np.asarray(stored[f"bias_{k}"], dtype=float) for k in range(layers)]
        except (KeyError, ValueError, TypeError) as error:
            raise ParameterError(f"these are no weights of a policy: {error}") from error
        return cls(tuple(weights), tuple(biases))

    def stored(self) -> NDArray[Any]:
        """Return the record for `numpy.save`.

        Returns
        -------
        (1,) array
            A record with a field for each matrix and bias.
        """
        arrays = self.named()
        kinds = [(name, array.dtype, array.shape) for name, array in arrays.items()]
        record = np.zeros(1, dtype=kinds)
        for name, array in arrays.items():
            record[name][0] = array
        return record

    def named(self) -> dict[str, Floats]:
        """Return the arrays by name, for `numpy.savez`: dict of (inputs, outputs) arrays."""
        found = {}
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            found[f"weight_{k}"], found[f"bias_{k}"] = weight, bias
        return found

    def act(self, seen: Floats) -> Floats:
        """Return what to do.

        Parameters
        ----------
        seen : (..., inputs) array
            What is seen, for each robot.

        Returns
        -------
        (..., outputs) array
            Actions from -1 to 1.

        Raises
        ------
        ParameterError
            Where something else is seen than the policy was trained with.
        """
        if seen.shape[-1] != self.sizes[0]:
            raise ParameterError(
                f"this policy takes {self.sizes[0]} numbers a robot, got {seen.shape[-1]}"
            )
        values = seen
        for weight, bias in zip(self.weights, self.biases, strict=True):
            values = np.tanh(values @ weight + bias)
        return values

    def velocities(self, seen: Floats, headings: Floats, speed: float) -> Floats:
        """Return where look-ahead points are to go, in the arena's frame.

        Parameters
        ----------
        seen : (N, inputs) array
            What each robot sees.
        headings : (N,) array
            Where robots look, rad.
        speed : float
            What an action of 1 means, m/s; what the motors can do is the certificate's to say.

        Returns
        -------
        (2, N) array
            Velocities, m/s.

        Raises
        ------
        ParameterError
            Where the policy has other than two outputs: ahead and left.
        """
        action = self.act(seen)
        if action.shape[-1] != 2 or not math.isfinite(speed):
            raise ParameterError(
                f"expected two outputs, ahead and left, and a finite speed; got {self.sizes[-1]}"
                f" and {speed!r}"
            )
        ahead, left = action.T
        cosine, sine = np.cos(headings), np.sin(headings)
        return speed * np.stack([cosine * ahead - sine * left, sine * ahead + cosine * left])
