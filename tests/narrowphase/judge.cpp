// Judges answers by the reference and by their documentation.
#include "judge.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "shapes/shape_insides.h"

namespace tandem::test {
namespace {

using reference::PosedPair;
using reference::Truth;

constexpr double epsilon = 0x1p-52;

bool is_round(const Shape& s) {
  return s.kind() == ShapeKind::cylinder || s.kind() == ShapeKind::cone || s.kind() == ShapeKind::ellipsoid;
}

std::ostream& operator<<(std::ostream& out, const Vec3& v) {
  return out << '[' << v.x() << ',' << v.y() << ',' << v.z() << ']';
}

void write(std::ostream& out, const Shape& s) {
  out << "{\"kind\":\"" << name(s.kind()) << '"';
  switch (s.kind()) {
    case ShapeKind::sphere:
      out << ",\"radius\":" << s.radius();
      break;
    case ShapeKind::box:
      out << ",\"size\":" << Vec3(2 * s.half_size());
      break;
    case ShapeKind::ellipsoid:
      out << ",\"radii\":" << s.radii();
      break;
    case ShapeKind::halfspace:
    case ShapeKind::plane:
      out << ",\"normal\":" << s.normal() << ",\"offset\":" << s.offset();
      break;
    case ShapeKind::convex:
    case ShapeKind::triangle: {
      // A triangle without area has fewer extreme points than corners.
      const auto& vertices = hull_of(s).vertices;
      const std::size_t corners = s.kind() == ShapeKind::triangle ? 3 : vertices.size();
      out << ",\"vertices\":[";
      for (std::size_t i = 0; i < corners; ++i) out << (i > 0 ? "," : "") << vertices[std::min(i, vertices.size() - 1)];
      out << ']';
      break;
    }
    default:
      out << ",\"radius\":" << s.radius() << ",\"length\":" << s.length();
  }
  out << '}';
}

void write(std::ostream& out, const Pose& p) {
  out << "{\"R\":[" << Vec3(p.rotation.row(0)) << ',' << Vec3(p.rotation.row(1)) << ',' << Vec3(p.rotation.row(2))
      << "],\"t\":" << p.translation << '}';
}

bool finite(const PairAnswer& r) {
  return std::isfinite(r.signed_distance) && r.normal.allFinite() && r.point_a.allFinite() && r.point_b.allFinite() &&
         std::isfinite(r.error_bound);
}

/// The distance of a point outside a shape, 0 inside; in double precision.
double outside(const Shape& s, const Pose& pose, const Vec3& point) {
  const double d = reference::signed_distance(s, pose, Shape(Sphere{0}), {Mat3::Identity(), point}).signed_distance;
  return std::max(d, 0.0);
}

class Judge {
 public:
  Judge(const PosedPair& pair, const Truth& truth) : p_(pair), truth_(truth) {
    out_.precision(17);
    const double size = reference::size(pair);
    bounds_ = accepted(pair.a, pair.b);
    const double between = reach(pair);
    bounds_.distance = bounds_.distance * size + 4 * epsilon * between;
    bounds_.points = bounds_.points * size + 4 * epsilon * between;
    // Large coordinates limit the accuracy.
    rounding_ = rounding(pair);
    size_ = size;
  }

  void distance(const char* what, const PairAnswer& r) {
    if (!finite(r)) return fail(what, "not finite", r.signed_distance, truth_.signed_distance);
    const double low = truth_.signed_distance, high = low + truth_.error, d = r.signed_distance;
    if (std::abs(r.normal.norm() - 1) > 1e-14) fail(what, "length of the normal", r.normal.norm(), 1);
    if (d < low - bounds_.distance) fail(what, "signed distance too small", d, low);
    if (d > high + bounds_.distance) fail(what, "signed distance too large", d, high);
    const double along = reference::separation(p_.a, p_.pose_a, p_.b, p_.pose_b, r.normal);
    if (along > high + 1e-15 * size_) fail(what, "THE REFERENCE IS WRONG: separation along the normal", along, high);
    if (along < d - bounds_.distance)
      fail(what, "separation along the normal is less than the signed distance", along, d);
    // A bound that is given must hold.
    if (r.status == Status::inexact &&
        (d + r.error_bound < low - bounds_.distance || d - r.error_bound > high + bounds_.distance))
      fail(what, "farther from the truth than its error bound", d, low);
    verdict(what, r.collide);
    if (r.collide != (d <= 0)) fail(what, "collide disagrees with the sign of the distance", r.collide, d);
    const double apart = (r.point_b - r.point_a - d * r.normal).norm();
    if (apart > bounds_.points + 8 * rounding_) fail(what, "points are not distance x normal apart", apart, 0);
    const double off_a = outside(p_.a, p_.pose_a, r.point_a), off_b = outside(p_.b, p_.pose_b, r.point_b);
    if (off_a > bounds_.points + 8 * rounding_) fail(what, "point_a lies outside A by", off_a, 0);
    if (off_b > bounds_.points + 8 * rounding_) fail(what, "point_b lies outside B by", off_b, 0);
  }

  void verdict(const char* what, bool collide) {
    const double sure = 1e-15 * size_;
    if (collide && truth_.signed_distance > sure) fail(what, "collides across a gap of", truth_.signed_distance, 0);
    if (!collide && truth_.signed_distance + truth_.error < -sure)
      fail(what, "does not collide at", truth_.signed_distance + truth_.error, 0);
  }

  void contacts(const char* what, const PairAnswer& r, const std::vector<Contact>& contacts, double margin) {
    const double d = r.signed_distance;
    if (contacts.size() > 4) fail(what, "more than 4 contacts", static_cast<double>(contacts.size()), 4);
    if (contacts.empty() != (d > margin))
      fail(what, "contacts, for a distance of", static_cast<double>(contacts.size()), d);
    double deepest = -1e300;
    for (const Contact& c : contacts) {
      if (!c.point.allFinite() || !c.normal.allFinite() || !std::isfinite(c.depth)) {
        fail(what, "a contact is not finite", c.depth, 0);
        continue;
      }
      deepest = std::max(deepest, c.depth);
      if ((c.normal - r.normal).norm() > 1e-12)
        fail(what, "a contact's normal is off by", (c.normal - r.normal).norm(), 0);
      if (c.depth < -margin - bounds_.points) fail(what, "a contact beyond the margin", c.depth, -margin);
      // Midway along the common normal, from which the normal of a face that lies on another may differ by rounding.
      const double reach = 0.501 * std::abs(c.depth) + 1e-7 * size_ + 8 * rounding_;
      const double off = std::max(outside(p_.a, p_.pose_a, c.point), outside(p_.b, p_.pose_b, c.point));
      if (off > reach) fail(what, "a contact lies outside a shape by", off, reach);
    }
    if (!contacts.empty() && std::abs(deepest + d) > bounds_.points) fail(what, "the deepest contact", deepest, -d);
  }

  void same(const char* what, const PairAnswer& r, const PairAnswer& other, const Vec3& normal) {
    if (!(std::abs(r.signed_distance - other.signed_distance) <= std::min(bounds_.distance, 1e-12 * size_)))
      fail(what, "another signed distance", other.signed_distance, r.signed_distance);
    if (r.collide != other.collide && std::abs(truth_.signed_distance) > 1e-15 * size_)
      fail(what, "another verdict", other.collide, r.collide);
    if (truth_.normal_unique && std::abs(truth_.signed_distance) > 1e-6 * size_ && !((normal - r.normal).norm() < 1e-4))
      fail(what, "another normal, off by", (normal - r.normal).norm(), 0);
  }

  std::string str() const { return out_.str(); }

 private:
  void fail(const char* what, const char* why, double found, double expected) {
    out_ << what << ": " << why << ": " << found << " for " << expected << " (size " << size_ << ")\n";
  }

  const PosedPair& p_;
  const Truth& truth_;
  Bounds64 bounds_;
  double rounding_, size_;
  std::ostringstream out_;
};

}  // namespace

Bounds64 accepted(const Shape& a, const Shape& b) {
  const bool round = is_round(a) || is_round(b);
  return {round ? 1e-10 : 1e-12, round ? 1e-9 : 1e-11};
}

double reach(const PosedPair& p) {
  double far = (p.pose_b.translation - p.pose_a.translation).norm();
  for (const Shape* s : {&p.a, &p.b}) {
    if (!s->is_bounded()) far += std::abs(s->offset());
    if (s->kind() == ShapeKind::convex || s->kind() == ShapeKind::triangle) far += hull_of(*s).inside.norm();
  }
  return far;
}

double rounding(const PosedPair& p) {
  return epsilon * (p.pose_a.translation.norm() + p.pose_b.translation.norm() + reach(p) + reference::size(p));
}

std::string record(const PosedPair& p) {
  std::ostringstream out;
  out.precision(17);
  out << "{\"id\":\"pair\",\"shapeA\":";
  write(out, p.a);
  out << ",\"poseA\":";
  write(out, p.pose_a);
  out << ",\"shapeB\":";
  write(out, p.b);
  out << ",\"poseB\":";
  write(out, p.pose_b);
  out << ",\"ask\":[\"distance\",\"normal\",\"contacts\"]}";
  return out.str();
}

std::string judge(const NarrowPhase& solver, const PosedPair& p, const Truth& truth) {
  Judge j(p, truth);
  const PairAnswer r = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
  j.distance("distance", r);
  if (!finite(r)) return j.str();
  j.verdict("collide", solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::collide).collide);
  j.verdict("collide swapped", solver.solve(p.b, p.pose_b, p.a, p.pose_a, Request::collide).collide);
  const PairAnswer swapped = solver.solve(p.b, p.pose_b, p.a, p.pose_a, Request::distance);
  j.same("swapped", r, swapped, -swapped.normal);
  std::vector<Contact> contacts;
  const PairAnswer c = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::contacts, &contacts);
  if (r.signed_distance <= 0) j.same("contacts", r, c, c.normal);
  if (r.signed_distance <= 0 || !contacts.empty()) j.contacts("contacts", c, contacts, 0);
  const double margin = std::abs(r.signed_distance) + 0.01 * reference::size(p);
  const NarrowPhase wide({.tolerance = 0, .margin = margin, .solver = {}});
  contacts.clear();
  const PairAnswer w = wide.solve(p.a, p.pose_a, p.b, p.pose_b, Request::contacts, &contacts);
  j.same("contacts with a margin", r, w, w.normal);
  j.contacts("contacts with a margin", w, contacts, margin);
  return j.str();
}

}  // namespace tandem::test
