"""Robots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence

import numpy as np

from . import _scandent
from ._arguments import Array, Config, PathLike, each, path, settings


@dataclass(frozen=True)
class Patch:
    """Where a robot may touch the world."""

    name: str
    #: The link that carries it.
    link: str
    #: What it is for, such as ``foot`` or ``hand``.
    roles: List[str]
    #: Coefficient of friction.
    friction: float


class Robot:
    """A floating-base robot, read from its files: ``Robot.load``."""

    def __init__(self, native: _scandent.Robot) -> None:
        self._native = native

    @staticmethod
    def load(
        urdf: PathLike,
        srdf: Optional[PathLike] = None,
        contacts: Optional[PathLike] = None,
        *,
        packages: Sequence[PathLike] = (),
        config: Optional[Config] = None,
    ) -> Robot:
        """Reads a robot.

        ``urdf`` is a file or the name of a robot that ships, such as ``builtin:hrp2``. Contact patches and
        postures that no file gives are proposed from the shapes; ``notes`` says so. ``packages`` are folders
        of ROS packages, for meshes named ``package://``. Raises ``InputError``.
        """
        return Robot(
            _scandent.Robot.load(
                path(urdf, "urdf"),
                None if srdf is None else path(srdf, "srdf"),
                None if contacts is None else path(contacts, "contacts"),
                [path(folder, "packages") for folder in each(packages, "packages")],
                settings(config),
            )
        )

    @property
    def name(self) -> str:
        """Its name in the URDF."""
        return self._native.name

    @property
    def urdf(self) -> str:
        """The text of its URDF, as for ``pinocchio.buildModelFromXML``."""
        return self._native.urdf()

    @property
    def mass_kg(self) -> float:
        """Total mass, kg."""
        return self._native.mass_kg

    @property
    def joint_names(self) -> List[str]:
        """The joints in the order of q, depth first in the order of the URDF."""
        return self._native.joint_names

    @property
    def patches(self) -> Dict[str, Patch]:
        """Where it may touch the world, by name."""
        return {patch[0]: Patch(*patch) for patch in self._native.patches}

    @property
    def postures(self) -> Dict[str, Array]:
        """Named postures as q (7 + joints): base position in m, quaternion x y z w, joints in rad or m."""
        return {name: np.array(q) for name, q in self._native.postures.items()}

    def resting(self) -> Array:
        """The posture that nothing else is wanted of, as q (7 + joints)."""
        return np.array(self._native.resting())

    @property
    def notes(self) -> List[str]:
        """What was assumed while reading."""
        return self._native.notes

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {len(self.joint_names)} joints, patches {', '.join(self.patches)}>"
