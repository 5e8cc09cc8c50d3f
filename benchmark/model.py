"""Equations of a chain of joints, for many configurations at once. Linear in the ten parameters of each body.

Motions are [angular; linear] in the frame of each link, whose origin is on the axis of its joint. The parameters of a body,
about this origin: m, mx, my, mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz. NumPy only.
"""
import numpy as np

BODY = ["m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz"]


def skew(x):
    """Matrix of the cross product, [..., 3, 3]."""
    out = np.zeros((*x.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -x[..., 2], x[..., 1], -x[..., 0]
    return out - np.swapaxes(out, -1, -2)


def basis():
    """Spatial inertia of a body with one of its ten parameters equal to 1, [10, 6, 6]."""
    out = np.zeros((10, 6, 6))
    out[0, 3:, 3:] = np.eye(3)
    for k in range(3):
        out[1 + k, :3, 3:] = skew(np.eye(3)[k])
        out[1 + k, 3:, :3] = -out[1 + k, :3, 3:]
    for k, (i, j) in enumerate([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]):
        out[4 + k, i, j] = out[4 + k, j, i] = 1
    return out


BASIS = basis()


def crossed(v):
    """Matrix of the cross product of motions, [..., 6, 6]."""
    out = np.zeros((*v.shape, 6))
    out[..., :3, :3] = out[..., 3:, 3:] = skew(v[..., :3])
    out[..., 3:, :3] = skew(v[..., 3:])
    return out


class Chain:
    """Joints one after the other: `origin` m, `rotation` [3, 3] and `axis` of each, in the frame of the link before."""

    def __init__(self, joints, gravity):
        self.n = len(joints)
        self.r = np.array([j["origin"] for j in joints], float)
        self.rotation = np.array([j["rotation"] for j in joints], float)
        self.axis = np.array([j["axis"] for j in joints], float)
        self.slides = np.array([bool(j.get("prismatic")) for j in joints])
        self.k = skew(self.axis)
        self.s = np.zeros((self.n, 6))
        for i in range(self.n):
            self.s[i, 3 * self.slides[i]:][:3] = self.axis[i]
        self.across = -crossed(self.s)
        self.gravity = np.r_[0, 0, 0, -np.asarray(gravity, float)]

    def kinematics(self, q, dq):
        """Jacobians [N, n, 6, n], velocities [N, n, 6], and accelerations without joint accelerations [N, n, 6]."""
        turn = np.where(self.slides, 0, q)
        sin, cos = np.sin(turn)[..., None, None], np.cos(turn)[..., None, None]
        down = self.rotation @ (np.eye(3) + sin * self.k + (1 - cos) * (self.k @ self.k))
        up = np.swapaxes(down, -1, -2)
        r = self.r + np.einsum("nij,nj->ni", self.rotation, self.axis) * np.where(self.slides, q, 0)[..., None]
        x = np.zeros((*q.shape, 6, 6))
        x[..., :3, :3] = x[..., 3:, 3:] = up
        x[..., 3:, :3] = -up @ skew(r)
        jacobian = np.zeros((*q.shape, 6, self.n))
        v, a = np.zeros((*q.shape, 6)), np.zeros((*q.shape, 6))
        for i in range(self.n):
            if i == 0:
                a[..., 0, :] = (x[..., 0, :, :] @ self.gravity[:, None])[..., 0]
            else:
                jacobian[..., i, :, :] = x[..., i, :, :] @ jacobian[..., i - 1, :, :]
                before = np.stack([v[..., i - 1, :], a[..., i - 1, :]], -1)
                both = x[..., i, :, :] @ before
                v[..., i, :], a[..., i, :] = both[..., 0], both[..., 1]
            jacobian[..., i, :, i] = self.s[i]
            v[..., i, :] += self.s[i] * dq[..., i, None]
            a[..., i, :] += (v[..., i, :] @ self.across[i].T) * dq[..., i, None]
        return jacobian, v, a

    def dynamics(self, inertia, q, dq):
        """Mass matrix [N, n, n] and torque without accelerations [N, n]; `inertia` [N or 1, n, 6, 6]."""
        jacobian, v, a = self.kinematics(q, dq)
        momentum = np.einsum("...ij,...j->...i", inertia, v)
        force = np.einsum("...ij,...j->...i", inertia, a) - np.einsum("...ji,...j->...i", crossed(v), momentum)
        mass = (np.swapaxes(jacobian, -1, -2) @ (inertia @ jacobian)).sum(-3)
        return mass, np.einsum("...nij,...ni->...j", jacobian, force)

    def regressor(self, q, dq, ddq):
        """Columns of the ten parameters of each body: joint torques are [N, n, 10 n] times the parameters."""
        jacobian, v, a = self.kinematics(q, dq)
        a = a + np.einsum("...ij,...j->...i", jacobian, ddq[..., None, :].repeat(self.n, -2))
        columns = np.einsum("pij,...j->...ip", BASIS, a)
        columns -= np.einsum("...ji,...jp->...ip", crossed(v), np.einsum("pij,...j->...ip", BASIS, v))
        y = np.swapaxes(jacobian, -1, -2) @ columns
        return np.concatenate([y[..., i, :, :] for i in range(self.n)], -1)


def inertias(bodies):
    """Spatial inertias [..., n, 6, 6] of bodies [..., n, 10]."""
    return np.einsum("...p,pij->...ij", np.asarray(bodies, float), BASIS)


def body(mass, centre, inertia_at_centre):
    """Ten parameters from mass, centre of mass and inertia [3, 3] about it."""
    c = np.asarray(centre, float)
    about = np.asarray(inertia_at_centre, float) + mass * (c @ c * np.eye(3) - np.outer(c, c))
    return np.r_[mass, mass * c, about[0, 0], about[0, 1], about[1, 1], about[0, 2], about[1, 2], about[2, 2]]
