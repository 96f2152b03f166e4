"""The closed loop once more, as the scalar code that a user of the rivals would write.

It runs as plain Python in Drake, python-control and SciPy, and is compiled by numba. It branches
to what a step needs and nothing more: in plain Python and in scalar machine code that is the faster
form. The turn (Step 0) and a second choice of the direction are left out.
"""

import math

from numba.extending import register_jitable

NOTHING_YET = (1.0, -1.0, -1.0, -1.0, *(0.0,) * 13, math.inf, -math.inf, *(0.0,) * 6)
"""What is kept of a trial before its first sample: Step 1, three ends, the metrics (`work.METRICS`,
before the roots and means of `work.found_from`), and τ1, τ2, x0 and x1 of the sample before."""


@register_jitable
def spow(x, p):
    """Signed power."""
    return math.copysign(abs(x) ** p, x)


@register_jitable
def push(z, gain, r, phi, gamma):
    """Theorem 1's input for the nominal input −gain·⌈z⌋^r."""
    if z == 0.0:
        return 0.0
    return -math.copysign(gain * abs(z) ** r + phi, z) / gamma


@register_jitable
def next_step(step, way, x0, x1, x2, u0, u1, p):
    """Step in force from this sample on."""
    if step >= 3.0 and abs(x1) > p.x1_leave:
        return 1.0
    if step == 1.0:
        return 2.0 if abs(u0 - way * p.runup_speed) <= p.tolerance1 else 1.0
    if step == 2.0:
        return 3.0 if max(abs(x1), abs(x2), abs(u1)) <= p.tolerance2 else 2.0
    if step == 3.0:
        return 4.0 if max(abs(x0), abs(u0)) <= p.tolerance3 else 3.0
    return step


@register_jitable
def inputs(step, way, x0, x1, x2, u0, u1, p):
    """Inputs τ1 and τ2."""
    if step <= 2.0:
        side = way
        tau1 = push(u0 - way * p.runup_speed, p.lambda1, p.q0, p.phi1, p.gamma_min1)
    else:
        side = 1.0 if u0 > 0.0 else (-1.0 if u0 < 0.0 else 0.0)
        z1 = spow(u0, p.inv_q2) + p.K1 * x0
        tau1 = push(z1, p.k3, p.r2, p.phi1, p.gamma_min1)
    if step == 2.0 or (step == 3.0 and p.steer_low <= abs(u0) <= p.steer_high):
        xi = spow(x2, p.inv_q1) + p.L1 * (side * x1)
        z2 = spow(u1, p.inv_e1) + p.L2 * xi
        return tau1, push(z2, p.l3, p.r1, p.phi2, p.gamma_min2)
    z2 = spow(u1, p.inv_q2) + p.H1 * x2
    return tau1, push(z2, p.hold3, p.r2, p.phi2, p.gamma_min2)


@register_jitable
def decide(t, way, x0, x1, x2, u0, u1, kept, p):
    """Inputs at a sample, and what is kept of the trial with this sample."""
    before, end1, end2, end3, tau1_max, tau2_max, max0, max1, max2, max3, max4, far = kept[:12]
    square1, square2, change1, change2, path, low, high, speed, turn = kept[12:21]
    tau1_was, tau2_was, x0_was, x1_was = kept[21:]
    step = next_step(before, way, x0, x1, x2, u0, u1, p)
    if step > before:
        if before == 1.0:
            end1 = t
        elif before == 2.0:
            end2 = t
        else:
            end3 = t
    elif step < before:
        end1, end2, end3 = -1.0, -1.0, -1.0
    tau1, tau2 = inputs(step, way, x0, x1, x2, u0, u1, p)
    if t > 0.0:
        change1, change2 = change1 + abs(tau1 - tau1_was), change2 + abs(tau2 - tau2_was)
        path += math.sqrt((x0 - x0_was) * (x0 - x0_was) + (x1 - x1_was) * (x1 - x1_was))
    square = 1.0 + x2 * x2
    kept = (
        step, end1, end2, end3, max(tau1_max, abs(tau1)), max(tau2_max, abs(tau2)),
        max(max0, abs(x0)), max(max1, abs(x1)), max(max2, abs(x2)), max(max3, abs(u0)),
        max(max4, abs(u1)), max(far, x0 * x0 + x1 * x1), square1 + tau1 * tau1,
        square2 + tau2 * tau2, change1, change2, path, min(low, x0), max(high, x0),
        max(speed, u0 * u0 * square), max(turn, abs(u1) / square), tau1, tau2, x0, x1,
    )  # fmt: skip
    return tau1, tau2, kept


@register_jitable
def rates(t, x2, u0, u1, tau1, tau2, truth):
    """Rates of x0, x1, x2, u0 and u1."""
    gamma1 = truth[2] + truth[3] * math.sin(truth[4] * t + truth[5])
    gamma2 = truth[6] + truth[7] * math.sin(truth[8] * t + truth[9])
    phi1 = truth[10] + truth[11] * math.sin(truth[12] * t + truth[13])
    phi2 = truth[14] + truth[15] * math.sin(truth[16] * t + truth[17])
    return truth[0] * u0, truth[1] * x2 * u0, u1, gamma1 * tau1 + phi1, gamma2 * tau2 + phi2


@register_jitable
def euler_period(t, h, way, x0, x1, x2, u0, u1, kept, truth, p):
    """State after one period, by Euler's method, and what is kept."""
    tau1, tau2, kept = decide(t, way, x0, x1, x2, u0, u1, kept, p)
    d0, d1, d2, d3, d4 = rates(t, x2, u0, u1, tau1, tau2, truth)
    return x0 + h * d0, x1 + h * d1, x2 + h * d2, u0 + h * d3, u1 + h * d4, kept
