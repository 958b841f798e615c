// Worlds of boxes for tests.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// The reference: a plain double loop that shares only `overlap` with the methods.
inline std::vector<Pair> overlapping_pairs(const BoxArray& boxes) {
  std::vector<Aabb> plain(boxes.size());
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = boxes[i];
  std::vector<Pair> pairs;
  for (std::uint32_t a = 0; a < plain.size(); ++a)
    for (std::uint32_t b = a + 1; b < plain.size(); ++b)
      if (overlap(plain[a], plain[b])) pairs.push_back({a, b});
  return pairs;
}

/// Boxes by centre and edge, both functions of a random source.
using Random = std::mt19937;
using Point = std::array<float, 3>;

inline float uniform(Random& random, float lo, float hi) {
  return lo + (hi - lo) * (static_cast<float>(random() >> 8) * 0x1p-24f);
}

inline BoxArray make_boxes(std::size_t n, unsigned seed, const std::function<Point(Random&)>& centre,
                           const std::function<Point(Random&)>& edge) {
  Random random(seed);
  BoxArray boxes;
  boxes.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Point c = centre(random), e = edge(random);
    Aabb box;
    for (std::size_t k = 0; k < 3; ++k) {
      box.lo[k] = c[k] - 0.5f * e[k];
      box.hi[k] = c[k] + 0.5f * e[k];
    }
    boxes.set(i, box);
  }
  return boxes;
}

struct BoxWorld {
  std::string name;
  BoxArray boxes;
};

/// Worlds that are hard for broad phases, n boxes each.
inline std::vector<BoxWorld> hard_worlds(std::size_t n) {
  const float side = 2 * std::cbrt(static_cast<float>(n) + 1);
  const auto in_cube = [](float size) {
    return [size](Random& r) { return Point{uniform(r, 0, size), uniform(r, 0, size), uniform(r, 0, size)}; };
  };
  const auto edges = [](float size) { return [size](Random&) { return Point{size, size, size}; }; };
  const auto log_edges = [](float lowest, float decades) {
    return [=](Random& r) {
      const float e = lowest * std::pow(10.0f, uniform(r, 0, decades));
      return Point{e, e, e};
    };
  };
  constexpr float big = std::numeric_limits<float>::max();
  const auto count = static_cast<float>(n);

  std::vector<BoxWorld> worlds;
  worlds.push_back({"random", make_boxes(n, 1, in_cube(side), edges(1))});
  worlds.push_back({"sparse", make_boxes(n, 2, in_cube(20 * side), edges(1))});
  worlds.push_back({"zero size", make_boxes(n, 3, in_cube(side), edges(0))});
  worlds.push_back({"line", make_boxes(
                                n, 4,
                                [&](Random& r) {
                                  return Point{5, uniform(r, 0, count), -3};
                                },
                                edges(1))});
  worlds.push_back({"points on a line", make_boxes(
                                            n, 5,
                                            [&](Random& r) {
                                              return Point{std::floor(uniform(r, 0, 4 * count)), 0, 0};
                                            },
                                            edges(0))});
  worlds.push_back({"plane", make_boxes(
                                 n, 6,
                                 [&](Random& r) {
                                   const float s = std::sqrt(count);
                                   return Point{uniform(r, 0, s), uniform(r, 0, s), 0};
                                 },
                                 edges(1))});
  worlds.push_back({"clusters", make_boxes(
                                    n, 7,
                                    [](Random& r) {
                                      Random place(r() % 5);
                                      Point p;
                                      for (float& x : p) x = uniform(place, -1e5f, 1e5f) + uniform(r, 0, 20);
                                      return p;
                                    },
                                    edges(0.5f))});
  worlds.push_back({"two tight clusters, far apart", make_boxes(
                                                         n, 8,
                                                         [](Random& r) {
                                                           const float at = r() % 2 == 0 ? 0 : 1e30f;
                                                           return Point{at, uniform(r, 0, 30), uniform(r, 0, 30)};
                                                         },
                                                         edges(0.5f))});
  worlds.push_back({"six decades of size", make_boxes(n, 9, in_cube(40 * side), log_edges(1e-4f, 6))});
  worlds.push_back({"tiny ones in a plane among big ones", make_boxes(
                                                               n, 10,
                                                               [=](Random& r) {
                                                                 Point p = in_cube(side)(r);
                                                                 if (r() % 5 != 0) p[0] = 3;
                                                                 return p;
                                                               },
                                                               log_edges(1e-3f, 3))});
  worlds.push_back({"needles", make_boxes(n, 11, in_cube(2 * side), [](Random& r) {
                      Point e{0.01f, 0.01f, 0.01f};
                      e[r() % 3] = 30;
                      return e;
                    })});
  worlds.push_back({"around 1e6", make_boxes(
                                      n, 12,
                                      [=](Random& r) {
                                        Point p = in_cube(side)(r);
                                        for (float& x : p) x += 1e6f;
                                        return p;
                                      },
                                      edges(0.9f))});
  worlds.push_back({"coordinates of 1e30", make_boxes(n, 13, in_cube(side * 1e30f), edges(1e30f))});
  worlds.push_back({"coordinates of 1e-30", make_boxes(n, 14, in_cube(side * 1e-30f), edges(1e-30f))});
  worlds.push_back(
      {"all of float", make_boxes(
                           n, 15,
                           [=](Random& r) {
                             return Point{uniform(r, -1, 1) * big, uniform(r, -1, 1) * big, uniform(r, -1, 1) * big};
                           },
                           edges(0))});
  worlds.push_back({"large outliers among many", make_boxes(
                                                     n, 16,
                                                     [=](Random& r) {
                                                       Point p = in_cube(side)(r);
                                                       if (r() % 50 == 0)
                                                         for (float& x : p) x *= 1e20f;
                                                       return p;
                                                     },
                                                     edges(1))});
  worlds.push_back({"many large ones", make_boxes(n, 17, in_cube(4 * side), [](Random& r) {
                      const float e = r() % 20 == 0 ? 20.0f : 0.1f;
                      return Point{e, e, e};
                    })});

  BoxWorld ground{"an unbounded ground", make_boxes(n, 18, in_cube(side), edges(1))};
  if (n > 2) ground.boxes.set(n / 2, {{-big, -big, -big}, {big, big, 0.2f}});
  if (n > 2) ground.boxes.set(n / 3, {{-1e30f, -1e30f, -1e30f}, {1e30f, 0.1f, 1e30f}});
  worlds.push_back(std::move(ground));

  BoxWorld removed{"bodies taken out", make_boxes(n, 19, in_cube(side), edges(1.2f))};
  for (std::size_t i = 0; i < n; i += 3) removed.boxes.set_empty(i);
  worlds.push_back(std::move(removed));

  BoxWorld none{"all bodies taken out", {}};
  none.boxes.resize(n);
  for (std::size_t i = 0; i < n; ++i) none.boxes.set_empty(i);
  worlds.push_back(std::move(none));
  return worlds;
}

/// Cells of a cube that share faces, edges and corners, shuffled.
inline BoxArray touching_cells(int n, float cell) {
  std::vector<Aabb> cells;
  const auto at = [&](int i) { return static_cast<float>(i) * cell; };
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) cells.push_back({{at(x), at(y), at(z)}, {at(x + 1), at(y + 1), at(z + 1)}});
  std::shuffle(cells.begin(), cells.end(), Random(7));
  BoxArray boxes;
  boxes.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) boxes.set(i, cells[i]);
  return boxes;
}

/// Along 3 axes, 6 face diagonals, 4 body diagonals.
inline std::size_t touching_cells_pairs(std::size_t n) {
  return 3 * (n - 1) * n * n + 6 * (n - 1) * (n - 1) * n + 4 * (n - 1) * (n - 1) * (n - 1);
}

class ListSink final : public PairSink {
 public:
  ListSink() : room_(64) {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  std::vector<Pair> take() {
    full();
    return std::move(pairs_);
  }

 private:
  void full() override {
    pairs_.insert(pairs_.end(), buffer_, buffer_ + count_);
    count_ = 0;
  }
  PairFilter everything_;
  std::vector<Pair> room_, pairs_;
};

enum class Order { forward, reversed, shuffled, threads };

/// Runs a step with the blocks of each stage in some order; returns the pairs of each block of the last stage.
inline std::vector<std::vector<Pair>> pairs_of_blocks(BroadPhase& method, const BoxArray& boxes, Order order) {
  Random random(99);
  const auto each = [&](std::size_t blocks, const std::function<void(std::size_t)>& work) {
    if (order == Order::threads) {
      std::atomic<std::size_t> next{0};
      std::vector<std::thread> threads;
      for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
          for (std::size_t block = next++; block < blocks; block = next++) work(block);
        });
      for (std::thread& thread : threads) thread.join();
      return;
    }
    std::vector<std::size_t> blocks_in_order(blocks);
    std::iota(blocks_in_order.begin(), blocks_in_order.end(), std::size_t{0});
    if (order == Order::reversed) std::reverse(blocks_in_order.begin(), blocks_in_order.end());
    if (order == Order::shuffled) std::shuffle(blocks_in_order.begin(), blocks_in_order.end(), random);
    for (const std::size_t block : blocks_in_order) work(block);
  };

  const std::size_t stages = method.begin(boxes);
  for (std::size_t stage = 0; stage + 1 < stages; ++stage)
    each(method.blocks(stage), [&](std::size_t block) { method.run(stage, block); });
  std::vector<std::vector<Pair>> found(method.blocks(stages - 1));
  each(found.size(), [&](std::size_t block) {
    ListSink sink;
    method.emit(block, sink);
    found[block] = sink.take();
  });
  return found;
}

inline std::vector<Pair> sorted_pairs(const std::vector<std::vector<Pair>>& found) {
  std::vector<Pair> pairs;
  for (const auto& block : found) pairs.insert(pairs.end(), block.begin(), block.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace tandem
