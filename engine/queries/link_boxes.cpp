// Boxes of links in many configurations, and the separating axes of two rotated boxes, in SIMD lanes.
#include "queries/link_boxes.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "scene/tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "queries/link_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, PoseNumbers::most_lanes>;
using V = hn::VFromD<Floats>;
using M = decltype(hn::Eq(hn::Zero(Floats()), hn::Zero(Floats())));
constexpr std::size_t poses_ahead = 32;  // poses prefetched before they are read

HWY_INLINE V set(double x) { return hn::Set(Floats(), static_cast<float>(x)); }

// Converts `count` configurations' poses to single precision, in memory order. Four numbers of a pose are contiguous,
// and vector i of `lanes` poses holds those of pose i, i + 4, ..., one in each of its blocks of four, so that only
// blocks have to be transposed. Gathers would be slow by some processors' microcode; a vector stored in parts and
// loaded at once would wait for the stores. Returns false if the last row of a matrix is not 0, 0, 0, 1.
bool copy_numbers(const PoseList& poses, std::size_t links, std::size_t count, PoseNumbers* numbers) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> f;
  const std::size_t lanes = hn::Lanes(Floats()), stride = poses.stride(), ahead = poses_ahead * stride;
  HWY_ALIGN constexpr double last_row[4] = {0, 0, 0, 1};
  const bool by_rows = poses.are_matrices();
  for (std::size_t link = 0; link < links; ++link) numbers[link].by_rows = by_rows;
  const double *pose = poses.numbers(0), *end = poses.numbers(poses.size());
  auto right = hn::Eq(hn::Zero(d), hn::Zero(d));
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t in_vector = k % lanes;
    const std::size_t to = (k - in_vector + in_vector % 4 * lanes / 4) * 4 + in_vector / 4 * 4;
    for (std::size_t link = 0; link < links; ++link, pose += stride) {
      if (end - pose > static_cast<std::ptrdiff_t>(ahead)) {
        hwy::Prefetch(pose + ahead);
        hwy::Prefetch(pose + ahead + 9);
      }
      for (std::size_t n = 0; n < 12; n += hn::Lanes(d))
        hn::StoreU(hn::DemoteTo(f, hn::LoadU(d, pose + n)), f, &numbers[link].groups[n / 4][to + n % 4]);
      for (std::size_t n = 0; by_rows && n < 4; n += hn::Lanes(d))
        right = hn::And(right, hn::Eq(hn::LoadU(d, pose + 12 + n), hn::Load(d, last_row + n)));
    }
  }
  return hn::AllTrue(d, right);
}

// Transposes four vectors of blocks of four.
HWY_INLINE void turn(const float* blocks, V* columns) {
  const Floats f;
  const std::size_t lanes = hn::Lanes(f);
  const V a = hn::Load(f, blocks), b = hn::Load(f, blocks + lanes);
  const V c = hn::Load(f, blocks + 2 * lanes), e = hn::Load(f, blocks + 3 * lanes);
#if HWY_TARGET == HWY_SCALAR
  columns[0] = a, columns[1] = b, columns[2] = c, columns[3] = e;
#else
  const V ac = hn::InterleaveLower(f, a, c), be = hn::InterleaveLower(f, b, e);
  const V ac_upper = hn::InterleaveUpper(f, a, c), be_upper = hn::InterleaveUpper(f, b, e);
  columns[0] = hn::InterleaveLower(f, ac, be), columns[1] = hn::InterleaveUpper(f, ac, be);
  columns[2] = hn::InterleaveLower(f, ac_upper, be_upper), columns[3] = hn::InterleaveUpper(f, ac_upper, be_upper);
#endif
}

// The poses of a vector's lanes: nine numbers of rotations by columns, three of translations.
struct Poses {
  V x[12];
  HWY_INLINE Poses(const PoseNumbers& numbers, std::size_t k) {
    V columns[12];
    for (std::size_t group = 0; group < 3; ++group) turn(numbers.groups[group].data() + 4 * k, columns + 4 * group);
    if (numbers.by_rows)
      for (std::size_t n = 0; n < 12; ++n) x[n] = columns[n % 3 * 4 + n / 3];
    else
      for (std::size_t n = 0; n < 12; ++n) x[n] = columns[n];
  }
  HWY_INLINE explicit Poses(const std::array<float, 12>& pose) {
    for (std::size_t n = 0; n < 12; ++n) x[n] = hn::Set(Floats(), pose[n]);
  }
  HWY_INLINE V axis_dot(int i, const Poses& b, int j) const {
    return hn::Add(hn::Add(hn::Mul(x[3 * i], b.x[3 * j]), hn::Mul(x[3 * i + 1], b.x[3 * j + 1])),
                   hn::Mul(x[3 * i + 2], b.x[3 * j + 2]));
  }
  HWY_INLINE V axis_dot(int i, const V* v) const {
    return hn::Add(hn::Add(hn::Mul(x[3 * i], v[0]), hn::Mul(x[3 * i + 1], v[1])), hn::Mul(x[3 * i + 2], v[2]));
  }
  HWY_INLINE V coordinate(int row, const LinkBox& box) const {
    V at = x[9 + row];
    for (int column = 0; column < 3; ++column) at = hn::Add(at, hn::Mul(x[3 * column + row], set(box.centre[column])));
    return at;
  }
};

// The lanes whose poses are rotations and translations within the limits, to single precision. NaN fails each
// comparison.
HWY_INLINE M are_poses(const Poses& p) {
  const Floats f;
  const auto squared = [](V v) HWY_ATTR { return hn::Mul(v, v); };
  const auto mixed = [&](int i, int j, int k) HWY_ATTR {
    return hn::Mul(p.x[6 + k], hn::Sub(hn::Mul(p.x[i], p.x[3 + j]), hn::Mul(p.x[j], p.x[3 + i])));
  };
  const V one = set(1);
  const V off = hn::Add(
      hn::Add(hn::Add(squared(hn::Sub(p.axis_dot(0, p, 0), one)), squared(hn::Sub(p.axis_dot(1, p, 1), one))),
              squared(hn::Sub(p.axis_dot(2, p, 2), one))),
      hn::Add(hn::Add(squared(p.axis_dot(0, p, 1)), squared(p.axis_dot(0, p, 2))), squared(p.axis_dot(1, p, 2))));
  auto valid = hn::Le(off, set(tolerance::skew_of_links * tolerance::skew_of_links));
  valid = hn::And(valid, hn::Gt(hn::Add(hn::Add(mixed(1, 2, 0), mixed(2, 0, 1)), mixed(0, 1, 2)), hn::Zero(f)));
  for (int row = 0; row < 3; ++row) valid = hn::And(valid, hn::Le(hn::Abs(p.x[9 + row]), set(1e30)));
  return valid;
}

// Computes the boxes of one link in world axes from the converted poses, and their union.
bool boxes_of(const LinkBox& link, const PoseNumbers& numbers, std::size_t count, BoxArray& boxes, std::size_t at,
              Aabb& all) {
  const Floats f;
  const V radius = set(link.radius), reach = set(link.reach()), rounding = set(tolerance::bound_of_floats);
  const V smallest = set(double{std::numeric_limits<float>::min()});
  V least[3], most[3];
  for (int row = 0; row < 3; ++row) {
    least[row] = hn::Set(f, std::numeric_limits<float>::infinity());
    most[row] = hn::Neg(least[row]);
  }
  bool valid = true;
  for (std::size_t k = 0; k < count; k += hn::Lanes(f)) {
    const Poses poses(numbers, k);
    const M taken = hn::FirstN(f, count - k);  // the other lanes hold old poses
    valid = valid && hn::AllFalse(f, hn::AndNot(are_poses(poses), taken));
    for (int row = 0; row < 3; ++row) {
      const V middle = poses.coordinate(row, link);
      V extent = radius;
      for (int column = 0; column < 3; ++column)
        extent = hn::Add(extent, hn::Mul(hn::Abs(poses.x[3 * column + row]), set(link.half[column])));
      extent = hn::Add(extent, hn::Add(hn::Mul(hn::Add(hn::Abs(poses.x[9 + row]), reach), rounding), smallest));
      // Elements written past the count are overwritten later, or lie unused between two links' boxes.
      const V lo = hn::Sub(middle, extent), hi = hn::Add(middle, extent);
      hn::StoreU(lo, f, boxes.lo(row) + at + k);
      hn::StoreU(hi, f, boxes.hi(row) + at + k);
      least[row] = hn::IfThenElse(taken, hn::Min(least[row], lo), least[row]);
      most[row] = hn::IfThenElse(taken, hn::Max(most[row], hi), most[row]);
    }
  }
  for (int row = 0; row < 3; ++row) {
    float &lo = all.lo[static_cast<std::size_t>(row)], &hi = all.hi[static_cast<std::size_t>(row)];
    lo = std::min(lo, hn::GetLane(hn::MinOfLanes(f, least[row])));
    hi = std::max(hi, hn::GetLane(hn::MaxOfLanes(f, most[row])));
  }
  return valid;
}

// A lower bound on the distance of two boxes: the largest separation along the normals of their faces and along the
// cross products of their edges (Gottschalk, Lin and Manocha, "OBBTree", 1996), whose length is at most 1, less the
// errors of rounding and of rotations that are not quite orthonormal.
V gaps(const LinkBox& box_a, const Poses& a, const LinkBox& box_b, const Poses& b) {
  V off[3], size[3][3], mixed[3][3], along_a[3], half_a[3], half_b[3];
  V place = hn::Zero(Floats()), far = set(box_a.reach() + box_b.reach());
  for (int k = 0; k < 3; ++k) {
    off[k] = hn::Sub(b.coordinate(k, box_b), a.coordinate(k, box_a));
    place = hn::Add(place, hn::Add(hn::Abs(a.x[9 + k]), hn::Abs(b.x[9 + k])));
    far = hn::Add(far, hn::Abs(off[k]));
    half_a[k] = set(box_a.half[k]), half_b[k] = set(box_b.half[k]);
  }
  V most = hn::Neg(far);
  for (int i = 0; i < 3; ++i) {
    along_a[i] = a.axis_dot(i, off);
    V extent = half_a[i];
    for (int j = 0; j < 3; ++j) {
      mixed[i][j] = a.axis_dot(i, b, j);
      size[i][j] = hn::Abs(mixed[i][j]);
      extent = hn::Add(extent, hn::Mul(half_b[j], size[i][j]));
    }
    most = hn::Max(most, hn::Sub(hn::Abs(along_a[i]), extent));
  }
  for (int j = 0; j < 3; ++j) {
    V extent = half_b[j];
    for (int i = 0; i < 3; ++i) extent = hn::Add(extent, hn::Mul(half_a[i], size[i][j]));
    most = hn::Max(most, hn::Sub(hn::Abs(b.axis_dot(j, off)), extent));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const V along = hn::Sub(hn::Mul(along_a[i2], mixed[i1][j]), hn::Mul(along_a[i1], mixed[i2][j]));
      const V extent = hn::Add(hn::Add(hn::Mul(half_a[i1], size[i2][j]), hn::Mul(half_a[i2], size[i1][j])),
                               hn::Add(hn::Mul(half_b[j1], size[i][j2]), hn::Mul(half_b[j2], size[i][j1])));
      most = hn::Max(most, hn::Sub(hn::Abs(along), extent));
    }
  const V lost = hn::Add(hn::Mul(place, set(tolerance::bound_of_floats)), hn::Mul(far, set(tolerance::gap_of_floats)));
  return hn::Sub(most, hn::Add(set(box_a.radius + box_b.radius), lost));
}

struct Row {
  const float *lo[3], *hi[3];
  HWY_INLINE Row(const BoxArray& boxes, std::size_t at) {
    for (int k = 0; k < 3; ++k) lo[k] = boxes.lo(k) + at, hi[k] = boxes.hi(k) + at;
  }
};

template <class Overlaps, class Gaps>
HWY_INLINE std::uint64_t bits_where(std::size_t count, const Overlaps& overlaps, const Gaps& gaps_at) {
  const Floats f;
  std::uint64_t all = 0;
  for (std::size_t k = 0; k < count; k += hn::Lanes(f)) {
    auto meet = overlaps(k);
    if (hn::AllFalse(f, meet)) continue;
    meet = hn::And(meet, hn::Le(gaps_at(k), hn::Zero(f)));
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, meet, bytes);
    std::uint64_t bits = 0;
    std::memcpy(&bits, bytes, 2);
    all |= bits << k;
  }
  return count < 64 ? all & ((std::uint64_t{1} << count) - 1) : all;
}

// NOLINTBEGIN(misc-definitions-in-headers): included once a target
bool take_boxes(const LinkBox* links, std::size_t n, const PoseList& poses, std::size_t count,
                const LinkBoxScratch& scratch) {
  bool valid = copy_numbers(poses, n, count, scratch.numbers);
  for (std::size_t i = 0; i < n; ++i)
    valid = boxes_of(links[i], scratch.numbers[i], count, *scratch.boxes, i * scratch.stride + scratch.at,
                     scratch.swept[i]) &&
            valid;
  return valid;
}

std::uint64_t meeting_links(const LinkInPart& a, const LinkInPart& b, const BoxArray* boxes, std::size_t count) {
  const Floats f;
  const Row p(*boxes, a.at), q(*boxes, b.at);
  return bits_where(
      count,
      [&](std::size_t k) HWY_ATTR {
        auto meet = hn::Le(hn::LoadU(f, p.lo[0] + k), hn::LoadU(f, q.hi[0] + k));
        meet = hn::And(meet, hn::Le(hn::LoadU(f, q.lo[0] + k), hn::LoadU(f, p.hi[0] + k)));
        for (int axis = 1; axis < 3; ++axis) {
          meet = hn::And(meet, hn::Le(hn::LoadU(f, p.lo[axis] + k), hn::LoadU(f, q.hi[axis] + k)));
          meet = hn::And(meet, hn::Le(hn::LoadU(f, q.lo[axis] + k), hn::LoadU(f, p.hi[axis] + k)));
        }
        return meet;
      },
      [&](std::size_t k) HWY_ATTR { return gaps(*a.box, Poses(*a.numbers, k), *b.box, Poses(*b.numbers, k)); });
}

std::uint64_t meeting_body(const LinkInPart& a, const PlacedBox& body, const BoxArray* boxes, std::size_t count) {
  const Floats f;
  const Row p(*boxes, a.at);
  const Poses pose(body.pose);
  return bits_where(
      count,
      [&](std::size_t k) HWY_ATTR {
        auto meet = hn::Le(hn::LoadU(f, p.lo[0] + k), hn::Set(f, body.world.hi[0]));
        meet = hn::And(meet, hn::Le(hn::Set(f, body.world.lo[0]), hn::LoadU(f, p.hi[0] + k)));
        for (std::size_t axis = 1; axis < 3; ++axis) {
          meet = hn::And(meet, hn::Le(hn::LoadU(f, p.lo[axis] + k), hn::Set(f, body.world.hi[axis])));
          meet = hn::And(meet, hn::Le(hn::Set(f, body.world.lo[axis]), hn::LoadU(f, p.hi[axis] + k)));
        }
        return meet;
      },
      [&](std::size_t k) HWY_ATTR { return gaps(*a.box, Poses(*a.numbers, k), body.own, pose); });
}

double gap_of_body(const LinkInPart& a, const PlacedBox& body, std::size_t k) {
  const Floats f;
  const std::size_t lane = k % hn::Lanes(f);
  HWY_ALIGN float all[PoseNumbers::most_lanes];
  hn::Store(gaps(*a.box, Poses(*a.numbers, k - lane), body.own, Poses(body.pose)), f, all);
  return double{all[lane]};
}
// NOLINTEND(misc-definitions-in-headers)

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(take_boxes);
HWY_EXPORT(meeting_links);
HWY_EXPORT(meeting_body);
HWY_EXPORT(gap_of_body);

LinkBox::LinkBox(const Shape& link, const WorkLimit* limit) : radius(link.rounding()) {
  const Bounds own = link.bounds(Pose{}, limit);
  centre = (own.lo + own.hi) / 2;
  half = (own.hi - own.lo) / 2 - Vec3::Constant(link.rounding());
  if (link.kind() == ShapeKind::sphere || link.kind() == ShapeKind::capsule) {
    half -= Vec3::Constant(link.radius());
    radius += link.radius();
  }
  half = half.cwiseMax(0.0);
}

PlacedBox::PlacedBox(const LinkBox& box, const Pose& at, const Aabb& in_world) : own(box), world(in_world) {
  for (std::size_t k = 0; k < 9; ++k) pose[k] = static_cast<float>(at.rotation.data()[k]);
  for (std::size_t k = 0; k < 3; ++k) pose[9 + k] = static_cast<float>(at.translation.data()[k]);
}

// The same as `gaps` for a single pair, one axis after the other.
bool known_apart(const LinkBox& a, const Pose& pose_a, const LinkBox& b, const Pose& pose_b) {
  const Mat3 &p = pose_a.rotation, &q = pose_b.rotation;
  const Vec3 off = pose_b * b.centre - pose_a * a.centre;
  const double place = pose_a.translation.lpNorm<1>() + pose_b.translation.lpNorm<1>();
  const double far = a.half.lpNorm<1>() + a.centre.lpNorm<1>() + a.radius + b.half.lpNorm<1>() + b.centre.lpNorm<1>() +
                     b.radius + off.lpNorm<1>();
  const double near = a.radius + b.radius + place * tolerance::bound_of_floats + far * tolerance::gap_of_floats;
  Mat3 mixed, size;
  Vec3 along;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) mixed(i, j) = p.col(i).dot(q.col(j));
    size.row(i) = mixed.row(i).cwiseAbs();
    along[i] = p.col(i).dot(off);
    if (std::abs(along[i]) - (a.half[i] + size.row(i).dot(b.half)) > near) return true;
  }
  for (int j = 0; j < 3; ++j)
    if (std::abs(q.col(j).dot(off)) - (b.half[j] + size.col(j).dot(a.half)) > near) return true;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double extent =
          a.half[i1] * size(i2, j) + a.half[i2] * size(i1, j) + b.half[j1] * size(i, j2) + b.half[j2] * size(i, j1);
      if (std::abs(along[i2] * mixed(i1, j) - along[i1] * mixed(i2, j)) - extent > near) return true;
    }
  return false;
}

bool LinkBoxes::take(std::span<const LinkBox> links, const PoseList& poses, std::size_t first, std::size_t count,
                     const WorkLimit& limit) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  const std::size_t n = links.size();
  links_ = links;
  count_ = count;
  stride_ = (count + PoseNumbers::most_lanes - 1) / PoseNumbers::most_lanes * PoseNumbers::most_lanes;
  if (boxes_.size() < n * stride_) boxes_.resize(n * stride_);
  if (numbers_.size() < n * parts()) numbers_.resize(n * parts());
  swept_.assign(n, {{inf, inf, inf}, {-inf, -inf, -inf}});
  bool valid = true;
  for (std::size_t part = 0; part < parts(); ++part) {
    if (part > 0 && limit.reached()) throw WorkStopped();
    const std::size_t at = part * PoseNumbers::count;
    const LinkBoxScratch scratch{&boxes_, stride_, at, swept_.data(), numbers_.data() + part * n};
    valid = HWY_DYNAMIC_DISPATCH(take_boxes)(links.data(), n, poses.from((first + at) * n),
                                             std::min(PoseNumbers::count, count - at), scratch) &&
            valid;
  }
  return valid;
}

LinkInPart LinkBoxes::in_part(std::size_t part, std::size_t link) const {
  return {&links_[link], &numbers_[part * links_.size() + link], link * stride_ + part * PoseNumbers::count};
}

std::uint64_t LinkBoxes::meeting(std::size_t part, std::size_t link, std::size_t other) const {
  const std::size_t some = std::min(PoseNumbers::count, count_ - part * PoseNumbers::count);
  return HWY_DYNAMIC_DISPATCH(meeting_links)(in_part(part, link), in_part(part, other), &boxes_, some);
}

std::uint64_t LinkBoxes::meeting(std::size_t part, std::size_t link, const PlacedBox& body) const {
  const std::size_t some = std::min(PoseNumbers::count, count_ - part * PoseNumbers::count);
  return HWY_DYNAMIC_DISPATCH(meeting_body)(in_part(part, link), body, &boxes_, some);
}

double LinkBoxes::gap(std::size_t k, std::size_t link, const PlacedBox& body) const {
  return HWY_DYNAMIC_DISPATCH(gap_of_body)(in_part(k / PoseNumbers::count, link), body, k % PoseNumbers::count);
}

}  // namespace tandem
#endif
