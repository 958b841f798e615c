// Messages with the kept answers of pairs.
#include "kept_messages.h"

#include "records.h"

namespace tandem::mpi {

void write_kept(Message& message, const IdPair& ids, const KeptRecord& record) {
  message.put(ids);
  message.put(record.entry);
  message.put(record.largest);
  message.put(record.detail.has_value());
  if (record.detail) {
    message.put(KeptPairRecord::of(*record.detail));
    message.put(static_cast<std::uint32_t>(record.detail->contacts.size()));
    record.detail->contacts.each([&](const Contact& contact) { message.put(ContactRecord::of(contact)); });
  }
  if (!record.entry.reported) return;
  message.put(AnswerRecord::of(record.answer));
  message.put(static_cast<std::uint32_t>(record.contacts.size()));
  for (const Contact& contact : record.contacts) message.put(ContactRecord::of(contact));
}

std::pair<IdPair, KeptRecord> take_kept(Message& message) {
  const auto ids = message.take<IdPair>();
  KeptRecord record;
  record.entry = message.take<KeptEntry>();
  record.largest = message.take<KeptLargest>();
  if (message.take<bool>()) {
    record.detail = message.take<KeptPairRecord>().kept();
    for (auto count = message.take<std::uint32_t>(); count > 0; --count)
      record.detail->contacts.add(message.take<ContactRecord>().contact());
  }
  if (!record.entry.reported) return {ids, record};
  record.answer = message.take<AnswerRecord>().answer();
  for (auto count = message.take<std::uint32_t>(); count > 0; --count)
    record.contacts.push_back(message.take<ContactRecord>().contact());
  return {ids, record};
}

}  // namespace tandem::mpi
