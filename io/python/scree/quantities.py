"""What the papers plot, from what the files have. Stresses are tension positive as in the files; pressures that come out are compression positive."""

from __future__ import annotations

import numpy as np

from scree.frames import Frame


#: Where the components of a symmetric tensor stand: xx, yy, xy in the plane, xx, yy, xy, zz, yz, xz in space.
NORMAL = {3: [0, 1], 6: [0, 1, 3]}
SHEAR = {3: [2], 6: [2, 4, 5]}


def pressure(stress: np.ndarray) -> np.ndarray:
    """p of stresses whose last axis is xx, yy, xy (the plane: of two) or xx, yy, xy, zz, yz, xz (space: of three); Pa, compression positive."""
    normal, _ = _parts(stress)
    return -normal.mean(axis=-1)


def deviatoric_stress(stress: np.ndarray) -> np.ndarray:
    """q, Pa: in the plane half of the difference of the principal stresses, in space sqrt(3 J2), which is sqrt(3) times the `q` of frames."""
    normal, shear = _parts(stress)
    if normal.shape[-1] == 2:
        return np.hypot(0.5 * (normal[..., 0] - normal[..., 1]), shear[..., 0])
    away = normal - normal.mean(axis=-1, keepdims=True)
    return np.sqrt(1.5 * (away**2).sum(axis=-1) + 3 * (shear**2).sum(axis=-1))


def _parts(stress: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    count = stress.shape[-1]
    if count not in NORMAL:
        raise ValueError(f"a symmetric tensor has 3 components in the plane and 6 in space, and these have {count}")
    return stress[..., NORMAL[count]], stress[..., SHEAR[count]]


def void_ratio(fraction: np.ndarray | float) -> np.ndarray | float:
    """e of a solid volume fraction."""
    return 1 / fraction - 1


def fabric(contacts: Frame, axes: int) -> np.ndarray:
    """phi = <n n> over the contacts of a frame of `contacts.vtkhdf`, (axes, axes)."""
    branch = contacts.places[:, 1] - contacts.places[:, 0]
    normal = branch[:, :axes] / np.linalg.norm(branch[:, :axes], axis=1, keepdims=True)
    return np.einsum("ci,cj->ij", normal, normal) / len(normal)
