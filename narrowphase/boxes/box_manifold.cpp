#include "boxes/box_manifold.h"

#include <bit>

#include "manifold/manifold.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// A point of the face plane: its two coordinates in the plane, and its height above the box's centre.
struct PlanePoint {
  double u, w, height;
};
PlanePoint operator+(const PlanePoint& p, const PlanePoint& q) { return {p.u + q.u, p.w + q.w, p.height + q.height}; }
PlanePoint operator*(double s, const PlanePoint& p) { return {s * p.u, s * p.w, s * p.height}; }

// The sides of a rectangle's corners, counterclockwise.
constexpr double side_u[4] = {1, -1, -1, 1}, side_w[4] = {1, 1, -1, -1};

// What meets in a point: the reference body's corner or edge first, then the incident one's. Face, then corner or edge
// of the face by number; the two bodies are told apart by place, so that a name says the same in the next step.
enum class Meeting : std::uint32_t { incident_corner = 0, reference_corner = 1, edges = 2 };
std::uint32_t feature_name(int reference_face, int incident_face, Meeting meeting, int of_reference, int of_incident,
                           bool reference_is_b) {
  return (reference_is_b ? 1u << 31 : 0u) | static_cast<std::uint32_t>(meeting) << 16 |
         static_cast<std::uint32_t>(reference_face) << 12 | static_cast<std::uint32_t>(incident_face) << 8 |
         static_cast<std::uint32_t>(of_reference) << 4 | static_cast<std::uint32_t>(of_incident);
}

/// The face that carries a patch, seen from its box; `tilted`: the normal is not its own.
struct Carrier {
  int axis;
  double side;
  bool tilted;
};

/// The end of both: nothing where the patch misses the deepest point of an edges' axis.
void append_patch(PatchPoint* points, int count, const Carrier& face, double signed_distance, double size,
                  const Pose& pose, const Vec3& world_normal, std::vector<Contact>& contacts) {
  if (face.tilted) {
    // Where the edges cross must be among them; the deepest that was found stands for it.
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

}  // namespace

void append_box_manifold(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                         const BoxAnswer& answer, double margin, std::vector<Contact>& contacts) {
  // The reference box carries the face; the other is seen from it. Of faces that lie on each other any will do, and
  // which separates by more, or an edge's axis by more than both, is left to rounding: A's.
  const Vec3& in_a = answer.local.normal;
  const Vec3 world_normal = pose_a.rotation * in_a;
  const bool slants = answer.axis >= 6, tilted = slants && answer.facing <= tolerance::flush_face;
  bool of_b = answer.axis >= 3;
  int axis = answer.axis % 3;
  if (answer.axis >= 6) {
    const Vec3 in_b = pose_b.rotation.transpose() * world_normal;
    int face_a = 0, face_b = 0;
    for (int i = 1; i < 3; ++i) {
      if (std::abs(in_a[i]) > std::abs(in_a[face_a])) face_a = i;
      if (std::abs(in_b[i]) > std::abs(in_b[face_b])) face_b = i;
    }
    of_b = std::abs(in_a[face_a]) + tolerance::alike_cosines < std::abs(in_b[face_b]);
    axis = of_b ? face_b : face_a;
  }
  for (int i = 0; i < 3; ++i)
    if (std::abs(in_a[i]) > tolerance::flush_face) of_b = false, axis = i;
  const int iu = (axis + 1) % 3, iw = (axis + 2) % 3;
  const HalfSize &reference = of_b ? b : a, &incident = of_b ? a : b;
  const Pose &pose = of_b ? pose_b : pose_a, &other = of_b ? pose_a : pose_b;
  const Vec3 d = other.translation - pose.translation;
  const auto row = [&](int i, const Vec3& v) { return pose.rotation.col(i).dot(v); };
  // Depths are measured, and points put midway, along the normal: seen from the face it has this slant and these slips.
  const Vec3 away = of_b ? Vec3(-world_normal) : world_normal;
  const double along_face = row(axis, away), side = along_face >= 0 ? 1.0 : -1.0;
  const double slant = slants ? std::abs(along_face) : 1.0;
  const double slip_u = slants ? row(iu, away) : 0.0, slip_w = slants ? row(iw, away) : 0.0;
  const Vec3 outward = side * pose.rotation.col(axis);

  // The incident face looks against the normal most; where two do alike, the first.
  const double size = reference[0] + reference[1] + reference[2] + incident[0] + incident[1] + incident[2];
  int k = 0;
  double facing = std::abs(outward.dot(other.rotation.col(0)));
  for (int j = 1; j < 3; ++j) {
    const double f = std::abs(outward.dot(other.rotation.col(j)));
    if (f > facing + tolerance::alike) facing = f, k = j;
  }
  const auto at_axis = [](const HalfSize& h, int i) { return h[static_cast<std::size_t>(i)]; };
  const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
  const double towards = outward.dot(other.rotation.col(k)) > 0 ? -1.0 : 1.0;
  const auto in_plane = [&](const Vec3& v) { return PlanePoint{row(iu, v), row(iw, v), outward.dot(v)}; };
  PlanePoint centre = in_plane(d + towards * at_axis(incident, k) * other.rotation.col(k));
  PlanePoint e1 = in_plane(at_axis(incident, k1) * other.rotation.col(k1));
  PlanePoint e2 = in_plane(at_axis(incident, k2) * other.rotation.col(k2));
  const double au = at_axis(reference, iu), aw = at_axis(reference, iw), top = at_axis(reference, axis);
  if (slants) {
    // From here on in the plane at the place over which a point lies, along the normal.
    const double lean_u = slip_u / slant, lean_w = slip_w / slant;
    const double below = top - centre.height;
    centre.u += lean_u * below, centre.w += lean_w * below;
    e1.u -= lean_u * e1.height, e1.w -= lean_w * e1.height;
    e2.u -= lean_u * e2.height, e2.w -= lean_w * e2.height;
  }
  const double near = tolerance::alike * size;
  const int reference_face = 2 * axis + (side > 0 ? 0 : 1), incident_face = 2 * k + (towards > 0 ? 0 : 1);

  // Deepest is the corner below both edges. Where it is the face's only one that touches, and all that touches around
  // it lies well over the reference face, it is all of the patch.
  const double lowest = centre.height - std::abs(e1.height) - std::abs(e2.height),
               touching = top + (margin + near) * slant;
  const double rise1 = 2 * std::abs(e1.height), rise2 = 2 * std::abs(e2.height), room = touching - lowest;
  if (room < rise1 && room < rise2) {
    const bool down1 = e1.height < 0, down2 = e2.height < 0;
    const int at = down1 ? (down2 ? 0 : 3) : (down2 ? 1 : 2);
    const PlanePoint c = centre + (side_u[at] * e1 + side_w[at] * e2);
    const double back1 = -2 * side_u[at], back2 = -2 * side_w[at], wide_u = au - near, wide_w = aw - near;
    const auto over = [&](double back, const PlanePoint& e, double rise) {
      return std::abs(c.u * rise + room * (back * e.u)) < wide_u * rise &&
             std::abs(c.w * rise + room * (back * e.w)) < wide_w * rise;
    };
    if (!slants && room >= 0 && std::abs(c.u) < wide_u && std::abs(c.w) < wide_w && over(back1, e1, rise1) &&
        over(back2, e2, rise2)) {
      const double depth = std::max(std::min(top - c.height, -answer.local.signed_distance), -margin);
      Vec3 point;
      point[iu] = c.u;
      point[iw] = c.w;
      point[axis] = side * (top - 0.5 * depth);
      contacts.push_back({pose * point, world_normal, depth,
                          feature_name(reference_face, incident_face, Meeting::incident_corner, 0, at, of_b)});
      return;
    }
  }

  PatchPoint points[24];
  int count = 0;
  const auto add = [&](const PlanePoint& p, Meeting meeting, int of_reference, int of_incident) {
    // Moving by the pair's depth separates them everywhere, so nowhere is it more; rounding alone keeps a point of a
    // face that touches from touching.
    const double depth = std::min((top - p.height) / slant, -answer.local.signed_distance);
    if (depth < -margin - near) return;
    const double kept = std::max(depth, -margin);
    PatchPoint& point = points[count++];
    point.at[iu] = std::clamp(p.u, -au, au) - 0.5 * kept * slip_u;
    point.at[iw] = std::clamp(p.w, -aw, aw) - 0.5 * kept * slip_w;
    point.at[axis] = side * (top - 0.5 * kept * slant);
    point.depth = kept;
    point.feature = feature_name(reference_face, incident_face, meeting, of_reference, of_incident, of_b);
  };

  PlanePoint corner[4];
  bool inside[4];
  int inner = 0;
  for (int i = 0; i < 4; ++i) {
    corner[i] = centre + (side_u[i] * e1 + side_w[i] * e2);
    inside[i] = std::abs(corner[i].u) <= au + near && std::abs(corner[i].w) <= aw + near;
    inner += inside[i] ? 1 : 0;
  }
  for (int i = 0; i < 4; ++i)
    if (inside[i]) add(corner[i], Meeting::incident_corner, 0, i);
  if (inner < 4) {
    const double det = e1.u * e2.w - e1.w * e2.u;  // the incident face is no steeper than a cube's on its corner
    const double near1 = near / at_axis(incident, k1), near2 = near / at_axis(incident, k2);
    int covered = 0;
    for (int i = 0; i < 4; ++i) {
      const double u = side_u[i] * au - centre.u, w = side_w[i] * aw - centre.w;
      const double x = (u * e2.w - w * e2.u) / det, y = (e1.u * w - e1.w * u) / det;
      if (std::abs(x) > 1 + near1 || std::abs(y) > 1 + near2) continue;
      ++covered;
      if (std::abs(x) >= 1 - near1 && std::abs(y) >= 1 - near2) continue;  // the incident corner stands for it
      PlanePoint p = centre + (x * e1 + y * e2);
      p.u = side_u[i] * au;
      p.w = side_w[i] * aw;
      add(p, Meeting::reference_corner, i, 0);
    }
    if (covered < 4) {
      // Lines 0, 1: u = au, -au; 2, 3: w = aw, -aw. An edge may cross one well between its ends; nearer, the corner
      // stands for the crossing.
      double before[4][4];
      unsigned crossed = 0;
      for (int line = 0; line < 4; ++line) {
        const double at = (line % 2 == 0 ? 1.0 : -1.0) * (line < 2 ? au : aw);
        unsigned over = 0, under = 0;
        for (int i = 0; i < 4; ++i) {
          before[line][i] = at - (line < 2 ? corner[i].u : corner[i].w);
          over |= (before[line][i] > near ? 1u : 0u) << i;
          under |= (before[line][i] < -near ? 1u : 0u) << i;
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
        if (std::abs(along) > (on_u ? aw : au) - near) continue;
        const double at = (line % 2 == 0 ? 1.0 : -1.0) * (on_u ? au : aw);
        PlanePoint p{on_u ? at : along, on_u ? along : at, from.height + s * (to.height - from.height)};
        add(p, Meeting::edges, line, i);
      }
    }
  }
  append_patch(points, count, {axis, side, tilted}, answer.local.signed_distance, size, pose, world_normal, contacts);
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
    // Corners by their numbers, crossings by both edges'.
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
  // The face that looks down most has the lowest corner, and its corners are all that can matter.
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
    stand_for_deepest(points, count, slack);  // corners of a face that is no strip: all of them
  else
    count = span_patch(points, count, slope, diagonal);
  append_points(points, count, pose, world_normal, contacts);
}

}  // namespace tandem
