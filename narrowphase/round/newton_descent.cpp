// Newton's method on h over the sphere of directions.
#include "round/newton_descent.h"

#include <algorithm>
#include <cmath>

#include "round/nearest_flat.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_newton_steps = 64;

/// Two unit vectors that make a right-handed frame with n (Duff et al., Building an Orthonormal Basis, Revisited,
/// 2017).
void tangents(const Vec3& n, Vec3& u, Vec3& v) {
  const double sign = std::copysign(1.0, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  u = {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
  v = {b, sign + n[1] * n[1] * a, -n[1]};
}

/// The intersection of two circles on n's side, for a small one or nearly parallel axes. Computed from the smaller: its
/// radius gives its distance from the axis accurately, while 1 minus its height squared has an error of rounding over
/// the radius.
Vec3 meet_on(const Circle& small, const Circle& other, const Vec3& n) {
  const Vec3 c = small.axis.cross(other.axis);
  // The cross product of nearly parallel axes, as of a needle's edges, has errors of rounding over its length, also
  // along the axes.
  const Vec3 across = (c - c.dot(small.axis) * small.axis).normalized(), along = across.cross(small.axis);
  const double away = (other.height - small.axis.dot(other.axis) * small.height) / c.norm(), r = small.radius;
  const double x = std::clamp(away, -r, r), y = std::copysign(std::sqrt((r - x) * (r + x)), across.dot(n));
  return (small.height * small.axis + x * along + y * across).normalized();
}

/// The intersection of two circles on n's side; false if they are (nearly) the same.
bool meet(const Circle& a, const Circle& b, Vec3& n) {
  const Vec3 c = a.axis.cross(b.axis);
  const double det = c.squaredNorm();
  if (det < tolerance::parallel_lines2) return false;
  const bool b_smaller = b.radius < a.radius;
  const double radius = b_smaller ? b.radius : a.radius;
  if (std::min(det, radius * radius) < tolerance::clearly_crossing2) {
    n = b_smaller ? meet_on(b, a, n) : meet_on(a, b, n);
    return true;
  }
  const double d = a.axis.dot(b.axis);
  const double x = (a.height - d * b.height) / det, y = (b.height - d * a.height) / det;
  const double rest = std::max(0.0, 1 - x * a.height - y * b.height);
  n = (x * a.axis + y * b.axis + std::copysign(std::sqrt(rest / det), c.dot(n)) * c).normalized();
  return true;
}

/// The unit vector perpendicular to the circle's axis towards n; any if n is on the axis.
Vec3 off_axis(const Circle& c, const Vec3& n) {
  Vec3 out = n;
  for (int twice = 0; twice < 2; ++twice) {  // near the axis the first pass leaves mostly rounding
    out -= out.dot(c.axis) * c.axis;
    const double length = out.norm();
    if (!(length > 0)) return any_perpendicular(c.axis);
    out /= length;
    if (length > tolerance::clearly_off_axis) break;
  }
  return out;
}

/// The disc of body `which` that faces along `side` times its axis as the supporting face: optimal if it touches the
/// other body's face. Otherwise `away` is the tangent in which h falls most, as long as it falls fast.
Support facing_disc(const RoundPair& pair, int which, double side, Vec3& away) {
  constexpr int corners = 16;
  const RoundBody &body = pair.body[which], &other = pair.body[1 - which];
  Support r;
  r.n = side * body.axis();
  const Vec3 centre = body.circle_centre(body.support_piece(r.n));
  Vec3 points[corners];
  double disc = 0;
  const int count = other.face(r.n, 8 * epsilon * pair.scale, points, corners, disc);
  const Vec3 u = any_perpendicular(r.n), v = r.n.cross(u);
  PlaneSum flat[corners];
  for (int i = 0; i < count; ++i) {
    const Vec3 w = centre + points[i];
    flat[i] = {u.dot(w), v.dot(w), i, 0};
  }
  const NearestFlat z = nearest_flat(flat, count);
  const double apart = std::sqrt(z.x * z.x + z.y * z.y);
  r.h = r.n.dot(centre + points[0]);
  const double reach = body.radius() + disc;
  r.optimal = apart <= reach;
  away = r.optimal ? Vec3::Zero() : Vec3((reach / apart - 1) * (z.x * u + z.y * v));
  const Vec3 off = (r.optimal ? 1.0 : reach / apart) * (z.x * u + z.y * v);
  r.point[which] = centre - body.radius() / reach * off;
  for (int k = 0; k < z.count; ++k) r.point[1 - which] += z.weight[k] * points[z.index[k]];
  r.point[1 - which] -= disc / reach * off;
  return r;
}

}  // namespace

/// Computes h and the least subgradient at n, for which the points of the first pieces are known; keeps the pieces that
/// support it.
void NewtonDescent::weigh() {
  const Vec3 sum = at_.point[0] + at_.point[1];
  at_.h = at_.n.dot(sum);
  at_.optimal = false;
  tangents(at_.n, u_, v_);
  if (active_[0].count == 1 && active_[1].count == 1) {
    zx_ = u_.dot(sum), zy_ = v_.dot(sum);
    return;
  }
  Vec3 p[2][ActivePieces::capacity];
  PlaneSum flat[ActivePieces::capacity * ActivePieces::capacity];
  flat[0] = {0, 0, 0, 0};
  int count = 0;
  for (int b = 0; b < 2; ++b) {
    p[b][0] = at_.point[b];
    for (int i = 1; i < active_[b].count; ++i) p[b][i] = pair_.body[b].point(active_[b].piece[i], at_.n);
  }
  for (int i = 0; i < active_[0].count; ++i)
    for (int j = 0; j < active_[1].count; ++j) {
      const Vec3 w = p[0][i] + p[1][j];
      flat[count++] = {u_.dot(w), v_.dot(w), i, j};
    }
  const NearestFlat z = nearest_flat(flat, count);
  zx_ = z.x, zy_ = z.y;
  at_.optimal = zx_ * zx_ + zy_ * zy_ <= small() * small() && surrounded(flat, count, small());
  double weight[2][ActivePieces::capacity] = {};
  for (int k = 0; k < z.count; ++k) {
    weight[0][flat[z.index[k]].i] += z.weight[k];
    weight[1][flat[z.index[k]].j] += z.weight[k];
  }
  for (int b = 0; b < 2; ++b) {
    ActivePieces& active = active_[b];
    if (active.count == 1) continue;
    const bool keep = stuck_ > 1 && active.count == 2;
    at_.point[b].setZero();
    int kept = 0;
    for (int i = 0; i < active.count; ++i) {
      if (!(weight[b][i] > 0) && !keep) continue;
      at_.point[b] += weight[b][i] * p[b][i];
      active.piece[kept++] = active.piece[i];
    }
    active.count = kept;
  }
}

/// Near the axis of a circle: checks whether its disc is the minimum.
bool NewtonDescent::at_disc() {
  for (int b = 0; b < 2; ++b) {
    const RoundBody& body = pair_.body[b];
    const int piece = active_[b].piece[0];
    if (active_[b].count > 1 || !body.is_circle(piece)) continue;
    const double side = body.facing(piece);
    bool& checked = checked_[b][side > 0 ? 0 : 1];
    if (checked || side * at_.n.dot(body.axis()) < 0.8) continue;
    checked = true;
    Vec3 away;
    const Support disc = facing_disc(pair_, b, side, away);
    if (disc.h > at_.h + small()) continue;
    if (disc.optimal) {
      at_ = disc;
      return true;
    }
    // Newton's steps towards a point where h is a cone would never leave it: start on the side where h falls.
    for (double angle = std::min(0.3, away.norm() / (std::abs(disc.h) + body.radius()));
         angle > tolerance::descent_angle; angle *= 0.4) {
      const Vec3 n = (disc.n + angle * away.normalized()).normalized();
      start(n);
      weigh();
      if (at_.h < disc.h) break;
    }
    return false;
  }
  return false;
}

NewtonDescent::Trial NewtonDescent::follow(const Arc& arc, double t) const {
  Trial r;
  double end = t;
  for (int b = 0; b < 2; ++b)
    pair_.body[b].first_crossing(arc, end, active_[b].piece, active_[b].count, [&](double at, int from, int other) {
      if (r.body >= 0 && !(at < end)) return;
      end = at;
      r.body = b, r.from = from, r.other = other;
    });
  r.n = arc.at(end);
  return r;
}

/// Moves along the arc by t, or less: until h decreases or another piece takes over. False where rounding prevents any
/// gain.
bool NewtonDescent::go(const Arc& arc, double t, double slope) {
  for (int halving = 0; halving < 40; ++halving, t *= 0.4) {
    Trial trial = follow(arc, t);
    trial.n.normalize();
    Vec3 point[2];
    for (int b = 0; b < 2; ++b) point[b] = pair_.body[b].point(active_[b].piece[0], trial.n);
    trial.h = trial.n.dot(point[0] + point[1]);
    if (trial.h > at_.h + small()) continue;
    if (trial.h > at_.h - small() && slope * t < tolerance::descent_end * pair_.scale && trial.body < 0) {
      // h is known to rounding: only the subgradient still shows progress.
      if (slope >= 0.5 * last_) {
        at_.optimal = slope <= tolerance::descent_flat * pair_.scale;
        return false;
      }
      last_ = slope;
    } else {
      last_ = infinity;  // h shows progress again: earlier slopes near a saddle do not count for later ones
    }
    stuck_ = trial.body >= 0 && (trial.n - at_.n).squaredNorm() < tolerance::standing_still2 ? stuck_ + 1 : 0;
    at_.n = trial.n;
    for (int b = 0; b < 2; ++b) at_.point[b] = point[b];
    if (trial.body >= 0) {
      const RoundBody& body = pair_.body[trial.body];
      ActivePieces& active = active_[trial.body];
      active.add(body, trial.from, trial.other);
      // Projects exactly onto the circles.
      Circle circles[2];
      int count = 0;
      for (int b = 0; b < 2; ++b)
        for (int i = 1; i < active_[b].count && count < 2; ++i) {
          const Circle c = pair_.body[b].circle(active_[b].piece[0], active_[b].piece[i]);
          if (count == 1 && c.axis.cross(circles[0].axis).squaredNorm() < tolerance::parallel_lines2) continue;
          circles[count++] = c;
        }
      if (count == 2) {
        meet(circles[0], circles[1], at_.n);
      } else if (count == 1) {
        const Circle& c = circles[0];
        at_.n = c.height * c.axis + c.radius * off_axis(c, at_.n);
      }
      for (int b = 0; b < 2; ++b) at_.point[b] = pair_.body[b].point(active_[b].piece[0], at_.n);
    }
    return true;
  }
  return false;
}

bool NewtonDescent::step_freely() {
  const double z = std::sqrt(zx_ * zx_ + zy_ * zy_);
  if (z <= small() && at_.h <= 0) {
    at_.optimal = true;
    return false;
  }
  double w[3] = {-at_.h, 0, -at_.h};
  for (int b = 0; b < 2; ++b) pair_.body[b].add_curvature(active_[b].piece[0], at_.n, u_, v_, w);
  // Eigenvalues and eigenvectors of the Hessian of h on the sphere.
  const double mean = 0.5 * (w[0] + w[2]), half = 0.5 * (w[0] - w[2]);
  const double spread = std::sqrt(half * half + w[1] * w[1]);
  const double high = mean + spread, low = mean - spread;
  double c = 1, s = 0;  // the eigenvector of `high`
  if (spread > 0) {
    if (half >= 0) {
      c = half + spread, s = w[1];
    } else {
      c = w[1], s = spread - half;
    }
    const double length = std::sqrt(c * c + s * s);
    c /= length, s /= length;
  }
  double x, y, length;
  if (z <= small()) {
    if (low >= -tolerance::descent_flat * pair_.scale || kicks_++ > 2) {
      at_.optimal = true;
      return false;
    }
    x = -s, y = c, length = 0.3;  // a saddle or a maximum
  } else {
    const double least = tolerance::descent_bend * pair_.scale;
    double gh = (zx_ * c + zy_ * s) / std::max(std::abs(high), least),
           gl = (-zx_ * s + zy_ * c) / std::max(std::abs(low), least);
    if (stuck_ > 0) gh = (zx_ * c + zy_ * s) / z, gl = (-zx_ * s + zy_ * c) / z;
    x = -(gh * c - gl * s), y = -(gh * s + gl * c);
    length = std::sqrt(x * x + y * y);
    x /= length, y /= length;
    length = std::min(length, 1.0);
  }
  const Vec3 along = x * u_ + y * v_;
  return go({at_.n, 2 * along, -at_.n}, 0.5 * length, z);
}

bool NewtonDescent::step_along(const Circle& circle) {
  const double radius = circle.radius;
  const Vec3 out = off_axis(circle, at_.n);
  Vec3 along = circle.axis.cross(out);
  const double du = along.dot(u_), dv = along.dot(v_);
  double slope = du * zx_ + dv * zy_;
  if (slope > 0) along = -along;
  slope = std::abs(slope);
  double w[3] = {0, 0, 0};
  Vec3 sum = Vec3::Zero();
  for (int b = 0; b < 2; ++b) {
    pair_.body[b].add_curvature(active_[b].piece[0], at_.n, u_, v_, w);
    sum += pair_.body[b].point(active_[b].piece[0], at_.n);
  }
  const double bend = radius * (w[0] * du * du + 2 * w[1] * du * dv + w[2] * dv * dv) - sum.dot(out);
  double angle;
  if (slope <= small()) {
    if (at_.h <= 0 || bend >= -tolerance::descent_flat * pair_.scale || kicks_++ > 2) {
      at_.optimal = zx_ * zx_ + zy_ * zy_ <= tolerance::descent_flat2 * pair_.scale * pair_.scale;
      return false;
    }
    angle = 0.3;
  } else {
    angle = std::min(slope / std::max(std::abs(bend), tolerance::descent_bend * pair_.scale), 1.0);
  }
  const Vec3 base = circle.height * circle.axis, side = radius * out;
  return go({base + side, 2 * radius * along, base - side}, 0.5 * angle, slope);
}

Support NewtonDescent::run() {
  for (int step = 0; step < max_newton_steps; ++step) {
    weigh();
    if (at_.h < below_ || at_.optimal) return at_;
    if (at_disc()) return at_;
    const int edges = active_[0].count + active_[1].count - 2;
    if (edges == 0) {
      if (!step_freely()) break;
      continue;
    }
    const int b = active_[0].count > 1 ? 0 : 1;
    if (!step_along(pair_.body[b].circle(active_[b].piece[0], active_[b].piece[1]))) break;
  }
  return at_;
}

}  // namespace tandem
