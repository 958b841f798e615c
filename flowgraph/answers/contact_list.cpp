// The hash of a step's contacts.
#include "tandem/flowgraph/contact_list.h"

#include "answers/word_hash.h"

namespace tandem {

std::uint64_t hash(const ContactList& list) {
  WordHash words;
  for (const PairResult& pair : list.pairs) {
    words.add(std::uint64_t{pair.a} << 32 | pair.b);
    words.add(std::uint64_t{pair.contact_count} << 1 | std::uint64_t{pair.answer.collide});
    words.add(pair.answer.signed_distance);
    words.add(pair.answer.normal);
  }
  for (const Contact& contact : list.contacts) {
    words.add(contact.point);
    words.add(contact.normal);
    words.add(contact.depth);
    words.add(std::uint64_t{contact.feature});
  }
  return words.value();
}

}  // namespace tandem
