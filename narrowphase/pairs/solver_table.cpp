// The table of methods by kinds of shapes and request.
#include "pairs/solver_table.h"

#include <utility>

#include "shapes/kind_rows.h"
#include "shapes/pair_order.h"

namespace tandem {
namespace {

using enum ShapeKind;

constexpr KindSet all_kinds = kinds_where([](const KindRow&) { return true; });
constexpr KindSet bounded = kinds_where([](const KindRow& row) { return row.convex && row.bounded; });
constexpr KindSet flat =
    kinds_where([](const KindRow& row) { return row.convex && row.bounded && row.core == CoreSurface::flat; });
/// The kinds for Newton's method (shapes/round_body.h). A new kind is not among them and begins with gjk.
constexpr KindSet newtonian = kinds(cylinder, cone, ellipsoid);

/// A direct solver, and the same with A and B exchanged.
struct DirectBothOrders {
  DirectSolver* forward = nullptr;
  DirectSolver* exchanged = nullptr;
};

template <DirectSolver solver>
PairAnswer solve_exchanged(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                           Request request, double margin, std::vector<Contact>* contacts) {
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  PairAnswer r = solver(b, pose_b, a, pose_a, request, margin, contacts);
  if (request != Request::collide) swap_answer(r, contacts, first);
  return r;
}

template <DirectSolver solver>
constexpr DirectBothOrders direct{solver, solve_exchanged<solver>};

/// The method for pairs of one kind of a set and one of another, in either order.
struct Rule {
  KindSet a, b;
  Method method;
  std::array<Exactness, 3> exactness;  // collide, distance, contacts
  DirectBothOrders direct{};
  CollideTest collides = CollideTest::none;
  LaneGroup lanes = LaneGroup::none;
};

constexpr std::array<Exactness, 3> every(Exactness e) { return {e, e, e}; }
constexpr std::array<Exactness, 3> to_rounding = every(Exactness::rounding);
constexpr std::array<Exactness, 3> least_found = {Exactness::rounding, Exactness::least_found, Exactness::least_found};
constexpr std::array<Exactness, 3> separating = {Exactness::rounding, Exactness::separating, Exactness::separating};
constexpr std::array<Exactness, 3> exact_separating = {Exactness::exact, Exactness::separating, Exactness::separating};

// The first rule that matches a pair gives its method; the methods of other matching rules can be named by options.
// Where a rule has a direct solver, the kind that ranks first (pair_order.h) comes first.
constexpr std::array rules = std::to_array<Rule>({
    {kinds(voxels), kinds(halfspace), Method::cells, to_rounding},
    {kinds(voxels), all_kinds, Method::cells, separating},
    {kinds(mesh), kinds(mesh, triangle), Method::bvh, exact_separating},
    {kinds(mesh), kinds(halfspace), Method::bvh, to_rounding},
    {kinds(mesh), kinds(plane), Method::bvh, separating},
    {kinds(mesh), all_kinds, Method::bvh, separating},
    {kinds(halfspace, plane),
     kinds(halfspace, plane),
     Method::closed,
     {Exactness::rounding, Exactness::refused, Exactness::refused},
     {},
     CollideTest::unbounded},
    {kinds(plane), bounded, Method::closed, to_rounding},
    {kinds(halfspace), kinds(sphere), Method::closed, to_rounding, direct<solve_halfspace_sphere>, CollideTest::none,
     LaneGroup::halfspace_sphere},
    {kinds(halfspace), kinds(box), Method::closed, to_rounding, direct<solve_halfspace_box>, CollideTest::none,
     LaneGroup::halfspace_box},
    {kinds(halfspace), bounded, Method::closed, to_rounding},
    {kinds(sphere), kinds(sphere), Method::closed, to_rounding, direct<solve_spheres>, CollideTest::none,
     LaneGroup::spheres},
    {kinds(sphere), kinds(box), Method::closed, to_rounding, direct<solve_sphere_box>},
    {kinds(sphere), kinds(capsule), Method::closed, to_rounding, direct<solve_sphere_capsule>},
    {kinds(sphere), kinds(cylinder, cone, triangle), Method::closed, to_rounding},
    {kinds(box), kinds(capsule), Method::closed, to_rounding, direct<solve_box_capsule>},
    {kinds(capsule), kinds(capsule), Method::closed, to_rounding, direct<solve_capsules>},
    {kinds(box), kinds(box), Method::sat, to_rounding, direct<solve_boxes>, CollideTest::none, LaneGroup::boxes},
    {kinds(box), kinds(triangle), Method::sat, to_rounding, {}, CollideTest::box_triangle},
    {kinds(triangle),
     kinds(triangle),
     Method::sat,
     {Exactness::exact, Exactness::rounding, Exactness::rounding},
     {},
     CollideTest::triangles},
    {kinds(ellipsoid), kinds(sphere), Method::newton, least_found},
    {newtonian, without(bounded, kinds(sphere)), Method::newton, least_found},
    {flat, flat, Method::gjk, to_rounding},
    {bounded, bounded, Method::gjk, every(Exactness::bounded)},
    {bounded, bounded, Method::fcl, every(Exactness::unknown)},
    {bounded, bounded, Method::libccd, every(Exactness::unknown)},
    {bounded, bounded, Method::mpr, every(Exactness::unknown)},
});

/// True if the rule matches the pair in this order: rules with a direct solver for two different kinds are written in
/// one order.
constexpr bool holds(const Rule& rule, ShapeKind a, ShapeKind b) { return rule.a.has(a) && rule.b.has(b); }

constexpr PairSolver compile(ShapeKind a, ShapeKind b) {
  for (const Rule& rule : rules) {
    if (!holds(rule, a, b) && !holds(rule, b, a)) continue;
    if (rule.direct.forward != nullptr && rank(a) <= rank(b) && !holds(rule, a, b)) throw "a direct rule out of order";
    DirectSolver* solver = rank(a) <= rank(b) ? rule.direct.forward : rule.direct.exchanged;
    const bool exact = rule.exactness[static_cast<std::size_t>(Request::collide)] == Exactness::exact;
    return {rule.method,    rule.collides, rule.lanes,
            rule.exactness, solver,        rule.method == Method::cells || (rule.method == Method::bvh && exact)};
  }
  throw "two kinds without a rule";
}

const Rule* find_rule(Method method, ShapeKind a, ShapeKind b) {
  for (const Rule& rule : rules)
    if (rule.method == method && (holds(rule, a, b) || holds(rule, b, a))) return &rule;
  return nullptr;
}

// Measured over 400 pairs of each two kinds, 80 a class; the error is three times the largest observed, and at least
// the tolerance the solver ran with. Only rows that save a fifth of the time are kept: for verdicts none does. FCL has
// none: on pairs that nearly touch its own assertions end the process.
constexpr SolverRow measured(ShapeKind a, ShapeKind b, Request request, Method method, double tolerance,
                             double nanoseconds, double error) {
  return {a, b, request, name(method), tolerance, nanoseconds, error, Exactness::bounded};
}
// By pair of kinds and request, the cheapest first.
constexpr std::array measured_rows = std::to_array<SolverRow>({
    measured(capsule, cylinder, Request::distance, Method::gjk, 0.01, 2952, 3e-02),
    measured(capsule, cylinder, Request::distance, Method::gjk, 0.001, 4126, 2e-03),
    measured(capsule, cone, Request::distance, Method::gjk, 0.01, 2422, 1e-02),
    measured(ellipsoid, ellipsoid, Request::distance, Method::gjk, 0.001, 3875, 1e-03),
});

/// The cheapest measured row whose error is within the tolerance; null if there is none.
const SolverRow* cheapest_row(ShapeKind a, ShapeKind b, Request request, double tolerance) {
  for (const SolverRow& row : measured_rows)
    if (row.a == std::min(a, b) && row.b == std::max(a, b) && row.request == request && row.error <= tolerance)
      return &row;
  return nullptr;
}

}  // namespace

constinit const std::array<std::array<PairSolver, shape_kinds>, shape_kinds> pair_solvers = [] {
  std::array<std::array<PairSolver, shape_kinds>, shape_kinds> table{};
  for (std::size_t a = 0; a < shape_kinds; ++a)
    for (std::size_t b = 0; b < shape_kinds; ++b)
      table[a][b] = compile(static_cast<ShapeKind>(a), static_cast<ShapeKind>(b));
  return table;
}();

bool covers(Method method, ShapeKind a, ShapeKind b) { return find_rule(method, a, b) != nullptr; }

Exactness exactness(Method method, ShapeKind a, ShapeKind b, Request request) {
  return find_rule(method, a, b)->exactness[static_cast<std::size_t>(request)];
}

MethodChoice choose_method(ShapeKind a, ShapeKind b, Request request, const NarrowPhaseOptions& options) {
  if (!options.solver.empty()) {
    if (const auto named = find_method(options.solver); named && covers(*named, a, b))
      return {*named, options.tolerance, nullptr};
  } else if (options.tolerance > 0) {
    if (const SolverRow* row = cheapest_row(a, b, request, options.tolerance))
      return {*find_method(row->solver), row->tolerance, row};
  }
  return {pair_solver(a, b).method, options.tolerance, nullptr};
}

std::span<const SolverRow> solver_rows() { return measured_rows; }

}  // namespace tandem
