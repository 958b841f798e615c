// Contacts of a mesh and a bounded convex shape: those of each triangle that comes near, gathered into patches.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "manifold/patch_collector.h"
#include "meshes/traversal/mesh_convex_pair.h"

namespace tandem {

class ConvexContacts {
 public:
  /// `margin`: gaps up to this are contacts; the pair's options hold it widened by rounding.
  ConvexContacts(const MeshConvexPair& pair, double margin) : pair_(pair), margin_(margin) {}

  /// Finds the contacts of all triangles, in the pair's coordinates; sets `near` to the answer of the nearest triangle
  /// within the margin, if that is nearer than before.
  /// `scratch`: contents at the start are preserved.
  void find(PairAnswer& near, PatchCollector& all, std::vector<Contact>& scratch) const;

  /// Appends the reduced patches, without contacts deeper than `limit`.
  void append_patches(PatchCollector& all, double limit, std::vector<Contact>& out) const;

 private:
  /// The known separation of a triangle and the convex shape, and its normal; zero for the triangle's own.
  struct Apart {
    double gap;
    Vec3 normal = Vec3::Zero();
  };

  /// An overlapping triangle that was not solved: its depth is at most this.
  struct Unsolved {
    std::uint32_t t;
    double depth;
    /// The deepest comes first in the heap; of equals the one with the smaller index.
    bool operator<(const Unsolved& other) const { return depth != other.depth ? depth < other.depth : t > other.t; }
  };
  /// A test whose result mostly repeats: after failures in a row it is tried less and less often, but at least every
  /// seventh time.
  class Turns {
   public:
    bool is_due() { return left_ == 0 || --left_ == 0; }
    void tell(bool success) { left_ = pass_ = success ? 0 : std::min(2 * pass_ + 1, 7); }

   private:
    int pass_ = 0, left_ = 0;
  };

  /// The state of the search: the answer of the nearest triangle, and the triangles that are not solved yet.
  struct Seen {
    Seen(PairAnswer& nearest, std::pmr::memory_resource* lent)
        : near(nearest), memory(usual.data(), usual.size(), lent) {
      unsolved.reserve(usual.size() / sizeof(Unsolved));
    }

    PairAnswer& near;
    alignas(std::max_align_t) std::array<std::byte, 4096> usual;
    std::pmr::monotonic_buffer_resource memory;
    std::pmr::vector<Unsolved> unsolved{
        &memory};  ///< a heap: triangles that may be deeper than all that were solved before
    Turns beside;  ///< when lies_beside is worth asking

    void leave(std::uint32_t t, double depth) {
      if (!(depth > -near.signed_distance)) return;
      unsolved.push_back({t, depth});
      std::push_heap(unsolved.begin(), unsolved.end());
    }
  };

  Apart find_contacts(std::uint32_t t, const Corners& p, Seen& seen, std::vector<Contact>& found,
                      std::size_t first) const;
  bool is_swallowed(std::uint32_t t, std::size_t lane, const ScreenedTriangles& screened, Seen& seen,
                    std::vector<Contact>& found) const;
  PairAnswer least_depth(const Corners& p) const;
  void find_deepest(Seen& seen) const;
  bool depth_along_plane(const Corners& p, const TrianglePlane& plane, double& depth, PairAnswer& r) const;
  using CornerBounds = std::array<TriangleBound, 3>;
  bool depth_by_corner(const Corners& p, TriangleBound& bound, CornerBounds& corners, PairAnswer& r) const;
  bool depth_by_edge(const Corners& p, const CornerBounds& corners, PairAnswer& r) const;
  bool depth_by_face(const Corners& p, const TrianglePlane& plane, PairAnswer& r) const;
  bool depth_by_point(const Corners& p, const TrianglePlane& plane, TriangleBound& bound, PairAnswer& r) const;
  bool is_depth_along(const Corners& p, const Vec3& n, const TriangleBound& point, PairAnswer& r) const;
  /// How deep it must be along a direction for that not to be the least; `bound` tells what suffices.
  double enough_for(const TriangleBound& bound) const { return -bound.gap + tolerance::flush * pair_.size(); }
  bool chord_forbids(std::uint32_t t, const Vec3& normal, const TriangleBound& bound) const;
  bool cannot_push(std::uint32_t t, const TrianglePlane& plane, double along_plane, const Corners& p,
                   const TriangleBound& bound) const;
  double exit_length(const Vec3& q, const Vec3& n) const;
  bool needs_more(const Vec3& corner, std::span<const std::uint32_t> around, std::span<const Vec3> normals, double sign,
                  const Vec3& towards, double enough) const;
  bool depth_is_along(const Vec3& n, const Corners& p, const Vec3& deepest, double depth) const;
  bool pushes(std::uint32_t t, const Corners& p, const TrianglePlane& plane, const PairAnswer& answer,
              std::span<const Contact> points) const;
  bool neighbours_reach_farther(std::uint32_t t, const Corners& p, const Vec3& n,
                                std::span<const Contact> points) const;
  bool lies_beside(const Corners& p, const Vec3& n, const Vec3& low) const;
  bool is_known_beside(const Corners& p, const Vec3& n, const Vec3& low, Seen& seen) const;
  void append_along_plane(const Corners& p, const TrianglePlane& plane, const Vec3& normal, Seen& seen,
                          std::vector<Contact>& found) const;

  void append_over(const Corners& p, const Vec3& n, const Vec3& low, double depth, std::vector<Contact>& found) const;

  const MeshConvexPair& pair_;
  double margin_;
};

}  // namespace tandem
