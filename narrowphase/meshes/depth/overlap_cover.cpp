// Proves lower bounds on the depth of two meshes by covering the shorter translations.
#include "meshes/depth/overlap_cover.h"

#include <algorithm>
#include <cmath>

#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t most_balls = 128;  // of a mesh
constexpr std::size_t none = ~std::size_t{0};

// A cube much smaller than the shortest known translation, of which hardly any part is proven to overlap: either an
// ascent ended at a low maximum, or a separating translation is near.
constexpr double small = 0.05, hardly = 0.25;
constexpr std::size_t between = 16;  // cubes between two searches
constexpr double far_step = 0.05;    // of an ascent from anywhere, relative to that translation

// The centre of one of the eight parts of a cube.
Vec3 middle_of_part(const Vec3& middle, double half, int k) {
  return middle + half / 2 * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
}

// The point of the segment between two vectors nearest to zero.
Vec3 least_between(const Vec3& p, const Vec3& q) {
  const Vec3 segment = q - p;
  const double length2 = segment.squaredNorm();
  if (!(length2 > 0)) return p;
  return p + std::clamp(-p.dot(segment) / length2, 0.0, 1.0) * segment;
}

}  // namespace

OverlapCover::OverlapCover(const DepthField& a, const DepthField& b, double length, Bodies bodies)
    : a_(a),
      b_(b),
      bodies_(std::move(bodies)),
      length_(length),
      least_half_(length / 64),
      balls_a_(inner_balls(a, most_balls)),
      balls_b_(inner_balls(b, most_balls)) {
  for (int k = 0; k < 8; ++k) push(middle_of_part(Vec3::Zero(), length, k), length / 2, none);
}

void OverlapCover::push(const Vec3& middle, double half, std::size_t proof) {
  const double nearest = (middle.cwiseAbs().array() - half).max(0).matrix().norm();
  (half >= least_half_ ? large_ : small_).push({nearest, numbered_++, middle, half, proof});
}

// No translation in the cubes that are not open is shorter than `wanted_` and separates.
double OverlapCover::raise_certain() {
  const double nearest =
      std::min(small_.empty() ? infinity : small_.top().nearest, large_.empty() ? infinity : large_.top().nearest);
  certain_ = std::max(certain_, std::min(wanted_, nearest));
  return nearest;
}

// Takes the nearest open cube, three times out of four among the large ones, if there are any: about the tip of a
// narrow gap cubes get ever smaller, and free translations lie in the larger ones beside them.
bool OverlapCover::pop(Cell& cell) {
  constexpr std::size_t turn = 4;
  if (raise_certain() >= wanted_) return false;
  const auto matters = [&](const std::priority_queue<Cell>& cells) {
    return !cells.empty() && cells.top().nearest < wanted_;
  };
  if (!matters(large_)) {
    least_half_ /= 4;
    for (; matters(small_); small_.pop()) large_.push(small_.top());
  }
  std::priority_queue<Cell>& from = examined_ % turn == 0 && matters(small_) ? small_ : large_;
  cell = from.top();
  from.pop();
  return true;
}

// Only translations as long as `wanted_` count. For these x, |x - m|^2 = x^2 - 2 m.x + m^2 is bounded by the length of
// x and the minimum of m.x in the cube.
bool OverlapCover::covers(const Proof& proof, const Cell& cell) const {
  const Vec3 m = proof.middle();
  const double far2 = ((cell.middle - m).cwiseAbs().array() + cell.half).matrix().squaredNorm();
  const double least = m.dot(cell.middle) - cell.half * m.lpNorm<1>();
  const double both = wanted_ * wanted_ + m.squaredNorm();
  const double cap2 = both - 2 * least + 8 * epsilon * both;  // reduced by a bound on rounding
  const double radius = proof.radius();
  return radius > 0 && std::min(far2, cap2) <= radius * radius;
}

OverlapCover::Proof OverlapCover::best_known(const Vec3& move, std::size_t first) const {
  Proof best;
  double most = -infinity;
  const auto take = [&](const Proof& proof) {
    if (const double r = proof.at(move); r > most) most = r, best = proof;
  };
  if (first != none) take(proofs_[first]);
  constexpr std::size_t recent = 64;
  for (std::size_t k = proofs_.size() - std::min(recent, proofs_.size()); k < proofs_.size(); ++k) take(proofs_[k]);
  for (const Ball& a : balls_a_) {
    const Vec3 m = a.centre - move;
    for (const Ball& b : balls_b_) {
      const double sum = a.radius + b.radius;
      const double slack = sum - most, d2 = (m - b.centre).squaredNorm();
      if (slack > 0 && d2 < slack * slack) most = sum - std::sqrt(d2), best = {a.centre, b.centre, a.radius, b.radius};
    }
  }
  return best;
}

OverlapCover::Proof OverlapCover::prove_near(const Vec3& p, const Vec3& move) const {
  const DepthAt a = a_.at(p), b = b_.at(p - move);
  return {p, p - move, a.depth, b.depth, a.inward, b.inward};
}

// Ascends along the gradient of the sum of the depths in A and in B, or, where that is steep on both sides as on a
// ridge, along the shortest vector of the gradients there (Wolfe, A method of conjugate subgradients, 1975).
OverlapCover::Proof OverlapCover::climb(const SharedPlace& from, const Vec3& move, double step,
                                        const std::function<bool(const Proof&)>& enough) const {
  constexpr int most_steps = 24;
  const double least_step = tolerance::last_climb * step;
  Proof here = prove_near(from.at, move);
  Vec3 direction = from.inward.isZero(0) ? here.inward() : from.inward;
  for (int i = 0; i < most_steps && !enough(here); ++i) {
    const double length = direction.norm();
    if (step < least_step || !(length > tolerance::near_surface)) break;
    const Proof there = prove_near(here.of_a + step / length * direction, move);
    if (there.radius() > here.radius()) {
      here = there;
      direction = there.inward();
      step *= 1.5;
    } else {
      direction = least_between(direction, there.inward());
      step *= 0.6;
    }
  }
  return here;
}

// The initial point lies between the balls' centres, equally deep in both.
OverlapCover::Proof OverlapCover::search_proof(Proof best, const Vec3& move, const Cell& cell) {
  const auto enough = [&](const Proof& proof) { return covers(proof, cell); };
  const Vec3 apart = best.of_b + move - best.of_a;
  const double distance = apart.norm();
  const double part = distance > 0 ? std::clamp((best.in_a - best.in_b + distance) / (2 * distance), 0.0, 1.0) : 0.0;
  best = climb({best.of_a + part * apart, Vec3::Zero()}, move, cell.half, enough);
  if (best.radius() > 0) return best;
  const std::vector<SharedPlace> places = bodies_.shared_places(move);
  if (places.empty()) length_ = std::min(length_, bodies_.shorten(move));
  for (const SharedPlace& place : places) {
    const Proof proof = climb(place, move, std::max(cell.half, far_step * length_), enough);
    if (proof.radius() > best.radius()) best = proof;
    if (covers(best, cell)) break;
  }
  return best;
}

// If ascents end at lower maxima: examines first the cubes in which the sum of the depths, whose Lipschitz constant is
// 2, may be largest (Piyavskii, An algorithm for finding the absolute extremum of a function, 1972).
OverlapCover::Proof OverlapCover::prove_anywhere(const Vec3& move, const Cell& cell, const Proof& known) const {
  constexpr int most_points = 400;
  constexpr double better = 2;  // factor over the known value that is worth an ascent
  struct Cube {
    double most;
    int number;
    Vec3 middle;
    double half;
    bool operator<(const Cube& o) const { return most != o.most ? most < o.most : number > o.number; }
  };
  const auto enough = [&](const Proof& proof) { return covers(proof, cell); };
  std::priority_queue<Cube> open;
  Proof best = known;
  int points = 0;
  const auto add = [&](const Vec3& middle, double half) {
    const Proof proof = prove_near(middle, move);
    const double reach = std::sqrt(3.0) * half;
    if (proof.in_a + reach > 0 && proof.in_b + reach > 0) open.push({proof.radius() + 2 * reach, points, middle, half});
    ++points;
    if (proof.radius() > better * std::max(best.radius(), 0.0))
      best = climb({middle, Vec3::Zero()}, move, half, enough);
  };
  const Bounds a = a_.box(), b = b_.box();
  const Vec3 lo = a.lo.cwiseMax(b.lo + move), hi = a.hi.cwiseMin(b.hi + move);
  if (((hi - lo).array() < 0).any()) return best;
  add((lo + hi) / 2, (hi - lo).maxCoeff() / 2);
  while (!open.empty() && points < most_points && !covers(best, cell)) {
    const Cube cube = open.top();
    open.pop();
    if (cube.most <= better * std::max(best.radius(), 0.0)) break;
    for (int k = 0; k < 8; ++k) add(middle_of_part(cube.middle, cube.half, k), cube.half / 2);
  }
  return best;
}

// Moves out of the deepest overlap, and of the next, as long as that gives a shorter translation than the known one.
void OverlapCover::leave(const Vec3& move, Proof proof) {
  constexpr int rounds = 6;
  Vec3 to = move;
  for (int i = 0; i < rounds; ++i) {
    const Vec3 out = proof.inward_b - proof.inward_a;
    const double length = out.norm();
    if (!(length > tolerance::near_surface)) return;
    to += (1.05 * proof.radius() + tolerance::near_apart * length_) / length * out;
    if (!(to.norm() < length_)) return;
    const std::vector<SharedPlace> places = bodies_.shared_places(to);
    if (places.empty()) {
      length_ = std::min(length_, bodies_.shorten(to));
      return;
    }
    proof = climb(places[places.size() / 2], to, far_step * length_, [](const Proof&) { return false; });
  }
}

// Moves either ball deeper as long as the ball of translations grows and nearly contains the smaller one.
void OverlapCover::grow(Proof& proof, const Cell& cell) const {
  constexpr double nearly = 0.9;
  constexpr int most_steps = 8;
  for (const bool of_a : {true, false}) {
    double step = std::max(of_a ? proof.in_a : proof.in_b, cell.half);
    for (int i = 0; i < most_steps; ++i, step *= 2) {
      Proof next = proof;
      Vec3& centre = of_a ? next.of_a : next.of_b;
      Vec3& inward = of_a ? next.inward_a : next.inward_b;
      double& depth = of_a ? next.in_a : next.in_b;
      const double before = depth;
      centre += step * inward;
      const DepthAt there = (of_a ? a_ : b_).at(centre);
      depth = there.depth;
      inward = there.inward;
      if (!(depth > before + nearly * step) || !covers(next, cell)) break;
      proof = next;
    }
  }
}

void OverlapCover::search(double part, std::size_t most) {
  Cell cell;
  wanted_ = part * length_;
  for (std::size_t i = 0; i < most && pop(cell); ++i, wanted_ = part * length_) {
    ++examined_;
    // The relevant part of the cell is nearest to this.
    const double away = cell.middle.norm();
    const Vec3 move = away > wanted_ ? Vec3(wanted_ / away * cell.middle) : cell.middle;
    Proof proof = best_known(move, cell.proof);
    if (covers(proof, cell)) continue;
    proof = search_proof(proof, move, cell);
    const bool search_on =
        proof.radius() < hardly * cell.half && cell.half < small * length_ && examined_ >= searched_on_at_ + between;
    if (search_on) {
      searched_on_at_ = examined_;
      proof = prove_anywhere(move, cell, proof);
    }
    if (covers(proof, cell)) {
      grow(proof, cell);
      if (search_on) {
        balls_a_.push_back({proof.of_a, proof.in_a});
        balls_b_.push_back({proof.of_b, proof.in_b});
      }
      proofs_.push_back(proof);
      continue;
    }
    std::size_t number = cell.proof;
    if (proof.radius() > 0) {
      number = proofs_.size();
      proofs_.push_back(proof);
      if (search_on) leave(move, proof);
    }
    for (int k = 0; k < 8; ++k) push(middle_of_part(cell.middle, cell.half, k), cell.half / 2, number);
  }
  raise_certain();
}

}  // namespace tandem
