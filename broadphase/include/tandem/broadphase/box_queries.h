// Queries on boxes: overlap, ray, nearest; on a bounding volume hierarchy.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Runs block(0) .. block(blocks - 1), in any order and on any threads, and returns when all are done. With oneTBB:
/// `[](auto blocks, const auto& block) { tbb::parallel_for(std::size_t{0}, blocks, block); }`.
using BlockRunner = std::function<void(std::size_t blocks, const std::function<void(std::size_t)>& block)>;

/// Points origin + t direction, 0 <= t <= t_max.
struct Ray {
  std::array<double, 3> origin{};
  std::array<double, 3> direction{};  ///< finite, not zero (below 1e-308 counts as zero); t is in units of its length
  double t_max = 0;                   ///< >= 0, infinity is allowed, and then any t that a double can be
};

/// A box on a ray, from the t where the ray enters it (0 when it starts inside).
struct RayHit {
  std::uint32_t index = 0;
  double t = 0;
  friend bool operator==(const RayHit&, const RayHit&) = default;
};

/// A box near a point, by the square of its distance; 0 when the point is inside.
struct Neighbour {
  std::uint32_t index = 0;
  double squared_distance = 0;
  friend bool operator==(const Neighbour&, const Neighbour&) = default;
};

/// The answers to a batch of queries, in the order of the queries.
template <class Item>
struct QueryAnswers {
  std::vector<Item> items;
  std::vector<std::size_t> begin{0};  ///< the first item of each query, and the end of the last

  std::size_t size() const { return begin.size() - 1; }
  std::span<const Item> of(std::size_t query) const {
    return std::span(items).subspan(begin[query], begin[query + 1] - begin[query]);
  }
};

/// A callback that receives boxes one after the other.
class BoxVisitor {
 public:
  virtual ~BoxVisitor() = default;
  /// Receives a box that overlaps the query; false ends the visit.
  virtual bool visit(std::uint32_t index) = 0;
};

/// A callback that receives boxes near a query, and says how near the next ones must be.
class NearVisitor {
 public:
  virtual ~NearVisitor() = default;
  /// Takes a box at this distance; returns the distance beyond which no further box is wanted; negative: no more at
  /// all.
  virtual double visit(std::uint32_t index, double distance) = 0;
};

/// Queries of a set of boxes (overlap, rays, nearest), answered by the hierarchy of the `bvh` method. The answers are
/// those of a loop over all boxes, in one order for any number of threads; empty boxes are in no answer. Const queries
/// may run from any number of threads at once. Arguments that are NaN or out of range throw std::invalid_argument,
/// which names them.
class BoxQueries {
 public:
  BoxQueries();
  ~BoxQueries();
  BoxQueries(BoxQueries&&) noexcept;
  BoxQueries& operator=(BoxQueries&&) noexcept;

  /// Builds the hierarchy; the boxes are copied. n log n; memory is kept for the next build.
  void build(const BoxArray& boxes, const BlockRunner& runner = {});
  /// Sets new bounds of the boxes `changed` without changing the hierarchy's structure: k log n. `boxes` must have as
  /// many boxes as at the build, those not in `changed` with unchanged bounds; where many have changed, all are read.
  /// Answers stay right however far boxes move; `worn` tells how much slower queries have become. A box may become
  /// empty; a box that was empty at the build has no place in the hierarchy and is refused: build anew.
  void refit(const BoxArray& boxes, std::span<const std::uint32_t> changed);
  void refit(std::span<const Aabb> boxes, std::span<const std::uint32_t> changed);
  /// The surface of the lowest nodes over that after the build: 1 after a build, larger after refits.
  double worn() const;
  std::size_t memory() const;  ///< bytes held

  /// Calls `visitor` for the boxes that overlap `box` (closed), in the order of the hierarchy, until it returns false;
  /// returns false then. Allocates nothing.
  bool visit_overlapping(const Aabb& box, BoxVisitor& visitor) const;
  /// Calls `visitor` for the boxes within `limit` (>= 0, infinity is allowed) of `box`, roughly by distance; every box
  /// within the distance that the visitor returned last is shown. Distances exceed the exact ones at most by rounding.
  /// Allocates nothing.
  void visit_near(const Aabb& box, double limit, NearVisitor& visitor) const;

  /// The boxes that overlap `box` (closed), ascending by index; none for an empty box. Appends to `out`.
  void overlapping(const Aabb& box, std::vector<std::uint32_t>& out) const;
  /// The boxes that the ray hits, by (t, index). Appends to `out`.
  void along(const Ray& ray, std::vector<RayHit>& out) const;
  /// The k boxes nearest to a point of coordinates up to 1e150 in size, fewer if there are fewer, by (distance, index).
  /// Appends to `out`.
  void nearest(const std::array<double, 3>& point, std::size_t k, std::vector<Neighbour>& out) const;

  /// The same queries, many at once.
  QueryAnswers<std::uint32_t> overlapping(std::span<const Aabb> boxes, const BlockRunner& runner = {}) const;
  QueryAnswers<RayHit> along(std::span<const Ray> rays, const BlockRunner& runner = {}) const;
  QueryAnswers<Neighbour> nearest(std::span<const std::array<double, 3>> points, std::size_t k,
                                  const BlockRunner& runner = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
