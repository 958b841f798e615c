// The entry point of the narrow phase: choice of the solver by kinds and request, verdict, cut-off and limit.
#include "tandem/narrowphase/narrow_phase.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "boxes/box_screen.h"
#include "dispatch/rounded_pair.h"
#include "dispatch/voxel_pair.h"
#include "meshes/mesh_pair.h"
#include "pairs/centre_test.h"
#include "pairs/convex_pair.h"
#include "pairs/solver_table.h"
#include "shapes/convex_view.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/undecided.h"
#include "shapes/unit_vector.h"
#include "shapes/without_hull.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tolerances.h"
#include "triangles/triangle_axes.h"

namespace tandem {
namespace {

bool triangular(const Shape& s) { return s.kind() == ShapeKind::triangle || s.kind() == ShapeKind::mesh; }

/// The extent of a half-space or plane along its normal, or against it.
double extent_along(const Shape& s, bool along) {
  if (along) return s.offset() + s.rounding();
  return s.kind() == ShapeKind::plane ? s.rounding() - s.offset() : std::numeric_limits<double>::infinity();
}

/// Two half-spaces or planes are disjoint only if their normals are equal or opposite.
bool unbounded_collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const Vec3 na = pose_a.rotation * a.normal(), nb = pose_b.rotation * b.normal();
  const bool alike = na == nb;
  if (!alike && na != -nb) return true;
  const double between = na.dot(pose_b.translation - pose_a.translation);
  return extent_along(a, true) + extent_along(b, !alike) >= between &&
         extent_along(a, false) + extent_along(b, alike) >= -between;
}

std::string refusal(const Shape& a, const Shape& b, Request request) {
  if (!is_refused(pair_solver(a.kind(), b.kind()), request)) return {};
  return std::string(name(a.kind())) + " with " + std::string(name(b.kind())) + ": " + std::string(name(request)) +
         " is not defined, no finite translation separates them unless their normals are opposite";
}

/// True if the test of centres answers the request without a manifold.
bool answered_by_centres(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                         double margin, PairAnswer& answer) {
  const bool contacts = request == Request::contacts;
  const CentreTest test = test_centres(a, pose_a, b, pose_b, contacts ? margin : 0);
  if (test.verdict == CentreTest::Verdict::apart) {
    if (contacts) {
      answer.normal = unit(test.between);
      answer.signed_distance = separation(a, pose_a, b, pose_b, answer.normal);
    }
    return true;
  }
  answer.collide = !contacts && test.verdict == CentreTest::Verdict::overlapping;
  return answer.collide;
}

/// True if the shapes are separated along the direction of the last answer.
bool still_apart(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const WarmStart& warm) {
  const double length = warm.direction.norm();
  if (!(length > 0)) return false;
  const double reach = a.size() + b.size() + (pose_b.translation - pose_a.translation).norm();
  return separation(a, pose_a, b, pose_b, pose_a.rotation * unit(warm.direction, length)) > tolerance::certain * reach;
}

/// The corners of a triangle that has three.
std::optional<std::span<const Vec3, 3>> corners(const Shape& s) {
  if (s.kind() != ShapeKind::triangle || hull_of(s).vertices.size() != 3) return std::nullopt;
  return std::span<const Vec3, 3>(hull_of(s).vertices);
}

/// The verdict by the quick test for the two kinds; empty if there is none, and if rounding could decide.
std::optional<bool> collide_by_test(CollideTest test, const Shape& a, const Pose& pose_a, const Shape& b,
                                    const Pose& pose_b, const NarrowPhaseOptions& options) {
  switch (test) {
    case CollideTest::none:
      break;
    case CollideTest::unbounded:
      return unbounded_collide(a, pose_a, b, pose_b);
    case CollideTest::triangles: {
      const auto in_a = corners(a), in_b = corners(b);
      const auto by_axes = in_a && in_b ? triangles_collide(*in_a, pose_a, *in_b, pose_b) : std::nullopt;
      return by_axes ? *by_axes : !mesh_triangle_pairs(a, pose_a, b, pose_b, options).empty();
    }
    case CollideTest::box_triangle:
      if (const auto in_a = corners(a)) return box_triangle_collide(b.parameters(), pose_b, *in_a, pose_a);
      if (const auto in_b = corners(b)) return box_triangle_collide(a.parameters(), pose_a, *in_b, pose_b);
      break;
  }
  return std::nullopt;
}

/// By the method of the two kinds, or the one that the options name. Kept apart so that pairs with a direct solver do
/// not pay for it.
[[gnu::noinline]] PairAnswer solve_by_method(const PairSolver& pair, const Shape& a, const Pose& pose_a, const Shape& b,
                                             const Pose& pose_b, Request request, const NarrowPhaseOptions& options,
                                             std::vector<Contact>* contacts, WarmStart* warm) {
  if (pair.method == Method::cells) return solve_voxels(a, pose_a, b, pose_b, request, options, contacts);
  if (pair.method == Method::bvh) return solve_mesh(a, pose_a, b, pose_b, request, options, contacts);
  if (is_refused(pair, request)) throw std::invalid_argument(refusal(a, b, request));
  const bool unforced = options.solver.empty();
  PairAnswer plain;
  if (request == Request::collide && (unforced || pair.collides == CollideTest::unbounded))
    if (const auto collide = collide_by_test(pair.collides, a, pose_a, b, pose_b, options)) {
      plain.collide = *collide;
      return plain;
    }
  if (unforced && a.is_bounded() && b.is_bounded()) {
    if (request == Request::collide && warm != nullptr && still_apart(a, pose_a, b, pose_b, *warm)) return plain;
    if (request != Request::distance && answered_by_centres(a, pose_a, b, pose_b, request, options.margin, plain))
      return plain;
  }
  return solve_convex(view(a), pose_a, view(b), pose_b, request, options, contacts, warm);
}

/// One request on its own: near a touch its verdict may differ from those of others.
[[gnu::always_inline]] inline PairAnswer solve_request(const PairSolver& pair, const Shape& a, const Pose& pose_a,
                                                       const Shape& b, const Pose& pose_b, Request request,
                                                       const NarrowPhaseOptions& options,
                                                       std::vector<Contact>* contacts, WarmStart* warm) {
  if (options.solver.empty() && pair.direct != nullptr)
    return pair.direct(a.parameters(), pose_a, b.parameters(), pose_b, request, options.margin, contacts);
  return solve_by_method(pair, a, pose_a, b, pose_b, request, options, contacts, warm);
}

/// Gives an answer whose sign rounding decided the verdict of Request::collide, so that all requests agree. The
/// contacts are those from `first` on.
[[gnu::noinline]] void take_verdict(const PairSolver& pair, const Shape& a, const Pose& pose_a, const Shape& b,
                                    const Pose& pose_b, Request request, const NarrowPhaseOptions& options,
                                    PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first,
                                    double within) {
  constexpr double apart = std::numeric_limits<double>::min();
  answer.collide = solve_request(pair, a, pose_a, b, pose_b, Request::collide, options, nullptr, nullptr).collide;
  answer.signed_distance =
      answer.collide ? std::min(answer.signed_distance, 0.0) : std::max(answer.signed_distance, apart);
  if (request != Request::contacts) return;
  if (!answer.collide) {
    if (options.margin == 0) contacts->resize(first);
    for (Contact& c : std::span(*contacts).subspan(first)) c.depth = std::min(c.depth, -apart);
    return;
  }
  if (contacts->size() == first) {
    NarrowPhaseOptions wider = options;
    wider.margin = within;
    const PairAnswer touch = solve_request(pair, a, pose_a, b, pose_b, request, wider, contacts, nullptr);
    answer.point_a = touch.point_a;
    answer.point_b = touch.point_b;
    answer.normal = touch.normal;
  }
  const std::span<Contact> found = std::span(*contacts).subspan(first);
  if (options.margin == 0)
    for (Contact& c : found) c.depth = std::max(c.depth, 0.0);
  else if (!found.empty())
    std::max_element(found.begin(), found.end(), [](const Contact& x, const Contact& y) {
      return x.depth < y.depth;
    })->depth = -answer.signed_distance;
}

/// A lower bound on the distance, by the boxes in world axes; seen from A's translation: far out, they would be rounded
/// by more than what is near lies apart.
double distance_of_bounds(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                          const WorkLimit* limit) {
  const Bounds p = quick_bounds(a, {pose_a.rotation, Vec3::Zero()}, limit),
               q = quick_bounds(b, {pose_b.rotation, pose_b.translation - pose_a.translation}, limit);
  return (q.lo - p.hi).cwiseMax(p.lo - q.hi).cwiseMax(0.0).norm();
}

/// Any request without a cut-off. Inlined: a call more is a tenth of the fastest queries.
[[gnu::always_inline]] inline PairAnswer solve_fully(const Shape& a, const Pose& pose_a, const Shape& b,
                                                     const Pose& pose_b, Request request,
                                                     const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                                                     WarmStart* warm) {
  const bool has_rounding = a.rounding() + b.rounding() > 0 && (a.is_bounded() || b.is_bounded());
  return has_rounding && !has_voxels(a, b) ? solve_rounded(a, pose_a, b, pose_b, request, options, contacts, warm)
                                           : solve_cores(a, pose_a, b, pose_b, request, options, contacts, warm);
}

/// Request::distance with a finite cut-off. Meshes that overlap are asked once more without it: which triangle is found
/// first depends on the cut-off, and their depth begins with it.
PairAnswer solve_within(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                        const NarrowPhaseOptions& options, WarmStart* warm) {
  if (has_voxels(a, b)) return solve_voxels(a, pose_a, b, pose_b, Request::distance, options, nullptr);
  PairAnswer farther;
  farther.farther = true;
  farther.signed_distance = options.cutoff;
  const double undecided = undecided_distance(a, pose_a, b, pose_b);
  if (a.is_bounded() && b.is_bounded() &&
      distance_of_bounds(a, pose_a, b, pose_b, options.limit) - undecided > options.cutoff)
    return farther;
  if (!a.is_convex() || !b.is_convex()) {
    const PairAnswer answer = solve_fully(a, pose_a, b, pose_b, Request::distance, options, nullptr, nullptr);
    if (answer.signed_distance > options.cutoff + undecided) return farther;
    if (answer.signed_distance > undecided) return answer.signed_distance > options.cutoff ? farther : answer;
  }
  NarrowPhaseOptions all = options;
  all.cutoff = std::numeric_limits<double>::infinity();
  const PairAnswer answer = solve_fully(a, pose_a, b, pose_b, Request::distance, all, nullptr, warm);
  return answer.signed_distance > options.cutoff ? farther : answer;
}

/// A query without a limit. Inlined as above.
[[gnu::always_inline]] inline PairAnswer solve_any(const Shape& a, const Pose& pose_a, const Shape& b,
                                                   const Pose& pose_b, Request request,
                                                   const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                                                   WarmStart* warm) {
  if (request == Request::distance && options.cutoff < std::numeric_limits<double>::infinity())
    return solve_within(a, pose_a, b, pose_b, options, warm);
  return solve_fully(a, pose_a, b, pose_b, request, options, contacts, warm);
}

/// A query that a work limit may end. Kept apart so that others do not pay for it.
[[gnu::noinline]] PairAnswer solve_limited(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                           Request request, const NarrowPhaseOptions& options,
                                           std::vector<Contact>* contacts, WarmStart* warm) {
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  try {
    // Two convex shapes are done within microseconds, but for large hulls deep in each other, which look later.
    if (!(a.is_convex() && b.is_convex())) WorkMeter(options.limit).spend();
    return solve_any(a, pose_a, b, pose_b, request, options, contacts, warm);
  } catch (const WorkStopped&) {
    if (contacts != nullptr) contacts->resize(first);
    PairAnswer stopped;
    stopped.status = Status::stopped;
    stopped.error_bound = std::numeric_limits<double>::infinity();
    return stopped;
  }
}

}  // namespace

PairAnswer solve_pair(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  return solve_any(a, pose_a, b, pose_b, request, options, contacts, nullptr);
}

PairAnswer solve_cores(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                       const NarrowPhaseOptions& options, std::vector<Contact>* contacts, WarmStart* warm) {
  const PairSolver& pair = pair_solver(a.kind(), b.kind());
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  PairAnswer answer = solve_request(pair, a, pose_a, b, pose_b, request, options, contacts, warm);
  if (request == Request::collide || pair.one_verdict) return answer;
  const double undecided = undecided_distance(a, pose_a, b, pose_b);
  if (std::abs(answer.signed_distance) <= undecided && !answer.normal.isZero(0))
    take_verdict(pair, a, pose_a, b, pose_b, request, options, answer, contacts, first, 4 * undecided);
  return answer;
}

std::string_view name(Request request) {
  switch (request) {
    case Request::collide:
      return "collide";
    case Request::distance:
      return "distance";
    default:
      return "contacts";
  }
}

std::string_view name(Exactness exactness) {
  switch (exactness) {
    case Exactness::exact:
      return "exact";
    case Exactness::rounding:
      return "to rounding";
    case Exactness::bounded:
      return "bounded";
    case Exactness::least_found:
      return "least found";
    case Exactness::separating:
      return "separating";
    case Exactness::unknown:
      return "unknown";
    default:
      return "refused";
  }
}

NarrowPhase::NarrowPhase(NarrowPhaseOptions options) : options_(std::move(options)) {
  if (!(options_.tolerance >= 0 && options_.tolerance <= 0.1))
    throw std::invalid_argument("tolerance: " + written(options_.tolerance) + " is not in [0, 0.1]");
  if (!(options_.margin >= 0) || !std::isfinite(options_.margin))
    throw std::invalid_argument("margin: " + written(options_.margin) + " is not finite and >= 0");
  if (!(options_.cutoff >= 0)) throw std::invalid_argument("cutoff: " + written(options_.cutoff) + " is not >= 0");
  if (!options_.solver.empty() && !find_method(options_.solver)) {
    std::string known;
    for (const SolverInfo& s : solvers()) known += (known.empty() ? "" : ", ") + std::string(s.name);
    constexpr std::size_t longest_quote = 64;
    throw std::invalid_argument("solver: \"" + options_.solver.substr(0, longest_quote) + "\" is none of " + known);
  }
}

const std::vector<SolverInfo>& NarrowPhase::solvers() {
  static const std::vector<SolverInfo> built = [] {
    std::vector<SolverInfo> list;
    for (const MethodRow& row : method_rows)
      if (is_built(row.method)) list.push_back(row.info);
    return list;
  }();
  return built;
}

std::string NarrowPhase::refuses(const Shape& a, const Shape& b, Request request) const {
  return refusal(a, b, request);
}

PairAnswer NarrowPhase::solve(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                              std::vector<Contact>* contacts, WarmStart* warm) const {
  std::vector<Contact> unwanted;
  if (request == Request::contacts && contacts == nullptr) contacts = &unwanted;
  if (options_.limit != nullptr) return solve_limited(a, pose_a, b, pose_b, request, options_, contacts, warm);
  return solve_any(a, pose_a, b, pose_b, request, options_, contacts, warm);
}

PairAnswer NarrowPhase::distance_within(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                        double cutoff) const {
  if (!(cutoff >= 0)) throw std::invalid_argument("cutoff: " + written(cutoff) + " is not >= 0");
  if (cutoff >= options_.cutoff) return solve(a, pose_a, b, pose_b, Request::distance);
  NarrowPhaseOptions options = options_;
  options.cutoff = cutoff;
  if (options.limit != nullptr)
    return solve_limited(a, pose_a, b, pose_b, Request::distance, options, nullptr, nullptr);
  return solve_within(a, pose_a, b, pose_b, options, nullptr);
}

void NarrowPhase::mark_apart(std::span<const PlacedPair> pairs, std::span<std::uint8_t> apart) const {
  std::fill(apart.begin(), apart.end(), std::uint8_t{0});
  if (!options_.solver.empty()) return;
  BoxPairList boxes;
  std::size_t place[BoxPairList::most];
  const auto screen = [&] {
    const std::uint32_t near = screen_boxes(boxes, options_.margin);
    for (std::size_t k = 0; k < boxes.count; ++k) apart[place[k]] = ~near >> k & 1u;
    boxes.count = 0;
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pair_solver(pairs[i].a->kind(), pairs[i].b->kind()).lanes != LaneGroup::boxes) continue;
    if (pairs[i].a->rounding() + pairs[i].b->rounding() > 0) continue;
    place[boxes.count] = i;
    boxes.add(pairs[i]);
    if (boxes.count == BoxPairList::most) screen();
  }
  screen();
}

std::vector<std::array<std::uint32_t, 2>> NarrowPhase::intersecting_triangles(const Shape& a, const Pose& pose_a,
                                                                              const Shape& b,
                                                                              const Pose& pose_b) const {
  for (const Shape* s : {&a, &b}) {
    if (!triangular(*s))
      throw std::invalid_argument("intersecting_triangles: " + std::string(tandem::name(s->kind())) +
                                  " has no triangles, a triangle or a mesh is needed");
    if (s->rounding() > 0)
      throw std::invalid_argument("intersecting_triangles: rounding " + written(s->rounding()) +
                                  ", a shape without rounding is needed");
  }
  return mesh_triangle_pairs(a, pose_a, b, pose_b, options_);
}

std::span<const SolverRow> NarrowPhase::table() { return solver_rows(); }

SolverRow NarrowPhase::solver_for(ShapeKind a, ShapeKind b, Request request) const {
  const MethodChoice choice = choose_method(a, b, request, options_);
  if (choice.row != nullptr) return *choice.row;
  return {
      a, b, request, tandem::name(choice.method), options_.tolerance, 0, 0, exactness(choice.method, a, b, request)};
}

}  // namespace tandem
