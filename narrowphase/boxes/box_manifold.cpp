// The contact manifold of two boxes: the incident face clipped by the reference face (Sutherland and Hodgman 1974).
#include "boxes/box_manifold.h"

#include <bit>

#include "manifold/manifold.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// A point relative to the reference face: two coordinates in its plane, and the height above its box's centre.
struct PlanePoint {
  double u, w, height;
};
PlanePoint operator+(const PlanePoint& p, const PlanePoint& q) { return {p.u + q.u, p.w + q.w, p.height + q.height}; }
PlanePoint operator*(double s, const PlanePoint& p) { return {s * p.u, s * p.w, s * p.height}; }

// The signs of a rectangle's corners along its two axes, counterclockwise.
constexpr double side_u[4] = {1, -1, -1, 1}, side_w[4] = {1, 1, -1, -1};

// The features that meet in a contact point, as its name: the face of each box, then the corner or edge of the face,
// the reference box's first. Bodies are distinguished by their order, so that a name is the same in the next step.
enum class Meeting : std::uint32_t { incident_corner = 0, reference_corner = 1, edges = 2 };
std::uint32_t feature_name(int reference_face, int incident_face, Meeting meeting, int of_reference, int of_incident,
                           bool reference_is_b) {
  return (reference_is_b ? 1u << 31 : 0u) | static_cast<std::uint32_t>(meeting) << 16 |
         static_cast<std::uint32_t>(reference_face) << 12 | static_cast<std::uint32_t>(incident_face) << 8 |
         static_cast<std::uint32_t>(of_reference) << 4 | static_cast<std::uint32_t>(of_incident);
}

/// The reference face in its box's frame; `tilted`: the contact normal is not the face's.
struct Carrier {
  int axis;
  double side;
  bool tilted;
};

/// Appends the points of the patch; nothing for an edge axis whose deepest point the patch misses.
void append_patch(PatchPoint* points, int count, const Carrier& face, double signed_distance, double size,
                  const Pose& pose, const Vec3& world_normal, std::vector<Contact>& contacts) {
  if (face.tilted) {
    // The crossing of the two edges must be among the points; the deepest one represents it.
    int deepest = 0;
    for (int i = 1; i < count; ++i)
      if (points[i].depth > points[deepest].depth) deepest = i;
    if (count == 0 || points[deepest].depth + 0.02 * (tolerance::alike * size) < -signed_distance) return;
    points[deepest].depth = -signed_distance;
  }
  Vec3 normal = Vec3::Zero();
  normal[face.axis] = face.side;
  count = span_patch(points, count, normal, size);
  append_points(points, count, pose, world_normal, contacts);
}

/// The reference face: its box and axis. Of faces that lie on each other either would do, and which separates by more,
/// or whether an edge axis does, depends on rounding: A's is taken.
struct ReferenceAxis {
  bool of_b;
  int axis;
};
ReferenceAxis choose_reference(const BoxAnswer& answer, const Pose& pose_b, const Vec3& world_normal) {
  const Vec3& in_a = answer.local.normal;
  ReferenceAxis out{answer.axis >= 3, answer.axis % 3};
  if (answer.axis >= 6) {
    const Vec3 in_b = pose_b.rotation.transpose() * world_normal;
    int face_a = 0, face_b = 0;
    for (int i = 1; i < 3; ++i) {
      if (std::abs(in_a[i]) > std::abs(in_a[face_a])) face_a = i;
      if (std::abs(in_b[i]) > std::abs(in_b[face_b])) face_b = i;
    }
    out.of_b = std::abs(in_a[face_a]) + tolerance::alike_cosines < std::abs(in_b[face_b]);
    out.axis = out.of_b ? face_b : face_a;
  }
  for (int i = 0; i < 3; ++i)
    if (std::abs(in_a[i]) > tolerance::flush_face) out = {false, i};
  return out;
}

double at_axis(const HalfSize& h, int i) { return h[static_cast<std::size_t>(i)]; }

/// Clips the rectangle of the incident face by that of the reference face.
class FaceClip {
 public:
  /// `away`: the normal in the world, pointing out of the reference box; `slants`: it is an edge axis. Metres.
  FaceClip(const HalfSize& reference, const Pose& pose, const HalfSize& incident, const Pose& other,
           const ReferenceAxis& chosen, const Vec3& away, bool slants, double most_depth, double margin)
      : of_b_(chosen.of_b),
        axis_(chosen.axis),
        iu_((axis_ + 1) % 3),
        iw_((axis_ + 2) % 3),
        slants_(slants),
        most_depth_(most_depth),
        margin_(margin),
        size_(reference[0] + reference[1] + reference[2] + incident[0] + incident[1] + incident[2]),
        near_(tolerance::alike * size_),
        au_(at_axis(reference, iu_)),
        aw_(at_axis(reference, iw_)),
        top_(at_axis(reference, axis_)) {
    const auto row = [&](int i, const Vec3& v) { return pose.rotation.col(i).dot(v); };
    // Depths are measured along the normal, and points lie midway along it: its components relative to the face.
    const double along_face = row(axis_, away);
    side_ = along_face >= 0 ? 1.0 : -1.0;
    slant_ = slants ? std::abs(along_face) : 1.0;
    slip_u_ = slants ? row(iu_, away) : 0.0, slip_w_ = slants ? row(iw_, away) : 0.0;
    const Vec3 outward = side_ * pose.rotation.col(axis_);

    // The incident face is the one most opposed to the reference face's normal; of two alike, the first.
    int k = 0;
    double facing = std::abs(outward.dot(other.rotation.col(0)));
    for (int j = 1; j < 3; ++j) {
      const double f = std::abs(outward.dot(other.rotation.col(j)));
      if (f > facing + tolerance::alike) facing = f, k = j;
    }
    const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    const double towards = outward.dot(other.rotation.col(k)) > 0 ? -1.0 : 1.0;
    const auto in_plane = [&](const Vec3& v) { return PlanePoint{row(iu_, v), row(iw_, v), outward.dot(v)}; };
    const Vec3 d = other.translation - pose.translation;
    centre_ = in_plane(d + towards * at_axis(incident, k) * other.rotation.col(k));
    e1_ = in_plane(at_axis(incident, k1) * other.rotation.col(k1));
    e2_ = in_plane(at_axis(incident, k2) * other.rotation.col(k2));
    half1_ = at_axis(incident, k1), half2_ = at_axis(incident, k2);
    if (slants) shear();
    reference_face_ = 2 * axis_ + (side_ > 0 ? 0 : 1), incident_face_ = 2 * k + (towards > 0 ? 0 : 1);
  }

  Carrier carrier(bool tilted) const { return {axis_, side_, tilted}; }

  /// If the deepest corner is the only one of the face that touches, and the touching region around it lies well inside
  /// the reference face, the corner is the whole patch, and is appended.
  bool append_lone_corner(const Pose& pose, const Vec3& world_normal, std::vector<Contact>& contacts) const {
    const double lowest = centre_.height - std::abs(e1_.height) - std::abs(e2_.height),
                 touching = top_ + (margin_ + near_) * slant_;
    const double rise1 = 2 * std::abs(e1_.height), rise2 = 2 * std::abs(e2_.height), clearance = touching - lowest;
    if (!(clearance < rise1 && clearance < rise2)) return false;
    const bool down1 = e1_.height < 0, down2 = e2_.height < 0;
    const int at = down1 ? (down2 ? 0 : 3) : (down2 ? 1 : 2);
    const PlanePoint c = centre_ + (side_u[at] * e1_ + side_w[at] * e2_);
    const double back1 = -2 * side_u[at], back2 = -2 * side_w[at], wide_u = au_ - near_, wide_w = aw_ - near_;
    const auto over = [&](double back, const PlanePoint& e, double rise) {
      return std::abs(c.u * rise + clearance * (back * e.u)) < wide_u * rise &&
             std::abs(c.w * rise + clearance * (back * e.w)) < wide_w * rise;
    };
    if (slants_ || !(clearance >= 0) || !(std::abs(c.u) < wide_u && std::abs(c.w) < wide_w) ||
        !over(back1, e1_, rise1) || !over(back2, e2_, rise2))
      return false;
    const double depth = std::max(std::min(top_ - c.height, most_depth_), -margin_);
    Vec3 point;
    point[iu_] = c.u;
    point[iw_] = c.w;
    point[axis_] = side_ * (top_ - 0.5 * depth);
    contacts.push_back({pose * point, world_normal, depth, name(Meeting::incident_corner, 0, at)});
    return true;
  }

  /// Sets the points of the patch: corners of either face over the other, and crossings of their edges. Returns how
  /// many.
  int clip(PatchPoint* points) {
    points_ = points;
    PlanePoint corner[4];
    bool inside[4];
    int inner = 0;
    for (int i = 0; i < 4; ++i) {
      corner[i] = centre_ + (side_u[i] * e1_ + side_w[i] * e2_);
      inside[i] = std::abs(corner[i].u) <= au_ + near_ && std::abs(corner[i].w) <= aw_ + near_;
      inner += inside[i] ? 1 : 0;
    }
    for (int i = 0; i < 4; ++i)
      if (inside[i]) add(corner[i], Meeting::incident_corner, 0, i);
    if (inner < 4 && add_reference_corners() < 4) add_crossings(corner);
    return count_;
  }

  double size() const { return size_; }  ///< of both boxes together

 private:
  std::uint32_t name(Meeting meeting, int of_reference, int of_incident) const {
    return feature_name(reference_face_, incident_face_, meeting, of_reference, of_incident, of_b_);
  }

  /// Shears the incident face along the normal, so that its points are projected onto the reference plane along it.
  void shear() {
    const double lean_u = slip_u_ / slant_, lean_w = slip_w_ / slant_;
    const double below = top_ - centre_.height;
    centre_.u += lean_u * below, centre_.w += lean_w * below;
    e1_.u -= lean_u * e1_.height, e1_.w -= lean_w * e1_.height;
    e2_.u -= lean_u * e2_.height, e2_.w -= lean_w * e2_.height;
  }

  /// Adds a point. Its depth is at most the pair's, since moving by that separates the boxes; a depth just below
  /// touching is rounded up to it.
  void add(const PlanePoint& p, Meeting meeting, int of_reference, int of_incident) {
    const double depth = std::min((top_ - p.height) / slant_, most_depth_);
    if (depth < -margin_ - near_) return;
    const double kept = std::max(depth, -margin_);
    PatchPoint& point = points_[count_++];
    point.at[iu_] = std::clamp(p.u, -au_, au_) - 0.5 * kept * slip_u_;
    point.at[iw_] = std::clamp(p.w, -aw_, aw_) - 0.5 * kept * slip_w_;
    point.at[axis_] = side_ * (top_ - 0.5 * kept * slant_);
    point.depth = kept;
    point.feature = name(meeting, of_reference, of_incident);
  }

  /// Adds corners of the reference face that lie under the incident face; returns how many do, including those for
  /// which an incident corner stands.
  int add_reference_corners() {
    // Nonzero: an incident face makes at most the angle of a cube standing on its corner.
    const double det = e1_.u * e2_.w - e1_.w * e2_.u;
    const double near1 = near_ / half1_, near2 = near_ / half2_;
    int covered = 0;
    for (int i = 0; i < 4; ++i) {
      const double u = side_u[i] * au_ - centre_.u, w = side_w[i] * aw_ - centre_.w;
      const double x = (u * e2_.w - w * e2_.u) / det, y = (e1_.u * w - e1_.w * u) / det;
      if (std::abs(x) > 1 + near1 || std::abs(y) > 1 + near2) continue;
      ++covered;
      if (std::abs(x) >= 1 - near1 && std::abs(y) >= 1 - near2) continue;  // the incident corner represents it
      PlanePoint p = centre_ + (x * e1_ + y * e2_);
      p.u = side_u[i] * au_;
      p.w = side_w[i] * aw_;
      add(p, Meeting::reference_corner, i, 0);
    }
    return covered;
  }

  void add_crossings(const PlanePoint* corner) {
    // Lines 0, 1: u = au, -au; 2, 3: w = aw, -aw. A crossing counts only well between the ends of an edge; near an end,
    // the corner represents it.
    double before[4][4];
    unsigned crossed = 0;
    for (int line = 0; line < 4; ++line) {
      const double at = (line % 2 == 0 ? 1.0 : -1.0) * (line < 2 ? au_ : aw_);
      unsigned over = 0, under = 0;
      for (int i = 0; i < 4; ++i) {
        before[line][i] = at - (line < 2 ? corner[i].u : corner[i].w);
        over |= (before[line][i] > near_ ? 1u : 0u) << i;
        under |= (before[line][i] < -near_ ? 1u : 0u) << i;
      }
      const auto next = [](unsigned bits) { return (bits >> 1 | bits << 3) & 15u; };
      const unsigned edges = (over & next(under)) | (under & next(over));
      crossed |= edges << 4 * line;
    }
    for (; crossed != 0; crossed &= crossed - 1) {
      const int bit = std::countr_zero(crossed), line = bit / 4, i = bit % 4;
      const PlanePoint &from = corner[i], &to = corner[(i + 1) % 4];
      const bool on_u = line < 2;
      const double s = before[line][i] / (before[line][i] - before[line][(i + 1) % 4]);
      const double along = on_u ? from.w + s * (to.w - from.w) : from.u + s * (to.u - from.u);
      if (std::abs(along) > (on_u ? aw_ : au_) - near_) continue;
      const double at = (line % 2 == 0 ? 1.0 : -1.0) * (on_u ? au_ : aw_);
      PlanePoint p{on_u ? at : along, on_u ? along : at, from.height + s * (to.height - from.height)};
      add(p, Meeting::edges, line, i);
    }
  }

  bool of_b_;
  int axis_, iu_, iw_;
  bool slants_;
  double most_depth_, margin_, size_, near_, au_, aw_, top_;
  double side_, slant_, slip_u_, slip_w_, half1_, half2_;
  PlanePoint centre_, e1_, e2_;
  int reference_face_, incident_face_;
  PatchPoint* points_ = nullptr;
  int count_ = 0;
};

}  // namespace

void append_box_manifold(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                         const BoxAnswer& answer, double margin, std::vector<Contact>& contacts) {
  const Vec3 world_normal = pose_a.rotation * answer.local.normal;
  const bool slants = answer.axis >= 6, tilted = slants && answer.facing <= tolerance::flush_face;
  const ReferenceAxis chosen = choose_reference(answer, pose_b, world_normal);
  const bool of_b = chosen.of_b;
  const Pose& pose = of_b ? pose_b : pose_a;
  FaceClip clip(of_b ? b : a, pose, of_b ? a : b, of_b ? pose_a : pose_b, chosen,
                of_b ? Vec3(-world_normal) : world_normal, slants, -answer.local.signed_distance, margin);
  if (clip.append_lone_corner(pose, world_normal, contacts)) return;
  PatchPoint points[24];
  const int count = clip.clip(points);
  append_patch(points, count, clip.carrier(tilted), answer.local.signed_distance, clip.size(), pose, world_normal,
               contacts);
}

void append_box_patch(const RectanglePairRows& pairs, std::size_t pair, const RectanglePatchRows& patches,
                      std::size_t column, bool tilted, const HalfSize& a, const Pose& pose_a, const HalfSize& b,
                      const Pose& pose_b, const Vec3& world_normal, std::vector<Contact>& contacts) {
  const auto name = static_cast<std::uint32_t>(static_cast<std::int64_t>(pairs.name[pair]));
  const bool of_b = name >> 31 != 0;
  const int axis = static_cast<int>(name >> 13 & 3), iu = (axis + 1) % 3, iw = (axis + 2) % 3;
  const double side = (name >> 12 & 1) == 0 ? 1.0 : -1.0, top = pairs.top[pair], slant = pairs.slant[pair];
  PatchPoint points[RectanglePatchRows::points];
  int count = 0;
  for (auto left = static_cast<unsigned>(patches.touching[column]); left != 0; left &= left - 1) {
    const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
    PatchPoint& point = points[count++];
    point.depth = patches.depth[i][column];
    point.at[iu] = patches.u[i][column];
    point.at[iw] = patches.w[i][column];
    point.at[axis] = side * (top - 0.5 * point.depth * slant);
    // The name of a corner has its number, that of a crossing both edges' numbers.
    point.feature = name | (i < 4   ? static_cast<std::uint32_t>(Meeting::incident_corner) << 16 | i
                            : i < 8 ? static_cast<std::uint32_t>(Meeting::reference_corner) << 16 | (i - 4) << 4
                                    : static_cast<std::uint32_t>(Meeting::edges) << 16 | (i - 8) / 4 << 4 | i % 4);
  }
  const HalfSize &reference = of_b ? b : a, &incident = of_b ? a : b;
  const double size = reference[0] + reference[1] + reference[2] + incident[0] + incident[1] + incident[2];
  append_patch(points, count, {axis, side, tilted}, pairs.distance[pair], size, of_b ? pose_b : pose_a, world_normal,
               contacts);
}

void append_halfspace_box(const HalfSize& half, const Pose& pose, const Vec3& world_normal, const Vec3& slope,
                          double height, double margin, std::vector<Contact>& contacts) {
  // The lowest corner lies on the face most opposed to the normal, and only this face's corners can touch.
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(slope[i]) > std::abs(slope[k])) k = i;
  const int u = (k + 1) % 3, w = (k + 2) % 3;
  const double side = std::copysign(1.0, -slope[k]);
  const auto size = [&](int i) { return half[static_cast<std::size_t>(i)]; };
  const std::uint32_t face = static_cast<std::uint32_t>(2 * k + (side > 0 ? 0 : 1)) << 8;
  const double middle = height + slope[k] * side * size(k), du = slope[u] * size(u), dw = slope[w] * size(w);
  constexpr double su[4] = {1, -1, -1, 1}, sw[4] = {1, 1, -1, -1};
  const double diagonal = 2 * Vec3(half[0], half[1], half[2]).norm(), slack = tolerance::alike * diagonal;
  PatchPoint points[4];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    const int at = side > 0 ? i : 3 - i;
    const double depth = -(middle + su[at] * du + sw[at] * dw);
    if (depth < -margin - slack) continue;
    PatchPoint& point = points[count++];
    point.at[k] = side * size(k);
    point.at[u] = su[at] * size(u);
    point.at[w] = sw[at] * size(w);
    point.at += 0.5 * depth * slope;
    point.depth = std::max(depth, -margin);
    point.feature = face | static_cast<std::uint32_t>(i);
  }
  if (count > 2 && std::min(size(u), size(w)) > 4 * thin * std::max(size(u), size(w)))
    share_greatest_depth(points, count, slack);  // a half-space's patch has all corners of the face
  else
    count = span_patch(points, count, slope, diagonal);
  append_points(points, count, pose, world_normal, contacts);
}

}  // namespace tandem
