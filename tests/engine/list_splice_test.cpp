// Lists of contacts of which ranges are replaced.
#include "pipeline/list_splice.h"

#include <algorithm>
#include <random>

#include "catch.h"

using namespace tandem;

namespace {

std::uint32_t below(std::uint32_t end, std::mt19937& random) { return static_cast<std::uint32_t>(random() % end); }

/// Pairs of 0 to 3 contacts, each with a unique number.
ContactList make_list(std::size_t pairs, std::mt19937& random, std::uint32_t& next) {
  ContactList list;
  for (std::size_t i = 0; i < pairs; ++i) {
    PairResult& pair = list.pairs.emplace_back();
    pair.a = next++;
    pair.first_contact = static_cast<std::uint32_t>(list.contacts.size());
    pair.contact_count = below(4, random);
    for (std::uint32_t k = 0; k < pair.contact_count; ++k) list.contacts.emplace_back().feature = next++;
  }
  return list;
}

void append(const ContactList& from, std::size_t first, std::size_t count, ContactList& to) {
  for (PairResult pair : std::span(from.pairs).subspan(first, count)) {
    const auto contacts = from.of(pair);
    pair.first_contact = static_cast<std::uint32_t>(to.contacts.size());
    to.contacts.insert(to.contacts.end(), contacts.begin(), contacts.end());
    to.pairs.push_back(pair);
  }
}

std::vector<std::array<std::uint32_t, 3>> pairs_of(const ContactList& list) {
  std::vector<std::array<std::uint32_t, 3>> out;
  for (const PairResult& pair : list.pairs) out.push_back({pair.a, pair.first_contact, pair.contact_count});
  return out;
}

std::vector<std::uint32_t> contacts_of(const ContactList& list) {
  std::vector<std::uint32_t> out;
  for (const Contact& contact : list.contacts) out.push_back(contact.feature);
  return out;
}

}  // namespace

TEST_CASE("list splice: changed where it lies, a list is what it would be if it were made anew") {
  std::mt19937 random(1);
  ListSplicer splicer;
  std::uint32_t next = 1;
  for (int round = 0; round < 3000; ++round) {
    CAPTURE(round);
    ContactList base = make_list(below(40, random), random, next), expected;
    const ContactList other = make_list(60, random, next);
    std::vector<Splice> splices;
    std::uint32_t at = 0, from = 0;
    const std::uint32_t few = 1 + below(8, random);  // pairs in a replaced range
    const auto size = static_cast<std::uint32_t>(base.pairs.size());
    while (from + few < other.pairs.size()) {
      const std::uint32_t stays = std::min<std::uint32_t>(size - at, below(12, random));
      append(base, at, stays, expected);
      at += stays;
      const Splice s{at, std::min<std::uint32_t>(size - at, below(few, random)), from, below(few, random)};
      splices.push_back(s);
      append(other, s.from, s.added, expected);
      at += s.removed;
      from += s.added + (s.removed + s.added == 0 ? 1 : 0);
    }
    append(base, at, size - at, expected);
    splicer.apply(splices, other, base);
    REQUIRE(pairs_of(base) == pairs_of(expected));
    REQUIRE(contacts_of(base) == contacts_of(expected));
  }
}
