// Contacts of negative depth, where surfaces of two meshes are near each other without intersecting.
#include "meshes/contacts/gap_contacts.h"

#include <algorithm>
#include <limits>
#include <memory_resource>
#include <numbers>
#include <vector>

#include "manifold/manifold.h"
#include "manifold/patch_collector.h"
#include "meshes/contacts/normal_cone.h"
#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/touching_faces.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// Pairs of nodes that cannot contain points nearest to the other surface around them: along the line between them A
/// has no normal, or B none against it.
class ApartByNormals {
 public:
  ApartByNormals(const Posed& a, const Posed& b, const WorkLimit* limit)
      : a_(a),
        b_(b),
        mesh_a_(mesh_of(a.shape)),
        mesh_b_(mesh_of(b.shape)),
        between_(b.pose.translation - a.pose.translation),
        limit_(limit) {}

  bool operator()(const Item& at) const {
    const BoxOf box_a(mesh_a_, at.a), box_b(mesh_b_, at.b);
    const Vec3 offset = b_.pose.rotation * box_b.mid + between_ - a_.pose.rotation * box_a.mid;
    const double length = offset.norm(), radius = box_a.half.norm() + box_b.half.norm();
    if (!(length > radius)) return false;
    const double spread = std::asin(radius / length);
    return misses(mesh_a_, at.a, a_.pose.rotation.transpose() * offset, length, spread) ||
           misses(mesh_b_, at.b, b_.pose.rotation.transpose() * -offset, length, spread);
  }

 private:
  bool misses(const MeshModel& mesh, std::uint32_t ref, const Vec3& offset, double length, double spread) const {
    if (lane_of(ref) == whole) return false;
    const NormalCone& cone = mesh.normal_cones(limit_).of(node_of(ref), lane_of(ref));
    const double within = cone.angle + spread;
    if (!(within < std::numbers::pi / 2)) return false;
    const double cosine = offset.dot(cone.axis.cast<double>()) / length;
    return (mesh.solid ? cosine : std::abs(cosine)) < std::cos(within);  // an open surface has two sides
  }

  const Posed &a_, &b_;
  const MeshModel &mesh_a_, &mesh_b_;
  const Vec3 between_;
  const WorkLimit* const limit_;
};

/// In world axes relative to A's translation.
class GapContacts {
 public:
  /// `scratch`: additions are removed again.
  GapContacts(const Posed& a, const Posed& b, const NarrowPhaseOptions& options, std::vector<Contact>& scratch)
      : a_(a),
        b_(b),
        mesh_a_(mesh_of(a.shape)),
        mesh_b_(mesh_of(b.shape)),
        between_(b.pose.translation - a.pose.translation),
        size_(a.shape.size() + b.shape.size()),
        noisy_(tolerance::noisy_difference * (reach(mesh_a_) + reach(mesh_b_))),
        options_(options),
        patches_(size_, options),
        touching_(lent_memory(options)),
        scratch_(scratch) {}

  /// Adds two triangles that do not intersect.
  void add(const TrianglePair& pair, const Nearest& near) {
    const Near found{near, near.distance > noisy_ ? direction(pair, near) : Vec3(Vec3::Zero()), pair};
    if (near.distance < nearest_.points.distance) nearest_ = found;
    if (near.distance > noisy_)
      add(found);
    else
      touching_.push_back(found);
  }

  void finish(std::vector<Contact>& out) {
    const std::size_t first = out.size();
    if (!touching_.empty()) add_touching();
    patches_.finish(Vec3::Zero(), false, out);
    for (Contact& c : std::span(out).subspan(first)) {
      c.point += a_.pose.translation;
      c.depth = std::clamp(c.depth, -options_.margin, -std::numeric_limits<double>::min());
    }
  }

  const Nearest& nearest() const { return nearest_.points; }
  const Vec3& normal() const { return nearest_.normal; }

 private:
  struct Near {
    Nearest points;
    Vec3 normal = Vec3::UnitZ();  // from A to B
    TrianglePair pair{};
  };

  Corners corners_of_a(std::uint32_t t) const {
    Corners c = mesh_a_.corners(t);
    for (Vec3& v : c) v = a_.pose.rotation * v;
    return c;
  }
  Corners corners_of_b(std::uint32_t t) const {
    Corners c = mesh_b_.corners(t);
    for (Vec3& v : c) v = b_.pose.rotation * v + between_;
    return c;
  }

  Vec3 direction(const TrianglePair& pair, const Nearest& near) const {
    return direction_between(near, {corners_of_a(pair[0]), Pose{}, mesh_a_.solid},
                             {corners_of_b(pair[1]), Pose{}, mesh_b_.solid}, reach(mesh_a_) + reach(mesh_b_), {});
  }

  void add(const Near& found) {
    if (is_nearest_around(found)) add_patch(found);
  }

  // Those as near as the nearest, to rounding, have one direction, if any.
  void add_touching() {
    WorkMeter meter(options_.limit);
    const double gap = nearest_.points.distance, rounding = rounding_of_corners(mesh_a_, mesh_b_, between_);
    TouchingFaces near(mesh_a_, mesh_b_, gap, rounding, meter, lent_memory(options_));
    const auto is_near = [&](const Near& t) { return t.points.distance <= gap + rounding; };
    const auto count = static_cast<std::size_t>(std::count_if(touching_.begin(), touching_.end(), is_near));
    nearest_.normal = direction(nearest_.pair, nearest_.points);
    if (count <= most_touching) {
      near.reserve(count);
      for (const Near& t : touching_) {
        meter.spend();
        if (is_near(t)) near.add(t.pair, corners_of_a(t.pair[0]), corners_of_b(t.pair[1]));
      }
      nearest_.normal = direction_of(near, gap, rounding, nearest_.normal);
    }
    const bool together = near.separable();
    for (Near& t : touching_) {
      if (together && is_near(t)) {
        t.normal = nearest_.normal;
      } else {
        const Vec3 own = direction(t.pair, t.points);
        t.normal = is_near(t) ? near.normal_near(own) : own;
        if (is_near(t) && near.leads_back(t.normal)) continue;
      }
      add(t);
    }
  }

  // True if no point of either surface around these two is nearer to the other one.
  bool is_nearest_around(const Near& near) const {
    const double slack = tolerance::alike * size_;
    const Mat3 &to_a = a_.pose.rotation.transpose(), &to_b = b_.pose.rotation.transpose();
    return in_normal_cone(mesh_a_, near.pair[0], to_a * near.normal, to_a * near.points.on_a, slack) &&
           in_normal_cone(mesh_b_, near.pair[1], to_b * -near.normal, to_b * (near.points.on_b - between_), slack);
  }

  void add_patch(const Near& near) {
    const Corners p = corners_of_a(near.pair[0]), q = corners_of_b(near.pair[1]);
    const LocalAnswer answer{near.points.distance, near.points.on_a, near.points.on_b, near.normal, 0};
    constexpr bool whole = true;
    const std::size_t first = scratch_.size();
    append_manifold(TriangleView(p), TriangleView(q), {Mat3::Identity(), Vec3::Zero()}, answer, options_.margin, Pose{},
                    scratch_, whole);
    patches_.add(near.pair[0], std::span(scratch_).subspan(first));
    scratch_.resize(first);
  }

  const Posed &a_, &b_;
  const MeshModel &mesh_a_, &mesh_b_;
  const Vec3 between_;
  const double size_, noisy_;  // `noisy_`: the direction of shorter distances is noise
  const NarrowPhaseOptions& options_;
  PatchCollector patches_;
  std::pmr::vector<Near> touching_;  // no farther than that, without their normals
  Near nearest_;
  std::vector<Contact>& scratch_;
};

}  // namespace

PairAnswer gap_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> meeting,
                        const NarrowPhaseOptions& options, std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  // Computed here, where a limit is known.
  for (const Posed& posed : {a, b}) mesh_of(posed.shape).neighbours(options.limit);
  GapContacts gaps(a, b, options, contacts);
  const auto meet = [&](std::uint32_t i, std::uint32_t j) {
    return std::binary_search(meeting.begin(), meeting.end(), TrianglePair{i, j});
  };
  const auto visit = [&](const TrianglePair& pair, const Nearest& near) {
    if (near.distance > 0) gaps.add(pair, near);
    return true;
  };
  NearestSearch(a, b, options.limit).each_within(options.margin, meet, visit, {}, ApartByNormals(a, b, options.limit));
  gaps.finish(contacts);
  PairAnswer answer;
  if (!meeting.empty() || gaps.nearest().distance > options.margin) return answer;
  const Nearest& near = gaps.nearest();
  answer.signed_distance = near.distance;
  answer.point_a = near.on_a + a.pose.translation;
  answer.point_b = near.on_b + a.pose.translation;
  answer.normal = gaps.normal();
  const auto deepest = [&] {
    return std::max_element(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
                            [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
  };
  // The nearest points may belong to triangles without a direction of their own, which form no patch.
  if (const double slack = tolerance::alike * (a.shape.size() + b.shape.size());
      contacts.size() == first || deepest()->depth < -near.distance - slack)
    contacts.push_back({(answer.point_a + answer.point_b) / 2, answer.normal, -answer.signed_distance, 0});
  for (Contact& c : std::span(contacts).subspan(first)) c.depth = std::min(c.depth, -near.distance);
  deepest()->depth = -near.distance;
  return answer;
}

}  // namespace tandem
