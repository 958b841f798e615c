// Replaces ranges of a list of contacts in place.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// A replacement: pairs [at, at + removed) of a list and their contacts are replaced by pairs [from, from + added) of
/// another list.
struct Splice {
  std::uint32_t at = 0, removed = 0;
  std::uint32_t from = 0, added = 0;
};

/// Changes ranges of a list in place: elements before the first change of length are not moved, nor are those after
/// changes that cancel out.
class ListSplicer {
 public:
  /// Splices with ascending, non-overlapping places, all in terms of the old `base`. In both lists contacts are in the
  /// order of their pairs, without gaps.
  void apply(std::span<const Splice> splices, const ContactList& other, ContactList& base);

 private:
  /// Unchanged elements, and their destination.
  struct Segment {
    std::size_t from, count, to;
  };
  template <class T>
  static void move(std::span<const Segment> segments, std::vector<T>& values);

  std::vector<Segment> pairs_, contacts_;
};

}  // namespace tandem
