// Spheres with spheres and half-spaces, a pair a lane (vector kernel).
#include "dispatch/sphere_lanes.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "lanes/lanes_of_256_bits.h"
#include "tolerances.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "dispatch/sphere_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(SphereFindings::most % hn::MaxLanes(D()) == 0 && hn::MaxLanes(D()) <= 8);
static_assert(SeveralPairs::most_screened % hn::MaxLanes(D()) == 0);
static_assert(sizeof(PlacedSphere) == 4 * sizeof(double) && offsetof(PlacedHalfspace, sense) == 7 * sizeof(double));

/// The answers of some pairs.
struct SphereAnswers {
  V distance, on_a[3], on_b[3], normal[3];
  M no_direction;
  V scale;  ///< the scale of rounding errors

  template <std::size_t most>
  HWY_INLINE void store(std::size_t at, AnswerRows<most>& answers, ContactRows<most>& contacts) const {
    V middle[3];
    for (int k = 0; k < 3; ++k) middle[k] = hn::Mul(number(0.5), hn::Add(on_a[k], on_b[k]));
    store_in_turn(distance, on_a[0], on_a[1], on_a[2], at, answers.first);
    store_in_turn(on_b[0], on_b[1], on_b[2], normal[0], at, answers.second);
    store_in_turn(middle[0], middle[1], middle[2], normal[0], at, contacts.first);
    store_in_turn(normal[1], normal[2], hn::Neg(distance), hn::Zero(D()), at, contacts.second);
  }
  /// Bits of those that must be solved separately, and of those farther apart than the margin.
  HWY_INLINE std::uint8_t unknown() const {
    const M undecided = hn::Le(hn::Abs(distance), hn::Mul(number(tolerance::undecided), scale));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(D(), hn::Or(undecided, no_direction), bits);
    return bits[0];
  }
  HWY_INLINE std::uint8_t far(double margin) const {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(D(), hn::Gt(distance, number(margin)), bits);
    return bits[0];
  }
  HWY_INLINE void store(double margin, std::size_t at, SphereFindings& found) const {
    store(at, found.answers, found.contacts);
    const std::uint8_t alone = unknown(), apart = far(margin);
    for (std::size_t lane = 0; lane < lanes; ++lane)
      found.finding[at + lane] = (alone >> lane & 1) != 0   ? SphereFindings::unknown
                                 : (apart >> lane & 1) != 0 ? SphereFindings::apart
                                                            : SphereFindings::touching;
  }
};

/// An upper bound on the scale of spheres with this sum of radii and this offset.
HWY_INLINE V scale_of(V radii, const V* offset) {
  const V far = hn::Add(hn::Add(hn::Abs(offset[0]), hn::Abs(offset[1])), hn::Abs(offset[2]));
  return hn::Add(hn::Mul(number(4), radii), far);
}

// NOLINTBEGIN(misc-definitions-in-headers): included once a target
std::uint32_t near_spheres(std::span<const PlacedSpheres> pairs, double margin) {
  const D d;
  std::uint32_t near = 0;
  for (std::size_t at = 0; at < pairs.size(); at += lanes) {
    const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.size() - 1); };
    V a[4], b[4], offset[3];
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].a->centre.data(); }, a);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].b->centre.data(); }, b);
    for (int k = 0; k < 3; ++k) offset[k] = hn::Sub(b[k], a[k]);
    const V far = hn::Add(hn::Add(a[3], b[3]), number(margin));
    const V far2 = hn::Mul(hn::Mul(far, far), number(1 + tolerance::certain));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::And(hn::Le(dot(offset, offset), far2), hn::FirstN(d, pairs.size() - at)), bits);
    near |= std::uint32_t{bits[0]} << at;
  }
  return near;
}

// As solve_spheres.
HWY_INLINE SphereAnswers meet(const V* a, const V* b) {
  V offset[3];
  for (int k = 0; k < 3; ++k) offset[k] = hn::Sub(b[k], a[k]);
  const V length = hn::Sqrt(dot(offset, offset)), reach = hn::Add(a[3], b[3]);
  SphereAnswers answers;
  answers.distance = hn::Sub(length, reach);
  for (int k = 0; k < 3; ++k) {
    answers.normal[k] = hn::Div(offset[k], length);
    answers.on_a[k] = hn::Add(a[k], hn::Mul(a[3], answers.normal[k]));
    answers.on_b[k] = hn::Sub(b[k], hn::Mul(b[3], answers.normal[k]));
  }
  answers.no_direction = hn::Or(hn::Le(length, number(tolerance::shortest_squared)),
                                hn::Ge(length, number(1 / tolerance::shortest_squared)));
  answers.scale = scale_of(reach, offset);
  return answers;
}

void find_on_spheres(std::span<const SpherePair> pairs, double margin, SphereFindings& found) {
  for (std::size_t at = 0; at < pairs.size(); at += lanes) {
    const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.size() - 1); };
    V a[4], b[4];
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].a.centre.data(); }, a);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].b.centre.data(); }, b);
    meet(a, b).store(margin, at, found);
  }
}

SpheresSolved solve_spheres(std::span<const PlacedSpheres> pairs, double margin, const AnswerPlaces& to) {
  AnswerRows<lanes> rows;
  ContactRows<lanes> contact_rows;
  SpheresSolved solved;
  char* place = reinterpret_cast<char*>(to.answers);
  for (std::size_t at = 0; at < pairs.size(); at += lanes) {
    const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.size() - 1); };
    V a[4], b[4];
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].a->centre.data(); }, a);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].b->centre.data(); }, b);
    const SphereAnswers answers = meet(a, b);
    const std::size_t count = std::min(lanes, pairs.size() - at);
    const std::uint32_t all = (std::uint32_t{1} << count) - 1, alone = answers.unknown() & all;
    answers.store(0, rows, contact_rows);
    const std::uint32_t known = alone == 0 ? all : (alone & -alone) - 1;
    for (std::uint32_t near = known & ~std::uint32_t{answers.far(margin)}; near != 0; near &= near - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(near));
      PairAnswer& answer = *reinterpret_cast<PairAnswer*>(place);
      rows.copy(lane, contact_rows, answer);
      answer.collide = answer.signed_distance <= 0;
      contact_rows.copy(lane, to.contacts[solved.answers]);
      to.pairs[solved.answers++] = static_cast<std::uint32_t>(at + lane);
      place += to.stride;
    }
    solved.pairs = at + static_cast<std::size_t>(std::popcount(known));
    if (alone != 0) break;
  }
  return solved;
}

// As halfspace_sphere.
void find_spheres_on_halfspaces(std::span<const HalfspaceSphere> pairs, double margin, SphereFindings& found) {
  const D d;
  for (std::size_t at = 0; at < pairs.size(); at += lanes) {
    const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.size() - 1); };
    V plane[8], sphere[4], to_centre[3];
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].halfspace->normal.data(); }, plane);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs[nth(i)].sphere.centre.data(); }, sphere);
    const V *const normal = plane, *const origin = plane + 4, offset = plane[3], sense = plane[7], radius = sphere[3];
    for (int k = 0; k < 3; ++k) to_centre[k] = hn::Sub(sphere[k], origin[k]);
    const M sphere_first = hn::Lt(sense, hn::Zero(d));
    SphereAnswers answers;
    answers.distance = hn::Sub(hn::Sub(dot(normal, to_centre), offset), radius);
    for (int k = 0; k < 3; ++k) {
      const V on_sphere = hn::Sub(sphere[k], hn::Mul(radius, normal[k]));
      const V on_halfspace = hn::Sub(on_sphere, hn::Mul(answers.distance, normal[k]));
      answers.normal[k] = hn::Mul(sense, normal[k]);
      answers.on_a[k] = hn::IfThenElse(sphere_first, on_sphere, on_halfspace);
      answers.on_b[k] = hn::IfThenElse(sphere_first, on_halfspace, on_sphere);
    }
    answers.no_direction = hn::Lt(radius, hn::Zero(d));
    answers.scale = scale_of(radius, to_centre);
    answers.store(margin, at, found);
  }
}
// NOLINTEND(misc-definitions-in-headers)

#else

// NOLINTBEGIN(misc-definitions-in-headers): included once a target
std::uint32_t near_spheres(std::span<const PlacedSpheres> pairs, double) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << pairs.size()) - 1);
}
SpheresSolved solve_spheres(std::span<const PlacedSpheres>, double, const AnswerPlaces&) { return {}; }
void find_on_spheres(std::span<const SpherePair> pairs, double, SphereFindings& found) {
  std::fill_n(found.finding, pairs.size(), SphereFindings::unknown);
}
void find_spheres_on_halfspaces(std::span<const HalfspaceSphere> pairs, double, SphereFindings& found) {
  std::fill_n(found.finding, pairs.size(), SphereFindings::unknown);
}
// NOLINTEND(misc-definitions-in-headers)

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(near_spheres);
HWY_EXPORT(solve_spheres);
HWY_EXPORT(find_on_spheres);
HWY_EXPORT(find_spheres_on_halfspaces);

std::uint32_t near_spheres(std::span<const PlacedSpheres> pairs, double margin) {
  return HWY_DYNAMIC_DISPATCH(near_spheres)(pairs, margin);
}
SpheresSolved solve_spheres(std::span<const PlacedSpheres> pairs, double margin, const AnswerPlaces& to) {
  return HWY_DYNAMIC_DISPATCH(solve_spheres)(pairs, margin, to);
}
void find_on_spheres(std::span<const SpherePair> pairs, double margin, SphereFindings& found) {
  HWY_DYNAMIC_DISPATCH(find_on_spheres)(pairs, margin, found);
}
void find_spheres_on_halfspaces(std::span<const HalfspaceSphere> pairs, double margin, SphereFindings& found) {
  HWY_DYNAMIC_DISPATCH(find_spheres_on_halfspaces)(pairs, margin, found);
}

bool SphereFindings::append(std::size_t k, std::size_t number, std::vector<Contact>& to, AnswerSink& sink) const {
  if (finding[k] != touching) return finding[k] == apart;
  PairAnswer& answer = sink.begin(number);
  answers.copy(k, contacts, answer);
  answer.collide = answer.signed_distance <= 0;
  contacts.copy(k, to.emplace_back());
  sink.end();
  return true;
}
}  // namespace tandem
#endif
