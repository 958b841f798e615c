#include <algorithm>
#include <bit>

#include "answer_sum.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {
namespace {

class Words {
 public:
  void add(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x9e3779b97f4a7c15u;
    value_ ^= value_ >> 32;
  }
  // Adding zero makes -0 and +0, which are equal, hash alike.
  void add(double x) { add(std::bit_cast<std::uint64_t>(x + 0.0)); }
  void add(const Vec3& v) {
    add(v.x());
    add(v.y());
    add(v.z());
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace

std::uint64_t hash_of_pair(GlobalId a, GlobalId b, const PairAnswer& answer, std::span<const Contact> contacts) {
  Words words;
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
