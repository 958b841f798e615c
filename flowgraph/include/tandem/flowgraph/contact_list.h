// The answer of a step: pairs and contacts in canonical order.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/narrowphase/answer.h"

namespace tandem {

/// The answer for one pair of bodies that a step reports: a pair that collides, or (Request::contacts with a margin) is
/// closer than the margin, or (Request::distance) every candidate. Its contacts are contacts[first_contact,
/// first_contact + contact_count).
struct PairResult {
  std::uint32_t a = 0;  ///< body index, a < b
  std::uint32_t b = 0;
  std::uint32_t first_contact = 0;
  std::uint32_t contact_count = 0;
  PairAnswer answer;
};

/// The answer of a step in canonical order: pairs by (a, b), a pair's contacts by feature.
struct ContactList {
  std::vector<PairResult> pairs;
  std::vector<Contact> contacts;

  std::span<const Contact> of(const PairResult& pair) const {
    return std::span(contacts).subspan(pair.first_contact, pair.contact_count);
  }
};

/// FNV-1a over the bits of every pair and contact, in order: equal hashes are equal answers.
std::uint64_t hash(const ContactList& list);

}  // namespace tandem
