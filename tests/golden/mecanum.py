import numpy as np


def wheel_matrix(steering, size):
    """W at steering angles and sizes.

    steering (..., 0): none
    size (..., 3): a, l, d
    Returns W (..., 3, 4).
    """
    steering = np.asarray(steering, dtype=np.float64)
    size = np.asarray(size, dtype=np.float64)
    a = size[..., 0]
    l = size[..., 1]
    d = size[..., 2]
    batch = np.broadcast_shapes(steering.shape[:-1], size.shape[:-1])
    t0 = (1/4)*a
    t1 = -t0
    t2 = t0/(d + l)
    t3 = -t2
    W = np.zeros((*batch, 3, 4))
    W[..., 0, 0] = t0
    W[..., 0, 1] = t0
    W[..., 0, 2] = t0
    W[..., 0, 3] = t0
    W[..., 1, 0] = t1
    W[..., 1, 1] = t0
    W[..., 1, 2] = t0
    W[..., 1, 3] = t1
    W[..., 2, 0] = t3
    W[..., 2, 1] = t2
    W[..., 2, 2] = t3
    W[..., 2, 3] = t2
    return W
