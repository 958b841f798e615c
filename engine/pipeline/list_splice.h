#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// In a list, pairs [at, at + removed) and their contacts give way to pairs [from, from + added) of another list.
struct Splice {
  std::uint32_t at = 0, removed = 0;
  std::uint32_t from = 0, added = 0;
};

/// Changes parts of a list where it lies: what comes before the first change of length is not touched, nor is what
/// comes after changes that cancel out.
class ListSplicer {
 public:
  /// Splices by ascending places, none of which overlap; they are all of `base` as it was. In both lists contacts lie
  /// by the order of their pairs, without gaps.
  void apply(std::span<const Splice> splices, const ContactList& other, ContactList& base);

 private:
  /// Elements that stay, and where they go.
  struct Segment {
    std::size_t from, count, to;
  };
  template <class T>
  static void move(std::span<const Segment> segments, std::vector<T>& values);

  std::vector<Segment> pairs_, contacts_;
};

}  // namespace tandem
