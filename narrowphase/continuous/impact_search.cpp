// The first time at which a polygon whose corners move on straight lines holds the origin, by intervals of time that
// are proven free one after the other from t = 0. What proves: a direction n(t) that is linear in t, along which all
// corners w(t) stay on the origin's far side: n(t) . w(t) is a quadratic, and its Bernstein coefficients are the
// products of the directions and corners at both ends of the interval; or the coplanarity cubic of Provot (Collision
// and self-collision handling in cloth model dedicated to design garments, 1997), if its Bernstein coefficients have
// one sign. Any direction will do for a proof, so those of nearest points are found in plain doubles; only signs of the
// coefficients are held against bounds on their rounding errors. A fixed direction leads to a next time as far as it
// proves (conservative advancement: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996); next to a
// simple root that converges as Newton's method does.
#include "continuous/impact_search.h"

#include "continuous/nearest_axis.h"

namespace tandem {
namespace {

constexpr int most_rounds = 200;
/// Iterations that begin within the tolerance and advance in no direction, and the fraction of the tolerance at which a
/// search ends early: most features that pass within the tolerance are found to pass, and impacts are known better than
/// asked for.
constexpr int most_near_rounds = 10;
constexpr double much_nearer = 1.0 / 1024;
/// An interval is halved if an advance leaves more than this fraction of it.
constexpr double slow_advance = 0.25;
/// Error bound of a product of direction and corner, relative to the sum of the corner's coordinates: 7 u for the
/// corner's difference and its position at t (4 u), the product (u) and the sums (2 u), 8 u with the sum of two
/// products, u = epsilon / 2. Smaller: impacts could be missed. Larger: impacts are reported from farther away.
constexpr double product_rounding = 6 * epsilon;
/// Error bound of the sum of three determinants, relative to the product of the largest coordinates: 330 u, namely 72 u
/// for the corners in each (6 products of three numbers with 4 u), 18 + 28 u for the sums and products. Smaller or
/// larger: as above.
constexpr double cubic_rounding = 200 * epsilon;
/// The most intervals on the stack: each is at most half as long as the one below it.
constexpr std::size_t most_open = 64;

// A time, the corners at that time, and the direction of the nearest point.
template <std::size_t N>
struct Instant {
  double t;
  Polygon<N> w;
  Vec3 e, f;
  NearestAxis axis;
};

// Extrapolates the time at which the gap would close from the last two times, less a fraction that shrinks with each
// success: a proof needs a gap that is large against the square of the angle by which the direction of the nearest
// point turns.
struct Guess {
  double t = infinity, gap = 0;  // of the last time
  double part = 0.125;

  double next(double now, double gap_now) {
    const double speed = (gap - gap_now) / (now - t);
    const bool closing = now > t && speed > 0 && gap_now > 0;
    t = now, gap = gap_now;
    if (!closing) return infinity;
    const double guessed = now + (1 - part) * gap_now / speed;
    part *= part;
    return guessed > now ? guessed : infinity;
  }
};

template <std::size_t N>
class AdvanceSearch {
 public:
  AdvanceSearch(const MovingPolygon<N>& polygon, const ImpactOptions& options, double until)
      : polygon_(polygon), until_(until), separation_(options.separation) {
    const double reach = polygon.reach();
    near_ = options.tolerance * polygon.longest_motion();
    // For directions of length 1 + 4 epsilon at most.
    rounding_ = product_rounding * reach + std::numeric_limits<double>::min();
    bound_ = separation_ * (1 + 16 * epsilon) + rounding_;
    reach_rounding_ = 16 * product_rounding * reach;
    const auto most = [](const Vec3& x, const Vec3& y) {
      return std::max(x.cwiseAbs().maxCoeff(), y.cwiseAbs().maxCoeff());
    };
    cubic_bound_ = cubic_rounding * most(polygon.from[0], polygon.to[0]) * most(polygon.e_from, polygon.e_to) *
                   most(polygon.f_from, polygon.f_to);
  }

  VertexImpact first() {
    if (apart_along_an_axis()) return {};
    Instant<N> now = instant(0);
    std::array<Instant<N>, most_open> ends;  // ends of the intervals still to be proven free, the next one last
    std::size_t open = 0;
    ends[open++] = instant(until_);
    Guess guess;
    int near_rounds = 0;
    for (int round = 0; round < most_rounds; ++round) {
      const Instant<N>& end = ends[open - 1];
      if (free_between(now, end)) {
        now = end;
        guess = {};
        if (--open == 0) return {};
        continue;
      }
      const double gap = now.axis.gap - separation_;
      if (gap <= near_ && (gap <= much_nearer * near_ || ++near_rounds > most_near_rounds)) break;
      if (const double t = guess.next(now.t, gap); t < end.t) {
        const Instant<N> guessed = instant(t);
        if (free_between(now, guessed)) {
          now = guessed;
          continue;
        }
        guess = {};
      }
      const double reached = advance(now, end);
      if (!(reached > now.t)) break;
      if (!(reached - now.t > slow_advance * (end.t - now.t))) {
        const double middle = reached + 0.5 * (end.t - reached);
        if (!(middle > reached && middle < end.t) || open == most_open) break;
        ends[open++] = instant(middle);
      }
      now = instant(reached);
    }
    return {true, now.t, distance_bound(now.w) * (1 + 16 * epsilon) + reach_rounding_};
  }

 private:
  // True if all corners stay on one side along a coordinate axis. Signs of differences are exact.
  bool apart_along_an_axis() const {
    for (Eigen::Index k = 0; k < 3; ++k) {
      double low = infinity, high = -infinity;
      for (std::size_t i = 0; i < N; ++i) {
        low = std::min({low, polygon_.from[i][k], polygon_.to[i][k]});
        high = std::max({high, polygon_.from[i][k], polygon_.to[i][k]});
      }
      const double wide = separation_ * (1 + 4 * epsilon);
      if (low > wide || high < -wide) return true;
    }
    return false;
  }

  Instant<N> instant(double t) const {
    Instant<N> r;
    r.t = t;
    for (std::size_t i = 0; i < N; ++i) r.w[i] = (1 - t) * polygon_.from[i] + t * polygon_.to[i];
    r.e = (1 - t) * polygon_.e_from + t * polygon_.e_to;
    r.f = (1 - t) * polygon_.f_from + t * polygon_.f_to;
    r.axis = nearest_axis(r.w, r.e, r.f);
    return r;
  }

  bool free_between(const Instant<N>& p, const Instant<N>& q) const {
    return parted(p, q) || (separation_ == 0 && out_of_plane(p, q));
  }

  // True if a direction that turns linearly from p's to q's separates throughout.
  bool parted(const Instant<N>& p, const Instant<N>& q) const {
    for (std::size_t i = 0; i < N; ++i) {
      const double first = p.axis.n.dot(p.w[i]) - bound_, last = q.axis.n.dot(q.w[i]) - bound_;
      if (!(first > 0 && last > 0)) return false;
      const double middle = p.axis.n.dot(q.w[i]) + q.axis.n.dot(p.w[i]) - 2 * bound_;
      // A quadratic with such coefficients has no root, if the products do not underflow.
      if (!(middle > 0 || (first * last > tolerance::shortest_squared && middle * middle < 3.9 * first * last)))
        return false;
    }
    return true;
  }

  // True if the determinant of a corner and the two sides keeps one sign.
  bool out_of_plane(const Instant<N>& p, const Instant<N>& q) const {
    if (!(cubic_bound_ > tolerance::shortest_squared)) return false;  // products may have lost digits by underflow
    const Vec3 pp = p.e.cross(p.f), qq = q.e.cross(q.f), pq = p.e.cross(q.f) + q.e.cross(p.f);
    const double c0 = p.w[0].dot(pp), c3 = q.w[0].dot(qq);
    const double c1 = q.w[0].dot(pp) + p.w[0].dot(pq), c2 = q.w[0].dot(pq) + p.w[0].dot(qq);
    return std::min(std::min(c0, c3), std::min(c1, c2)) > cubic_bound_ ||
           std::max(std::max(c0, c3), std::max(c1, c2)) < -cubic_bound_;
  }

  // The time up to which p's direction alone proves the interval free; p's time if it proves nothing.
  double advance(const Instant<N>& p, const Instant<N>& q) const {
    const double aim = bound_ + rounding_;
    double part = 1;
    for (std::size_t i = 0; i < N; ++i) {
      const double first = p.axis.n.dot(p.w[i]), last = p.axis.n.dot(q.w[i]);
      if (!(first > bound_)) return p.t;
      if (last <= aim) part = std::min(part, (first - aim) / (first - last));
    }
    const double t = part < 1 ? p.t + std::max(0.0, part) * (q.t - p.t) : q.t;
    for (std::size_t i = 0; i < N; ++i)
      if (!(p.axis.n.dot((1 - t) * polygon_.from[i] + t * polygon_.to[i]) > bound_)) return p.t;
    return t;
  }

  const MovingPolygon<N>& polygon_;
  const double until_, separation_;
  double near_, rounding_, bound_, reach_rounding_, cubic_bound_;
};

}  // namespace

template <std::size_t N>
VertexImpact search_impact(const MovingPolygon<N>& polygon, const ImpactOptions& options, double until) {
  return AdvanceSearch<N>(polygon, options, until).first();
}

template VertexImpact search_impact(const MovingPolygon<3>&, const ImpactOptions&, double);
template VertexImpact search_impact(const MovingPolygon<4>&, const ImpactOptions&, double);

}  // namespace tandem
