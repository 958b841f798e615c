// Contacts of a mesh and a bounded convex shape: those of each triangle that comes near, gathered into patches.
#pragma once
#include <span>
#include <vector>

#include "manifold/patch_collector.h"
#include "meshes/traversal/mesh_convex_pair.h"

namespace tandem {

class ConvexContacts {
 public:
  /// `margin`: gaps up to this are contacts; the pair's options hold it widened by rounding.
  ConvexContacts(const MeshConvexPair& pair, double margin) : pair_(pair), margin_(margin) {}

  /// Appends those of all triangles, in the pair's coordinates, but what is deeper than `limit`; `near` is the answer
  /// of the nearest triangle within the margin, if that is nearer than what it was.
  void gather(double limit, PairAnswer& near, std::vector<Contact>& out) const;

 private:
  /// How far apart a triangle and the convex shape are known to be, and along which normal; zero where that is its own.
  struct Apart {
    double gap;
    Vec3 normal = Vec3::Zero();
  };

  Apart add_contacts(std::uint32_t t, const Corners& p, double limit, PairAnswer& near, PatchCollector& patches,
                     std::vector<Contact>& room) const;
  Apart find_contacts(std::uint32_t t, const Corners& p, PairAnswer& near, std::vector<Contact>& found,
                      std::size_t first) const;
  bool depth_is_along(const Vec3& n, const Corners& p, const Vec3& deepest, double depth) const;
  bool pushes(std::uint32_t t, const Corners& p, const TrianglePlane& plane, const PairAnswer& answer,
              std::span<const Contact> points) const;
  bool neighbours_reach_farther(std::uint32_t t, const Corners& p, const Vec3& n,
                                std::span<const Contact> points) const;
  void append_along_plane(const Corners& p, const TrianglePlane& plane, const Vec3& normal,
                          std::vector<Contact>& found) const;

  const MeshConvexPair& pair_;
  double margin_;
};

}  // namespace tandem
