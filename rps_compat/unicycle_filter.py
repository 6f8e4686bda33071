"""An extended Kalman filter for the pose of one unicycle.

The state is x = (x, y, θ), in metres and radians, with covariance P. The wheels' encoders tell the
forward speed v and the turn rate ω, so prediction follows the unicycle:

    x ← x + dt (v cos θ, v sin θ, ω)        P ← F P Fᵀ + L M Lᵀ + Q dt

F is the derivative of that step by the state. What the encoders err, M of the right and left wheel
(rad²/s²), comes through v = R (ω_right + ω_left) / 2 and ω = R (ω_right − ω_left) / b, so that
L = G [[R/2, R/2], [R/b, −R/b]], with G the derivative of the step by (v, ω). Q is what the model
itself errs in a second.

A measurement z = h(x) with variance R corrects by its innovation y = z − h(x), angles wrapped:

    S = H P Hᵀ + R      K = P Hᵀ S⁻¹      x ← x + K y      P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ

The last is Joseph's form, which stays symmetric and positive however small R is.

A gyroscope tells how far the robot has turned since it was last asked: θ − θ₀, with θ₀ the heading
of then. That is no measurement of θ, which the filter would be surer of with every step without
having seen anything. So θ₀ is a fourth state that stays as it is, with its covariance to the others
(stochastic cloning, Roumeliotis and Burdick 2002).

Source: Thrun, Burgard and Fox, *Probabilistic Robotics*, chapters 3, 5 and 7.
"""

from typing import Any

import numpy as np

from rps_compat.arguments import ShapeError, number
from rps_compat.errors import RobotariumError
from rps_compat.kinematics import Array, wrap


class NoiseError(RobotariumError, TypeError, ValueError):
    """The variance of a measurement is missing, not positive, or not of the measurement's size."""


def numbers(name: str, values: Any, *shape: int) -> Array:
    """Return values as a float array, whatever way they are nested.

    Parameters
    ----------
    name : str
        What the error calls them.
    values : (...) array-like
        What was given.
    *shape : int
        The shape that they get.

    Returns
    -------
    (...) array
        The values, of that shape.

    Raises
    ------
    ShapeError
        There are more or fewer of them, or one is no finite number.
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} is {values!r}, expected numbers of shape {shape}") from None
    if array.size != np.prod(shape, dtype=int) or not np.isfinite(array).all():
        raise ShapeError(
            f"{name} has shape {array.shape}, expected {shape} finite numbers; got {values!r}"
        )
    return array.reshape(shape)


class UnicycleFilter:
    """Estimates the pose of one unicycle from its encoders and from other measurements.

    Parameters
    ----------
    initial_state : (3,) array
        Pose, m and rad.
    initial_covariance : (3, 3) array
        Of that pose, m² and rad².
    b : float
        Length of the axle, from wheel to wheel, m.
    r : float
        Radius of the wheels, m.
    M : (2, 2) array
        Covariance of the speeds that the encoders tell, right wheel first, rad²/s².
    Q : (3, 3) array
        Covariance that the model gains in a second.

    Attributes
    ----------
    state : (3,) array
        Estimated pose; the heading within [−π, π] after every step.
    base_length, wheel_radius, wheel_encoder_noise_covariance_matrix, Q
        As given.

    Raises
    ------
    NumberError, ShapeError
        A length that is not positive; an array of another size, or with numbers that are not
        finite.
    """

    def __init__(
        self, initial_state: Any, initial_covariance: Any, b: float, r: float, M: Any, Q: Any
    ) -> None:
        number("b", b, above=0)
        number("r", r, above=0)
        self.state: Array = numbers("initial_state", initial_state, 3).copy()
        self.P = numbers("initial_covariance", initial_covariance, 3, 3)
        self.base_length, self.wheel_radius = b, r
        self.wheel_encoder_noise_covariance_matrix = numbers("M", M, 2, 2)
        self.Q = numbers("Q", Q, 3, 3)

    @property
    def P(self) -> Array:  # noqa: N802 - the published name
        """Covariance (3, 3) of the estimate. Who sets it begins afresh: what was then is as now."""
        return self._joint[:3, :3]

    @P.setter
    def P(self, covariance: Array) -> None:  # noqa: N802 - the published name
        self._joint: Array = np.zeros((4, 4))
        self._joint[:3, :3] = covariance
        self.clone_heading()

    @property
    def covariance(self) -> Array:
        """Covariance (3, 3) of the estimate, as it is now."""
        return self.P

    def clone_heading(self) -> None:
        """Let the heading of now be the one that is turned from, θ₀."""
        self.previous_theta = float(self.state[2])
        self._joint[3], self._joint[:, 3] = self._joint[2], self._joint[:, 2]
        self._joint[3, 3] = self._joint[2, 2]

    def form_fx(self, v: float, w: float, dt: float) -> Array:
        """Return what a step adds to the state.

        Parameters
        ----------
        v : float
            Forward speed, m/s.
        w : float
            Turn rate, rad/s.
        dt : float
            Duration of the step, s.

        Returns
        -------
        (3, 1) array
            Change of the pose, m and rad.
        """
        heading = float(self.state[2])
        moved: Array = dt * np.array([[v * np.cos(heading)], [v * np.sin(heading)], [w]])
        return moved

    def form_F(self, v: float, dt: float) -> Array:  # noqa: N802 - the published name
        """Return the derivative of a step by the state.

        Parameters
        ----------
        v : float
            Forward speed, m/s.
        dt : float
            Duration of the step, s.

        Returns
        -------
        (3, 3) array
            The Jacobian F.
        """
        heading = self.state[2]
        derivative: Array = np.eye(3)
        derivative[:2, 2] = v * dt * np.array([-np.sin(heading), np.cos(heading)])
        return derivative

    def form_G(self, dt: float) -> Array:  # noqa: N802 - the published name
        """Return the derivative of a step by (v, ω).

        Parameters
        ----------
        dt : float
            Duration of the step, s.

        Returns
        -------
        (3, 2) array
            The Jacobian G.
        """
        heading = self.state[2]
        return np.array([[dt * np.cos(heading), 0.0], [dt * np.sin(heading), 0.0], [0.0, dt]])

    def form_Q(self, dt: float) -> Array:  # noqa: N802 - the published name
        """Return the covariance that the model gains in a step.

        Parameters
        ----------
        dt : float
            Duration of the step, s.

        Returns
        -------
        (3, 3) array
            Covariance, m² and rad².
        """
        return np.asarray(self.Q * dt)

    def form_wheel_encoder_process_noise_matrix(self, dt: float) -> Array:
        """Return the covariance that the encoders' errors bring in a step.

        Parameters
        ----------
        dt : float
            Duration of the step, s.

        Returns
        -------
        (3, 3) array
            Covariance, m² and rad².
        """
        radius, axle = self.wheel_radius, self.base_length
        wheels = np.array([[radius / 2, radius / 2], [radius / axle, -radius / axle]])
        through = self.form_G(dt) @ wheels
        return np.asarray(through @ self.wheel_encoder_noise_covariance_matrix @ through.T)

    def predict(self, v: float, w: float, dt: float) -> None:
        """Move the estimate by one step.

        Parameters
        ----------
        v, w
            Forward speed (m/s) and turn rate (rad/s) that the encoders tell.
        dt
            Length of the step, s.
        """
        moved = self.form_fx(v, w, dt)[:, 0]
        step = np.eye(4)
        step[:3, :3] = self.form_F(v, dt)
        self._joint = step @ self._joint @ step.T
        self._joint[:3, :3] += self.form_wheel_encoder_process_noise_matrix(dt) + self.form_Q(dt)
        self.state = self._wrapped(self.state + moved)

    def correct(self, innovation: Any, derivative: Any, name: str, noise: Any) -> None:
        """Correct the estimate by a measurement.

        Parameters
        ----------
        innovation
            What was measured beyond what was expected, (K,).
        derivative
            Of the expected measurement by x, y, θ and θ₀, (K, 4).
        name, noise
            The measurement's covariance, (K, K), and what the caller calls it.

        Raises
        ------
        NoiseError
            The covariance is missing, has another size, or is not positive.
        """
        beyond = np.atleast_1d(np.asarray(innovation, dtype=float))
        by_state = np.asarray(derivative, dtype=float).reshape(beyond.size, 4)
        variance = _variance(name, noise, beyond.size)
        spread = by_state @ self._joint @ by_state.T + variance
        gain = np.linalg.solve(spread, by_state @ self._joint).T
        left = np.eye(4) - gain @ by_state
        self._joint = left @ self._joint @ left.T + gain @ variance @ gain.T
        correction = gain @ beyond
        self.state = self._wrapped(self.state + correction[:3])
        self.previous_theta += float(correction[3])

    def correct_position(self, position: Any, name: str, noise: Any) -> None:
        """Correct by a measured position.

        Parameters
        ----------
        position : (2,) array-like
            The position, m.
        name : str
            What errors call the covariance.
        noise : (2, 2) array-like
            Its covariance, m².
        """
        beyond = numbers("gps_measurement", position, 2) - self.state[:2]
        self.correct(beyond, np.eye(2, 4), name, noise)

    @staticmethod
    def _wrapped(state: Array) -> Array:
        state[2] = wrap(state[2])
        return state


def _variance(name: str, noise: Any, size: int) -> Array:
    try:
        matrix = np.asarray(noise, dtype=float).reshape(size, size)
        if not np.isfinite(matrix).all():  # None is NaN
            raise ValueError
        np.linalg.cholesky(matrix)
    except (TypeError, ValueError, np.linalg.LinAlgError):
        what = "a positive number" if size == 1 else f"a positive definite ({size}, {size}) matrix"
        raise NoiseError(
            f"{name} is {noise!r}, expected {what}, the measurement's variance"
        ) from None
    return matrix
