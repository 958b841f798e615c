#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "storage/memory.h"
#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Bodies that left the boxes with which a list of candidates was made, and were put back with others.
class ReturnedBodies {
 public:
  /// Forgets all; bodies are below `count` from now on.
  void clear(std::size_t count);

  struct Return {
    std::uint32_t body;
    Aabb box;  ///< the new one
  };
  /// Puts some back, each body at most once; those of a later call are later. `now(body)` is the box before.
  template <class BoxNow>
  void put(std::span<const Return> returns, const BoxNow& now) {
    if (returns.empty()) return;
    ++turn_;
    for (const Return& r : returns) {
      if (!has(r.body)) {
        place_[r.body] = static_cast<std::uint32_t>(first_.size());
        first_.push_back(now(r.body));
      }
      turn_of_[r.body] = turn_;
      recent_.items.push_back({r.body, turn_, r.box});
    }
    sort();
  }
  /// Calls of `put` that had something.
  std::uint32_t turn() const { return turn_; }

  bool has(std::uint32_t body) const { return turn_of_[body] != 0; }
  /// The call of `put` in which it was put back last, counted from 1; 0: it never was.
  std::uint32_t turn(std::uint32_t body) const { return turn_of_[body]; }
  void prefetch(std::uint32_t body) const { __builtin_prefetch(&turn_of_[body]); }
  /// The box with which the list was made; only of one that was put back.
  const Aabb& first(std::uint32_t body) const { return first_[place_[body]]; }

  /// Appends those whose boxes overlap `box`, each once.
  void overlapping(const Aabb& box, std::vector<std::uint32_t>& row, std::vector<std::uint32_t>& out) const;

  std::size_t memory() const {
    return bytes_of(turn_of_) + bytes_of(place_) + bytes_of(first_) + sorted_.memory() + recent_.memory();
  }

 private:
  struct Item {
    std::uint32_t body, turn;
    Aabb box;
  };
  /// By lower bound on the first axis.
  struct Sorted {
    std::vector<Item> items;
    BoxArray boxes;
    std::vector<float> reach;  // the highest bound on that axis of all up to here
    std::size_t memory() const { return bytes_of(items) + boxes.memory() + bytes_of(reach); }
  };

  void sort();
  static void order(std::vector<Item>& items, std::size_t first);
  static void refresh(Sorted& sorted);
  void search(const Sorted& sorted, const Aabb& box, std::vector<std::uint32_t>& row,
              std::vector<std::uint32_t>& out) const;

  std::vector<std::uint32_t> turn_of_;  // one a body
  std::vector<std::uint32_t> place_;    // one a body, in first_, of those that were put back
  std::vector<Aabb> first_;
  Sorted sorted_, recent_;  // the recent ones apart, so that few are sorted in a step
  std::uint32_t turn_ = 0;
};

}  // namespace tandem
