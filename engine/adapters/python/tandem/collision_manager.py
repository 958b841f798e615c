"""trimesh.collision.CollisionManager's names, answered by tandem: its users change an import.

Meshes are surfaces, as there, unless solids are asked for; what has `vertices` and `faces`, such as a trimesh.Trimesh, is a mesh.
"""

from typing import Any, Dict, List, Optional, Set, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _tandem

Transform = Any  # (4, 4), (7,) or None
Names = Tuple[str, str]


class ContactData:
    """A contact point of two objects: names, normal (unit), point, depth (m), index(name): the triangle touched."""

    def __init__(self, names: Names, indices: Tuple[int, int], contact: Any) -> None:
        self.names: Set[str] = set(names)
        self._indices: Dict[str, int] = dict(zip(names, indices))
        self.normal = np.array(contact["normal"])
        self.point = np.array(contact["point"])
        self.depth = float(contact["depth"])

    def index(self, name: str) -> int:
        return self._indices[name]


class DistanceData:
    """The distance of two objects: names, distance (m), point(name), index(name): the triangle that has it."""

    def __init__(self, names: Names, answer: "_tandem.Answer", indices: Tuple[int, int]) -> None:
        self.names: Set[str] = set(names)
        self.distance = answer.signed_distance
        self._points = dict(zip(names, (answer.point_a, answer.point_b)))
        self._indices: Dict[str, int] = dict(zip(names, indices))

    def point(self, name: str) -> NDArray[np.float64]:
        return self._points[name]

    def index(self, name: str) -> int:
        return self._indices[name]


class CollisionManager:
    """Objects by name: which collide, and how far apart are they? Objects that are asked about and not in the manager are
    called "__external". With return_data the last value is a list of ContactData, or a DistanceData."""

    external = "__external"

    def __init__(self, solid: bool = False) -> None:
        """solid: the inside of closed meshes counts."""
        self._solid = solid
        self._scene = _tandem.Scene()
        self._ids: Dict[str, int] = {}
        self._names: Dict[int, str] = {}
        self._shapes: Dict[str, _tandem.Shape] = {}
        self._shape_ids: Dict[str, int] = {}
        self._queries: Optional[_tandem.SceneQueries] = None

    def add_object(self, name: str, mesh: Any, transform: Transform = None) -> "_tandem.Shape":
        """mesh: a Shape, or what has vertices and faces. A name that is there gives its object up."""
        shape = self._shape(mesh)
        shape_id = self._scene.add_shape(shape, name)
        try:
            body = self._scene.add_body(shape_id, transform)
        except ValueError:
            self._scene.remove_shape(shape_id)
            raise
        if name in self._ids:
            self.remove_object(name)
        self._ids[name], self._names[body] = body, name
        self._shapes[name], self._shape_ids[name] = shape, shape_id
        return shape

    def remove_object(self, name: str) -> None:
        body = self._id(name)
        self._scene.remove_body(body)
        self._scene.remove_shape(self._shape_ids.pop(name))
        del self._ids[name], self._names[body], self._shapes[name]

    def set_transform(self, name: str, transform: Transform) -> None:
        self._scene.set_pose(self._id(name), transform)

    def in_collision_single(
        self, mesh: Any, transform: Transform = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """bool; with return_names a set of names; with return_data a list of ContactData."""
        shape = self._shape(mesh)
        queries = self._current()
        if not return_names and not return_data:
            return queries.collides(shape, transform)
        names = {self._names[int(i)] for i in queries.hits(shape, transform)}
        data = [
            item
            for name in sorted(names)
            for item in self._contacts((self.external, name), (shape, transform), self._placed(name))
        ]
        return _result(bool(names), names, data, return_names, return_data)

    def in_collision_internal(self, return_names: bool = False, return_data: bool = False) -> Any:
        """The same of all pairs of objects; names are pairs."""
        return self._pairs_in_collision(self._scene, self._name_at(), return_names, return_data)

    def in_collision_other(
        self, other_manager: "CollisionManager", return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The same of each object with each of another manager; names are (here, there)."""
        queries = self._current()
        names: Set[Names] = set()
        data: List[ContactData] = []
        for theirs in other_manager._ids:
            placed = other_manager._placed(theirs)
            if not return_names and not return_data:
                if queries.collides(*placed):
                    return True
                continue
            for body in queries.hits(*placed):
                mine = self._names[int(body)]
                names.add((mine, theirs))
                if return_data:
                    data += self._contacts((mine, theirs), self._placed(mine), placed)
        return _result(bool(names), names, data, return_names, return_data)

    def min_distance_single(
        self, mesh: Any, transform: Transform = None, return_name: bool = False, return_data: bool = False
    ) -> Any:
        """m, < 0 the penetration depth; with return_name the nearest object's; with return_data a DistanceData."""
        shape = self._shape(mesh)
        found = self._current().nearest(shape, transform)
        if found is None:
            return _result(float("inf"), None, None, return_name, return_data)
        name = self._names[found[0]]
        data = self._distance((self.external, name), (shape, transform), self._placed(name)) if return_data else None
        return _result(found[1].signed_distance, name, data, return_name, return_data)

    def min_distance_internal(
        self, name: Optional[str] = None, return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The least of all pairs of objects, or of those of one name."""
        queries = self._current()
        least, names = float("inf"), None
        for mine in [name] if name is not None else self._ids:
            found = queries.nearest(*self._placed(mine), cutoff=max(least, 0.0), ignore=[self._id(mine)])
            if found is not None and found[1].signed_distance < least:
                least, names = found[1].signed_distance, (mine, self._names[found[0]])
        data = self._distance(names, self._placed(names[0]), self._placed(names[1])) if return_data and names else None
        return _result(least, names, data, return_names, return_data)

    def min_distance_other(
        self, other_manager: "CollisionManager", return_names: bool = False, return_data: bool = False
    ) -> Any:
        """The least of each object with each of another manager; names are (here, there)."""
        queries = self._current()
        least, names = float("inf"), None
        for theirs in other_manager._ids:
            found = queries.nearest(*other_manager._placed(theirs), cutoff=max(least, 0.0))
            if found is not None and found[1].signed_distance < least:
                least, names = found[1].signed_distance, (self._names[found[0]], theirs)
        data = (
            self._distance(names, self._placed(names[0]), other_manager._placed(names[1]))
            if return_data and names
            else None
        )
        return _result(least, names, data, return_names, return_data)

    def _shape(self, mesh: Any) -> "_tandem.Shape":
        if isinstance(mesh, _tandem.Shape):
            return mesh
        if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
            return _tandem.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), solid=self._solid)
        raise ValueError(f"mesh: {type(mesh)}, allowed: a tandem.Shape, or what has vertices and faces")

    def _id(self, name: str) -> int:
        if name not in self._ids:
            raise ValueError(
                f"{name!r} is not in the collision manager, allowed: {', '.join(sorted(self._ids)) or 'nothing yet'}"
            )
        return self._ids[name]

    def _placed(self, name: str) -> Tuple["_tandem.Shape", NDArray[np.float64]]:
        return self._shapes[name], self._scene.pose(self._id(name))

    def _current(self) -> "_tandem.SceneQueries":
        if self._queries is None:
            self._queries = _tandem.SceneQueries(self._scene)
        else:
            self._queries.update(self._scene)
        return self._queries

    def _name_at(self) -> Dict[int, str]:
        return {self._scene.index(body): name for body, name in self._names.items()}

    def _pairs_in_collision(
        self, scene: "_tandem.Scene", name_at: Dict[int, str], return_names: bool, return_data: bool
    ) -> Any:
        pipeline = _tandem.Pipeline(request="collide")
        found = pipeline.step(scene).colliding_pairs > 0
        pairs = (
            [tuple(sorted((name_at[int(p["a"])], name_at[int(p["b"])]))) for p in pipeline.pairs()]
            if return_names or return_data
            else []
        )
        data = (
            [item for a, b in pairs for item in self._contacts((a, b), self._placed(a), self._placed(b))]
            if return_data
            else []
        )
        return _result(found, set(pairs), data, return_names, return_data)

    @staticmethod
    def _contacts(names: Names, a: Tuple["_tandem.Shape", Any], b: Tuple["_tandem.Shape", Any]) -> List[ContactData]:
        found = _tandem.contacts(*a, *b)
        places = _tandem.triangles_at(*a, *b, found)
        return [
            ContactData(names, (int(places[i, 0]), int(places[i, 1])), contact) for i, contact in enumerate(found)
        ]

    @staticmethod
    def _distance(names: Names, a: Tuple["_tandem.Shape", Any], b: Tuple["_tandem.Shape", Any]) -> DistanceData:
        answer = _tandem.distance(*a, *b)
        return DistanceData(names, answer, _tandem.triangles_at(*a, *b, answer))


def _result(value: Any, names: Any, data: Any, return_names: bool, return_data: bool) -> Union[Any, Tuple[Any, ...]]:
    out = (value,) + ((names,) if return_names else ()) + ((data,) if return_data else ())
    return out if len(out) > 1 else value
