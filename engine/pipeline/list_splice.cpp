// Replaces ranges of a list of contacts in place.
#include "pipeline/list_splice.h"

#include <algorithm>

namespace tandem {
namespace {

std::size_t first_contact(const ContactList& list, std::size_t pair) {
  return pair < list.pairs.size() ? list.pairs[pair].first_contact : list.contacts.size();
}

}  // namespace

// Moves elements within a vector. Elements moved to the left may overwrite the old places of those before, elements
// moved to the right those after: each range is moved before its place is overwritten. Destinations do not overlap.
template <class T>
void ListSplicer::move(std::span<const Segment> segments, std::vector<T>& values) {
  const auto at = [&](std::size_t place) { return values.begin() + static_cast<std::ptrdiff_t>(place); };
  for (std::size_t i = 0; i < segments.size();) {
    if (segments[i].to <= segments[i].from) {
      const Segment& s = segments[i++];
      if (s.to != s.from) std::move(at(s.from), at(s.from + s.count), at(s.to));
      continue;
    }
    std::size_t end = i;
    while (end < segments.size() && segments[end].to > segments[end].from) ++end;
    for (std::size_t k = end; k-- > i;) {
      const Segment& s = segments[k];
      std::move_backward(at(s.from), at(s.from + s.count), at(s.to + s.count));
    }
    i = end;
  }
}

void ListSplicer::apply(std::span<const Splice> splices, const ContactList& other, ContactList& base) {
  pairs_.clear();
  contacts_.clear();
  std::size_t pair = 0, contact = 0;        // next element in the old list
  std::size_t to_pair = 0, to_contact = 0;  // and in the new one
  const auto stay = [&](std::size_t end) {
    const std::size_t contact_end = first_contact(base, end);
    pairs_.push_back({pair, end - pair, to_pair});
    contacts_.push_back({contact, contact_end - contact, to_contact});
    to_pair += end - pair;
    to_contact += contact_end - contact;
  };
  for (const Splice& s : splices) {
    stay(s.at);
    pair = std::size_t{s.at} + s.removed;
    contact = first_contact(base, pair);
    to_pair += s.added;
    to_contact += first_contact(other, std::size_t{s.from} + s.added) - first_contact(other, s.from);
  }
  stay(base.pairs.size());

  base.pairs.resize(std::max(base.pairs.size(), to_pair));
  base.contacts.resize(std::max(base.contacts.size(), to_contact));
  move(std::span<const Segment>(pairs_), base.pairs);
  move(std::span<const Segment>(contacts_), base.contacts);
  base.pairs.resize(to_pair);
  base.contacts.resize(to_contact);

  const auto put = [&](std::size_t first, std::size_t end, std::size_t from_contact, std::size_t its_contact) {
    if (from_contact == its_contact) return;
    const auto moved = static_cast<std::uint32_t>(its_contact - from_contact);  // modulo 2^32
    for (std::size_t i = first; i < end; ++i) base.pairs[i].first_contact += moved;
  };
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const Segment &stayed = pairs_[k], &its_contacts = contacts_[k];
    put(stayed.to, stayed.to + stayed.count, its_contacts.from, its_contacts.to);
    if (k == splices.size()) break;
    const Splice& s = splices[k];
    const std::size_t to = stayed.to + stayed.count, contacts_to = its_contacts.to + its_contacts.count;
    const std::size_t first = first_contact(other, s.from), last = first_contact(other, std::size_t{s.from} + s.added);
    std::copy_n(other.pairs.begin() + s.from, s.added, base.pairs.begin() + static_cast<std::ptrdiff_t>(to));
    std::copy_n(other.contacts.begin() + static_cast<std::ptrdiff_t>(first), last - first,
                base.contacts.begin() + static_cast<std::ptrdiff_t>(contacts_to));
    put(to, to + s.added, first, contacts_to);
  }
}

}  // namespace tandem
