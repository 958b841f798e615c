// Splits triangles by the surface area heuristic over bins of the centroids (Wald, On fast construction of SAH-based
// bounding volume hierarchies, 2007), eight children a node. Boxes for splitting are floats, moved together with their
// triangles.
#include "shapes/mesh_splits.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

#include "shapes/run_parts.h"
#include "shapes/uninitialised.h"
#include "tolerances.h"

namespace tandem {
namespace {
using Lanes = FourFloats;  // x, y, z and one more, which is 0
using FourIntegers = std::int32_t __attribute__((vector_size(16)));

constexpr int bins = 16;
// Below this level splits are by the median, so that the depth is at most this plus log2 of the number of triangles for
// any input.
constexpr int last_binned_level = 24;

constexpr float far_away = std::numeric_limits<float>::infinity();

// A triangle's box, in units of the mesh relative to its centre.
class Reference {
 public:
  Reference() = default;
  Reference(Lanes low, Lanes high, std::uint32_t triangle) : low_(low), high_(high) {
    low_[3] = std::bit_cast<float>(triangle);
  }

  // Without the triangle's number read as a float: sums with such denormal numbers are slow.
  Lanes lower() const { return Lanes(FourIntegers(low_) & FourIntegers{-1, -1, -1, 0}); }
  Lanes upper() const { return high_; }
  Lanes centre() const { return lower() + upper(); }  // twice the centre: only compared
  std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(low_[3]); }

 private:
  Lanes low_, high_;
};

struct FlatBox {
  Lanes low = all_four(far_away), high = all_four(-far_away);

  void add(Lanes l, Lanes h) { low = min_of(low, l), high = max_of(high, h); }
  void add(Lanes p) { add(p, p); }
  void add(const FlatBox& b) { add(b.low, b.high); }
};

// Triangles begin ... end of the order, and the extent of their centroids.
struct Range {
  std::uint32_t begin = 0, end = 0;
  FlatBox centres{};
  std::uint32_t size() const { return end - begin; }
};

// A split of a range: before a bin along an axis.
struct Split {
  int axis = -1, bin = 0;
  float cost = std::numeric_limits<float>::infinity();
  std::uint32_t left = 0;  // triangles before it
};

// The bin along each of the three axes.
class Grid {
 public:
  explicit Grid(const FlatBox& centres) : low_(centres.low) {
    const Lanes width = centres.high - centres.low;
    for (int axis = 0; axis < 4; ++axis) scale_[axis] = width[axis] > least_width ? bins / width[axis] : 0;
  }
  FourIntegers bins_of(const Reference& r) const {
    return __builtin_convertvector(min_of((r.centre() - low_) * scale_, all_four(bins - 1)), FourIntegers);
  }

 private:
  static constexpr float least_width = static_cast<float>(tolerance::no_extent);
  Lanes low_, scale_;
};

// The sums of the three axes in lanes: boxes about the content of one side of a split.
struct SideOfSplits {
  Lanes low[3] = {all_four(far_away), all_four(far_away), all_four(far_away)};
  Lanes high[3] = {all_four(-far_away), all_four(-far_away), all_four(-far_away)};
  FourIntegers count{};

  // The area times the number.
  Lanes cost() const {
    Lanes s[3];
    for (int axis = 0; axis < 3; ++axis) s[axis] = max_of(high[axis] - low[axis], all_four(0));
    return (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) * __builtin_convertvector(count, Lanes);
  }
};

// The content of the bins along the three axes.
class Binning {
 public:
  void add(const Grid& grid, const Reference& r) {
    const FourIntegers bin = grid.bins_of(r);
    const Lanes low = r.lower(), high = r.upper();
    for (int axis = 0; axis < 3; ++axis) {
      box_[bin[axis]][axis].add(low, high);
      ++count_[bin[axis]][axis];
    }
  }
  // Similar references follow each other, and writing to a bin twice in a row is slow: every second one goes to another
  // set of bins.
  void add(const Grid& grid, const Reference* from, const Reference* to) {
    constexpr std::ptrdiff_t many = 128;
    if (to - from >= many) {
      Binning odd;
      for (; from + 1 < to; from += 2) add(grid, from[0]), odd.add(grid, from[1]);
      add(odd);
    }
    for (; from != to; ++from) add(grid, *from);
  }
  void add(const Binning& o) {
    for (std::size_t b = 0; b < bins; ++b) {
      for (std::size_t axis = 0; axis < 3; ++axis) box_[b][axis].add(o.box_[b][axis]);
      count_[b] += o.count_[b];
    }
  }

  Split best(std::uint32_t all) const {
    Lanes right[bins];
    SideOfSplits sum;
    for (std::size_t b = bins - 1; b > 0; --b) {
      grow(sum, b);
      right[b] = sum.cost();
    }
    sum = {};
    Lanes least = all_four(far_away);
    FourIntegers bin{}, left{};
    const FourIntegers whole = FourIntegers{} + static_cast<std::int32_t>(all);
    for (std::size_t b = 1; b < bins; ++b) {
      grow(sum, b - 1);
      const FourIntegers better = (sum.cost() + right[b] < least) & (sum.count != 0) & (sum.count != whole);
      least = better ? sum.cost() + right[b] : least;
      bin = better ? FourIntegers{} + static_cast<std::int32_t>(b) : bin;
      left = better ? sum.count : left;
    }
    Split split;
    for (int axis = 0; axis < 3; ++axis)
      if (least[axis] < split.cost) split = {axis, bin[axis], least[axis], static_cast<std::uint32_t>(left[axis])};
    return split;
  }

 private:
  // The boxes of three axes, a column each.
  static void columns(const Lanes& p, const Lanes& q, const Lanes& r, Lanes (&column)[3]) {
    const Lanes a = __builtin_shufflevector(p, q, 0, 4, 1, 5), b = __builtin_shufflevector(p, q, 2, 6, 3, 7);
    column[0] = __builtin_shufflevector(a, r, 0, 1, 4, 4);
    column[1] = __builtin_shufflevector(a, r, 2, 3, 5, 5);
    column[2] = __builtin_shufflevector(b, r, 0, 1, 6, 6);
  }
  void grow(SideOfSplits& sum, std::size_t b) const {
    Lanes low[3], high[3];
    columns(box_[b][0].low, box_[b][1].low, box_[b][2].low, low);
    columns(box_[b][0].high, box_[b][1].high, box_[b][2].high, high);
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum.low[axis] = min_of(sum.low[axis], low[axis]), sum.high[axis] = max_of(sum.high[axis], high[axis]);
    sum.count += count_[b];
  }

  FlatBox box_[bins][3];
  FourIntegers count_[bins] = {};
};

class Splitter {
 public:
  Splitter(const MeshModel& mesh, std::span<const FourFloats> corners, std::span<std::uint32_t> triangles,
           const PartRunner& parts, BuildMeter& meter)
      : size_(static_cast<std::uint32_t>(triangles.size())),
        references_(triangles.size()),
        runner_(parts),
        meter_(meter) {
    whole_.end = size_;
    std::vector<FlatBox> centres(chunks(size_, shared_above));
    run_chunks(parts, size_, shared_above, [&](std::size_t k, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& t = mesh.triangles[triangles[i]];
        const Lanes p = corners[t[0]], q = corners[t[1]], r = corners[t[2]];
        references_[i] = {min_of(p, min_of(q, r)), max_of(p, max_of(q, r)), triangles[i]};
        centres[k].add(references_[i].centre());
      }
    });
    for (const FlatBox& box : centres) whole_.centres.add(box);
  }

  SplitTree tree(int level) {
    SplitTree tree;
    build(whole_, level, tree);
    if (!is_shared(size_)) meter_.spend(size_);
    return tree;
  }

  void give_order(std::span<std::uint32_t> triangles) const {
    run_chunks(runner_, size_, shared_above, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) triangles[i] = references_[i].triangle();
    });
  }

 private:
  static bool is_shared(std::uint32_t size) { return size > shared_above; }

  void build(const Range& range, int level, SplitTree& tree) {
    const std::size_t self = tree.nodes.size();
    SplitNode node{range.begin, range.end};
    tree.nodes.push_back(node);
    tree.depth = std::max(tree.depth, level);
    if (range.size() <= mesh_lanes) {
      node.bottoms = 1;
      node.lanes = range.size();
    } else {
      std::array<Range, mesh_lanes> part;
      node.lanes = split(range, level, part);
      build_children(std::span(part).first(node.lanes), is_shared(range.size()), level + 1, tree);
      node.nodes = static_cast<std::uint32_t>(tree.nodes.size() - self);
      for (std::size_t n = self + 1; n < tree.nodes.size(); n += tree.nodes[n].nodes)
        node.bottoms += tree.nodes[n].bottoms;
    }
    tree.nodes[self] = node;
  }

  void build_children(std::span<const Range> part, bool shared, int level, SplitTree& tree) {
    if (!shared) {
      for (const Range& range : part) build(range, level, tree);
      return;
    }
    std::array<SplitTree, mesh_lanes> subtree;
    run_parts(runner_, part.size(), [&](std::size_t k) {
      build(part[k], level, subtree[k]);
      if (!is_shared(part[k].size())) meter_.spend(part[k].size());
    });
    std::size_t all = tree.nodes.size();
    for (const SplitTree& s : subtree) all += s.nodes.size();
    tree.nodes.reserve(all);
    for (const SplitTree& s : subtree) {
      tree.nodes.insert(tree.nodes.end(), s.nodes.begin(), s.nodes.end());
      tree.depth = std::max(tree.depth, s.depth);
    }
  }

  // Splits the largest range until there are eight, or all fit in a bottom node.
  std::uint32_t split(const Range& range, int level, std::array<Range, mesh_lanes>& part) {
    part[0] = range;
    std::uint32_t lanes = 1;
    while (lanes < mesh_lanes) {
      std::uint32_t largest = 0;
      for (std::uint32_t k = 1; k < lanes; ++k)
        if (part[k].size() > part[largest].size()) largest = k;
      if (part[largest].size() <= mesh_lanes) break;
      const Range whole = part[largest];
      halve(whole, level, part[largest], part[lanes++]);
    }
    return lanes;
  }

  // Splits a range by the surface area heuristic; by the median if that gains nothing.
  void halve(const Range& r, int level, Range& left, Range& right) {
    const Grid grid(r.centres);
    const Split best = level < last_binned_level ? binning(r, grid).best(r.size()) : Split{};
    left = {r.begin, r.begin + (best.axis >= 0 ? best.left : r.size() / 2)};
    right = {left.end, r.end};
    if (best.axis < 0)
      halve_by_median(r, left, right);
    else if (is_shared(r.size()))
      part_at_once(grid, best, left, right);
    else
      part(grid, best, left, right);
  }

  Binning binning(const Range& r, const Grid& grid) {
    Binning all;
    if (!is_shared(r.size())) {
      all.add(grid, &references_[r.begin], &references_[r.begin] + r.size());
      return all;
    }
    std::vector<Binning> some(chunks(r.size(), shared_above));
    run_chunks(runner_, r.size(), shared_above, [&](std::size_t k, std::size_t begin, std::size_t end) {
      meter_.spend(0);
      some[k].add(grid, &references_[r.begin] + begin, &references_[r.begin] + end);
    });
    for (const Binning& b : some) all.add(b);
    return all;
  }

  // From both ends: elements on the wrong side are exchanged (as by std::partition).
  void part(const Grid& grid, const Split& split, Range& left, Range& right) {
    Reference *from = &references_[left.begin], *to = from + (right.end - left.begin);
    const auto goes_left = [&](const Reference& r) { return grid.bins_of(r)[split.axis] < split.bin; };
    for (;;) {
      for (; from != to && goes_left(*from); ++from) left.centres.add(from->centre());
      if (from == to) return;
      for (--to; from != to && !goes_left(*to); --to) right.centres.add(to->centre());
      right.centres.add(from->centre());
      if (from == to) return;
      left.centres.add(to->centre());
      std::swap(*from++, *to);
    }
  }

  // `part` with several threads: the first element on the wrong side on the left is exchanged with the last on the
  // right.
  void part_at_once(const Grid& grid, const Split& split, Range& left, Range& right) {
    const auto goes_left = [&](const Reference& r) { return grid.bins_of(r)[split.axis] < split.bin; };
    struct Some {
      std::vector<std::uint32_t> wrong{};
      FlatBox left{}, right{};
    };
    const auto survey = [&](const Range& side, bool is_left) {
      std::vector<Some> some(chunks(side.size(), shared_above));
      run_chunks(runner_, side.size(), shared_above, [&](std::size_t k, std::size_t begin, std::size_t end) {
        meter_.spend(0);
        for (std::size_t i = side.begin + begin; i < side.begin + end; ++i) {
          const bool to_left = goes_left(references_[i]);
          (to_left ? some[k].left : some[k].right).add(references_[i].centre());
          if (to_left != is_left) some[k].wrong.push_back(static_cast<std::uint32_t>(i));
        }
      });
      std::vector<std::uint32_t> wrong;
      for (const Some& s : some) {
        left.centres.add(s.left), right.centres.add(s.right);
        wrong.insert(wrong.end(), s.wrong.begin(), s.wrong.end());
      }
      return wrong;
    };
    const Range on_left = left, on_right = right;
    const std::vector<std::uint32_t> in_left = survey(on_left, true), in_right = survey(on_right, false);
    run_chunks(runner_, in_left.size(), shared_above, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        std::swap(references_[in_left[i]], references_[in_right[in_right.size() - 1 - i]]);
    });
  }

  void halve_by_median(const Range& r, Range& left, Range& right) {
    const Lanes width = r.centres.high - r.centres.low;
    const int axis = width[0] >= width[1] && width[0] >= width[2] ? 0 : width[1] >= width[2] ? 1 : 2;
    Reference* const from = &references_[r.begin];
    std::nth_element(from, from + left.size(), from + r.size(), [&](const Reference& a, const Reference& b) {
      const float p = a.centre()[axis], q = b.centre()[axis];
      return p != q ? p < q : a.triangle() < b.triangle();
    });
    for (std::uint32_t i = left.begin; i < left.end; ++i) left.centres.add(references_[i].centre());
    for (std::uint32_t i = right.begin; i < right.end; ++i) right.centres.add(references_[i].centre());
  }

  const std::uint32_t size_;
  UninitialisedList<Reference> references_;
  const PartRunner& runner_;
  BuildMeter& meter_;
  Range whole_;
};

}  // namespace

SplitTree split_triangles(const MeshModel& mesh, std::span<const FourFloats> corners,
                          std::span<std::uint32_t> triangles, int level, const PartRunner& parts, BuildMeter& meter) {
  Splitter splitter(mesh, corners, triangles, parts, meter);
  SplitTree tree = splitter.tree(level);
  splitter.give_order(triangles);
  return tree;
}

}  // namespace tandem
