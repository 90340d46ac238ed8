# SPDX-License-Identifier: BSD-3-Clause
"""Poses in plain Python: (translation, quaternion x y z w), m and rad."""
import math

IDENTITY = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def unit(q):
    n = math.sqrt(sum(c * c for c in q))
    return tuple(c / n for c in q)


def times(a, b):
    """Product of two quaternions."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz)


def conjugate(q):
    return (-q[0], -q[1], -q[2], q[3])


def turn(q, v):
    x, y, z, _ = times(times(q, (v[0], v[1], v[2], 0.0)), conjugate(q))
    return (x, y, z)


def add(a, b):
    return tuple(p + r for p, r in zip(a, b))


def sub(a, b):
    return tuple(p - r for p, r in zip(a, b))


def scale(s, a):
    return tuple(s * p for p in a)


def norm(a):
    return math.sqrt(sum(p * p for p in a))


def compose(a, b):
    return (add(a[0], turn(a[1], b[0])), unit(times(a[1], b[1])))


def inverse(a):
    q = conjugate(a[1])
    return (scale(-1, turn(q, a[0])), q)


def log(q):
    """Rotation vector of a unit quaternion, at most pi long."""
    if q[3] < 0:
        q = scale(-1, q)
    s = norm(q[:3])
    if s < 1e-150:
        return scale(2, q[:3])
    return scale(2 * math.atan2(s, q[3]) / s, q[:3])


def exp(v):
    angle = norm(v)
    f = 0.5 if angle < 1e-12 else math.sin(angle / 2) / angle
    return unit((f * v[0], f * v[1], f * v[2], math.cos(angle / 2)))


def angle(a, b):
    """Angle between two quaternions."""
    return norm(log(times(conjugate(a), b)))


def about_axis(axis, value):
    return exp(scale(value / norm(axis), axis))


def from_rpy(roll, pitch, yaw):
    """Rotation of a URDF: first about x, then y, then z, of the fixed frame."""
    about = [about_axis(a, v) for a, v in (((1, 0, 0), roll), ((0, 1, 0), pitch), ((0, 0, 1), yaw))]
    return times(about[2], times(about[1], about[0]))


def between(a, b, f):
    """Straight in translation, along the shorter geodesic in rotation."""
    step = scale(f, log(times(conjugate(a[1]), b[1])))
    return (add(scale(1 - f, a[0]), scale(f, b[0])), unit(times(a[1], exp(step))))


def mean_rotation(rotations):
    """Frechet mean: where the rotation vectors to all of them sum to nothing."""
    mean = rotations[0]
    for _ in range(100):
        step = (0.0, 0.0, 0.0)
        for q in rotations:
            step = add(step, log(times(conjugate(mean), q)))
        step = scale(1 / len(rotations), step)
        mean = unit(times(mean, exp(step)))
        if norm(step) < 1e-15:
            break
    return mean


def spread(poses):
    """Root mean square distance and angle to the mean pose."""
    n = len(poses)
    center = tuple(math.fsum(p[0][k] for p in poses) / n for k in range(3))
    mean = mean_rotation([p[1] for p in poses])
    return (math.sqrt(math.fsum(norm(sub(p[0], center)) ** 2 for p in poses) / n),
            math.sqrt(math.fsum(angle(mean, p[1]) ** 2 for p in poses) / n))


def heading(q):
    """Direction of the x axis seen from above."""
    x, y, _ = turn(q, (1, 0, 0))
    return math.atan2(y, x)
