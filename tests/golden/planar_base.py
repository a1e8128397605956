import numpy as np


def planar_base(q, qdot, p):
    """Mass matrix and bias of the equations of motion.

    q (..., 3): x, y, psi
    qdot (..., 3): xdot, ydot, psidot
    p (..., 4): I_cz, m, x_bc, y_bc
    Returns M (..., 3, 3), n (..., 3).
    """
    q = np.asarray(q, dtype=np.float64)
    psi = q[..., 2]
    qdot = np.asarray(qdot, dtype=np.float64)
    psidot = qdot[..., 2]
    p = np.asarray(p, dtype=np.float64)
    I_cz = p[..., 0]
    m = p[..., 1]
    x_bc = p[..., 2]
    y_bc = p[..., 3]
    batch = np.broadcast_shapes(q.shape[:-1], qdot.shape[:-1], p.shape[:-1])
    t0 = np.sin(psi)
    t1 = np.cos(psi)
    t2 = m*(t0*x_bc + t1*y_bc)
    t3 = -t2
    t4 = m*(-t0*y_bc + t1*x_bc)
    t5 = psidot**2
    M = np.zeros((*batch, 3, 3))
    M[..., 0, 0] = m
    M[..., 0, 2] = t3
    M[..., 1, 1] = m
    M[..., 1, 2] = t4
    M[..., 2, 0] = t3
    M[..., 2, 1] = t4
    M[..., 2, 2] = I_cz + m*x_bc**2 + m*y_bc**2
    n = np.zeros((*batch, 3))
    n[..., 0] = -t4*t5
    n[..., 1] = -t2*t5
    return M, n
