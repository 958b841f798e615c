#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "hull.h"
#include "mesh_contacts.h"
#include "mesh_inside.h"
#include "mesh_model.h"
#include "mesh_pair.h"
#include "mesh_walk.h"
#include "solvers.h"

namespace tandem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

class MeshConvex {
 public:
  MeshConvex(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options)
      : mesh_(mesh),
        convex_(convex),
        model_(mesh.shape.mesh()),
        view_(view(convex.shape)),
        options_(for_triangles(options)) {
    const Mat3 inverse = mesh.pose.rotation.inverse();
    box_ = convex.shape.bounds(
        {inverse * convex.pose.rotation, inverse * (convex.pose.translation - mesh.pose.translation)});
    const double slack = 1e-5 * (convex.shape.size() + 1e-6 * reach(model_));
    box_.lo -= Vec3::Constant(slack);
    box_.hi += Vec3::Constant(slack);
  }

  bool collide() const {
    bool hit = false;
    each_near(0, [&](std::uint32_t t) { return hit = solve(t, Request::collide, nullptr).collide; });
    return hit || inside();
  }

  PairAnswer distance() const {
    Depth deepest;
    deepest.certain = -1;
    each_near(0, [&](std::uint32_t t) {
      const PairAnswer r = solve(t, Request::distance, nullptr);
      if (r.collide && -r.signed_distance > deepest.certain)
        deepest = {-r.signed_distance, r.normal, (r.point_a + r.point_b) / 2};
      return false;
    });
    if (deepest.certain < 0) {
      const PairAnswer r = nearest();
      if (!inside()) return r;
      // The convex leaves through the nearest wall; the normal points from there to its inside.
      deepest = {r.signed_distance, -r.normal, (r.point_a + r.point_b) / 2};
    }
    return with_depth(mesh_, convex_, deepest, model_.solid, [&](const Vec3& move) {
      const Pose moved{convex_.pose.rotation, convex_.pose.translation + move};
      return MeshConvex(mesh_, {convex_.shape, moved}, options_).collide();
    });
  }

  PairAnswer contacts(std::vector<Contact>& out) const {
    std::vector<Contact> all, good;
    std::vector<Contact> one;
    each_near(options_.margin, [&](std::uint32_t t) {
      one.clear();
      solve(t, Request::contacts, &one);
      const Corners p = model_.corners(t);
      const Vec3 face = (mesh_.pose.rotation * (p[1] - p[0]).cross(p[2] - p[0])).stableNormalized();
      for (std::uint32_t k = 0; k < one.size(); ++k) {
        Contact c = one[k];
        c.feature = t * 4 + std::min(k, 3u);
        all.push_back(c);
        // From inside a solid only its outer side pushes; a triangle's border that the solid goes on beyond does not.
        if (!model_.solid || c.normal.dot(face) > 0.5) good.push_back(c);
      }
      return false;
    });
    if (good.empty()) good = all;
    const std::size_t first = out.size();
    merge(good, out);
    PairAnswer answer;
    if (out.size() == first) {
      if (!inside()) return answer;
      answer = distance();
      out.push_back({(answer.point_a + answer.point_b) / 2, answer.normal, -answer.signed_distance, 0});
      return answer;
    }
    return from_deepest(out, first);
  }

 private:
  PairAnswer solve(std::uint32_t t, Request request, std::vector<Contact>* contacts) const {
    const Corners p = model_.corners(t);
    return solve_convex(view_triangle(p), mesh_.pose, view_, convex_.pose, request, options_, contacts);
  }

  double gap(const BoxOf& b) const {
    const Vec3 lo = b.mid - b.half, hi = b.mid + b.half;
    return (box_.lo - hi).cwiseMax(lo - box_.hi).cwiseMax(0).norm();
  }

  // Triangles whose boxes come within `margin` of the convex's, until visit returns true.
  template <class Visit>
  void each_near(double margin, Visit&& visit) const {
    const double reach = margin * (1 + 1e-5);
    if (gap(BoxOf(model_, whole)) > reach) return;
    std::vector<std::uint32_t> stack{whole};
    bool done = false;
    while (!stack.empty() && !done) {
      const std::uint32_t ref = stack.back();
      stack.pop_back();
      if (is_leaf(model_, ref))
        each_triangle(model_, ref, [&](std::uint32_t t) { done = done || visit(t); });
      else
        each_child(model_, ref, [&](std::uint32_t c) {
          if (gap(BoxOf(model_, c)) <= reach) stack.push_back(c);
        });
    }
  }

  PairAnswer nearest() const {
    PairAnswer best;
    best.signed_distance = infinity;
    std::priority_queue<Item> queue;
    queue.push({0, whole, 0});
    while (!queue.empty() && queue.top().bound * (1 - 1e-5) < best.signed_distance) {
      const std::uint32_t ref = queue.top().a;
      queue.pop();
      if (is_leaf(model_, ref))
        each_triangle(model_, ref, [&](std::uint32_t t) {
          if (const PairAnswer r = solve(t, Request::distance, nullptr); r.signed_distance < best.signed_distance)
            best = r;
        });
      else
        each_child(model_, ref, [&](std::uint32_t c) { queue.push({gap(BoxOf(model_, c)), c, 0}); });
    }
    return best;
  }

  // For a convex that no triangle meets: inside the solid as a whole?
  bool inside() const {
    if (!model_.solid) return false;
    const Vec3 local = convex_.shape.kind() == ShapeKind::convex ? convex_.shape.hull().inside : Vec3(0, 0, 0);
    const Vec3 world = convex_.pose.rotation * local + (convex_.pose.translation - mesh_.pose.translation);
    return is_inside(model_, mesh_.pose.rotation.inverse() * world);
  }

  // Contacts of one direction are one patch: at most four of them, the deepest first choice.
  static void merge(const std::vector<Contact>& all, std::vector<Contact>& out) {
    std::vector<std::size_t> order(all.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return all[i].depth != all[j].depth ? all[i].depth > all[j].depth : all[i].feature < all[j].feature;
    });
    std::vector<std::vector<Contact>> patches;
    for (const std::size_t i : order) {
      const auto same = std::find_if(patches.begin(), patches.end(), [&](const std::vector<Contact>& p) {
        return p.front().normal.dot(all[i].normal) > 0.9;
      });
      if (same == patches.end())
        patches.push_back({all[i]});
      else
        same->push_back(all[i]);
    }
    const std::size_t first = out.size();
    for (auto& patch : patches) {
      keep_four(patch, 0);
      out.insert(out.end(), patch.begin(), patch.end());
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
              [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
  }

  const Posed mesh_, convex_;
  const MeshModel& model_;
  const ConvexView view_;
  const NarrowPhaseOptions options_;
  Bounds box_;  // of the convex, in the mesh's frame
};

}  // namespace

PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts) {
  const MeshConvex pair(mesh, convex, options);
  if (request == Request::contacts) return pair.contacts(*contacts);
  if (request == Request::distance) return pair.distance();
  PairAnswer answer;
  answer.collide = pair.collide();
  return answer;
}

}  // namespace tandem
