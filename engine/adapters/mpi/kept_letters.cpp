#include "kept_letters.h"

#include "records.h"

namespace tandem::mpi {

void write_kept(Message& letter, const IdPair& ids, const KeptRecord& record) {
  letter.put(ids);
  letter.put(record.entry);
  letter.put(record.largest);
  letter.put(record.detail.has_value());
  if (record.detail) {
    letter.put(KeptPairRecord::of(*record.detail));
    letter.put(static_cast<std::uint32_t>(record.detail->contacts.size()));
    record.detail->contacts.each([&](const Contact& contact) { letter.put(ContactRecord::of(contact)); });
  }
  if (!record.entry.reported) return;
  letter.put(AnswerRecord::of(record.answer));
  letter.put(static_cast<std::uint32_t>(record.contacts.size()));
  for (const Contact& contact : record.contacts) letter.put(ContactRecord::of(contact));
}

std::pair<IdPair, KeptRecord> take_kept(Message& letter) {
  const auto ids = letter.take<IdPair>();
  KeptRecord record;
  record.entry = letter.take<KeptEntry>();
  record.largest = letter.take<KeptLargest>();
  if (letter.take<bool>()) {
    record.detail = letter.take<KeptPairRecord>().kept();
    for (auto count = letter.take<std::uint32_t>(); count > 0; --count)
      record.detail->contacts.add(letter.take<ContactRecord>().contact());
  }
  if (!record.entry.reported) return {ids, record};
  record.answer = letter.take<AnswerRecord>().answer();
  for (auto count = letter.take<std::uint32_t>(); count > 0; --count)
    record.contacts.push_back(letter.take<ContactRecord>().contact());
  return {ids, record};
}

}  // namespace tandem::mpi
