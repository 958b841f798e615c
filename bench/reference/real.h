// Arithmetic of the reference solver: binary128 numbers and vectors.
#pragma once
#include <cmath>
#include <limits>

#include "tandem/narrowphase/pose.h"

namespace tandem::reference {

/// 113 bits of mantissa, IEEE binary128: the same bits on every machine. On 64-bit ARM that is `long double`.
#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 Real;
#else
using Real = long double;
static_assert(std::numeric_limits<Real>::digits == 113, "no type of 113 bits here");
#endif

inline Real abs(Real x) { return x < 0 ? -x : x; }
inline Real min(Real a, Real b) { return b < a ? b : a; }
inline Real max(Real a, Real b) { return a < b ? b : a; }

/// Heron's iteration from the double's root: 53 bits become 106, then all. For 0 and 1e-290..1e290.
inline Real sqrt(Real x) {
  if (!(x > 0)) return 0;
  Real root = std::sqrt(static_cast<double>(x));
  if (!(root > 0)) return 0;
  for (int i = 0; i < 2; ++i) root = (root + x / root) / 2;
  return root;
}

struct Vec {
  Real x = 0, y = 0, z = 0;

  Vec() = default;
  Vec(Real a, Real b, Real c) : x(a), y(b), z(c) {}
  explicit Vec(const Vec3& v) : x(v.x()), y(v.y()), z(v.z()) {}
  Vec3 rounded() const { return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}; }
  Vec& operator+=(const Vec& o) { return *this = {x + o.x, y + o.y, z + o.z}; }
};

inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(const Vec& a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(Real s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec operator/(const Vec& a, Real s) { return {a.x / s, a.y / s, a.z / s}; }
inline Real dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Real norm(const Vec& a) { return sqrt(dot(a, a)); }

/// Some unit vector at right angles to v (not zero).
inline Vec perpendicular(const Vec& v) {
  Vec least = abs(v.x) < abs(v.y) ? Vec{1, 0, 0} : Vec{0, 1, 0};
  if (abs(v.z) < abs(dot(least, v))) least = {0, 0, 1};
  const Vec p = cross(v, least);
  return p / norm(p);
}

}  // namespace tandem::reference
