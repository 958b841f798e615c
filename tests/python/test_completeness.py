"""Python has what the public C++ headers have: each option, and each function and class, or this file says why not."""

import pathlib
import re
import unittest

import tandem

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["broadphase", "narrowphase", "engine", "engine/formats", "flowgraph"]

CALLED_MEANWHILE = "a function that C++ calls for each pair or batch, from all threads: Python's would run one at a time"
OF_MY_OWN = "a part of one's own, in C++"
THREADS = "Python's calls share long work on all threads"
TIMEOUT = "Python's calls have a timeout"
IN_C = "Python has the lists, which all threads make"

# Where the options of a struct are given. Those that have another name in Python: C++ name -> Python's.
OPTIONS = {
    "NarrowPhaseOptions": ["distance", "collide", "contacts", "SceneQueries.__init__"],
    "BuildOptions": ["Mesh", "read_mesh"],
    "NearOptions": ["near_triangles", "clearance_zones"],
    "SearchOptions": ["near_features"],
    "DepthOptions": ["penetration_depth"],
    "HausdorffOptions": ["hausdorff_distance"],
    "InspectionOptions": ["inspect"],
    "ImpactOptions": ["point_triangle_impacts", "edge_edge_impacts"],
    "VoxelSolidOptions": ["voxel_solid"],
    "BodyOptions": ["Scene.add_body"],
    "BatchOptions": ["SceneQueries.check"],
    "ResponseOptions": ["Response.__init__"],
    "PipelineOptions": ["Pipeline.__init__"],
    "AnswerOptions": ["Pipeline.__init__"],
    "BalanceOptions": ["Pipeline.__init__"],
    "PairBatchOptions": ["Pipeline.__init__"],
    "SharingOptions": ["Pipeline.__init__"],
}
RENAMED = {
    "BatchOptions.world": "world_pairs",
    "BatchOptions.filter": "group",
    "BalanceOptions.rule": "balance",
    "PairBatchOptions.pairs": "batch_pairs",
    "PipelineOptions.answer": "request",
    "PipelineOptions.balance": "balance",
    "PipelineOptions.batches": "batch_pairs",
    "PipelineOptions.sharing": "form",
}
OPTIONS_OF_CPP_ALONE = {
    "NarrowPhaseOptions.parts": THREADS,
    "NarrowPhaseOptions.limit": TIMEOUT,
    "InspectionOptions.limit": TIMEOUT,
    "NarrowPhaseOptions.memory": IN_C,
    "NarrowPhaseOptions.mesh_gaps": "tells of an answer that tandem.contacts does not return",
    "BuildOptions.parts": THREADS,
    "BuildOptions.limit": TIMEOUT,
    "NearOptions.limit": TIMEOUT,
    "SearchOptions.limit": IN_C,
    "SearchOptions.progress": IN_C,
    "DepthOptions.limit": TIMEOUT,
    "HausdorffOptions.limit": TIMEOUT,
    "VoxelSolidOptions.limit": TIMEOUT,
    "InspectionOptions.parts": THREADS,
    "BatchOptions.deadline": TIMEOUT,
    "BatchOptions.stop": TIMEOUT,
    "ResponseOptions.predicate": CALLED_MEANWHILE,
    "PipelineOptions.predicate": CALLED_MEANWHILE,
    "PipelineOptions.on_answers": CALLED_MEANWHILE,
    "PipelineOptions.own_broad_phase": OF_MY_OWN,
    "PipelineOptions.own_executor": OF_MY_OWN,
    "PipelineOptions.own_costs": OF_MY_OWN,
    "BalanceOptions.own_rule": OF_MY_OWN,
}

# Free functions and classes of headers that Python has under another name, or inside of another one.
ELSEWHERE = {
    "first_impact": "point_triangle_impacts",
    "point_triangle_impact": "point_triangle_impacts",
    "edge_edge_impact": "edge_edge_impacts",
    "read_mesh_shape": "read_mesh",
    "read_mesh_file": "read_mesh",
    "read_octomap_file": "read_octomap",
    "read_scene_file": "read_scene",
    "write_scene_file": "write_scene",
    "make_builtin_scene": "builtin_scene",
    "find_pairs": "overlapping_boxes",
    "make_broad_phase": "overlapping_boxes",
    "NarrowPhase": "distance",
    "visit_triangles": "near_triangles",
    "visit_near_features": "near_features",
    "prepare": "Shape",
    "ContinuousMotion": "limit_motion",
    "PairTable": "SceneQueries",
    "BoxArray": "BoxQueries",
    "BatchPoses": "SceneQueries",
    "InputError": "Scene",
}
CPP_ALONE = {
    "SeveralPairs": "pairs by the dozen; a Pipeline or a batch has them",
    "AnswerSink": "pairs by the dozen; a Pipeline or a batch has them",
    "ContactMap": "values of the host's own with each contact; ContactEvents has the pairs",
    "PairMap": "values of the host's own with each pair; ContactEvents has the pairs",
    "StepNode": "a node of a host's flow graph",
    "BoxVisitor": CALLED_MEANWHILE,
    "NearVisitor": CALLED_MEANWHILE,
    "BroadPhase": OF_MY_OWN,
    "PairSink": OF_MY_OWN,
    "CostModel": OF_MY_OWN,
    "is_mesh_file": "a name's end",
    "require_valid": "Python's calls check",
    "is_valid": "Python's calls check",
    "orthonormalized": "for what has rotations of its own; numpy",
    "unless_stopped": "Python's calls raise",
    "overlap": "numpy",
    "round_up": "BoxQueries does it",
    "round_down": "BoxQueries does it",
    "body_pair": "ContactEvents",
    "compare_pairs": "ContactEvents",
    "triangle_at": "triangles_at",
    "name": "names are texts in Python",
}


# Classes whose public methods are compared, and those that Python has in another form.
CLASSES = {
    "narrowphase/include/tandem/narrowphase/shape.h": "Shape",
    "narrowphase/include/tandem/narrowphase/deformable_mesh.h": "DeformableMesh",
    "narrowphase/include/tandem/narrowphase/winding_number.h": "WindingNumber",
    "engine/include/tandem/engine/scene.h": "Scene",
    "engine/include/tandem/engine/pipeline.h": "Pipeline",
    "engine/include/tandem/engine/response.h": "Response",
    "engine/include/tandem/engine/scene_queries.h": "SceneQueries",
    "engine/include/tandem/engine/contact_memory.h": "ContactEvents",
    "broadphase/include/tandem/broadphase/box_queries.h": "BoxQueries",
}
PARAMETERS = "Shape.parameters"
METHODS_OF_CPP_ALONE = {
    "Shape": {
        **dict.fromkeys(["radius", "length", "half_size", "radii", "normal", "offset", "origin", "cell_size"], PARAMETERS),
        "mass": "Shape.volume, centre_of_mass, inertia",
        "identity": "Python's `is` for one object; copies of shapes are rare",
    },
    "Scene": {
        "alive": "Scene.ids: 0 where none lives",
        "id": "Scene.ids",
        "bodies": "len(scene)",
        "indices": "len(scene.ids())",
        "has_continuous": "Scene.continuous",
        "has_kind": "Scene.shape_of",
        "move": "Scene.set_poses and set_velocity, with their checks",
        "reserve": "room is made when bodies are added by add_bodies",
        **dict.fromkeys(["has_shape", "shape_indices", "shape_name", "shapes"], "Scene.shape_of and shape_id"),
    },
    "DeformableMesh": dict.fromkeys(["visit_self_intersections", "visit_near_features"], IN_C),
    "Pipeline": {"options": "what was passed", "record_to": "Pipeline.record_timeline"},
    "BoxQueries": {
        "build": "BoxQueries.__init__",
        **dict.fromkeys(["refit", "worn"], "a new BoxQueries"),
        **dict.fromkeys(["visit_near", "visit_overlapping"], CALLED_MEANWHILE),
    },
}


def headers(folder):
    return sorted((ROOT / folder / "include" / "tandem").rglob("*.h"))


def text_of(path):
    return re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))


def fields(struct):
    """Names of a struct's members, from its declaration somewhere in the headers."""
    for folder in FOLDERS:
        for path in headers(folder):
            found = re.search(r"struct " + struct + r" \{(.*?)\n\};", text_of(path), re.S)
            if found:
                return [re.search(r"(\w+)\s*$", re.split(r"[={]", line)[0]).group(1) for line in found.group(1).split(";")[:-1]]
    raise AssertionError(f"{struct} is in no public header")


def arguments(callable_name):
    thing = tandem
    for part in callable_name.split("."):
        thing = getattr(thing, part)
    return set(re.findall(r"[(,] ?(\w+):", thing.__doc__.split("\n")[0]))


class Completeness(unittest.TestCase):
    def test_all_options_structs_are_listed(self):
        found = set()
        for folder in FOLDERS:
            for path in headers(folder):
                found |= set(re.findall(r"^struct (\w+Options) \{", text_of(path), re.M))
        self.assertEqual(found - {"ExecutorOptions"}, set(OPTIONS))

    def test_options(self):
        used = set()
        for struct, callables in OPTIONS.items():
            there = set().union(*(arguments(name) for name in callables))
            names = fields(struct)
            self.assertTrue(names, struct)
            for field in names:
                key = f"{struct}.{field}"
                if key in OPTIONS_OF_CPP_ALONE:
                    used.add(key)
                    continue
                self.assertIn(RENAMED.get(key, field), there, key)
        self.assertEqual(used, set(OPTIONS_OF_CPP_ALONE), "what is excused and no longer there")

    def test_functions_and_classes(self):
        missing, used = [], set()
        for folder in FOLDERS[:4]:
            for path in headers(folder):
                text = re.sub(r"namespace (?:tandem::)?detail \{.*?\n\}", "", text_of(path), flags=re.S)
                names = set(re.findall(r"^class (\w+)[^;{]*\{", text, re.M))
                names |= set(re.findall(r"^(?!using|template|inline constexpr|namespace)\w[\w:<>,& *]*[ >&*](\w+)\(", text, re.M))
                used |= names
                for name in sorted(names):
                    python = ELSEWHERE.get(name, name)
                    if name not in CPP_ALONE and not hasattr(tandem, python) and not hasattr(tandem.DeformableMesh, python):
                        missing.append(f"{path.name}: {name}")
        self.assertEqual(missing, [])
        self.assertEqual((set(CPP_ALONE) | set(ELSEWHERE)) - used, set(), "what is excused and no longer there")

    def test_methods(self):
        for header, name in CLASSES.items():
            text = text_of(ROOT / header)
            public = re.search(r"^class " + name + r" \{\n public:(.*?)^ private:", text, re.S | re.M).group(1)
            there = set(re.findall(r"^  (?!using|friend|template|static)\w[\w:<>,& *]*[ >&*](\w+)\(", public, re.M))
            self.assertTrue(there, name)
            excused = METHODS_OF_CPP_ALONE.get(name, {})
            self.assertEqual(there - {name} - set(dir(getattr(tandem, name))), set(excused), name)


if __name__ == "__main__":
    unittest.main()
