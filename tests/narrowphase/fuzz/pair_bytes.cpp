// Makes pairs of shapes from bytes.
#include "pair_bytes.h"

#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace tandem::test {
namespace {

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() { return at_ < bytes_.size() ? bytes_[at_++] : std::uint8_t{0}; }
  std::uint64_t word() {
    std::uint64_t w = 0;
    for (int i = 0; i < 8; ++i) w = w << 8 | byte();
    return w;
  }
  double unit() { return static_cast<double>(word() >> 11) * 0x1p-53; }

  /// A length > 0: usually a simple one, else any of a decade, else any double.
  double length() {
    constexpr std::array<double, 8> round = {1, 0.5, 2, 0.25, 1.5, 0.1, 0.3, 3};
    const std::uint8_t mode = byte();
    if (mode < 128) return round[mode % round.size()];
    if (mode < 224) return (0.1 + 0.9 * unit()) * decade();
    if (mode < 248) return round[mode % round.size()] * decade();
    return std::bit_cast<double>(word());
  }
  double coordinate() {
    const std::uint8_t sign = byte();
    if (sign % 4 == 0) return 0;
    return sign % 4 == 1 ? length() : -length();
  }
  Vec3 point() {
    const double x = coordinate(), y = coordinate();
    return {x, y, coordinate()};
  }

 private:
  double decade() {
    // Most sizes are near 1; some are extreme.
    const std::uint8_t b = byte();
    const int exponent = b < 192 ? b % 5 - 2 : b % 25 - 12;
    double d = 1;
    for (int i = 0; i < std::abs(exponent); ++i) d *= 10;
    return exponent < 0 ? 1 / d : d;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

Shape read_shape(Reader& r) {
  switch (static_cast<ShapeKind>(r.byte() % 9)) {
    case ShapeKind::sphere:
      return Shape(Sphere{r.byte() % 8 == 0 ? 0.0 : r.length()});
    case ShapeKind::box: {
      const double x = r.length(), y = r.length();
      return Shape(Box{{x, y, r.length()}});
    }
    case ShapeKind::capsule: {
      const double radius = r.length();
      return Shape(Capsule{radius, r.byte() % 8 == 0 ? 0.0 : r.length()});
    }
    case ShapeKind::cylinder: {
      const double radius = r.length();
      return Shape(Cylinder{radius, r.length()});
    }
    case ShapeKind::cone: {
      const double radius = r.length();
      return Shape(Cone{radius, r.length()});
    }
    case ShapeKind::ellipsoid: {
      const double x = r.length(), y = r.length();
      return Shape(Ellipsoid{{x, y, r.length()}});
    }
    case ShapeKind::halfspace: {
      const Vec3 n = r.point();
      return Shape(HalfSpace{n, r.coordinate()});
    }
    case ShapeKind::convex: {
      Convex hull;
      const int points = 1 + r.byte() % 20;
      for (int i = 0; i < points; ++i) hull.vertices.push_back(r.point());
      return Shape(hull);
    }
    default: {
      const Vec3 p = r.point(), q = r.point();
      return Shape(Triangle{{p, q, r.point()}});
    }
  }
}

Mat3 read_rotation(Reader& r) {
  const std::uint8_t mode = r.byte();
  Mat3 m = Mat3::Identity();
  if (mode < 64) return m;
  if (mode < 128) {  // quarter turns
    for (int turns = mode % 4; turns > 0; --turns) m = (Mat3() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished() * m;
    for (int turns = mode / 4 % 3; turns > 0; --turns) m = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished() * m;
    return m;
  }
  Quat q(1, 0, 0, 0);
  if (mode < 192) {  // tiny angles
    const double small = std::ldexp(1.0, -(20 + mode % 33));
    q = Quat{1, small * (r.unit() - 0.5), small * (r.unit() - 0.5), small * (r.unit() - 0.5)};
  } else {
    q = Quat{r.unit() - 0.5, r.unit() - 0.5, r.unit() - 0.5, r.unit() - 0.5};
  }
  return q.norm() > 1e-3 ? q.normalized().toRotationMatrix() : m;
}

Pose read_pose_of_b(Reader& r, const Shape& a, const Pose& pose_a, const Shape& b) {
  Pose p{read_rotation(r), pose_a.translation};
  const std::uint8_t turned = r.byte();
  if (turned % 2 == 0) p.rotation = pose_a.rotation * p.rotation;
  const std::uint8_t mode = r.byte();
  if (mode < 32) return p;  // concentric
  if (mode < 96) {
    p.translation += r.point();
    return p;
  }
  if (!a.is_bounded() || !b.is_bounded()) {
    p.translation += r.point();
    return p;
  }
  // Their bounding boxes touch along an axis, or almost.
  const Bounds box_a = a.bounds(pose_a), box_b = b.bounds({p.rotation, pose_a.translation});
  const int k = mode % 3;
  const double touch = box_a.hi[k] - box_b.lo[k];
  constexpr std::array<double, 10> hairs = {0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8, -1e-8, 1e-3, -1e-3, -0.3};
  p.translation[k] += touch * (1 + hairs[r.byte() % hairs.size()]);
  if (mode % 2 == 0) p.translation[(k + 1) % 3] += touch * (r.unit() - 0.5);
  if (mode % 4 == 0) p.translation[(k + 2) % 3] += touch * (r.unit() - 0.5);
  return p;
}

}  // namespace

std::optional<reference::PosedPair> pair_from_bytes(std::span<const std::uint8_t> bytes) {
  Reader r(bytes);
  try {
    const Shape a = read_shape(r), b = read_shape(r);
    if (!a.is_bounded() && !b.is_bounded()) return std::nullopt;
    Pose pose_a{read_rotation(r), Vec3::Zero()};
    if (r.byte() % 2 == 0) pose_a.translation = r.point();
    const Pose pose_b = read_pose_of_b(r, a, pose_a, b);
    require_valid(pose_a, "A");
    require_valid(pose_b, "B");
    return reference::PosedPair{a, pose_a, b, pose_b};
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace tandem::test
