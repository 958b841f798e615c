// Bindings of queries of boxes: overlap, rays, nearest.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include "arrays.h"
#include "bindings.h"
#include "names.h"
#include "rows.h"
#include "tandem/broadphase/box_queries.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem::python {

// Rows of the arrays; the members' names are the arrays' fields.
struct RayHitRow {
  std::uint32_t index;
  double t;
};
struct NeighbourRow {
  std::uint32_t index;
  double squared_distance;
};

namespace {

// Boxes rounded outward to floats, so that they contain the given ones.
std::vector<Aabb> boxes_in(const py::object& value, const char* what) {
  const Doubles given = doubles(value, what, {-1, 2, 3});
  std::vector<Aabb> out(static_cast<std::size_t>(given.shape(0)));
  const double* x = given.data();
  for (std::size_t i = 0; i < out.size(); ++i, x += 6)
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(x[k] <= x[3 + k]) || !std::isfinite(x[k]) || !std::isfinite(x[3 + k]))
        throw std::invalid_argument(std::string(what) + '[' + std::to_string(i) + "]: from " + written(x[k]) + " to " +
                                    written(x[3 + k]) + " on axis " + std::to_string(k) +
                                    ", allowed: finite, the least corner first");
      out[i].lo[k] = round_down(x[k]);
      out[i].hi[k] = round_up(x[3 + k]);
    }
  return out;
}

BoxArray box_array(const std::vector<Aabb>& boxes) {
  BoxArray out;
  out.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) out.set(i, boxes[i]);
  return out;
}

void on_blocks(std::size_t blocks, const std::function<void(std::size_t)>& block) {
  tbb::parallel_for(std::size_t{0}, blocks, block);
}

py::array_t<std::uint32_t> overlapping_boxes(const py::object& given, const std::string& method) {
  const auto kind = named(method, "method",
                          std::array{BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                     BroadPhaseKind::bvh, BroadPhaseKind::automatic});
  const BoxArray boxes = box_array(boxes_in(given, "boxes"));
  std::vector<std::array<std::uint32_t, 2>> pairs;
  {
    const py::gil_scoped_release released;
    for (const Pair& pair : find_pairs(*make_broad_phase(kind), boxes)) pairs.push_back({pair.a, pair.b});
  }
  return to_array(std::span<const std::array<std::uint32_t, 2>>(pairs));
}

// The tuple (items, begin): query i has items[begin[i]:begin[i + 1]].
template <class Items, class Answers>
py::tuple with_begins(const Items& items, const Answers& answers) {
  py::array_t<std::uint64_t> begin(static_cast<py::ssize_t>(answers.begin.size()));
  std::copy(answers.begin.begin(), answers.begin.end(), begin.mutable_data());
  return py::make_tuple(items, begin);
}

py::tuple overlapping(const BoxQueries& queries, const py::object& given) {
  const std::vector<Aabb> boxes = boxes_in(given, "boxes");
  QueryAnswers<std::uint32_t> found;
  {
    const py::gil_scoped_release released;
    found = queries.overlapping(boxes, on_blocks);
  }
  return with_begins(py::array_t<std::uint32_t>(static_cast<py::ssize_t>(found.items.size()), found.items.data()),
                     found);
}

py::tuple along(const BoxQueries& queries, const py::object& origins, const py::object& directions, double t_max) {
  const std::vector<Vec3> from = points(origins, "origins"), to = points(directions, "directions");
  if (from.size() != to.size())
    throw std::invalid_argument("directions: " + std::to_string(to.size()) + ", allowed: as many as origins, " +
                                std::to_string(from.size()));
  std::vector<Ray> rays(from.size());
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = {numbers(from[i]), numbers(to[i]), t_max};
  QueryAnswers<RayHit> found;
  {
    const py::gil_scoped_release released;
    found = queries.along(rays, on_blocks);
  }
  return with_begins(structured<RayHitRow>(found.items,
                                           [](const RayHit& hit) {
                                             return RayHitRow{hit.index, hit.t};
                                           }),
                     found);
}

py::tuple nearest(const BoxQueries& queries, const py::object& given, std::size_t k) {
  std::vector<Triple> places;
  for (const Vec3& point : points(given, "points")) places.push_back(numbers(point));
  QueryAnswers<Neighbour> found;
  {
    const py::gil_scoped_release released;
    found = queries.nearest(places, k, on_blocks);
  }
  return with_begins(structured<NeighbourRow>(found.items,
                                              [](const Neighbour& n) {
                                                return NeighbourRow{n.index, n.squared_distance};
                                              }),
                     found);
}

}  // namespace

void bind_boxes(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(RayHitRow, index, t);
  PYBIND11_NUMPY_DTYPE(NeighbourRow, index, squared_distance);
  m.def(
      "overlapping_boxes", &overlapping_boxes, py::arg("boxes"), py::kw_only(), py::arg("method") = "auto",
      "(pairs, 2) indices, sorted, of boxes that overlap or touch. boxes: (n, 2, 3), least and largest corner, rounded "
      "outward to\n"
      "single precision. method: 'brute', 'sweep', 'grid', 'bvh', 'auto'; the answer is the same.");
  py::class_<BoxQueries>(m, "BoxQueries",
                         "Questions to a set of boxes; answers of several are (items, begin): of query i "
                         "items[begin[i]:begin[i + 1]].")
      .def(py::init([](const py::object& given) {
             const BoxArray boxes = box_array(boxes_in(given, "boxes"));
             const py::gil_scoped_release released;
             auto queries = std::make_unique<BoxQueries>();
             queries->build(boxes, on_blocks);
             return queries;
           }),
           py::arg("boxes"))
      .def("overlapping", &overlapping, py::arg("boxes"),
           "Of (n, 2, 3) boxes: indices of those that they overlap, sorted.")
      .def("along", &along, py::arg("origins"), py::arg("directions"),
           py::arg("t_max") = std::numeric_limits<double>::infinity(),
           "Of rays origin + t direction, (n, 3) each, 0 <= t <= t_max: a structured array index, t (where the box is "
           "entered), by t.")
      .def("nearest", &nearest, py::arg("points"), py::arg("k"),
           "Of (n, 3) points: a structured array index, squared_distance of the k nearest boxes, the nearest first.")
      .def_property_readonly("memory", &BoxQueries::memory, "Bytes held.");
}

}  // namespace tandem::python
