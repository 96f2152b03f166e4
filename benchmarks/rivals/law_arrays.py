"""The closed loop as array code, for NumPy and for JAX: every lane goes through every branch."""

from typing import Any

from parkproof.laws.parameters import LawParameters


def spow(xp: Any, x: Any, p: Any) -> Any:
    """Signed power."""
    return xp.copysign(xp.power(xp.abs(x), p), x)


def push(xp: Any, z: Any, gain: Any, r: Any, phi: float, gamma: float) -> Any:
    """Theorem 1's input for the nominal input −gain·⌈z⌋^r."""
    return -xp.sign(z) * (gain * xp.power(xp.abs(z), r) + phi) / gamma


def next_step(xp: Any, step: Any, way: Any, state: Any, p: LawParameters) -> Any:
    """Step in force from this sample on."""
    x0, x1, x2, u0, u1 = state
    done1 = (step == 1.0) & (xp.abs(u0 - way * p.runup_speed) <= p.tolerance1)
    across = xp.maximum(xp.maximum(xp.abs(x1), xp.abs(x2)), xp.abs(u1))
    done2 = (step == 2.0) & (across <= p.tolerance2)
    done3 = (step == 3.0) & (xp.maximum(xp.abs(x0), xp.abs(u0)) <= p.tolerance3)
    lost = (step >= 3.0) & (xp.abs(x1) > p.x1_leave)
    return xp.where(lost, 1.0, step + (done1 | done2 | done3))


def inputs(xp: Any, step: Any, way: Any, state: Any, p: LawParameters) -> tuple[Any, Any]:
    """Inputs τ1 and τ2."""
    x0, x1, x2, u0, u1 = state
    cruising, speed = step <= 2.0, xp.abs(u0)
    window = (step == 3.0) & (speed >= p.steer_low) & (speed <= p.steer_high)
    steering = (step == 2.0) | window
    back = spow(xp, u0, p.inv_q2) + p.K1 * x0
    z1 = xp.where(cruising, u0 - way * p.runup_speed, back)
    gain1, r1 = xp.where(cruising, p.lambda1, p.k3), xp.where(cruising, p.q0, p.r2)
    sided = xp.where(cruising, way, xp.sign(u0)) * x1
    xi = spow(xp, x2, p.inv_q1) + p.L1 * sided
    offset = xp.where(steering, p.L2 * xi, p.H1 * x2)
    z2 = spow(xp, u1, xp.where(steering, p.inv_e1, p.inv_q2)) + offset
    gain2, r2 = xp.where(steering, p.l3, p.hold3), xp.where(steering, p.r1, p.r2)
    return (
        push(xp, z1, gain1, r1, p.phi1, p.gamma_min1),
        push(xp, z2, gain2, r2, p.phi2, p.gamma_min2),
    )


def rates(xp: Any, t: Any, state: Any, tau: Any, truth: Any) -> tuple[Any, ...]:
    """Rates of x0, x1, x2, u0 and u1."""
    _, _, x2, u0, u1 = state
    gamma1, gamma2, phi1, phi2 = (
        truth[i] + truth[i + 1] * xp.sin(truth[i + 2] * t + truth[i + 3]) for i in (2, 6, 10, 14)
    )
    return (
        truth[0] * u0,
        truth[1] * x2 * u0,
        u1,
        gamma1 * tau[0] + phi1,
        gamma2 * tau[1] + phi2,
    )


def metrics(xp: Any, t: Any, kept: Any, state: Any, tau: Any) -> tuple[Any, ...]:
    """What is kept beside steps and ends, with this sample; in the order of `law.NOTHING_YET`."""
    x0, x1, x2, u0, u1 = state
    largest, sums, low, high, speed, turn, before = (
        kept[:8], kept[8:13], *kept[13:17], kept[17:]
    )  # fmt: skip
    sizes = (*(xp.abs(value) for value in (*tau, *state)), x0**2 + x1**2)
    length = xp.sqrt((x0 - before[2]) ** 2 + (x1 - before[3]) ** 2)
    changes = (xp.abs(tau[0] - before[0]), xp.abs(tau[1] - before[1]), length)
    later = xp.where(t > 0.0, 1.0, 0.0)
    more = (tau[0] ** 2, tau[1] ** 2, *(later * change for change in changes))
    square = 1.0 + x2**2
    return (
        *(xp.maximum(old, new) for old, new in zip(largest, sizes, strict=True)),
        *(old + new for old, new in zip(sums, more, strict=True)),
        xp.minimum(low, x0),
        xp.maximum(high, x0),
        xp.maximum(speed, u0**2 * square),
        xp.maximum(turn, xp.abs(u1) / square),
        *tau,
        x0,
        x1,
    )
