"""Terrains: from depth images, meshes, polygons and files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _scandent
from ._arguments import (
    Array, Config, PathLike, dimensions, each, mapping, matrix, number, numbers, path, pose, settings, text, whole, write
)
from ._errors import InputError

#: No coordinate of a world is greater, m.
WORLD_M = 1e4


@dataclass(frozen=True)
class Face:
    """A plane face that may be touched."""

    id: str
    #: Pose of F in W (4, 4): z out of the body, m.
    X_WF: Array
    #: Outer ring, then holes, each (n, 2) in F, m.
    rings: List[Array]
    #: Coefficient of friction that it has at most with whatever touches it; without one the patches' own count.
    friction: Optional[float] = None

    @property
    def normal_W(self) -> Array:
        """Outward normal in W (3,)."""
        return np.array(self.X_WF[:3, 2])

    @property
    def vertices_W(self) -> Array:
        """Corners of the outer ring in W (n, 3), m."""
        ring = self.rings[0]
        return np.asarray(ring @ self.X_WF[:3, :2].T + self.X_WF[:3, 3])


class Terrain:
    """Faces that a robot may touch, and bodies that it must avoid."""

    def __init__(self, native: _scandent.Terrain) -> None:
        self._native = native
        self._faces: Optional[List[Face]] = None

    @staticmethod
    def load(file: PathLike) -> Terrain:
        """Reads a ``surfaces.json``. Raises ``InputError``."""
        return Terrain(_scandent.Terrain.load(path(file, "file")))

    @staticmethod
    def from_mesh(
        mesh: Union[PathLike, npt.ArrayLike],
        triangles: Optional[npt.ArrayLike] = None,
        *,
        config: Optional[Config] = None,
    ) -> Terrain:
        """The plane faces and the bodies of a mesh of the surroundings in W.

        ``mesh`` is a file (STL, OBJ, PLY, DAE, glTF), or the vertices (n, 3), m, with ``triangles`` (m, 3) that index
        them, wound counter-clockwise seen from outside. Raises ``InputError``.
        """
        if triangles is None:
            return Terrain(_scandent.Terrain.mesh_file(path(mesh, "mesh"), settings(config)))  # type: ignore[arg-type]
        vertices = numbers(mesh, "mesh", None, 3)
        corners = np.asarray(triangles) if dimensions(triangles, "triangles") else np.empty(0)
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
            raise InputError(
                f"triangles are {corners.dtype} of the shape {corners.shape}, not whole numbers of n x 3", "triangles"
            )
        if corners.size and not 0 <= int(corners.min()) <= int(corners.max()) < len(vertices):
            raise InputError(f"triangles index beyond the {len(vertices)} vertices", "triangles")
        return Terrain(_scandent.Terrain.mesh(vertices.tolist(), corners.tolist(), settings(config)))

    @staticmethod
    def from_polygons(
        polygons: Union[Mapping[str, npt.ArrayLike], Sequence[npt.ArrayLike]],
        obstacles: Optional[Mapping[str, npt.ArrayLike]] = None,
        *,
        friction: Optional[Union[float, Mapping[str, float]]] = None,
    ) -> Terrain:
        """Faces with these corners: (n, 3) each in W, m, in one plane, counter-clockwise seen from outside.

        A mapping names the faces; of a sequence they are ``face0``, ``face1``, … ``obstacles`` are convex
        bodies to avoid, the hulls of points (n, 3) in W, m. ``friction`` is that of ``with_friction``. Raises
        ``InputError``.
        """
        if not isinstance(polygons, Mapping):
            polygons = {f"face{i}": polygon for i, polygon in enumerate(each(polygons, "polygons"))}
        faces = [_face(name, polygon) for name, polygon in polygons.items()]
        bodies = [
            {"id": text(name, "obstacles"), "points_W": numbers(points, f"obstacles[{name!r}]", None, 3).tolist()}
            for name, points in mapping(obstacles, "obstacles").items()
        ]
        terrain = Terrain._of({"faces": faces, "obstacles": bodies}, "polygons")
        return terrain if friction is None else terrain.with_friction(friction)

    def with_friction(self, friction: Union[float, Mapping[str, float]]) -> Terrain:
        """The same with these coefficients of friction: of all faces, or of those named.

        Whatever touches a face has at most the face's own. Raises ``InputError``.
        """
        if isinstance(friction, Mapping):
            own = {text(name, "friction"): number(value, f"friction[{name!r}]") for name, value in friction.items()}
        else:
            everywhere = number(friction, "friction")
            own = {face.id: everywhere for face in self.faces}
        return Terrain(self._native.with_friction(own))

    @staticmethod
    def _of(record: Mapping[str, Any], argument: str) -> Terrain:
        file = {"format": "scandent-surfaces/2", "faces": record["faces"], "obstacles": record["obstacles"]}
        return Terrain(_scandent.Terrain.json(json.dumps(file), argument))

    @property
    def faces(self) -> List[Face]:
        """What may be touched."""
        if self._faces is None:
            self._faces = [
                Face(
                    face["id"],
                    matrix(face["X_WF"]),
                    [np.array(ring["vertices"]) for ring in face["region"]],
                    face.get("friction"),
                )
                for face in json.loads(self.to_json())["faces"]
            ]
        return self._faces

    def face(self, name: str) -> Face:
        """The face of that name. Raises ``InputError``."""
        wanted = text(name, "name")
        for face in self.faces:
            if face.id == wanted:
                return face
        known = ", ".join(face.id for face in self.faces)
        raise InputError(f"name: no face {name!r}; there are {known}", "name")

    @property
    def cloud_W(self) -> npt.NDArray[np.float32]:
        """The points that it was perceived from, (n, 3) in W, m; none of other terrains."""
        return self._native.cloud_W()

    @property
    def notes(self) -> List[str]:
        """What was found and assumed on the way."""
        return self._native.notes

    def to_json(self) -> str:
        """The text of ``surfaces.json``."""
        return self._native.to_json()

    def save(self, file: PathLike) -> None:
        """Writes a ``surfaces.json``."""
        write(file, self.to_json())

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return f"<Terrain of {len(self)} faces>"


def _face(name: str, polygon: npt.ArrayLike) -> Dict[str, Any]:
    argument = f"polygons[{name!r}]"
    corners = numbers(polygon, argument, None, 3)
    if len(corners) < 3:
        raise InputError(f"{argument} has {len(corners)} corners, 3 are wanted", argument)
    if np.abs(corners).max() > WORLD_M:
        raise InputError(f"{argument} has a corner farther away than {WORLD_M:g} m", argument)
    middle = corners.mean(axis=0)
    # Newell: twice the area along the normal, for any polygon.
    after = np.roll(corners, -1, axis=0)
    normal = np.cross(corners - middle, after - middle).sum(axis=0)
    length = float(np.linalg.norm(normal))
    if length < 1e-9:
        raise InputError(f"{argument} has no area", argument)
    z = normal / length
    off = float(np.abs((corners - middle) @ z).max())
    if off > 1e-3:
        raise InputError(f"{argument} is not in one plane: a corner is {off:.4f} m off", argument)
    # x of F as near to W's as the plane allows.
    ahead = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = ahead - z * float(ahead @ z)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = middle
    seven = pose(T, argument)
    inside = (corners - middle) @ T[:3, :2]
    return {
        "id": text(name, "polygons"),
        "X_WF": {"p": list(seven[:3]), "quat_xyzw": list(seven[3:])},
        "polygon": inside.tolist(),
    }


def perceive(
    depth: Union[npt.NDArray[np.uint16], Sequence[npt.NDArray[np.uint16]]],
    K: Optional[npt.ArrayLike] = None,
    T_WV: Optional[npt.ArrayLike] = None,
    *,
    sensor: Optional[str] = None,
    depth_scale_m: Optional[float] = None,
    config: Optional[Config] = None,
    threads: Optional[int] = None,
) -> Terrain:
    """What a depth image shows, as ``scandent surfaces`` finds it in the same image as a PNG.

    ``depth`` is (rows, columns) of ``uint16`` in the sensor's unit, ``depth_scale_m`` metres each (1 mm where
    the sensor has no other), 0 where nothing was measured; or a sequence of such images in their order in
    time. ``K`` is the camera matrix (3, 3) or fx, fy, cx, cy in pixels; without it that of ``sensor`` for the
    image's size. ``T_WV`` is the pose of the optical frame V (x right, y down, z forward) in W (z up): a
    matrix (4, 4), or x, y, z, qx, qy, qz, qw; a sequence of them for a sequence of images. ``sensor`` is a
    name of the sensor table, for noise and range (``generic`` where ``K`` alone is given, else ``xtion``).

    Raises ``InputError`` that names the argument.
    """
    several = isinstance(depth, (list, tuple))
    images = [_image(image) for image in (depth if several else [depth])]
    if not images:
        raise InputError("depth holds no image", "depth")
    if T_WV is None:
        raise InputError("T_WV, the sensor's pose in the world, is missing", "T_WV")
    poses: List[Any] = each(T_WV, "T_WV") if several else [T_WV]
    if len(poses) != len(images):
        raise InputError(f"T_WV holds {len(poses)} poses for {len(images)} images", "T_WV")
    pinhole = _pinhole(K)
    if sensor is not None:
        text(sensor, "sensor")
    scale = None if depth_scale_m is None else number(depth_scale_m, "depth_scale_m")
    shots = [(image, pose(at, "T_WV"), pinhole, sensor, scale) for image, at in zip(images, poses)]
    return Terrain(_scandent.perceive(shots, settings(config), whole(threads, "threads", 1)))


def _image(depth: Any) -> npt.NDArray[np.uint16]:
    if not isinstance(depth, np.ndarray):
        raise InputError(f"depth is no array but a {type(depth).__name__}", "depth")
    if depth.dtype != np.uint16:
        what = "multiply metres by 1000 and round, with 0 where nothing was measured" if depth.dtype.kind == "f" else "convert it"
        raise InputError(f"depth is of {depth.dtype}, not uint16: {what}", "depth")
    if depth.ndim != 2 or 0 in depth.shape:
        raise InputError(f"depth has the shape {depth.shape}, not rows x columns", "depth")
    return depth


def _pinhole(K: Optional[npt.ArrayLike]) -> Optional[List[float]]:
    if K is None:
        return None
    if dimensions(K, "K") == 1:
        four = numbers(K, "K", 4)
    else:
        k = numbers(K, "K", 3, 3)
        if np.abs([k[0, 1], k[1, 0], k[2, 0], k[2, 1], k[2, 2] - 1.0]).max() > 1e-9:
            raise InputError("K is no camera matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]", "K")
        four = np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2]])
    if four[:2].min() <= 0.0:
        raise InputError(f"K has the focal lengths {four[:2].tolist()}, which are not positive", "K")
    return [float(value) for value in four]
