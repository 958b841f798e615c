// Bindings of queries of a scene.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>

#include "arrays.h"
#include "bindings.h"
#include "building.h"
#include "contact_arrays.h"
#include "rows.h"
#include "scene_objects.h"
#include "tandem/engine/scene_queries.h"
#include "timeout.h"

namespace tandem::python {

// A row of the array; the members' names are the array's fields.
struct FirstHitRow {
  std::uint8_t verdict;
  std::uint32_t configuration, link, other_link;
  IdNumber body;
};

namespace {

using SharedQueries = SharedUse<SceneQueries>;
constexpr double no_cutoff = std::numeric_limits<double>::infinity();

// The filter of a query, as it was passed.
struct Filter {
  Filter(std::uint32_t group, std::uint32_t mask, const py::object& ignored) {
    if (!ignored.is_none()) ignore = body_ids(ignored, "ignore");
    filter.group = group;
    filter.mask = mask;
    filter.ignore = ignore;
  }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;

  std::vector<BodyId> ignore;
  QueryFilter filter;
};

bool collides(const SharedQueries& queries, const Shape& shape, const py::object& at, double margin,
              std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Pose where = pose(at, "pose");
  return queries.read([&](const SceneQueries& q) { return q.collides(shape, where, margin, filter.filter); });
}

py::array_t<IdNumber> hits(const SharedQueries& queries, const Shape& shape, const py::object& at, std::uint32_t group,
                           std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Pose where = pose(at, "pose");
  std::vector<BodyId> found;
  queries.read([&](const SceneQueries& q) { q.hits(shape, where, found, filter.filter); });
  return to_array(found);
}

py::object tuple_of(const std::optional<Hit>& hit) {
  if (!hit) return py::none();
  return py::make_tuple(number(hit->body), hit->answer);
}

py::object nearest(const SharedQueries& queries, const Shape& shape, const py::object& at, double cutoff,
                   std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Pose where = pose(at, "pose");
  return tuple_of(queries.read([&](const SceneQueries& q) { return q.nearest(shape, where, cutoff, filter.filter); }));
}

py::list tuples_of(const std::vector<Hit>& hits) {
  py::list out;
  for (const Hit& hit : hits) out.append(py::make_tuple(number(hit.body), hit.answer));
  return out;
}

py::list within(const SharedQueries& queries, const Shape& shape, const py::object& at, double margin,
                std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Pose where = pose(at, "pose");
  std::vector<Hit> found;
  queries.read([&](const SceneQueries& q) { q.within(shape, where, margin, found, filter.filter); });
  return tuples_of(found);
}

py::list contacts(const SharedQueries& queries, const Shape& shape, const py::object& at, double margin,
                  std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Pose where = pose(at, "pose");
  std::vector<ContactHit> found;
  std::vector<Contact> points;
  queries.read([&](const SceneQueries& q) { q.contacts(shape, where, margin, found, points, filter.filter); });
  py::list out;
  for (const ContactHit& hit : found)
    out.append(
        py::make_tuple(number(hit.body), hit.answer, contact_array(std::span(points).subspan(hit.first, hit.count))));
  return out;
}

py::object cast(const SharedQueries& queries, const Shape& shape, const py::object& from, const py::object& to,
                std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Motion motion{pose(from, "from_pose"), pose(to, "to_pose")};
  const auto found = queries.read([&](const SceneQueries& q) { return q.cast(shape, motion, filter.filter); });
  if (!found) return py::none();
  return py::make_tuple(number(found->body), FirstTouch{found->t, found->point, found->normal, found->feature});
}

PairTable pair_table(const py::object& value, const char* what) {
  if (value.is_none()) return {};
  const auto array = py::array_t<bool, py::array::c_style>::ensure(value);
  if (!array || array.ndim() != 2) {
    PyErr_Clear();
    throw std::invalid_argument(std::string(what) + ": not a table, allowed: a bool array of two dimensions");
  }
  const auto rows = static_cast<std::size_t>(array.shape(0)), columns = static_cast<std::size_t>(array.shape(1));
  PairTable table(rows, columns, false);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) table.set(i, j, array.data()[i * columns + j]);
  return table;
}

// Makes the table symmetric: a pair of links is the same in either order.
PairTable either_way(PairTable table) {
  for (std::size_t i = 0; i < std::min(table.rows(), table.columns()); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (table.checked(i, j)) table.set(j, i, true);
  return table;
}

// The arguments of a batch: links, their poses, and which pairs of them are checked.
struct Batch {
  Batch(const SharedQueries& queries, const std::vector<Shape>& links, const py::object& at,
        const py::object& self_pairs, const py::object& world_pairs, const Filter& filter, const py::object& progress,
        std::optional<double> timeout)
      : links(links),
        rows(at, "poses"),
        placed(rows.matrices().empty()
                   ? BatchPoses(rows.size(), [this](std::size_t first, std::span<Pose> out) { rows.read(first, out); })
                   : BatchPoses::of_matrices(rows.matrices())),
        self(either_way(pair_table(self_pairs, "self_pairs"))),
        world(pair_table(world_pairs, "world_pairs")) {
    if (links.empty()) throw std::invalid_argument("links: none, allowed: at least one");
    if (placed.size() % links.size() != 0)
      throw std::invalid_argument("poses: " + std::to_string(placed.size()) + " of " + std::to_string(links.size()) +
                                  " links, allowed: one for each link of each configuration");
    configurations = placed.size() / links.size();
    options.filter = filter.filter;
    options.progress = progress_of<std::size_t, std::size_t>(progress, &queries);
    if (world.rows() > 0) options.world = &world;
    options.deadline = deadline_after(timeout);
  }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  std::size_t motions(std::size_t of_configurations) {
    if (of_configurations == 0) throw std::invalid_argument("configurations_a_motion: 0, allowed: >= 1");
    options.configurations_a_motion = of_configurations;
    return configurations / of_configurations;
  }

  const std::vector<Shape>& links;
  PoseRows rows;
  BatchPoses placed;
  PairTable self, world;
  std::size_t configurations = 0;
  BatchOptions options;
};

py::array_t<std::uint8_t> check(const SharedQueries& queries, const std::vector<Shape>& links, const py::object& at,
                                const py::object& self_pairs, const py::object& world_pairs, double margin,
                                std::size_t configurations_a_motion, bool continuous, const py::object& progress,
                                std::optional<double> timeout, std::uint32_t group, std::uint32_t mask,
                                const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  Batch batch(queries, links, at, self_pairs, world_pairs, filter, progress, timeout);
  batch.options.margin = margin;
  batch.options.continuous = continuous;
  py::array_t<std::uint8_t> out(static_cast<py::ssize_t>(batch.motions(configurations_a_motion)));
  static_assert(sizeof(Verdict) == 1);
  const std::span verdicts(reinterpret_cast<Verdict*>(out.mutable_data()), static_cast<std::size_t>(out.size()));
  queries.read([&](const SceneQueries& q) { q.check(links, batch.placed, batch.self, verdicts, batch.options); });
  return out;
}

py::array first_hits(const SharedQueries& queries, const std::vector<Shape>& links, const py::object& at,
                     const py::object& self_pairs, const py::object& world_pairs, double margin,
                     std::size_t configurations_a_motion, const py::object& progress, std::optional<double> timeout,
                     std::uint32_t group, std::uint32_t mask, const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  Batch batch(queries, links, at, self_pairs, world_pairs, filter, progress, timeout);
  batch.options.margin = margin;
  std::vector<FirstHit> found(batch.motions(configurations_a_motion));
  queries.read([&](const SceneQueries& q) { q.first_hits(links, batch.placed, batch.self, found, batch.options); });
  return structured<FirstHitRow>(found, [](const FirstHit& hit) {
    return FirstHitRow{static_cast<std::uint8_t>(hit.verdict), hit.configuration, hit.link, hit.other_link,
                       number(hit.body)};
  });
}

Doubles clearance(const SharedQueries& queries, const std::vector<Shape>& links, const py::object& at,
                  const py::object& self_pairs, const py::object& world_pairs, double cutoff,
                  const py::object& progress, std::optional<double> timeout, std::uint32_t group, std::uint32_t mask,
                  const py::object& ignore) {
  const Filter filter(group, mask, ignore);
  const Batch batch(queries, links, at, self_pairs, world_pairs, filter, progress, timeout);
  Doubles out(static_cast<py::ssize_t>(batch.configurations));
  const std::span distances(out.mutable_data(), batch.configurations);
  queries.read(
      [&](const SceneQueries& q) { q.clearance(links, batch.placed, batch.self, distances, cutoff, batch.options); });
  return out;
}

// Binds the queries with a body of the scene, at its pose.
void bind_of_bodies(py::class_<SharedQueries>& queries) {
  const auto body = py::arg("body"), margin = py::arg("margin");
  queries
      .def(
          "collides_body",
          [](const SharedQueries& queries_, IdNumber id, double within) {
            return queries_.read([&](const SceneQueries& q) { return q.collides(body_id(id), within); });
          },
          body, py::kw_only(), py::arg("margin") = 0.0,
          "As collides, asked by a body of the scene where it is, by its groups and mask; itself is left out.")
      .def(
          "hits_body",
          [](const SharedQueries& queries_, IdNumber id) {
            std::vector<BodyId> found;
            queries_.read([&](const SceneQueries& q) { q.hits(body_id(id), found); });
            return to_array(found);
          },
          body, "As hits, asked by a body of the scene.")
      .def(
          "nearest_body",
          [](const SharedQueries& queries_, IdNumber id, double cutoff) {
            return tuple_of(queries_.read([&](const SceneQueries& q) { return q.nearest(body_id(id), cutoff); }));
          },
          body, py::kw_only(), py::arg("cutoff") = no_cutoff, "As nearest, asked by a body of the scene.")
      .def(
          "within_body",
          [](const SharedQueries& queries_, IdNumber id, double within) {
            std::vector<Hit> found;
            queries_.read([&](const SceneQueries& q) { q.within(body_id(id), within, found); });
            return tuples_of(found);
          },
          body, py::kw_only(), margin, "As within, asked by a body of the scene.");
}

void bind_batches(py::class_<SharedQueries>& queries) {
  const auto links = py::arg("links"), poses = py::arg("poses");
  const auto self = py::arg("self_pairs") = py::none(), world = py::arg("world_pairs") = py::none(),
             group = py::arg("group") = 1, mask = py::arg("mask") = 0xffffffffu,
             ignore = py::arg("ignore") = py::none(), timeout = py::arg("timeout") = py::none(),
             progress = py::arg("progress") = py::none(), margin = py::arg("margin") = 0.0,
             a_motion = py::arg("configurations_a_motion") = 1;
  queries
      .def("check", &check, links, poses, py::kw_only(), self, world, margin, a_motion, py::arg("continuous") = false,
           progress, timeout, group, mask, ignore,
           "Configurations of links, on all threads: (configurations,) uint8, 0 free, 1 hit, 2 unknown (the timeout "
           "passed).\n"
           "links: Shapes. poses: (configurations, links, 4, 4) or (configurations, links, 7). self_pairs: (links, "
           "links) bool, i < j or j < i:\n"
           "which links are checked with one another. world_pairs: (links, indices) bool: which with which bodies. "
           "margin: m, gaps up\n"
           "to it count. configurations_a_motion: that many in a row are one motion, of which one verdict is told; "
           "continuous: what\n"
           "lies between them counts, too, certified. progress: a function that is told (done, all) verdicts now and "
           "then, "
           "from any\n"
           "thread; what it raises ends the work. timeout: s.")
      .def("first_hits", &first_hits, links, poses, py::kw_only(), self, world, margin, a_motion, progress, timeout,
           group, mask, ignore,
           "The same, told what is hit first: a structured array verdict, configuration (of the motion), link, "
           "other_link, "
           "body (id;\n"
           "0: other_link is hit).")
      .def("clearance", &clearance, links, poses, py::kw_only(), self, world, py::arg("cutoff") = no_cutoff, progress,
           timeout, group, mask, ignore,
           "(configurations,) m: the least signed distance of all links from bodies and one another, `cutoff` where it "
           "is not less,\n"
           "-inf where the timeout passed first.");
}

}  // namespace

void bind_queries(py::module_& m) {
  py::class_<SharedQueries> queries(m, "SceneQueries",
                                    "Asks a scene as it was at the last update; from any number of threads.");
  const auto shape = py::arg("shape");
  const auto at = py::arg("pose") = py::none(), group = py::arg("group") = 1, mask = py::arg("mask") = 0xffffffffu,
             ignore = py::arg("ignore") = py::none();
  queries
      .def(py::init([](const SharedScene& scene, double tolerance, const std::string& solver) {
             NarrowPhaseOptions options;
             options.tolerance = tolerance;
             options.solver = solver;
             return scene.read([&](const Scene& s) { return std::make_unique<SharedQueries>(s, options); });
           }),
           py::arg("scene"), py::kw_only(), py::arg("tolerance") = 0.0, py::arg("solver") = "",
           "tolerance, solver: of all queries, as of tandem.distance.")
      .def(
          "update",
          [](SharedQueries& queries_, const SharedScene& scene) {
            return queries_
                .change([&](SceneQueries& q) { return scene.read([&](const Scene& s) { return q.update(s); }); })
                .changed;
          },
          py::arg("scene"), "Takes over what changed; returns how many bodies did.")
      .def("collides", &collides, shape, at, py::kw_only(), py::arg("margin") = 0.0, group, mask, ignore,
           "Is any body touched, or as near as the margin (m)? group, mask: of the asking shape. ignore: ids that are "
           "left out.")
      .def("hits", &hits, shape, at, py::kw_only(), group, mask, ignore,
           "(n,) ids of bodies that are touched, by index.")
      .def("nearest", &nearest, shape, at, py::kw_only(), py::arg("cutoff") = no_cutoff, group, mask, ignore,
           "(id, Answer) of the body of the least signed distance that is at most cutoff (m), or None.")
      .def("within", &within, shape, at, py::kw_only(), py::arg("margin"), group, mask, ignore,
           "[(id, Answer), ...] of the bodies at most margin (m) away, by index.")
      .def("contacts", &contacts, shape, at, py::kw_only(), py::arg("margin") = 0.0, group, mask, ignore,
           "[(id, Answer, contacts), ...] of the bodies with contacts, by index.")
      .def("cast", &cast, shape, py::arg("from_pose"), py::arg("to_pose"), py::kw_only(), group, mask, ignore,
           "(id, FirstTouch) of the first body that the moving shape touches, or None; a sphere of radius 0 is a ray.");
  queries.def_property_readonly(
      "memory", [](const SharedQueries& q) { return q.read([](const SceneQueries& x) { return x.memory(); }); },
      "Bytes held, shapes not counted.");
  PYBIND11_NUMPY_DTYPE(FirstHitRow, verdict, configuration, link, other_link, body);
  bind_of_bodies(queries);
  bind_batches(queries);
}

}  // namespace tandem::python
