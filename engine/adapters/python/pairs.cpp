// Bindings of queries of two shapes.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>
#include <sstream>

#include "all_threads.h"
#include "arrays.h"
#include "bindings.h"
#include "contact_arrays.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/triangles_at.h"
#include "timeout.h"

namespace tandem::python {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// Two shapes with their poses, the arguments of the calls below.
struct Placed {
  Placed(const Shape& a, const py::handle& pose_a, const Shape& b, const py::handle& pose_b)
      : a(a), b(b), at_a(pose(pose_a, "pose_a")), at_b(pose(pose_b, "pose_b")) {}

  const Shape &a, &b;
  Pose at_a, at_b;
};

PairAnswer solved(const Placed& pair, Request request, NarrowPhaseOptions options, std::optional<double> timeout,
                  std::vector<Contact>* contacts = nullptr) {
  const WorkLimit limit = limit_after(timeout);
  if (timeout) options.limit = &limit;
  options.parts = on_all_threads;
  const py::gil_scoped_release released;
  const NarrowPhase solver(options);
  if (const std::string why = solver.refuses(pair.a, pair.b, request); !why.empty()) throw std::invalid_argument(why);
  return solver.solve(pair.a, pair.at_a, pair.b, pair.at_b, request, contacts);
}

PairAnswer distance(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b,
                    double tolerance, double cutoff, const std::string& solver, std::optional<double> timeout) {
  NarrowPhaseOptions options;
  options.tolerance = tolerance;
  options.cutoff = cutoff;
  options.solver = solver;
  return solved({a, pose_a, b, pose_b}, Request::distance, options, timeout);
}

bool collide(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b,
             const std::string& solver, std::optional<double> timeout) {
  NarrowPhaseOptions options;
  options.solver = solver;
  return unless_stopped(solved({a, pose_a, b, pose_b}, Request::collide, options, timeout)).collide;
}

py::array contacts(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b, double margin,
                   bool mesh_bounds, bool mesh_margin, double tolerance, const std::string& solver,
                   std::optional<double> timeout) {
  NarrowPhaseOptions options;
  options.margin = margin;
  options.mesh_bounds = mesh_bounds;
  options.mesh_margin = mesh_margin;
  options.tolerance = tolerance;
  options.solver = solver;
  std::vector<Contact> found;
  unless_stopped(solved({a, pose_a, b, pose_b}, Request::contacts, options, timeout, &found));
  return contact_array(found);
}

py::array intersecting_triangles(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b,
                                 std::optional<double> timeout) {
  const Placed pair(a, pose_a, b, pose_b);
  const WorkLimit limit = limit_after(timeout);
  NarrowPhaseOptions options;
  if (timeout) options.limit = &limit;
  std::vector<std::array<std::uint32_t, 2>> found;
  {
    const py::gil_scoped_release released;
    found = NarrowPhase(options).intersecting_triangles(a, pair.at_a, b, pair.at_b);
  }
  return to_array(std::span<const std::array<std::uint32_t, 2>>(found));
}

std::optional<Vec3> point(const py::object& value, const char* what) {
  if (value.is_none()) return {};
  return vec3(value, what);
}

std::optional<FirstTouch> time_of_impact(const Shape& a, const py::object& from_a, const py::object& to_a,
                                         const Shape& b, const py::object& from_b, const py::object& to_b,
                                         const py::object& straight_of_a, const py::object& straight_of_b,
                                         std::optional<double> timeout) {
  const Motion motion_a{pose(from_a, "from_a"), pose(to_a, "to_a"), point(straight_of_a, "straight_of_a")},
      motion_b{pose(from_b, "from_b"), pose(to_b, "to_b"), point(straight_of_b, "straight_of_b")};
  require_valid(motion_a, "motion of A");
  require_valid(motion_b, "motion of B");
  const WorkLimit limit = limit_after(timeout);
  NarrowPhaseOptions options;
  if (timeout) options.limit = &limit;
  const py::gil_scoped_release released;
  return NarrowPhase(options).time_of_impact(a, motion_a, b, motion_b);
}

Doubles place_at(const py::object& from, const py::object& to, double t, const py::object& straight_of) {
  const Motion motion{pose(from, "from_pose"), pose(to, "to_pose"), point(straight_of, "straight_of")};
  require_valid(motion, "motion");
  if (!(t >= 0 && t <= 1)) throw std::invalid_argument("t: " + written(t) + ", allowed: [0, 1]");
  return to_array(pose_at(motion, t));
}

py::list all_solvers() {
  py::list out;
  for (const SolverInfo& solver : NarrowPhase::solvers())
    out.append(py::make_tuple(std::string(solver.name), std::string(solver.description)));
  return out;
}

py::tuple triangles_of(const Shape& a, const py::object& pose_a, const Shape& b, const py::object& pose_b,
                       const PairAnswer& answer) {
  const Placed pair(a, pose_a, b, pose_b);
  const auto found = triangles_at(a, pair.at_a, b, pair.at_b, answer);
  return py::make_tuple(found[0], found[1]);
}

py::array_t<std::uint32_t> triangles_of_contacts(const Shape& a, const py::object& pose_a, const Shape& b,
                                                 const py::object& pose_b, const py::object& given) {
  const Placed pair(a, pose_a, b, pose_b);
  std::vector<std::array<std::uint32_t, 2>> found;
  for (const Contact& contact : contacts_in(given, "of"))
    found.push_back(triangles_at(a, pair.at_a, b, pair.at_b, contact));
  return to_array(std::span<const std::array<std::uint32_t, 2>>(found));
}

const char* status_name(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::inexact:
      return "inexact";
    case Status::stopped:
      return "stopped";
    default:
      return "unproven";
  }
}

std::string described(const PairAnswer& answer) {
  std::ostringstream out;
  out << "<tandem.Answer signed_distance " << answer.signed_distance << " m, " << status_name(answer.status) << ">";
  return out.str();
}

void bind_answers(py::module_& m) {
  py::class_<PairAnswer>(m, "Answer", "What is known of two shapes; points and normal in world axes.")
      .def_readonly("collide", &PairAnswer::collide)
      .def_readonly("farther", &PairAnswer::farther, "Farther apart than the cut-off, which is signed_distance then.")
      .def_readonly("signed_distance", &PairAnswer::signed_distance, "m; > 0 gap, < 0 minus the penetration depth")
      .def_property_readonly(
          "point_a", [](const PairAnswer& a) { return to_array(a.point_a); }, "(3,) on A, m")
      .def_property_readonly(
          "point_b", [](const PairAnswer& a) { return to_array(a.point_b); }, "(3,) on B, m")
      .def_property_readonly(
          "normal", [](const PairAnswer& a) { return to_array(a.normal); }, "(3,) unit, from A to B")
      .def_property_readonly(
          "status", [](const PairAnswer& a) { return status_name(a.status); },
          "'ok', 'inexact', or 'stopped': the timeout passed first")
      .def_readonly("error_bound", &PairAnswer::error_bound, "m, on signed_distance; 0: rounding")
      .def("__repr__", &described);
  py::class_<FirstTouch>(m, "FirstTouch", "The first touch of two shapes on their motions.")
      .def_readonly("t", &FirstTouch::t, "[0, 1]; 0 where they touch at the start")
      .def_property_readonly(
          "point", [](const FirstTouch& f) { return to_array(f.point); }, "(3,) midway, m")
      .def_property_readonly(
          "normal", [](const FirstTouch& f) { return to_array(f.normal); }, "(3,) unit, from A to B")
      .def_property_readonly(
          "feature", [](const FirstTouch& f) { return py::make_tuple(f.feature[0], f.feature[1]); },
          "of A and of B: the triangle of a mesh, else 0");
}

}  // namespace

void bind_pairs(py::module_& m) {
  bind_answers(m);
  const auto a = py::arg("a"), pose_a = py::arg("pose_a"), b = py::arg("b"), pose_b = py::arg("pose_b");
  const auto timeout = py::arg("timeout") = py::none(), solver = py::arg("solver") = "";
  m.def("distance", &distance, a, pose_a, b, pose_b, py::kw_only(), py::arg("tolerance") = 0.0,
        py::arg("cutoff") = infinite, solver, timeout,
        "Signed distance, points and normal of two shapes. Poses: (4, 4), or (7,): translation, then quaternion w, x, "
        "y, z;\n"
        "or None. tolerance: accepted error relative to the size, [0, 0.1]. cutoff: m; farther pairs are not told "
        "apart.\n"
        "solver: one of tandem.solvers() by its name, where it covers the pair; '': the table's choice.\n"
        "timeout: s; status 'stopped' where it passed first; the calls below raise TimeoutError then.");
  m.def("collide", &collide, a, pose_a, b, pose_b, py::kw_only(), solver, timeout,
        "Whether two shapes touch or overlap; exact for meshes.");
  m.def(
      "contacts", &contacts, a, pose_a, b, pose_b, py::kw_only(), py::arg("margin") = 0.0,
      py::arg("mesh_bounds") = NarrowPhaseOptions{}.mesh_bounds,
      py::arg("mesh_margin") = NarrowPhaseOptions{}.mesh_margin, py::arg("tolerance") = 0.0, solver, timeout,
      "Contacts as a structured array: point, normal (unit, from a to b), depth, feature. margin: m; gaps up to it "
      "are\n"
      "reported with negative depth; of two meshes unless mesh_margin is False. mesh_bounds: the deepest contact of a "
      "mesh is\n"
      "proven to separate; False is faster, up to a hundred times. tolerance, solver: as of distance.");
  m.def("intersecting_triangles", &intersecting_triangles, a, pose_a, b, pose_b, py::kw_only(), timeout,
        "(n, 2): all intersecting pairs of triangles of two meshes, sorted; exact.");
  m.def("time_of_impact", &time_of_impact, a, py::arg("from_a"), py::arg("to_a"), b, py::arg("from_b"), py::arg("to_b"),
        py::kw_only(), py::arg("straight_of_a") = py::none(), py::arg("straight_of_b") = py::none(), timeout,
        "The first touch on screw motions between two poses each, or None. Never missed. straight_of_a, straight_of_b: "
        "(3,) where\n"
        "given, no screw: this point of the body, in its frame, goes straight, and the body turns about it.");
  m.def("pose_at", &place_at, py::arg("from_pose"), py::arg("to_pose"), py::arg("t"), py::kw_only(),
        py::arg("straight_of") = py::none(), "(4, 4): where a body is at the time t, [0, 1], of such a motion.");
  m.def("solvers", &all_solvers, "[(name, description), ...] of all that a pair may be solved by.");
  m.def("triangles_at", &triangles_of, a, pose_a, b, pose_b, py::arg("of"),
        "The triangles of a and of b on which the points of an Answer lie; 0 where a shape is no mesh.");
  m.def("triangles_at", &triangles_of_contacts, a, pose_a, b, pose_b, py::arg("of"),
        "(n, 2): the same of each contact of an array as tandem.contacts gives it.");
}

}  // namespace tandem::python
