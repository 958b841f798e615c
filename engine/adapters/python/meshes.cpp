// Bindings for pairs of meshes (all triangle pairs), deforming meshes, and the inspection of a mesh.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "all_threads.h"
#include "arrays.h"
#include "bindings.h"
#include "building.h"
#include "rows.h"
#include "shared_use.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/deformable_mesh.h"
#include "tandem/narrowphase/hausdorff.h"
#include "tandem/narrowphase/inspection.h"
#include "tandem/narrowphase/near_features.h"
#include "tandem/narrowphase/penetration.h"
#include "timeout.h"

namespace tandem::python {

// Rows of the arrays; the members' names are the arrays' fields.
struct NearTrianglesRow {
  std::array<std::uint32_t, 2> triangles;
  double distance;
  Triple point_a, point_b;
};
struct ZoneRow {
  std::uint64_t pairs, intersecting_pairs;
  std::array<Triple, 2> bounds;
  std::array<double, 2> area;
  std::array<std::uint32_t, 2> triangles;
  double signed_distance;
  Triple point_a, point_b, normal;
};
struct NearPointRow {
  std::uint32_t vertex, triangle;
  double distance;
};
struct NearEdgesRow {
  std::array<std::uint32_t, 2> a, b;
  double distance;
};
struct FaultyEdgeRow {
  std::uint8_t fault;
  std::array<std::uint32_t, 2> vertices;
  std::array<Triple, 2> ends;
  std::uint32_t triangle;
  std::uint64_t forward, backward;
};
struct DuplicateRow {
  std::uint32_t index, same_as;
  Triple place;
};
struct FlatTriangleRow {
  std::uint32_t triangle;
  Triple place;
};
struct InsideOutRow {
  std::uint32_t triangle;
  std::uint64_t triangles;
  double volume;
  Triple place;
};
struct SelfIntersectionRow {
  std::array<std::uint32_t, 2> triangles;
  Triple place;
};

namespace {

void describe_mesh_rows() {
  PYBIND11_NUMPY_DTYPE(NearTrianglesRow, triangles, distance, point_a, point_b);
  PYBIND11_NUMPY_DTYPE(ZoneRow, pairs, intersecting_pairs, bounds, area, triangles, signed_distance, point_a, point_b,
                       normal);
  PYBIND11_NUMPY_DTYPE(NearPointRow, vertex, triangle, distance);
  PYBIND11_NUMPY_DTYPE(NearEdgesRow, a, b, distance);
  PYBIND11_NUMPY_DTYPE(FaultyEdgeRow, fault, vertices, ends, triangle, forward, backward);
  PYBIND11_NUMPY_DTYPE(DuplicateRow, index, same_as, place);
  PYBIND11_NUMPY_DTYPE(FlatTriangleRow, triangle, place);
  PYBIND11_NUMPY_DTYPE(InsideOutRow, triangle, triangles, volume, place);
  PYBIND11_NUMPY_DTYPE(SelfIntersectionRow, triangles, place);
}

py::array near_triangles(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b,
                         double clearance, const py::object& progress, std::optional<double> timeout) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  const WorkLimit limit = limit_after(timeout);
  const auto told = progress_of<double>(progress);
  std::vector<NearTriangles> found;
  {
    const py::gil_scoped_release released;
    const auto keep = [&](const NearTriangles& pair) {
      found.push_back(pair);
      return true;
    };
    NearOptions options;
    options.clearance = clearance;
    options.limit = &limit;
    options.progress = told;
    if (visit_triangles(a, pose_a, b, pose_b, keep, options) == SearchEnd::stopped) throw WorkStopped();
    std::sort(found.begin(), found.end(), [](const auto& x, const auto& y) { return x.triangles < y.triangles; });
  }
  return structured<NearTrianglesRow>(found, [](const NearTriangles& pair) {
    return NearTrianglesRow{pair.triangles, pair.distance, numbers(pair.point_a), numbers(pair.point_b)};
  });
}

py::array zones(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b, double clearance,
                const py::object& progress, std::optional<double> timeout) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  const WorkLimit limit = limit_after(timeout);
  const auto told = progress_of<double>(progress);
  std::vector<ClearanceZone> found;
  {
    const py::gil_scoped_release released;
    NearOptions options;
    options.clearance = clearance;
    options.limit = &limit;
    options.progress = told;
    found = clearance_zones(a, pose_a, b, pose_b, options);
  }
  return structured<ZoneRow>(found, [](const ClearanceZone& z) {
    return ZoneRow{z.pairs,
                   z.intersecting_pairs,
                   {numbers(z.bounds.lo), numbers(z.bounds.hi)},
                   z.area,
                   z.triangles,
                   z.signed_distance,
                   numbers(z.point_a),
                   numbers(z.point_b),
                   numbers(z.normal)};
  });
}

double separation(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b,
                  const py::object& direction, std::optional<double> timeout) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  const Vec3 along = vec3(direction, "direction");
  const WorkLimit limit = limit_after(timeout);
  NarrowPhaseOptions options;
  options.limit = &limit;
  const py::gil_scoped_release released;
  return separation_along(a, pose_a, b, pose_b, along, options);
}

DepthBounds depth(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b, double gap,
                  std::size_t most_boxes, std::optional<double> timeout) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  const WorkLimit limit = limit_after(timeout);
  const py::gil_scoped_release released;
  return penetration_depth(a, pose_a, b, pose_b, {.gap = gap, .most_boxes = most_boxes, .limit = &limit});
}

HausdorffBounds hausdorff(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b,
                          double tolerance, double gap, double least, std::size_t most_parts,
                          std::optional<double> timeout) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  const WorkLimit limit = limit_after(timeout);
  const py::gil_scoped_release released;
  return hausdorff_distance(
      a, pose_a, b, pose_b,
      {.tolerance = tolerance, .gap = gap, .least = least, .most_parts = most_parts, .limit = &limit});
}

void bind_bounds(py::module_& m) {
  py::class_<DepthBounds>(m, "DepthBounds",
                          "Bounds on how deep two shapes are in each other; all 0 where they are apart.")
      .def_readonly("collide", &DepthBounds::collide)
      .def_readonly("lower", &DepthBounds::lower, "m: after every shorter translation of b they still collide")
      .def_readonly("upper", &DepthBounds::upper, "m: the length of translation")
      .def_property_readonly(
          "translation", [](const DepthBounds& r) { return to_array(r.translation); },
          "(3,) of b: after it they are apart")
      .def_readonly("boxes", &DepthBounds::boxes, "of translations that were looked at")
      .def_readonly("incomplete", &DepthBounds::incomplete, "the timeout ended the search; the bounds hold");
  py::class_<HausdorffBounds>(m, "HausdorffBounds", "Bounds on the Hausdorff distance of two surfaces.")
      .def_readonly("lower", &HausdorffBounds::lower, "m")
      .def_readonly("upper", &HausdorffBounds::upper, "m")
      .def_property_readonly(
          "point", [](const HausdorffBounds& r) { return to_array(r.point); }, "(3,) lower away from the other surface")
      .def_property_readonly(
          "nearest", [](const HausdorffBounds& r) { return to_array(r.nearest); }, "(3,) its nearest point there")
      .def_readonly("of_a", &HausdorffBounds::of_a, "whether point is of a, else of b")
      .def_readonly("parts", &HausdorffBounds::parts, "of surfaces that were looked at");
}

// The tuple (points, points_of_b, edges).
py::tuple arrays_of(const NearFeatures& found) {
  const auto point = [](const NearPoint& p) { return NearPointRow{p.vertex, p.triangle, p.distance}; };
  const auto edge = [](const NearEdges& e) { return NearEdgesRow{e.a, e.b, e.distance}; };
  return py::make_tuple(structured<NearPointRow>(found.points, point),
                        structured<NearPointRow>(found.points_of_b, point),
                        structured<NearEdgesRow>(found.edges, edge));
}

py::tuple features(const Shape& a, const py::object& at_a, const Shape& b, const py::object& at_b, double margin) {
  const Pose pose_a = pose(at_a, "pose_a"), pose_b = pose(at_b, "pose_b");
  NearFeatures found;
  {
    const py::gil_scoped_release released;
    found = near_features(a, pose_a, b, pose_b, margin, on_all_threads);
  }
  return arrays_of(found);
}

MeshInspection inspected(const py::object& vertices, const py::object& indices, std::size_t most,
                         std::optional<double> timeout) {
  const Mesh mesh{points(vertices, "vertices"), index_rows<std::uint32_t, 3>(indices, "triangles"), false};
  const py::gil_scoped_release released;
  const WorkLimit limit = limit_after(timeout);
  return inspect(mesh, {.most = most, .parts = on_all_threads, .limit = timeout ? &limit : nullptr});
}

// The number of faults, and an array of the first.
template <class Row, class Fault, class MakeRow>
py::tuple listed(const FaultList<Fault>& faults, const MakeRow& row) {
  return py::make_tuple(faults.count, structured<Row>(faults.first, row));
}

void bind_counts(py::class_<MeshInspection>& inspection) {
  inspection.def_readonly("vertices", &MeshInspection::vertices)
      .def_readonly("triangles", &MeshInspection::triangles)
      .def_readonly("components", &MeshInspection::components, "of triangles that hang together by edges")
      .def_property_readonly("is_closed", &MeshInspection::closed, "every edge joins two triangles in opposite sense")
      .def_property_readonly("is_clean_solid", &MeshInspection::is_clean_solid,
                             "closed, and nothing of it crosses itself, is double, flat or inside out");
}

void bind_faults(py::class_<MeshInspection>& inspection) {
  inspection
      .def_property_readonly(
          "faulty_edges",
          [](const MeshInspection& i) {
            return listed<FaultyEdgeRow>(i.faulty_edges, [](const FaultyEdge& f) {
              return FaultyEdgeRow{static_cast<std::uint8_t>(f.fault),
                                   f.vertices,
                                   {numbers(f.ends[0]), numbers(f.ends[1])},
                                   f.triangle,
                                   f.forward,
                                   f.backward};
            });
          },
          "fault: 0 of one triangle, 1 of more than two, 2 of two in the same sense; vertices, ends, triangle, "
          "forward, backward")
      .def_property_readonly(
          "self_intersections",
          [](const MeshInspection& i) {
            return listed<SelfIntersectionRow>(i.self_intersections, [](const SelfIntersection& f) {
              return SelfIntersectionRow{f.triangles, numbers(f.place)};
            });
          },
          "triangles, place; exact")
      .def_property_readonly(
          "inside_out",
          [](const MeshInspection& i) {
            return listed<InsideOutRow>(i.inside_out, [](const InsideOut& f) {
              return InsideOutRow{f.triangle, f.triangles, f.volume, numbers(f.place)};
            });
          },
          "components of negative volume: their first triangle, how many, volume (m^3), place")
      .def_property_readonly(
          "flat_triangles",
          [](const MeshInspection& i) {
            return listed<FlatTriangleRow>(i.flat_triangles, [](const FlatTriangle& f) {
              return FlatTriangleRow{f.triangle, numbers(f.place)};
            });
          },
          "triangle, place; exact")
      .def_property_readonly(
          "duplicate_triangles",
          [](const MeshInspection& i) {
            return listed<DuplicateRow>(i.duplicate_triangles, [](const DuplicateTriangle& f) {
              return DuplicateRow{f.triangle, f.same_as, numbers(f.place)};
            });
          },
          "index, same_as, place")
      .def_property_readonly(
          "duplicate_vertices",
          [](const MeshInspection& i) {
            return listed<DuplicateRow>(i.duplicate_vertices, [](const DuplicateVertex& f) {
              return DuplicateRow{f.vertex, f.same_as, numbers(f.place)};
            });
          },
          "index, same_as, place; they do no harm");
}

void bind_inspection(py::module_& m) {
  py::class_<MeshInspection> inspection(
      m, "Inspection",
      "What is found in a mesh that may not be as it should: of each kind (how many, array of the first).");
  bind_counts(inspection);
  bind_faults(inspection);
  m.def("inspect", &inspected, py::arg("vertices"), py::arg("triangles"), py::kw_only(), py::arg("most") = 100,
        py::arg("timeout") = py::none(),
        "What is wrong with a mesh, with places. most: faults listed of each kind; all are counted. timeout: s, of the "
        "search for\ntriangles that cross, whose pairs grow with the square of those about one vertex; TimeoutError.");
}

using SharedDeformable = SharedUse<DeformableMesh>;

void bind_deformable(py::module_& m) {
  py::class_<SharedDeformable>(m, "DeformableMesh", "A mesh whose vertices move while its triangles stay.")
      .def(py::init([](const py::object& v, const py::object& t, bool solid) {
             Mesh mesh{points(v, "vertices"), index_rows<std::uint32_t, 3>(t, "triangles"), solid};
             const py::gil_scoped_release released;
             return std::make_unique<SharedDeformable>(std::move(mesh), on_all_threads);
           }),
           py::arg("vertices"), py::arg("triangles"), py::kw_only(), py::arg("solid") = false)
      .def(
          "update",
          [](SharedDeformable& mesh, const py::object& v) {
            const std::vector<Vec3> to = points(v, "vertices");
            return mesh.change([&](DeformableMesh& d) { return d.update(to, on_all_threads); }).rebuilt_triangles;
          },
          py::arg("vertices"),
          "Moves all vertices, (n, 3), m. Returns how many triangles' hierarchy was built anew, as it had become slow.")
      .def(
          "shape", [](const SharedDeformable& mesh) { return mesh.read([](const auto& d) { return d.shape(); }); },
          "As of the last update; later ones do not change it.")
      .def(
          "self_intersections",
          [](const SharedDeformable& mesh) {
            const auto found = mesh.read([](const auto& d) { return d.self_intersections(on_all_threads); });
            return to_array(std::span<const std::array<std::uint32_t, 2>>(found));
          },
          "(n, 2): all pairs of triangles that share no vertex and meet, sorted; exact.")
      .def(
          "near_features",
          [](const SharedDeformable& mesh, double margin) {
            return arrays_of(mesh.read([&](const auto& d) { return d.near_features(margin, on_all_threads); }));
          },
          py::arg("margin"), "As tandem.near_features, of the mesh with itself, for features without a common vertex.")
      .def_property_readonly(
          "vertices",
          [](const SharedDeformable& mesh) {
            return to_array(std::span<const Vec3>(
                mesh.read([](const auto& d) { return std::vector<Vec3>(d.vertices().begin(), d.vertices().end()); })));
          },
          "(n, 3), m, as of the last update.")
      .def_property_readonly(
          "triangles",
          [](const SharedDeformable& mesh) { return to_array(mesh.read([](const auto& d) { return d.triangles(); })); },
          "(k, 3), turned alike.")
      .def_property_readonly(
          "memory", [](const SharedDeformable& mesh) { return mesh.read([](const auto& d) { return d.memory(); }); },
          "Bytes, shapes of earlier updates that are in use included.");
}

}  // namespace

void bind_meshes(py::module_& m) {
  describe_mesh_rows();
  bind_inspection(m);
  bind_deformable(m);
  bind_bounds(m);
  const auto a = py::arg("a"), pose_a = py::arg("pose_a"), b = py::arg("b"), pose_b = py::arg("pose_b");
  const auto timeout = py::arg("timeout") = py::none(), progress = py::arg("progress") = py::none();
  m.def("near_triangles", &near_triangles, a, pose_a, b, pose_b, py::kw_only(), py::arg("clearance") = 0.0, progress,
        timeout,
        "All pairs of triangles of two meshes at most clearance (m) apart, sorted; 0: those that intersect, exactly. "
        "A structured\n"
        "array: triangles (2,), distance (m), point_a, point_b. progress: a function that is told how much is done, "
        "[0, 1]. "
        "timeout: s; then TimeoutError.");
  m.def(
      "clearance_zones", &zones, a, pose_a, b, pose_b, py::kw_only(), py::arg("clearance") = 0.0, progress, timeout,
      "Those pairs by places where the meshes meet or come near, the deepest or nearest first. A structured array: "
      "pairs,\n"
      "intersecting_pairs, bounds (2, 3), area (2,) m^2, and of the nearest pair triangles (2,), signed_distance (m), "
      "point_a,\n"
      "point_b, normal. progress: as of near_triangles. timeout: s; then TimeoutError.");
  m.def("separation_along", &separation, a, pose_a, b, pose_b, py::arg("direction"), py::kw_only(), timeout,
        "How far b must be moved along a direction (metres along it) to be apart from a and stay so. timeout: s; then "
        "TimeoutError.");
  m.def("penetration_depth", &depth, a, pose_a, b, pose_b, py::kw_only(), py::arg("gap") = DepthOptions{}.gap,
        py::arg("most_boxes") = DepthOptions{}.most_boxes, timeout,
        "How deep two shapes are in each other, as bounds that are at most gap (of the upper one) apart, if most_boxes "
        "of\n"
        "translations are enough. timeout: s; then the bounds reached by then (incomplete), TimeoutError if there are "
        "none.");
  m.def("hausdorff_distance", &hausdorff, a, pose_a, b, pose_b, py::kw_only(), py::arg("tolerance") = 0.0,
        py::arg("gap") = HausdorffOptions{}.gap, py::arg("least") = HausdorffOptions{}.least,
        py::arg("most_parts") = HausdorffOptions{}.most_parts, timeout,
        "The largest distance of a point of either mesh's surface from the other, as bounds that are at most tolerance "
        "(m)\n"
        "or gap (of the upper one) apart, or the upper one at most least (of the surfaces' size), if most_parts of "
        "them are "
        "enough.\n"
        "timeout: s; then TimeoutError.");
  m.def("near_features", &features, a, pose_a, b, pose_b, py::arg("margin"),
        "Points and triangles, and edges, of two meshes at most margin (m) apart, on all threads: (points of a with "
        "triangles of\n"
        "b, points of b with triangles of a, edges). Structured arrays: vertex, triangle, distance; a (2,), b (2,), "
        "distance.");
}

}  // namespace tandem::python
