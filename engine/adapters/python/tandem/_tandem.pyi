"""Collision detection on many cores; what the compiled part of tandem has. Lengths are metres."""

from os import PathLike as _PathLike
from types import TracebackType
from typing import Callable, Dict, List, Optional, Sequence, Tuple, Type, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

PathLike = Union[str, _PathLike[str]]
PoseLike = Optional[ArrayLike]
Progress = Optional[Callable[[float], object]]
ProgressOfMany = Optional[Callable[[int, int], object]]

__version__: str

class Answer:
    """What is known of two shapes; points and normal in world axes."""

    @property
    def collide(self) -> bool: ...
    @property
    def farther(self) -> bool:
        """Farther apart than the cut-off, which is signed_distance then."""
    @property
    def signed_distance(self) -> float:
        """m; > 0 gap, < 0 minus the penetration depth"""
    @property
    def point_a(self) -> NDArray[np.float64]:
        """(3,) on A, m"""
    @property
    def point_b(self) -> NDArray[np.float64]:
        """(3,) on B, m"""
    @property
    def normal(self) -> NDArray[np.float64]:
        """(3,) unit, from A to B"""
    @property
    def status(self) -> str:
        """'ok', 'inexact', or 'stopped': the timeout passed first"""
    @property
    def error_bound(self) -> float:
        """m, on signed_distance; 0: rounding"""

class BoxQueries:
    """Questions to a set of boxes; answers of several are (items, begin): of query i items[begin[i]:begin[i + 1]]."""

    def __init__(self, boxes: ArrayLike) -> None: ...
    def overlapping(self, boxes: ArrayLike) -> Tuple[NDArray[np.uint32], NDArray[np.uint64]]:
        """Of (n, 2, 3) boxes: indices of those that they overlap, sorted."""
    def along(
        self, origins: ArrayLike, directions: ArrayLike, t_max: float = ...
    ) -> Tuple[NDArray[np.void], NDArray[np.uint64]]:
        """Of rays origin + t direction, (n, 3) each, 0 <= t <= t_max: a structured array index, t (where the box is entered), by t."""
    def nearest(self, points: ArrayLike, k: int) -> Tuple[NDArray[np.void], NDArray[np.uint64]]:
        """Of (n, 3) points: a structured array index, squared_distance of the k nearest boxes, the nearest first."""
    @property
    def memory(self) -> int:
        """Bytes held."""

class ContactEvents:
    """Which pairs began to touch, still touch and no longer touch: (n, 2) ids, sorted by indices."""

    def __init__(self) -> None: ...
    def update(self, scene: Scene, pipeline: Pipeline) -> None:
        """After a step, before the scene changes."""
    def end_all(self) -> None:
        """All that touched end, as if a step had found no contact."""
    @property
    def touching(self) -> NDArray[np.uint64]:
        """began and stayed"""
    @property
    def began(self) -> NDArray[np.uint64]: ...
    @property
    def stayed(self) -> NDArray[np.uint64]: ...
    @property
    def ended(self) -> NDArray[np.uint64]: ...

class DeformableMesh:
    """A mesh whose vertices move while its triangles stay."""

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike, *, solid: bool = False) -> None: ...
    def update(self, vertices: ArrayLike) -> int:
        """Moves all vertices, (n, 3), m. Returns how many triangles' hierarchy was built anew, as it had become slow."""
    def shape(self) -> Shape:
        """As of the last update; later ones do not change it."""
    def self_intersections(self) -> NDArray[np.uint32]:
        """(n, 2): all pairs of triangles that share no vertex and meet, sorted; exact."""
    def near_features(self, margin: float) -> Tuple[NDArray[np.void], NDArray[np.void], NDArray[np.void]]:
        """As tandem.near_features, of the mesh with itself, for features without a common vertex."""
    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 3), m, as of the last update."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(k, 3), turned alike."""
    @property
    def memory(self) -> int:
        """Bytes, shapes of earlier updates that are in use included."""

class DepthBounds:
    """Bounds on how deep two shapes are in each other; all 0 where they are apart."""

    @property
    def collide(self) -> bool: ...
    @property
    def lower(self) -> float:
        """m: after every shorter translation of b they still collide"""
    @property
    def upper(self) -> float:
        """m: the length of translation"""
    @property
    def translation(self) -> NDArray[np.float64]:
        """(3,) of b: after it they are apart"""
    @property
    def boxes(self) -> int:
        """of translations that were looked at"""
    @property
    def incomplete(self) -> bool:
        """the timeout ended the search; the bounds hold"""

class FirstTouch:
    """The first touch of two shapes on their motions."""

    @property
    def t(self) -> float:
        """[0, 1]; 0 where they touch at the start"""
    @property
    def point(self) -> NDArray[np.float64]:
        """(3,) midway, m"""
    @property
    def normal(self) -> NDArray[np.float64]:
        """(3,) unit, from A to B"""
    @property
    def feature(self) -> Tuple[int, int]:
        """of A and of B: the triangle of a mesh, else 0"""

class HausdorffBounds:
    """Bounds on the Hausdorff distance of two surfaces."""

    @property
    def lower(self) -> float:
        """m"""
    @property
    def upper(self) -> float:
        """m"""
    @property
    def point(self) -> NDArray[np.float64]:
        """(3,) lower away from the other surface"""
    @property
    def nearest(self) -> NDArray[np.float64]:
        """(3,) its nearest point there"""
    @property
    def of_a(self) -> bool:
        """whether point is of a, else of b"""
    @property
    def parts(self) -> int:
        """of surfaces that were looked at"""

class Inspection:
    """What is found in a mesh that may not be as it should: of each kind (how many, array of the first)."""

    @property
    def vertices(self) -> int: ...
    @property
    def triangles(self) -> int: ...
    @property
    def components(self) -> int:
        """of triangles that hang together by edges"""
    @property
    def is_closed(self) -> bool:
        """every edge joins two triangles in opposite sense"""
    @property
    def is_clean_solid(self) -> bool:
        """closed, and nothing of it crosses itself, is double, flat or inside out"""
    @property
    def faulty_edges(self) -> Tuple[int, NDArray[np.void]]:
        """fault: 0 of one triangle, 1 of more than two, 2 of two in the same sense; vertices, ends, triangle, forward, backward"""
    @property
    def self_intersections(self) -> Tuple[int, NDArray[np.void]]:
        """triangles, place; exact"""
    @property
    def inside_out(self) -> Tuple[int, NDArray[np.void]]:
        """components of negative volume: their first triangle, how many, volume (m^3), place"""
    @property
    def flat_triangles(self) -> Tuple[int, NDArray[np.void]]:
        """triangle, place; exact"""
    @property
    def duplicate_triangles(self) -> Tuple[int, NDArray[np.void]]:
        """index, same_as, place"""
    @property
    def duplicate_vertices(self) -> Tuple[int, NDArray[np.void]]:
        """index, same_as, place; they do no harm"""

class Pipeline:
    """Detects collisions in a scene, step by step; the answer does not depend on threads or executor."""

    def __init__(
        self,
        *,
        threads: int = 0,
        executor: str = "flowgraph",
        broad_phase: str = "auto",
        request: str = "contacts",
        tolerance: float = 0.0,
        margin: float = 0.0,
        keep_contacts: float = 0.0,
        mesh_margin: bool = False,
        contact_hash: bool = False,
        split: Optional[Tuple[int, int]] = None,
        balance: str = "busy",
        strict: bool = False,
        batch_pairs: int = 128,
        queue_capacity: int = 0,
        form: str = "automatic",
        short_step_ms: float = 0.3,
        stay_awake: float = 0.0
    ) -> None:
        """threads: in all, 0 asks oneTBB. executor: 'sequential', 'barrier', 'fused', 'threads', 'flowgraph'. broad_phase: 'brute',
        'sweep', 'grid', 'bvh', 'auto'. request: 'collide', 'distance', 'contacts'. tolerance, keep_contacts: accepted error
        relative to the bodies' size, [0, 0.1]. margin: m, gaps up to it are reported; of two meshes with mesh_margin.
        How steps are run, which changes no answer: split: (broad, narrow) threads, None moves them by the rule balance, 'busy' or
        'paper'; strict: no help across the phases. batch_pairs, [1, 65536]: at most, from phase to phase; queue_capacity:
        batches that wait, 0 chooses. form: 'automatic', 'caller', 'overlapped', 'ordered'. short_step_ms: steps of less work stay
        on the caller. stay_awake: us, [0, 100000], that workers stay awake after a step.
        """
    def step(self, scene: Scene, *, timeout: Optional[float] = None) -> StepReport:
        """Finds all contacts; returns the report. timeout: s; then with what is finished, and 'incomplete' among its issues."""
    def contacts(self) -> NDArray[np.void]:
        """Of the last step: a structured array a, b (body indices), point, normal (unit, a to b), depth (m), feature."""
    def pairs(self) -> NDArray[np.void]:
        """Of the last step: a structured array a, b, collide, signed_distance (m), error_bound, first_contact, contact_count,
        status (0 ok, 1 inexact, 2 unproven: a mesh's depth is its deepest contact's, without a bound)."""
    @property
    def memory(self) -> int:
        """Bytes held between steps."""
    @property
    def memory_by_part(self) -> Dict[str, int]:
        """The same by parts: bodies, broad_phase, executor, kept_answers, contacts."""
    def record_timeline(self) -> None:
        """Slices of the steps that follow are recorded, until write_timeline."""
    def write_timeline(self, path: PathLike) -> None:
        """A trace as JSON, for Perfetto or the report."""

class Recording:
    """Writes steps to a file, for tandem.show and `tandem-bench report`; as `with` block, or closed."""

    def __init__(self, path: PathLike, scene: Scene) -> None: ...
    def add(self, scene: Scene, pipeline: Pipeline) -> None:
        """After a step, before the scene changes."""
    def close(self) -> None: ...
    def __enter__(self) -> "Recording": ...
    def __exit__(
        self, type: Optional[Type[BaseException]], value: Optional[BaseException], traceback: Optional[TracebackType]
    ) -> None: ...

class Response:
    """Moves the bodies of one scene by their contacts, gravity and friction."""

    def __init__(
        self,
        *,
        substeps: int = 4,
        friction: float = 0.5,
        rolling_resistance: float = 0.05,
        contact_hertz: float = 30.0,
        contact_damping_ratio: float = 10.0,
        max_push_out: float = 3.0,
        max_speed: float = 500.0,
        threads: int = 0
    ) -> None:
        """substeps: [1, 64], more is stiffer. friction: Coulomb, >= 0. rolling_resistance: torque over normal force and radius,
        >= 0. contact_hertz, contact_damping_ratio: of a contact, > 0. max_push_out: m/s at which overlap is undone. max_speed:
        m/s, faster bodies are slowed to it. threads: in all, 0: the caller's. The motion does not depend on them.
        """
    def step(self, scene: Scene, pipeline: Pipeline) -> ResponseReport:
        """Moves the scene by its dt, by the contacts of the pipeline's last step."""

class ResponseReport:
    @property
    def kinetic_energy(self) -> float:
        """J, all moving bodies"""
    @property
    def max_depth(self) -> float:
        """m, as detected"""
    @property
    def stops(self) -> int:
        """of continuous bodies on their way"""
    @property
    def ms(self) -> float:
        """wall"""
    @property
    def serial_ms(self) -> float:
        """of it, what threads cannot share"""

class Scene:
    """Bodies and their shapes. Ids of bodies and shapes are whole numbers; that of a removed one is found out."""

    def __init__(self) -> None: ...
    def copy(self) -> Scene: ...
    def add_shape(self, shape: Shape, name: str = "") -> int:
        """Returns its id: many bodies may have one shape."""
    def remove_shape(self, id: int) -> None: ...
    def add_body(
        self,
        shape: Union[Shape, int],
        pose: PoseLike = None,
        *,
        velocity: Optional[ArrayLike] = None,
        angular_velocity: Optional[ArrayLike] = None,
        density: float = 1000.0,
        is_static: bool = False,
        is_sensor: bool = False,
        continuous: bool = False,
        group: int = 1,
        mask: int = 0xFFFFFFFF
    ) -> int:
        """Adds a body; returns its id. shape: a Shape, or the id of one of the scene. velocity, angular_velocity: (3,), m/s
        and rad/s, of the centre of mass, world axes. density: kg/m^3, > 0. is_static: never moved by a response.
        is_sensor: reported, never pushed. continuous: passes through nothing, however fast it is. group, mask: bits; a
        pair needs both directions.
        """
    def add_bodies(
        self,
        shape: Union[Shape, int],
        poses: ArrayLike,
        *,
        velocity: Optional[ArrayLike] = None,
        angular_velocity: Optional[ArrayLike] = None,
        density: float = 1000.0,
        is_static: bool = False,
        is_sensor: bool = False,
        continuous: bool = False,
        group: int = 1,
        mask: int = 0xFFFFFFFF
    ) -> NDArray[np.uint64]:
        """The same for (n, 4, 4) or (n, 7) poses, all of one shape; returns (n,) ids. All or none are added."""
    def remove_body(self, id: int) -> None: ...
    def set_pose(self, id: int, pose: PoseLike) -> None: ...
    def set_poses(self, ids: ArrayLike, poses: ArrayLike) -> None:
        """Of many bodies: (n,) ids and as many poses. All or none are changed."""
    def set_velocity(self, id: int, velocity: Optional[ArrayLike], angular_velocity: Optional[ArrayLike]) -> None:
        """(3,) each: m/s, rad/s"""
    def set_shape(self, id: int, shape: int) -> None:
        """shape: the id of one of the scene"""
    def replace_shape(self, id: int, shape: Shape) -> None:
        """Gives all bodies of the shape with this id another one in its place."""
    def set_filter(self, id: int, group: int, mask: int) -> None: ...
    def set_static(self, id: int, is_static: bool) -> None: ...
    def set_continuous(self, id: int, continuous: bool) -> None: ...
    def set_density(self, id: int, density: float) -> None:
        """kg/m^3, finite, > 0; not used of what is static."""
    def set_sensor(self, id: int, is_sensor: bool) -> None: ...
    def pose(self, id: int) -> NDArray[np.float64]:
        """(4, 4)"""
    def index(self, id: int) -> int:
        """As in contacts and pairs."""
    def shape_of(self, id: int) -> Shape: ...
    def shape_id(self, id: int) -> int:
        """Of a body's shape."""
    def ids(self) -> NDArray[np.uint64]:
        """(indices,) uint64: scene.ids()[contacts['a']] are the ids of bodies in contact; 0 where none lives."""
    def poses(self) -> NDArray[np.float64]:
        """(indices, 4, 4); those of removed bodies are stale."""
    def velocities(self) -> NDArray[np.float64]:
        """(indices, 3), m/s, of the centres of mass, world axes."""
    def angular_velocities(self) -> NDArray[np.float64]:
        """(indices, 3), rad/s, world axes."""
    def densities(self) -> NDArray[np.float64]:
        """(indices,), kg/m^3."""
    def groups(self) -> NDArray[np.uint32]:
        """(indices,) bits."""
    def masks(self) -> NDArray[np.uint32]:
        """(indices,) bits."""
    def is_static(self) -> NDArray[np.bool_]:
        """(indices,) bool."""
    def is_sensor(self) -> NDArray[np.bool_]:
        """(indices,) bool."""
    def continuous(self) -> NDArray[np.bool_]:
        """(indices,) bool."""
    def __len__(self) -> int: ...
    @property
    def memory(self) -> int:
        """Bytes, shapes included; what several have in common once."""
    @property
    def memory_by_part(self) -> Dict[str, int]:
        """The same by parts: bodies, shapes, shape_names."""
    @property
    def name(self) -> str: ...
    @name.setter
    def name(self, to: str) -> None: ...
    @property
    def gravity(self) -> NDArray[np.float64]:
        """(3,), m/s^2"""
    @gravity.setter
    def gravity(self, to: ArrayLike) -> None: ...
    @property
    def dt(self) -> float:
        """s, of one step"""
    @dt.setter
    def dt(self, to: float) -> None: ...

class SceneQueries:
    """Asks a scene as it was at the last update; from any number of threads."""

    def __init__(self, scene: Scene, *, tolerance: float = 0.0, solver: str = "") -> None:
        """tolerance, solver: of all queries, as of tandem.distance."""
    @property
    def memory(self) -> int:
        """Bytes held, shapes not counted."""
    def update(self, scene: Scene) -> int:
        """Takes over what changed; returns how many bodies did."""
    def collides(
        self,
        shape: Shape,
        pose: PoseLike = None,
        *,
        margin: float = 0.0,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> bool:
        """Is any body touched, or as near as the margin (m)? group, mask: of the asking shape. ignore: ids that are left out."""
    def hits(
        self,
        shape: Shape,
        pose: PoseLike = None,
        *,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> NDArray[np.uint64]:
        """(n,) ids of bodies that are touched, by index."""
    def nearest(
        self,
        shape: Shape,
        pose: PoseLike = None,
        *,
        cutoff: float = ...,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> Optional[Tuple[int, Answer]]:
        """(id, Answer) of the body of the least signed distance that is at most cutoff (m), or None."""
    def within(
        self,
        shape: Shape,
        pose: PoseLike = None,
        *,
        margin: float,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> List[Tuple[int, Answer]]:
        """[(id, Answer), ...] of the bodies at most margin (m) away, by index."""
    def contacts(
        self,
        shape: Shape,
        pose: PoseLike = None,
        *,
        margin: float = 0.0,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> List[Tuple[int, Answer, NDArray[np.void]]]:
        """[(id, Answer, contacts), ...] of the bodies with contacts, by index."""
    def cast(
        self,
        shape: Shape,
        from_pose: PoseLike,
        to_pose: PoseLike,
        *,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> Optional[Tuple[int, FirstTouch]]:
        """(id, FirstTouch) of the first body that the moving shape touches, or None; a sphere of radius 0 is a ray."""
    def check(
        self,
        links: Sequence[Shape],
        poses: ArrayLike,
        *,
        self_pairs: Optional[ArrayLike] = None,
        world_pairs: Optional[ArrayLike] = None,
        margin: float = 0.0,
        configurations_a_motion: int = 1,
        continuous: bool = False,
        progress: ProgressOfMany = None,
        timeout: Optional[float] = None,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> NDArray[np.uint8]:
        """Configurations of links, on all threads: (configurations,) uint8, 0 free, 1 hit, 2 unknown (the timeout passed).
        links: Shapes. poses: (configurations, links, 4, 4) or (configurations, links, 7). self_pairs: (links, links) bool, i < j:
        which links are checked with one another. world_pairs: (links, indices) bool: which with which bodies. margin: m, gaps up
        to it count. configurations_a_motion: that many in a row are one motion, of which one verdict is told; continuous: what
        lies between them counts, too, certified. progress: a function that is told (done, all) verdicts now and then, from any
        thread; what it raises ends the work. timeout: s.
        """
    def first_hits(
        self,
        links: Sequence[Shape],
        poses: ArrayLike,
        *,
        self_pairs: Optional[ArrayLike] = None,
        world_pairs: Optional[ArrayLike] = None,
        margin: float = 0.0,
        configurations_a_motion: int = 1,
        progress: ProgressOfMany = None,
        timeout: Optional[float] = None,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> NDArray[np.void]:
        """The same, told what is hit first: a structured array verdict, configuration (of the motion), link, other_link, body (id;
        0: other_link is hit).
        """
    def collides_body(self, body: int, *, margin: float = 0.0) -> bool:
        """As collides, asked by a body of the scene where it is, by its groups and mask; itself is left out."""
    def hits_body(self, body: int) -> NDArray[np.uint64]:
        """As hits, asked by a body of the scene."""
    def nearest_body(self, body: int, *, cutoff: float = ...) -> Optional[Tuple[int, Answer]]:
        """As nearest, asked by a body of the scene."""
    def within_body(self, body: int, *, margin: float) -> List[Tuple[int, Answer]]:
        """As within, asked by a body of the scene."""
    def clearance(
        self,
        links: Sequence[Shape],
        poses: ArrayLike,
        *,
        self_pairs: Optional[ArrayLike] = None,
        world_pairs: Optional[ArrayLike] = None,
        cutoff: float = ...,
        progress: ProgressOfMany = None,
        timeout: Optional[float] = None,
        group: int = 1,
        mask: int = 0xFFFFFFFF,
        ignore: Optional[ArrayLike] = None
    ) -> NDArray[np.float64]:
        """(configurations,) m: the least signed distance of all links from bodies and one another, `cutoff` where it is not less,
        -inf where the timeout passed first.
        """

class Shape:
    """A checked shape in its own frame, metres; immutable. Made by Sphere, Box, Mesh ..."""

    def rounded(self, radius: float) -> Shape:
        """This shape with a ball of the radius (m, >= 0) about each point."""
    @property
    def kind(self) -> str:
        """'sphere', 'box', ... 'mesh'"""
    @property
    def size(self) -> float:
        """Diagonal of the box in the shape's frame, m; of a half-space 0."""
    @property
    def rounding(self) -> float:
        """m"""
    @property
    def is_solid(self) -> bool:
        """Whether the inside counts: all but triangles and open meshes."""
    @property
    def vertices(self) -> NDArray[np.float64]:
        """(n, 3), m: of a hull, triangle or mesh; else empty."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(n, 3) indices of vertices: of a triangle or mesh; else empty."""
    @property
    def cells(self) -> NDArray[np.int32]:
        """(n, 4) i, j, k, level: of voxels, in the order by which contacts name them; else empty."""
    @property
    def volume(self) -> float:
        """m^3"""
    @property
    def centre_of_mass(self) -> NDArray[np.float64]:
        """(3,), m"""
    @property
    def inertia(self) -> NDArray[np.float64]:
        """(3, 3), m^5, about the centre of mass: times the density kg m^2"""
    @property
    def parameters(self) -> NDArray[np.float64]:
        """(4,), then zeros: radius; half a box's size; radius, length; radii; a half-space's or plane's normal, offset;
        of voxels the origin and the size of a cell. Of the core of a rounded shape.
        """
    @property
    def is_convex(self) -> bool: ...
    @property
    def is_bounded(self) -> bool:
        """All but half-spaces and planes."""
    @property
    def memory(self) -> int:
        """Bytes beside the object itself; copies share them."""
    @property
    def memory_by_part(self) -> Dict[str, int]:
        """The same by parts: surface, adjacency, hierarchy, hull, other."""
    def bounds(self, pose: PoseLike = None) -> NDArray[np.float64]:
        """(2, 3): least and largest corner of the smallest box around it, world axes."""
    def prepare(self) -> None:
        """Makes now what queries of a mesh make when they first need it, such as its hull."""

class StepReport:
    """What one step found and did; times in ms."""

    @property
    def step(self) -> int: ...
    @property
    def bodies(self) -> int: ...
    @property
    def colliding_pairs(self) -> int: ...
    @property
    def contacts(self) -> int:
        """that touch or overlap"""
    @property
    def gaps(self) -> int:
        """contacts within the margin"""
    @property
    def contact_hash(self) -> int:
        """0 unless asked for"""
    @property
    def max_depth(self) -> float:
        """m"""
    @property
    def kept_pairs(self) -> int: ...
    @property
    def computed_pairs(self) -> int: ...
    @property
    def kept_error_bound(self) -> float:
        """m"""
    @property
    def broad_phase(self) -> str: ...
    @property
    def broad_phase_reason(self) -> str: ...
    @property
    def candidate_pairs(self) -> int: ...
    @property
    def heavy_pairs(self) -> int:
        """in batches of their own"""
    @property
    def batches(self) -> int: ...
    @property
    def queue_high_water(self) -> int:
        """batches waiting at most"""
    @property
    def update_ms(self) -> float:
        """wall: poses to boxes"""
    @property
    def heavy_ms(self) -> float:
        """busy, of narrow_ms"""
    @property
    def broad_end_ms(self) -> float:
        """wall, to the last broad block"""
    @property
    def narrow_end_ms(self) -> float:
        """wall, to the last narrow batch"""
    @property
    def join_ms(self) -> float:
        """wall: putting answers in order"""
    @property
    def busy_ms(self) -> float:
        """summed over threads"""
    @property
    def awake_ms(self) -> float:
        """of workers that stayed awake, summed"""
    @property
    def serial_ms(self) -> float:
        """wall: what one thread did while no other could"""
    @property
    def decision(self) -> Tuple[str, str]:
        """(what the balancer did after the step, why)"""
    @property
    def detect_ms(self) -> float:
        """wall"""
    @property
    def broad_ms(self) -> float:
        """busy, summed over threads"""
    @property
    def narrow_ms(self) -> float:
        """busy, summed over threads"""
    @property
    def threads(self) -> int: ...
    @property
    def split(self) -> Tuple[int, int]: ...
    @property
    def form(self) -> str: ...
    @property
    def issues(self) -> List[str]:
        """'inexact', 'pool_grew', 'ran_on_caller', 'ended_early', 'incomplete'"""

class WindingNumber:
    """How often a mesh's surface goes round a place: 1 inside, 0 outside, between where it has holes."""

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None: ...
    def at(self, places: ArrayLike) -> NDArray[np.float64]:
        """(n,) of (n, 3) places in the mesh's frame, m; on all threads."""

def Box(size: ArrayLike) -> Shape:
    """size: (3,) full edge lengths, m, > 0; centred"""

def Capsule(radius: float, length: float) -> Shape:
    """radius > 0; a core segment of length >= 0 along z, centred; m"""

def Cone(radius: float, length: float) -> Shape:
    """base at z = -length / 2, apex at z = +length / 2; m"""

def Convex(vertices: ArrayLike) -> Shape:
    """The hull of (n, 3) points, m; may be flat."""

def Cylinder(radius: float, length: float) -> Shape:
    """radius > 0; length > 0 along z, centred; m"""

def Ellipsoid(radii: ArrayLike) -> Shape:
    """radii: (3,), m, > 0"""

def HalfSpace(normal: ArrayLike, offset: float = 0.0) -> Shape:
    """normal . x <= offset; a normal of any length but 0"""

def Mesh(
    vertices: ArrayLike,
    triangles: ArrayLike,
    solid: bool = False,
    *,
    progress: Progress = None,
    timeout: Optional[float] = None
) -> Shape:
    """vertices (n, 3), m; triangles (k, 3) indices. solid: the inside counts; each edge must then have as many
    triangles along it one way as the other.
    Made ready on all threads. progress: a function that is told how much is done, (0, 1], from any thread; what it raises
    ends the work. timeout: s; then TimeoutError.
    """

def Plane(normal: ArrayLike, offset: float = 0.0) -> Shape:
    """normal . x = offset, two-sided; a normal of any length but 0"""

def Sphere(radius: float) -> Shape:
    """radius >= 0, m; 0 is a point"""

def Triangle(vertices: ArrayLike) -> Shape:
    """vertices: (3, 3), m; may have no area"""

def builtin_scene(name: str, bodies: int = 0, seed: int = 1) -> Scene:
    """bodies: 0 is the paper's size; [1, 1000000]."""

def builtin_scenes() -> List[str]:
    """Names for builtin_scene."""

def clearance_zones(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    clearance: float = 0.0,
    progress: Progress = None,
    timeout: Optional[float] = None
) -> NDArray[np.void]:
    """Those pairs by places where the meshes meet or come near, the deepest or nearest first. A structured array: pairs,
    intersecting_pairs, bounds (2, 3), area (2,) m^2, and of the nearest pair triangles (2,), signed_distance (m), point_a,
    point_b, normal. progress: as of near_triangles. timeout: s; then TimeoutError.
    """

def collide(
    a: Shape, pose_a: PoseLike, b: Shape, pose_b: PoseLike, *, solver: str = "", timeout: Optional[float] = None
) -> bool:
    """Whether two shapes touch or overlap; exact for meshes."""

def contacts(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    margin: float = 0.0,
    mesh_bounds: bool = True,
    mesh_margin: bool = True,
    tolerance: float = 0.0,
    solver: str = "",
    timeout: Optional[float] = None
) -> NDArray[np.void]:
    """Contacts as a structured array: point, normal (unit, from a to b), depth, feature. margin: m; gaps up to it are
    reported with negative depth; of two meshes unless mesh_margin is False. mesh_bounds: the deepest contact of a mesh is
    proven to separate; False is faster, up to a hundred times. tolerance, solver: as of distance.
    """

def distance(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    tolerance: float = 0.0,
    cutoff: float = ...,
    solver: str = "",
    timeout: Optional[float] = None
) -> Answer:
    """Signed distance, points and normal of two shapes. Poses: (4, 4), or (7,): translation, then quaternion w, x, y, z;
    or None. tolerance: accepted error relative to the size, [0, 0.1]. cutoff: m; farther pairs are not told apart.
    solver: one of tandem.solvers() by its name, where it covers the pair; '': the table's choice.
    timeout: s; status 'stopped' where it passed first; the calls below raise TimeoutError then.
    """

def edge_edge_impacts(
    a_from: ArrayLike,
    a_to: ArrayLike,
    b_from: ArrayLike,
    b_to: ArrayLike,
    pairs: ArrayLike,
    *,
    tolerance: float = 1e-6,
    separation: float = 0.0
) -> NDArray[np.void]:
    """The same as point_triangle_impacts, of edges. pairs: (k, 4) indices: two vertices of a, two of b."""

def free_ends(scene: Scene) -> NDArray[np.float64]:
    """(indices, 4, 4): where each body would be after scene.dt by its velocities alone."""

def hausdorff_distance(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    tolerance: float = 0.0,
    gap: float = 0.001,
    least: float = 0.0001,
    most_parts: int = 1000000,
    timeout: Optional[float] = None
) -> HausdorffBounds:
    """The largest distance of a point of either mesh's surface from the other, as bounds that are at most tolerance (m) or
    gap (of the upper one) apart, or the upper one at most least (of the surfaces' size), if most_parts of them are enough.
    timeout: s; then TimeoutError.
    """

def height_field(heights: ArrayLike, spacing: float, bottom: float) -> Shape:
    """The solid between `bottom` and (rows, columns) heights, m, `spacing` (m, > 0) apart; centred in x and y."""

def inspect(vertices: ArrayLike, triangles: ArrayLike, *, most: int = 100, timeout: Optional[float] = None) -> Inspection:
    """What is wrong with a mesh, with places. most: faults listed of each kind; all are counted. timeout: s, of the search for
    triangles that cross, whose pairs grow with the square of those about one vertex; TimeoutError."""

def intersecting_triangles(
    a: Shape, pose_a: PoseLike, b: Shape, pose_b: PoseLike, *, timeout: Optional[float] = None
) -> NDArray[np.uint32]:
    """(n, 2): all intersecting pairs of triangles of two meshes, sorted; exact."""

def limit_motion(scene: Scene, ends: ArrayLike) -> Tuple[NDArray[np.float64], NDArray[np.void]]:
    """Keeps continuous bodies from passing through others on their way to ends, (indices, 4, 4) or (indices, 7): (ends taken
    back as far as needed, stops). Stops are a structured array: t ([0, 1] of the step), a, b (ids), point, normal (unit, from
    a to b). For who moves bodies himself; a Response does it.
    """

def memory_of(shapes: Sequence[Shape]) -> int:
    """Bytes held beside these shapes; what several of them share, as copies do and a shape and its rounded one, once."""

def near_features(
    a: Shape, pose_a: PoseLike, b: Shape, pose_b: PoseLike, margin: float
) -> Tuple[NDArray[np.void], NDArray[np.void], NDArray[np.void]]:
    """Points and triangles, and edges, of two meshes at most margin (m) apart, on all threads: (points of a with triangles of
    b, points of b with triangles of a, edges). Structured arrays: vertex, triangle, distance; a (2,), b (2,), distance.
    """

def near_triangles(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    clearance: float = 0.0,
    progress: Progress = None,
    timeout: Optional[float] = None
) -> NDArray[np.void]:
    """All pairs of triangles of two meshes at most clearance (m) apart, sorted; 0: those that intersect, exactly. A structured
    array: triangles (2,), distance (m), point_a, point_b. progress: a function that is told how much is done, [0, 1].
    timeout: s; then TimeoutError.
    """

def penetration_depth(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    *,
    gap: float = 0.05,
    most_boxes: int = 20000,
    timeout: Optional[float] = None
) -> DepthBounds:
    """How deep two shapes are in each other, as bounds that are at most gap (of the upper one) apart, if most_boxes of
    translations are enough. timeout: s; then the bounds reached by then (incomplete), TimeoutError if there are none.
    """

def occupancy_grid(occupied: ArrayLike, size: float, origin: Optional[ArrayLike] = None) -> Shape:
    """The same of a dense grid: (nz, ny, nx), what is not 0 is occupied; [0, 0, 0] is the cube that begins at origin."""

def overlapping_boxes(boxes: ArrayLike, *, method: str = "auto") -> NDArray[np.uint32]:
    """(pairs, 2) indices, sorted, of boxes that overlap or touch. boxes: (n, 2, 3), least and largest corner, rounded outward to
    single precision. method: 'brute', 'sweep', 'grid', 'bvh', 'auto'; the answer is the same.
    """

def point_cloud(points: ArrayLike, radius: float) -> Shape:
    """Balls of one radius (m, >= 0) about (n, 3) points, as one shape."""

def point_triangle_impacts(
    points_from: ArrayLike,
    points_to: ArrayLike,
    vertices_from: ArrayLike,
    vertices_to: ArrayLike,
    pairs: ArrayLike,
    *,
    tolerance: float = 1e-6,
    separation: float = 0.0
) -> NDArray[np.void]:
    """First impacts of points and triangles whose vertices move on straight lines, on all threads: a structured array hit, t
    ([0, 1]: at or before the impact), gap (m: a bound on the distance then). No impact is missed. ..._from, ..._to: (n, 3), m,
    before and after. pairs: (k, 4) indices: a point, three vertices. tolerance: [0, 0.1], of the longest motion of a vertex.
    separation: m; features that come this near meet.
    """

def pose_at(
    from_pose: PoseLike, to_pose: PoseLike, t: float, *, straight_of: Optional[ArrayLike] = None
) -> NDArray[np.float64]:
    """(4, 4): where a body is at the time t, [0, 1], of such a motion as time_of_impact has."""

def read_mesh(
    path: PathLike, solid: bool = False, *, progress: Progress = None, timeout: Optional[float] = None
) -> Shape:
    """The mesh in a .obj, .stl, .ply, .off, .gltf or .glb file. solid: the inside counts. ValueError 'FILE:LINE: ...' where it
    cannot be used, or with the first edge that does not close. progress, timeout: of what comes after reading, as of Mesh.
    """

def read_octomap(path: PathLike) -> Shape:
    """The occupied leaves of an octree in one of octomap's .bt or .ot files, as voxels. ValueError 'FILE: byte N: ...' where it
    cannot be used, 'FILE: voxels: ...' where no leaf is occupied.
    """

def read_scene(path: PathLike) -> Scene:
    """ValueError 'FILE: POINTER: ...' where it cannot be used."""

def recommended_margin(scene: Scene) -> float:
    """m: for a pipeline whose contacts a response uses."""

def separation_along(
    a: Shape,
    pose_a: PoseLike,
    b: Shape,
    pose_b: PoseLike,
    direction: ArrayLike,
    *,
    timeout: Optional[float] = None
) -> float:
    """How far b must be moved along a direction (metres along it) to be apart from a and stay so. timeout: s; then TimeoutError."""

def solvers() -> List[Tuple[str, str]]:
    """[(name, description), ...] of all that a pair may be solved by."""

def time_of_impact(
    a: Shape,
    from_a: PoseLike,
    to_a: PoseLike,
    b: Shape,
    from_b: PoseLike,
    to_b: PoseLike,
    *,
    straight_of_a: Optional[ArrayLike] = None,
    straight_of_b: Optional[ArrayLike] = None,
    timeout: Optional[float] = None
) -> Optional[FirstTouch]:
    """The first touch on screw motions between two poses each, or None. Never missed. straight_of_a, straight_of_b: (3,) where
    given, no screw: this point of the body, in its frame, goes straight, and the body turns about it.
    """

@overload
def triangles_at(a: Shape, pose_a: PoseLike, b: Shape, pose_b: PoseLike, of: Answer) -> Tuple[int, int]:
    """The triangles of a and of b on which the points of an Answer lie; 0 where a shape is no mesh."""

@overload
def triangles_at(a: Shape, pose_a: PoseLike, b: Shape, pose_b: PoseLike, of: NDArray[np.void]) -> NDArray[np.uint32]:
    """(n, 2): the same of each contact of an array as tandem.contacts gives it."""

def voxel_mesh(cells: ArrayLike, size: float) -> Shape:
    """The surface of such cubes as a solid mesh: of the faces between a cell and a place without one. cells: (n, 3), -2^20 to 2^20 - 2."""

def voxel_solid(
    vertices: ArrayLike,
    triangles: ArrayLike,
    size: float,
    *,
    least: float = 0.5,
    most_cells: int = 16777216,
    timeout: Optional[float] = None
) -> Shape:
    """A solid for a mesh that need not be closed: the cubes, of size (m, > 0), whose middles have at least that winding number.
    most_cells: of the mesh's box; more are refused. timeout: s; then TimeoutError.
    """

def voxels(cells: ArrayLike, size: float, origin: Optional[ArrayLike] = None) -> Shape:
    """The solid union of cubes of a grid, of kind 'voxels'. cells: (n, 3) whole numbers i, j, k, of the cube from origin +
    (i, j, k) * size to origin + (i + 1, ...) * size, -2^20 to 2^20 - 1, in any order, doubles allowed; or (n, 4) with a level l,
    0 to 20, of a cube 2^l times as wide whose i, j, k are multiples of that. size: m, > 0. origin: (3,), m.
    """

def write_scene(path: PathLike, scene: Scene) -> None:
    """Read back, it has the same contacts, bit for bit."""
