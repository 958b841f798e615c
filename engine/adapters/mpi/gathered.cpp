// Gathers the answers of all ranks in canonical order, and hashes them.
#include <algorithm>
#include <utility>

#include "answer_sum.h"
#include "answers/word_hash.h"
#include "communicator.h"
#include "pipeline_impl.h"
#include "records.h"
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

/// Sends each pair to a rank, and sorts the pairs that arrive, with their contacts.
GatheredContacts Pipeline::Impl::gather(const std::function<int(GlobalId)>& to) const {
  Outbox outbox(communicator.ranks());
  const ContactList& list = contacts();
  for (const PairResult& pair : list.pairs) {
    Message& message = outbox.to(to(bodies.id(pair.a)));
    message.put(bodies.id(pair.a));
    message.put(bodies.id(pair.b));
    message.put(pair.contact_count);
    message.put(AnswerRecord::of(pair.answer));
    for (const Contact& contact : list.of(pair)) message.put(ContactRecord::of(contact));
  }
  std::vector<RankMessage> received = communicator.exchange(outbox);
  GatheredContacts all;
  std::vector<Contact> points;
  for (RankMessage& message : received)
    while (!message.content.done()) {
      GatheredPair& pair = all.pairs.emplace_back();
      pair.a = message.content.take<GlobalId>();
      pair.b = message.content.take<GlobalId>();
      pair.contact_count = message.content.take<std::uint32_t>();
      pair.first_contact = points.size();
      pair.answer = message.content.take<AnswerRecord>().answer();
      for (std::uint32_t i = 0; i < pair.contact_count; ++i)
        points.push_back(message.content.take<ContactRecord>().contact());
    }
  std::sort(all.pairs.begin(), all.pairs.end(),
            [](const GatheredPair& x, const GatheredPair& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  all.contacts.reserve(points.size());
  for (GatheredPair& pair : all.pairs) {
    const auto first = points.begin() + static_cast<std::ptrdiff_t>(pair.first_contact);
    pair.first_contact = all.contacts.size();
    all.contacts.insert(all.contacts.end(), first, first + pair.contact_count);
  }
  return all;
}

GatheredContacts Pipeline::Impl::share() const {
  std::uint64_t last[] = {0};
  for (const PairResult& pair : contacts().pairs) last[0] = std::max(last[0], bodies.id(pair.a));
  if (communicator.ranks() > 1) communicator.largest(std::span<std::uint64_t>(last));
  const GlobalId ids = last[0] / static_cast<GlobalId>(communicator.ranks()) + 1;
  return gather([ids](GlobalId a) { return static_cast<int>(a / ids); });
}

std::uint64_t Pipeline::Impl::list_hash(const GatheredContacts& share) const {
  const int rank = communicator.rank(), last = communicator.ranks() - 1;
  std::uint64_t value = WordHash().value();
  // All pairs first, then all contacts.
  for (const bool of_contacts : {false, true}) {
    if (of_contacts && last > 0 && rank == last) communicator.send(value, 0);
    if (rank > 0)
      value = communicator.receive(rank - 1);
    else if (of_contacts && last > 0)
      value = communicator.receive(last);
    WordHash words(value);
    for (const GatheredPair& pair : share.pairs) {
      if (of_contacts) break;
      words.add(pair.a << 32 | pair.b);
      words.add(std::uint64_t{pair.contact_count} << 1 | std::uint64_t{pair.answer.collide});
      words.add(pair.answer.signed_distance);
      words.add(pair.answer.normal);
    }
    for (const Contact& contact : share.contacts) {
      if (!of_contacts) break;
      words.add(contact.point);
      words.add(contact.normal);
      words.add(contact.depth);
      words.add(std::uint64_t{contact.feature});
    }
    value = words.value();
    if (rank < last) communicator.send(value, rank + 1);
  }
  std::uint64_t whole[] = {rank == last ? value : 0};
  if (last > 0) communicator.largest(std::span<std::uint64_t>(whole));
  return whole[0];
}

}  // namespace tandem::mpi
