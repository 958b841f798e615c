// Bodies that left the enlarged boxes of a list of candidates, and were inserted again.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "storage/memory.h"
#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Bodies that left the enlarged boxes of a list of candidates, and were put back with new ones.
class ReturnedBodies {
 public:
  /// Removes all; body indices are below `count` from now on.
  void clear(std::size_t count);

  struct Return {
    std::uint32_t body;
    Aabb box;  ///< its new enlarged box
  };
  /// Puts bodies back, each at most once in a call. `now(body)` is the enlarged box that it has had so far.
  template <class BoxNow>
  void put(std::span<const Return> returns, const BoxNow& now) {
    if (returns.empty()) return;
    ++turn_;
    for (const Return& r : returns) {
      if (!has(r.body)) {
        known_.push_back({turn_, now(r.body)});
        place_[r.body] = static_cast<std::uint32_t>(known_.size());
      }
      known_[place_[r.body] - 1].turn = turn_;
      recent_.items.push_back({r.body, turn_, r.box});
    }
    sort();
  }
  /// The number of calls of `put` with at least one body.
  std::uint32_t turn() const { return turn_; }

  bool has(std::uint32_t body) const { return place_[body] != 0; }
  /// The number of the last call of `put` that had this body, counted from 1; 0: none had.
  std::uint32_t turn(std::uint32_t body) const {
    const std::uint32_t place = place_[body];
    return place == 0 ? 0 : known_[place - 1].turn;
  }
  void prefetch(std::uint32_t body) const { __builtin_prefetch(&place_[body]); }
  /// The box with which the list was made; only for a body that was put back.
  const Aabb& first(std::uint32_t body) const { return known_[place_[body] - 1].first; }

  /// Appends the bodies that were put back whose boxes overlap `box`, each once.
  void overlapping(const Aabb& box, std::vector<std::uint32_t>& row, std::vector<std::uint32_t>& out) const;

  std::size_t memory() const { return bytes_of(place_) + bytes_of(known_) + sorted_.memory() + recent_.memory(); }

 private:
  struct Item {
    std::uint32_t body, turn;
    Aabb box;
  };
  /// Boxes sorted by their lower bound on the first axis.
  struct Sorted {
    std::vector<Item> items;
    BoxArray boxes;
    std::vector<float> reach;  // the highest upper bound on that axis of all boxes up to here
    std::size_t memory() const { return bytes_of(items) + boxes.memory() + bytes_of(reach); }
  };

  void sort();
  static void order(std::vector<Item>& items, std::size_t first);
  static void refresh(Sorted& sorted);
  void search(const Sorted& sorted, const Aabb& box, std::vector<std::uint32_t>& row,
              std::vector<std::uint32_t>& out) const;

  struct Known {
    std::uint32_t turn;
    Aabb first;
  };

  std::vector<std::uint32_t> place_;  // one a body: 1 + its place in known_, or 0 if it was not put back
  std::vector<Known> known_;
  Sorted sorted_, recent_;  // recent ones apart, so that a step sorts few
  std::uint32_t turn_ = 0;
};

}  // namespace tandem
