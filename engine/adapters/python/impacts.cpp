// Bindings of first impacts of moving vertices.
#include <pybind11/pybind11.h>

#include "all_threads.h"
#include "arrays.h"
#include "bindings.h"
#include "rows.h"
#include "tandem/narrowphase/vertex_impact.h"

namespace tandem::python {

// A row of the arrays; the members' names are the arrays' fields.
struct ImpactRow {
  bool hit;
  double t, gap;
};

namespace {

// The vertices before and after a step; both arrays are referred to, not copied.
class Moving {
 public:
  Moving(const py::object& from, const py::object& to, const char* from_name, const char* to_name)
      : from_(points(from, from_name)), to_(points(to, to_name)) {}
  operator MovingVertices() const { return {from_, to_}; }

 private:
  std::vector<Vec3> from_, to_;
};

using FourIndices = std::array<std::uint32_t, 4>;

// The impacts of all candidates, by a function that takes the candidates, room for answers, options and threads.
template <class Pair, class MakePair, class Find>
py::array impacts(const py::object& given, double tolerance, double separation, const MakePair& make,
                  const Find& find) {
  const std::vector<FourIndices> rows = index_rows<std::uint32_t, 4>(given, "pairs");
  std::vector<VertexImpact> found(rows.size());
  {
    const py::gil_scoped_release released;
    std::vector<Pair> pairs;
    pairs.reserve(rows.size());
    for (const FourIndices& row : rows) pairs.push_back(make(row));
    find(std::span<const Pair>(pairs), std::span<VertexImpact>(found), ImpactOptions{tolerance, separation},
         on_all_threads);
  }
  return structured<ImpactRow>(found, [](const VertexImpact& i) { return ImpactRow{i.hit, i.t, i.gap}; });
}

py::array of_points(const py::object& points_from, const py::object& points_to, const py::object& vertices_from,
                    const py::object& vertices_to, const py::object& pairs, double tolerance, double separation) {
  const Moving points(points_from, points_to, "points_from", "points_to"),
      vertices(vertices_from, vertices_to, "vertices_from", "vertices_to");
  return impacts<PointTriangle>(
      pairs, tolerance, separation,
      [](const FourIndices& i) {
        return PointTriangle{i[0], {i[1], i[2], i[3]}};
      },
      [&](auto... arguments) { point_triangle_impacts(points, vertices, arguments...); });
}

py::array of_edges(const py::object& a_from, const py::object& a_to, const py::object& b_from, const py::object& b_to,
                   const py::object& pairs, double tolerance, double separation) {
  const Moving a(a_from, a_to, "a_from", "a_to"), b(b_from, b_to, "b_from", "b_to");
  return impacts<EdgeEdge>(
      pairs, tolerance, separation,
      [](const FourIndices& i) {
        return EdgeEdge{{i[0], i[1]}, {i[2], i[3]}};
      },
      [&](auto... arguments) { edge_edge_impacts(a, b, arguments...); });
}

}  // namespace

void bind_impacts(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(ImpactRow, hit, t, gap);
  const auto pairs = py::arg("pairs");
  const auto tolerance = py::arg("tolerance") = ImpactOptions{}.tolerance, separation = py::arg("separation") = 0.0;
  m.def("point_triangle_impacts", &of_points, py::arg("points_from"), py::arg("points_to"), py::arg("vertices_from"),
        py::arg("vertices_to"), pairs, py::kw_only(), tolerance, separation,
        "First impacts of points and triangles whose vertices move on straight lines, on all threads: a structured "
        "array hit, t\n"
        "([0, 1]: at or before the impact), gap (m: a bound on the distance then). No impact is missed. ..._from, "
        "..._to: (n, 3), m,\n"
        "before and after. pairs: (k, 4) indices: a point, three vertices. tolerance: [0, 0.1], of the longest motion "
        "of a vertex.\n"
        "separation: m; features that come this near meet.");
  m.def("edge_edge_impacts", &of_edges, py::arg("a_from"), py::arg("a_to"), py::arg("b_from"), py::arg("b_to"), pairs,
        py::kw_only(), tolerance, separation, "The same of edges. pairs: (k, 4) indices: two vertices of a, two of b.");
}

}  // namespace tandem::python
