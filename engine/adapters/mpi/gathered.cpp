#include <algorithm>

#include "answer_sum.h"
#include "answers/word_hash.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

std::uint64_t hash_of_pair(GlobalId a, GlobalId b, const PairAnswer& answer, std::span<const Contact> contacts) {
  WordHash words;
  words.add(a);
  words.add(b);
  words.add(std::uint64_t{contacts.size()} << 1 | std::uint64_t{answer.collide});
  words.add(answer.signed_distance);
  words.add(answer.normal);
  for (const Contact& contact : contacts) {
    words.add(contact.point);
    words.add(contact.normal);
    words.add(contact.depth);
    words.add(std::uint64_t{contact.feature});
  }
  return words.value();
}

std::uint64_t hash(const GatheredContacts& all) {
  std::uint64_t sum = 0;
  for (const GatheredPair& pair : all.pairs)
    sum += hash_of_pair(pair.a, pair.b, pair.answer,
                        std::span(all.contacts).subspan(pair.first_contact, pair.contact_count));
  return sum;
}

}  // namespace tandem::mpi
