// Solves contacts as constraints on velocities, by sequential impulses.
#include "response/contact_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "response/parallel_blocks.h"
#include "scene/tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t pairs_a_block = 64;  // about 10 us

void apply(const Vec3& impulse, const Vec3& arm_a, const Vec3& arm_b, SolverBody& a, SolverBody& b) {
  a.velocity -= a.inverse_mass * impulse;
  a.angular_velocity.noalias() -= a.inverse_inertia * arm_a.cross(impulse);
  b.velocity += b.inverse_mass * impulse;
  b.angular_velocity.noalias() += b.inverse_inertia * arm_b.cross(impulse);
}

Vec3 relative_velocity(const Vec3& arm_a, const Vec3& arm_b, const SolverBody& a, const SolverBody& b) {
  return b.velocity + b.angular_velocity.cross(arm_b) - a.velocity - a.angular_velocity.cross(arm_a);
}

Vec3 any_perpendicular(const Vec3& unit) {
  int smallest = 0;
  unit.cwiseAbs().minCoeff(&smallest);
  return unit.cross(Vec3::Unit(smallest)).normalized();
}

}  // namespace

void ContactSolver::prepare_point(Point& point, const Contact& contact, const SolverBody& a,
                                  const SolverBody& b) const {
  point.arm_a = contact.point - a.centre;
  point.arm_b = contact.point - b.centre;
  point.normal = contact.normal;
  point.tangent = any_perpendicular(contact.normal);
  point.bitangent = contact.normal.cross(point.tangent);
  point.gap = -contact.depth;
  point.feature = contact.feature;
  point.normal_impulse = point.tangent_impulse = point.bitangent_impulse = 0;
  point.keeps = point.kept = false;

  const auto response = [&](const Vec3& along, const Vec3& pushed) {
    const Vec3 turn_a = a.inverse_inertia * point.arm_a.cross(pushed);
    const Vec3 turn_b = b.inverse_inertia * point.arm_b.cross(pushed);
    return (a.inverse_mass + b.inverse_mass) * along.dot(pushed) + turn_a.dot(point.arm_a.cross(along)) +
           turn_b.dot(point.arm_b.cross(along));
  };
  point.normal_mass = 1 / response(point.normal, point.normal);
  const double tt = response(point.tangent, point.tangent), tb = response(point.tangent, point.bitangent),
               bb = response(point.bitangent, point.bitangent), determinant = tt * bb - tb * tb;
  point.tangent_mass = bb / determinant;
  point.mixed_mass = -tb / determinant;
  point.bitangent_mass = tt / determinant;
}

void ContactSolver::give_colours(const ContactList& contacts, const std::vector<SolverBody>& bodies) {
  taken_.assign(bodies.size(), {});
  constexpr TakenColours nothing;
  for (std::uint32_t i = 0; i < contacts.pairs.size(); ++i) {
    const PairResult& found = contacts.pairs[i];
    if (!takes_part(found, bodies)) continue;
    TakenColours &a = taken_[found.a], &b = taken_[found.b];
    const std::uint32_t colour = TakenColours::first_free(bodies[found.a].inverse_mass != 0 ? a : nothing,
                                                          bodies[found.b].inverse_mass != 0 ? b : nothing);
    a.take(colour);
    b.take(colour);
    add_entry(contacts, i, colour);
  }
}

void ContactSolver::add_entry(const ContactList& contacts, std::uint32_t found, std::uint32_t colour) {
  const PairResult& pair = contacts.pairs[found];
  if (colour >= colour_ends_.size()) {
    colour_ends_.resize(colour + 1);
    first_points_.resize(colour + 1);
  }
  entries_.push_back({std::uint64_t{pair.a} << 32 | pair.b, found, colour, pair.contact_count, colour_ends_[colour]++});
  first_points_[colour] += pair.contact_count;
}

/// Assigns each colour's pairs and points a range, by their numbers.
void ContactSolver::arrange() {
  std::uint32_t pairs = 0, points = 0;
  for (std::uint32_t colour = 0; colour < colour_ends_.size(); ++colour) {
    points += std::exchange(first_points_[colour], points);
    pairs += std::exchange(colour_ends_[colour], pairs);
  }
  pairs_.resize(pairs);
  points_.resize(points);
  for (Entry& entry : entries_) {
    entry.place += colour_ends_[entry.colour];
    Pair& pair = pairs_[entry.place];
    pair.first = first_points_[entry.colour];
    pair.end = first_points_[entry.colour] += entry.points;
  }
  for (std::uint32_t colour = 0; colour < colour_ends_.size(); ++colour)
    colour_ends_[colour] = colour + 1 < colour_ends_.size() ? colour_ends_[colour + 1] : pairs;
}

void ContactSolver::begin(const ResponseOptions& options) {
  friction_ = options.friction;
  rolling_resistance_ = options.rolling_resistance;
  max_push_out_ = options.max_push_out;
  std::swap(points_, points_before_);
  std::swap(pairs_, pairs_before_);
  std::swap(entries_, entries_before_);
  entries_.clear();
  colour_ends_.clear();
  first_points_.clear();
}

void ContactSolver::prepare(const ContactList& contacts, const std::vector<SolverBody>& bodies,
                            const ResponseOptions& options) {
  begin(options);
  give_colours(contacts, bodies);
  arrange();
  for_blocks(entries_.size(), pairs_a_block, parallel_, [&](std::size_t begin, std::size_t end) {
    // Both lists are sorted by (a, b).
    auto old = std::lower_bound(entries_before_.begin(), entries_before_.end(), entries_[begin].key,
                                [](const Entry& entry, std::uint64_t key) { return entry.key < key; });
    for (std::size_t i = begin; i < end; ++i) {
      const Entry& entry = entries_[i];
      prepare_pair(entry, contacts, bodies);
      while (old != entries_before_.end() && old->key < entry.key) ++old;
      if (old != entries_before_.end() && old->key == entry.key)
        keep_impulses(pairs_[entry.place], pairs_before_[old->place]);
    }
  });
}

void ContactSolver::prepare_share(const ContactList& contacts, const std::vector<SolverBody>& bodies,
                                  const ResponseOptions& options, const Share& share) {
  begin(options);
  for (std::uint32_t i = 0; i < share.colours.size(); ++i)
    if (share.colours[i] != none) add_entry(contacts, i, share.colours[i]);
  arrange();
  for_blocks(entries_.size(), pairs_a_block, parallel_, [&](std::size_t begin, std::size_t end) {
    for (const Entry& entry : std::span(entries_).subspan(begin, end - begin)) {
      prepare_pair(entry, contacts, bodies);
      if (const std::uint32_t before = share.before[entry.found]; before != none)
        keep_impulses(pairs_[entry.place], pairs_before_[before]);
    }
  });
}

Vec3 ContactSolver::kept(std::uint32_t place, std::vector<KeptPoint>& points) const {
  const Pair& pair = pairs_[place];
  const auto numbers = [](const Vec3& v) { return std::array{v.x(), v.y(), v.z()}; };
  for (const Point& p : std::span(points_).subspan(pair.first, pair.end - pair.first))
    points.push_back({numbers(p.arm_a), numbers(p.arm_b), numbers(p.tangent), numbers(p.bitangent), p.normal_impulse,
                      p.tangent_impulse, p.bitangent_impulse, p.feature});
  return pair.rolling_impulse;
}

std::uint32_t ContactSolver::take_in(const Vec3& rolling_impulse, std::span<const KeptPoint> points) {
  Pair& pair = pairs_.emplace_back();
  pair.rolling_impulse = rolling_impulse;
  pair.first = static_cast<std::uint32_t>(points_.size());
  for (const KeptPoint& from : points) {
    Point& p = points_.emplace_back();
    p.arm_a = Eigen::Map<const Vec3>(from.arm_a.data());
    p.arm_b = Eigen::Map<const Vec3>(from.arm_b.data());
    p.tangent = Eigen::Map<const Vec3>(from.tangent.data());
    p.bitangent = Eigen::Map<const Vec3>(from.bitangent.data());
    p.normal_impulse = from.normal_impulse;
    p.tangent_impulse = from.tangent_impulse;
    p.bitangent_impulse = from.bitangent_impulse;
    p.feature = static_cast<std::uint32_t>(from.feature);
  }
  pair.end = static_cast<std::uint32_t>(points_.size());
  return static_cast<std::uint32_t>(pairs_.size() - 1);
}

void ContactSolver::prepare_pair(const Entry& entry, const ContactList& contacts,
                                 const std::vector<SolverBody>& bodies) {
  const PairResult& found = contacts.pairs[entry.found];
  const SolverBody &a = bodies[found.a], &b = bodies[found.b];
  Pair& pair = pairs_[entry.place];
  pair.a = found.a;
  pair.b = found.b;
  std::uint32_t point = pair.first;
  for (const Contact& contact : contacts.of(found)) prepare_point(points_[point++], contact, a, b);
  pair.rolling_mass = (a.inverse_inertia + b.inverse_inertia).inverse();
  pair.rolling_impulse.setZero();
  pair.rolling_radius = a.inverse_mass == 0 ? b.radius : b.inverse_mass == 0 ? a.radius : std::min(a.radius, b.radius);
}

// Matches points of contact with those of the step before. A point's feature number alone does not identify its
// position: a patch may be clipped by one face now and by the other in the next step, with other numbers for the same
// positions, and the deepest point of a disc moves around. Impulses that were lost, or went to other points, kept
// stacks in motion.
void ContactSolver::keep_impulses(Pair& pair, const Pair& before) {
  constexpr double same_place = 0.1;  // fraction of the smaller body's radius
  pair.rolling_impulse = before.rolling_impulse;
  const auto points = std::span(points_).subspan(pair.first, pair.end - pair.first);
  const auto points_before = std::span(points_before_).subspan(before.first, before.end - before.first);
  // In either body's frame: one may rotate or slide along the other.
  const auto distance = [](const Point& x, const Point& y) {
    return std::sqrt(std::min((x.arm_a - y.arm_a).squaredNorm(), (x.arm_b - y.arm_b).squaredNorm()));
  };
  std::size_t kept = 0;
  // Both are sorted by feature.
  for (std::size_t i = 0, old = 0; i < points.size(); ++i) {
    while (old < points_before.size() && points_before[old].feature < points[i].feature) ++old;
    if (old == points_before.size()) break;
    if (points_before[old].feature != points[i].feature) continue;
    if (distance(points[i], points_before[old]) < same_place * pair.rolling_radius) {
      keep_impulse(points[i], points_before[old]);
      ++kept;
    }
    ++old;
  }
  // The remaining points by their positions.
  for (std::size_t i = 0; i < points.size() && kept < points_before.size(); ++i) {
    if (points[i].keeps) continue;
    Point* nearest = nullptr;
    double least = pair.rolling_radius;
    for (Point& old : points_before) {
      if (old.kept) continue;
      const double away = distance(points[i], old);
      if (away < least) nearest = &old, least = away;
    }
    if (nearest == nullptr) continue;
    keep_impulse(points[i], *nearest);
    ++kept;
  }
}

void ContactSolver::keep_impulse(Point& point, Point& before) {
  point.keeps = before.kept = true;
  // The normal may have rotated since: the component of the old friction impulse in the new plane.
  const Vec3 rubbing = before.tangent_impulse * before.tangent + before.bitangent_impulse * before.bitangent;
  point.normal_impulse = before.normal_impulse;
  point.tangent_impulse = rubbing.dot(point.tangent);
  point.bitangent_impulse = rubbing.dot(point.bitangent);
}

void ContactSolver::begin_substeps(double h, const ResponseOptions& options) {
  inverse_h_ = std::min(1 / h, tolerance::largest_of_response);  // times a gap it remains finite
  const double omega = 2 * std::numbers::pi * std::min(options.contact_hertz, 0.25 * inverse_h_);
  const double a1 = 2 * options.contact_damping_ratio + h * omega;
  const double a2 = h * omega * a1;
  bias_rate_ = omega / a1;
  mass_scale_ = a2 / (1 + a2);
  impulse_scale_ = 1 / (1 + a2);
}

template <class Body>
void ContactSolver::for_each_pair(std::vector<SolverBody>& bodies, const AfterColour& after, const Body& body) const {
  const auto run = [&](std::size_t first, std::size_t last) {
    // A fixed body belongs to many pairs of a colour, and none may write to it; what is added to this one is zero.
    SolverBody fixed;
    const auto side = [&](std::uint32_t index) -> SolverBody& {
      SolverBody& own = bodies[index];
      if (own.inverse_mass != 0) return own;
      fixed.velocity = own.velocity;
      fixed.angular_velocity = own.angular_velocity;
      return fixed;
    };
    for (std::size_t i = first; i < last; ++i) body(i, side(pairs_[i].a), side(pairs_[i].b));
  };
  std::uint32_t begin = 0;
  for (std::uint32_t colour = 0; colour < colour_ends_.size(); ++colour) {
    const std::uint32_t end = colour_ends_[colour];
    for_blocks(end - begin, pairs_a_block, parallel_,
               [&](std::size_t first, std::size_t last) { run(begin + first, begin + last); });
    begin = end;
    if (after) after(colour);
  }
}

void ContactSolver::warm_start(std::vector<SolverBody>& bodies, const AfterColour& after) {
  for_each_pair(bodies, after, [this](std::size_t index, SolverBody& a, SolverBody& b) {
    const Pair& pair = pairs_[index];
    for (std::uint32_t i = pair.first; i < pair.end; ++i) {
      const Point& p = points_[i];
      apply(p.normal_impulse * p.normal + p.tangent_impulse * p.tangent + p.bitangent_impulse * p.bitangent, p.arm_a,
            p.arm_b, a, b);
    }
    a.angular_velocity.noalias() -= a.inverse_inertia * pair.rolling_impulse;
    b.angular_velocity.noalias() += b.inverse_inertia * pair.rolling_impulse;
  });
}

void ContactSolver::solve(std::vector<SolverBody>& bodies, Overlap overlap, const AfterColour& after) {
  for_each_pair(bodies, after,
                [&](std::size_t i, SolverBody& a, SolverBody& b) { solve_pair(pairs_[i], a, b, overlap); });
}

// Friction first, overlap last: the constraint solved last is satisfied best.
void ContactSolver::solve_pair(Pair& pair, SolverBody& a, SolverBody& b, Overlap overlap) {
  double pressed = 0;
  for (std::uint32_t i = pair.first; i < pair.end; ++i) pressed += points_[i].normal_impulse;

  const double most_rolling = rolling_resistance_ * pair.rolling_radius * pressed;
  if (most_rolling > 0) {
    Vec3 total = pair.rolling_impulse - pair.rolling_mass * (b.angular_velocity - a.angular_velocity);
    const double length = total.norm();
    if (length > most_rolling) total *= most_rolling / length;
    const Vec3 change = total - pair.rolling_impulse;
    pair.rolling_impulse = total;
    a.angular_velocity.noalias() -= a.inverse_inertia * change;
    b.angular_velocity.noalias() += b.inverse_inertia * change;
  } else {
    a.angular_velocity.noalias() += a.inverse_inertia * pair.rolling_impulse;
    b.angular_velocity.noalias() -= b.inverse_inertia * pair.rolling_impulse;
    pair.rolling_impulse.setZero();
  }

  for (std::uint32_t i = pair.first; i < pair.end; ++i) {
    Point& p = points_[i];
    if (p.normal_impulse == 0 && p.tangent_impulse == 0 && p.bitangent_impulse == 0) continue;
    const Vec3 slip = relative_velocity(p.arm_a, p.arm_b, a, b);
    const double along = slip.dot(p.tangent), across = slip.dot(p.bitangent);
    double tangent = p.tangent_impulse - (p.tangent_mass * along + p.mixed_mass * across);
    double bitangent = p.bitangent_impulse - (p.mixed_mass * along + p.bitangent_mass * across);
    const double most = friction_ * p.normal_impulse, length = std::sqrt(tangent * tangent + bitangent * bitangent);
    if (length > most) {
      tangent *= most / length;
      bitangent *= most / length;
    }
    apply((tangent - p.tangent_impulse) * p.tangent + (bitangent - p.bitangent_impulse) * p.bitangent, p.arm_a, p.arm_b,
          a, b);
    p.tangent_impulse = tangent;
    p.bitangent_impulse = bitangent;
  }

  const Vec3 moved = b.moved - a.moved;
  for (std::uint32_t i = pair.first; i < pair.end; ++i) {
    Point& p = points_[i];
    const double gap = p.gap + p.normal.dot(moved + b.turned.cross(p.arm_b) - a.turned.cross(p.arm_a));
    double bias = 0, mass_scale = 1, impulse_scale = 0;
    if (gap > 0) {
      bias = gap * inverse_h_;
    } else if (overlap == Overlap::push_out) {
      bias = std::max(bias_rate_ * gap, -max_push_out_);
      mass_scale = mass_scale_;
      impulse_scale = impulse_scale_;
    }
    const double approach = p.normal.dot(relative_velocity(p.arm_a, p.arm_b, a, b));
    const double wanted =
        p.normal_impulse - p.normal_mass * mass_scale * (approach + bias) - impulse_scale * p.normal_impulse;
    const double total = std::max(wanted, 0.0);
    const double change = total - p.normal_impulse;
    if (change == 0) continue;
    p.normal_impulse = total;
    apply(change * p.normal, p.arm_a, p.arm_b, a, b);
  }
}

}  // namespace tandem
