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
  std::array<double, 3> direction{};  ///< finite, not zero; t is in units of its length
  double t_max = 0;                   ///< >= 0, infinity is allowed
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

/// Answers of a batch, in the order of its queries.
template <class Item>
struct QueryAnswers {
  std::vector<Item> items;
  std::vector<std::size_t> begin{0};  ///< of each query's items, and the end of the last

  std::size_t size() const { return begin.size() - 1; }
  std::span<const Item> of(std::size_t query) const {
    return std::span(items).subspan(begin[query], begin[query + 1] - begin[query]);
  }
};

/// Is given boxes one after the other.
class BoxVisitor {
 public:
  virtual ~BoxVisitor() = default;
  /// Takes a box that overlaps what was asked; false ends the visit.
  virtual bool visit(std::uint32_t index) = 0;
};

/// Is given boxes that are near, and says how near the next ones must be.
class NearVisitor {
 public:
  virtual ~NearVisitor() = default;
  /// Takes a box and returns the distance beyond which no further one is wanted; negative: none at all.
  virtual double visit(std::uint32_t index, double distance) = 0;
};

/// Questions to a set of boxes, answered by the hierarchy of the `bvh` method. Answers are those of a loop over all
/// boxes, in one order for any number of threads; empty boxes are in none. Const queries may run from any number of
/// threads at once. Refuses what is NaN or out of range with std::invalid_argument that names it.
class BoxQueries {
 public:
  BoxQueries();
  ~BoxQueries();
  BoxQueries(BoxQueries&&) noexcept;
  BoxQueries& operator=(BoxQueries&&) noexcept;

  /// Builds the hierarchy; the boxes are copied. n log n; memory is kept for the next build.
  void build(const BoxArray& boxes, const BlockRunner& runner = {});
  /// Gives boxes `changed` their new bounds in the hierarchy as it is: k log n. `boxes` has as many as those built
  /// from, and those that have not changed as they are: where many have, all are read. It stays right whatever moves;
  /// `worn` says how much slower it has become. A box may become empty; one that was empty at the build is refused, as
  /// it has no place: build anew.
  void refit(const BoxArray& boxes, std::span<const std::uint32_t> changed);
  void refit(std::span<const Aabb> boxes, std::span<const std::uint32_t> changed);
  /// How much larger the lowest nodes have become by refits, by surface: 1 after a build.
  double worn() const;
  std::size_t memory() const;  ///< bytes held

  /// Shows `visitor` the boxes that overlap `box` (closed), in the order of the hierarchy, until it has enough; false
  /// if it had. Allocates nothing.
  bool visit_overlapping(const Aabb& box, BoxVisitor& visitor) const;
  /// Shows `visitor` the boxes within `limit` (>= 0, infinity is allowed) of `box`, nearer ones about first; none is
  /// left out that is within what the visitor said last. Distances are at most rounding larger than exact. Allocates
  /// nothing.
  void visit_near(const Aabb& box, double limit, NearVisitor& visitor) const;

  /// Boxes that overlap `box` (closed), ascending by index; none for an empty box. Appends to `out`.
  void overlapping(const Aabb& box, std::vector<std::uint32_t>& out) const;
  /// Boxes that the ray meets, by (t, index). Appends to `out`.
  void along(const Ray& ray, std::vector<RayHit>& out) const;
  /// The k boxes nearest to a finite point, fewer if there are fewer, by (distance, index). Appends to `out`.
  void nearest(const std::array<double, 3>& point, std::size_t k, std::vector<Neighbour>& out) const;

  /// Answer many such queries at once.
  QueryAnswers<std::uint32_t> overlapping(std::span<const Aabb> boxes, const BlockRunner& runner = {}) const;
  QueryAnswers<RayHit> along(std::span<const Ray> rays, const BlockRunner& runner = {}) const;
  QueryAnswers<Neighbour> nearest(std::span<const std::array<double, 3>> points, std::size_t k,
                                  const BlockRunner& runner = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
