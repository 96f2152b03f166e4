"""The exact proof of homogeneous control, against its definitions in floating point."""

import itertools
import math
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from flint import arb, fmpq, fmpq_mat

import parkproof.proof.checker.ellipsoid as module
from parkproof.proof.checker.ellipsoid import (
    Ellipsoid,
    not_positive,
    positive_definite,
    rational,
)

H = np.diag([3.0, 2.0, 1.0])
NUMBERS = (15.96, 8.41, 2.09, 5.76, 1.52, 0.48)
K = (-53.4, -37.3, -10.9)
BOX = ((0.9, 1.1), (0.95, 1.05), (1.0, 1.2))


def matrix_of(numbers: tuple[float, ...]) -> np.ndarray:
    a, b, c, d, e, f = numbers
    return np.array([[a, b, c], [b, d, e], [c, e, f]])


def exact(matrix: np.ndarray) -> fmpq_mat:
    return fmpq_mat(3, 3, [rational(float(x)) for x in matrix.ravel()])


def inequality(
    P: np.ndarray,
    k: np.ndarray,
    rate: float,
    rho: float,
    b1: float,
    b2: float,
    g: float,
    phi: float,
) -> np.ndarray:
    """M of the module's docstring, plainly."""
    A = np.array([[0.0, b1, 0.0], [0.0, 0.0, b2], [0.0, 0.0, 0.0]])
    b = np.array([[0.0], [0.0], [1.0]])
    loop = A + g * b @ k[None]
    pushed = phi**2 / rho * P @ b @ b.T @ P if phi else 0.0
    return P @ loop + loop.T @ P + pushed + rho * P + rate * (H @ P + P @ H)


def value(P: np.ndarray, x: np.ndarray) -> float:
    """V by the roots of its polynomial of degree 6."""
    quadratic = P * np.outer(x, x)
    coefficients = np.zeros(7)
    for i, j in itertools.product(range(3), repeat=2):
        coefficients[6 - (3 - i) - (3 - j)] += quadratic[i, j]
    coefficients[6] -= 1.0
    roots = np.roots(coefficients)
    real = roots[(abs(roots.imag) < 1e-9 * abs(roots)) & (roots.real > 0)].real
    assert real.size == 1
    return float(1.0 / real[0])


def test_definite_matrices_are_told_from_others_like_their_eigenvalues() -> None:
    rng = np.random.default_rng(1)
    seen = set()
    for _ in range(400):
        half = rng.integers(-3, 4, (3, 3)).astype(float)
        matrix = half + half.T + rng.integers(0, 9) * np.eye(3)
        lowest, highest = np.linalg.eigvalsh(matrix)[[0, 2]]
        if min(abs(lowest), abs(highest)) > 1e-9:
            assert positive_definite(exact(matrix)) == (lowest > 0)
            assert not_positive(exact(matrix)) == (highest < 0)
            seen.add((lowest > 0, highest < 0))
    assert seen == {(True, False), (False, True), (False, False)}


def test_a_singular_matrix_is_semidefinite_and_not_definite() -> None:
    singular = fmpq_mat(3, 3, [-1, 2, 0, 2, -4, 0, 0, 0, 0])
    assert not_positive(singular)
    assert not positive_definite(-singular)
    assert not not_positive(singular + fmpq_mat(3, 3, [0, 0, 0, 0, 0, 0, 0, 0, fmpq(1, 10**40)]))


@pytest.mark.parametrize(
    "P",
    [
        (1.0, 2.0, 0.0, 1.0, 0.0, 1.0),  # not positive definite
        (1.0, 0.99, 0.98, 1.0, 0.995, 1.0),  # positive definite, but HP + PH is not
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ],
)
def test_a_form_that_defines_no_value_proves_nothing(P: tuple[float, ...]) -> None:
    bad = Ellipsoid(P, K)
    assert not bad.sound()
    assert not bad.prove_rate(-1e9, 1.0, *BOX, 0.1)
    assert not bad.level([(-1.0, 1.0)] * 3).is_finite()


def test_rates_are_proved_up_to_the_largest_and_not_beyond() -> None:
    """The largest rate at the vertices, by a generalised eigenvalue in floating point."""
    P, k = matrix_of(NUMBERS), np.array(K)
    ellipsoid = Ellipsoid(NUMBERS, K)
    for phi, rho in ((0.0, 0.0), (0.4, 0.1), (1.0, 0.3)):
        root = np.linalg.inv(np.linalg.cholesky(H @ P + P @ H))
        best = min(
            -np.linalg.eigvalsh(root @ inequality(P, k, 0.0, rho, *at, phi) @ root.T)[-1]
            for at in itertools.product(*BOX)
        )
        assert ellipsoid.prove_rate(best - 1e-6, rho, *BOX, phi)
        assert not ellipsoid.prove_rate(best + 1e-6, rho, *BOX, phi)


def test_the_value_falls_at_the_proved_rate_inside_the_box() -> None:
    """Against the derivative of V along the flow, for gains anywhere in their intervals."""
    P, k = matrix_of(NUMBERS), np.array(K)
    rng = np.random.default_rng(2)
    phi, rho = 0.4, 0.1
    ellipsoid = Ellipsoid(NUMBERS, K)
    tried = (float(rate) for rate in np.linspace(0.0, 1.0, 101))
    proved = max(rate for rate in tried if ellipsoid.prove_rate(rate, rho, *BOX, phi))
    assert proved > 0.02
    for _ in range(300):
        x = rng.normal(size=3) * 10.0 ** rng.uniform(-2, 1)
        v = value(P, x)
        z = x / np.array([v**3, v**2, v])
        b1, b2, g = (rng.uniform(*ends) for ends in BOX)
        push = rng.uniform(-phi, phi)
        flow = np.array([b1 * x[1], b2 * x[2], g * (k @ z) + push])
        h = 1e-6 * v
        slope = (value(P, x + h * flow) - value(P, x - h * flow)) / (2.0 * h)
        assert slope <= -proved + 1e-5


def test_every_end_of_every_interval_counts() -> None:
    """A rate that holds on a box fails once any interval is long enough."""
    ellipsoid = Ellipsoid(NUMBERS, K)
    b1, b2, gamma = BOX
    assert ellipsoid.prove_rate(0.02, 0.1, b1, b2, gamma, 0.4)
    wide = [
        ((0.01, 1.1), b2, gamma),
        ((0.9, 9.0), b2, gamma),
        (b1, (0.05, 1.05), gamma),
        (b1, (0.95, 9.0), gamma),
        (b1, b2, (0.2, 1.2)),
    ]
    assert [ellipsoid.prove_rate(0.02, 0.1, *box, 0.4) for box in wide] == [False] * 5
    assert not ellipsoid.prove_rate(0.02, 0.1, *BOX, 4.0)


def test_each_end_of_the_input_gain_has_its_own_rho() -> None:
    ellipsoid = Ellipsoid(NUMBERS, K)
    for pair in ((0.05, 0.3), (0.3, 0.05), (0.1, 0.1)):
        ends = [
            [
                rate
                for rate in np.linspace(-0.5, 0.5, 101)
                if ellipsoid.prove_rate(float(rate), rho, *BOX[:2], (end, end), 0.4)
            ][-1]
            for rho, end in zip(pair, BOX[2], strict=True)
        ]
        assert ellipsoid.prove_rate(float(min(ends)), pair, *BOX, 0.4)
        assert not ellipsoid.prove_rate(float(min(ends)) + 0.011, pair, *BOX, 0.4)
    assert not ellipsoid.prove_rate(0.02, (0.1, 0.0), *BOX, 0.4)


def test_claims_about_disturbances_that_make_no_sense_are_refused() -> None:
    ellipsoid = Ellipsoid(NUMBERS, K)
    assert not ellipsoid.prove_rate(0.02, 0.0, *BOX, 0.4)
    assert not ellipsoid.prove_rate(0.02, -0.1, *BOX, 0.4)
    assert not ellipsoid.prove_rate(0.02, 0.1, *BOX, -0.4)


def test_numbers_are_taken_exactly() -> None:
    assert rational(0.1) == fmpq(3602879701896397, 36028797018963968)
    assert rational(Fraction(1, 10)) == rational(fmpq(1, 10)) == fmpq(1, 10)
    edge = Ellipsoid((1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    zero = (0, 0)
    assert edge.prove_rate(0, 0, zero, zero, zero, 0)
    assert not edge.prove_rate(5e-324, 0, zero, zero, zero, 0)


def test_a_level_bounds_the_value_over_its_box_and_is_nearly_reached() -> None:
    P = matrix_of(NUMBERS)
    ellipsoid = Ellipsoid(NUMBERS, K)
    rng = np.random.default_rng(3)
    for _ in range(30):
        middle, half = rng.normal(size=3), rng.uniform(0.0, 1.0, 3) * 10.0 ** rng.uniform(-3, 1)
        box = [(float(m - h), float(m + h)) for m, h in zip(middle, half, strict=True)]
        level = float(ellipsoid.level(box))
        inside = rng.uniform(middle - half, middle + half, (50, 3))
        assert max(value(P, x) for x in inside) <= level
        assert max(value(P, np.array(x)) for x in itertools.product(*box)) == pytest.approx(level)


def test_levels_of_balls_points_and_the_origin() -> None:
    ellipsoid = Ellipsoid(NUMBERS, K)
    point = float(ellipsoid.level([(1.0, 1.0), (-2.0, -2.0), (0.5, 0.5)]))
    assert point == pytest.approx(value(matrix_of(NUMBERS), np.array([1.0, -2.0, 0.5])))
    fuzzy = arb(1.0, 0.25)
    balls = ellipsoid.level([(fuzzy, fuzzy), (arb(0), arb(0)), (arb(0), arb(0))])
    assert float(balls) == pytest.approx(
        float(ellipsoid.level([(0.75, 1.25), (0.0, 0.0), (0.0, 0.0)]))
    )
    assert ellipsoid.level([(0.0, 0.0)] * 3) == 0
    assert not ellipsoid.level([(0.0, math.inf), (0.0, 0.0), (0.0, 0.0)]).is_finite()


@pytest.mark.parametrize("size", [1e-30, 1e-3, 1e3, 1e30])
def test_levels_scale_with_the_weights_of_the_states(size: float) -> None:
    ellipsoid = Ellipsoid(NUMBERS, K)
    one = float(ellipsoid.level([(-1.0, 1.0), (0.5, 2.0), (-3.0, 0.0)]))
    scaled = ellipsoid.level(
        [(-(size**3), size**3), (0.5 * size**2, 2.0 * size**2), (-3.0 * size, 0.0)]
    )
    assert float(scaled) == pytest.approx(one * size, rel=1e-6)


def test_sizes_and_input_are_bounds_and_are_reached() -> None:
    P, k = matrix_of(NUMBERS), np.array(K)
    ellipsoid = Ellipsoid(NUMBERS, K)
    root = np.linalg.inv(np.linalg.cholesky(P)).T
    y = np.random.default_rng(4).normal(size=(200_000, 3))
    z = (y / np.linalg.norm(y, axis=1)[:, None]) @ root.T
    v = 1.7
    reached = np.abs(z * np.array([v**3, v**2, v])).max(axis=0)
    for bound, seen in zip(ellipsoid.sizes(arb(v)), reached, strict=True):
        assert seen <= float(bound) <= 1.001 * seen
    largest = np.abs(z @ k).max()
    assert largest <= float(ellipsoid.input_bound()) <= 1.001 * largest


def test_the_module_needs_only_the_standard_library_and_the_arithmetic() -> None:
    """Copied alone into an empty folder, it runs."""
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]); import ellipsoid; "
        "print(ellipsoid.Ellipsoid((1, 0, 0, 1, 0, 1), (0, 0, 0)).sound(), 'numpy' in sys.modules)"
    )
    folder = str(Path(module.__file__).parent)
    done = subprocess.run(
        [sys.executable, "-c", code, folder], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["True", "False"]
