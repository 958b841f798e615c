// The transfer of kept data of bodies and pairs between pipelines.
#include "pipeline/kept_handover.h"

#include <algorithm>
#include <utility>

namespace tandem {

std::optional<KeptRest> KeptContacts::rest(const Scene& scene, std::uint32_t body) const {
  if (body >= body_shapes_.size() || body_shapes_[body] == 0) return {};
  const bool has_shape = scene.shape_of(body).identity() == body_shapes_[body];
  return KeptRest{anchor(body), reach_[body], step_ - since_[body], has_shape};
}

std::vector<KeptRecord> KeptContacts::leaving(const ContactList& contacts,
                                              const std::function<bool(Pair)>& leaves) const {
  std::vector<KeptRecord> records;
  std::uint32_t place = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::uint32_t at = std::exchange(place, place + listed_[i]);
    const Pair pair = pair_of(keys_[i]);
    if (!entries_[i].candidate || !leaves(pair)) continue;
    KeptRecord& record = records.emplace_back();
    record.pair = pair;
    record.entry = entries_[i];
    record.entry.seen = step_ - entries_[i].seen;
    record.entry.as_of = step_ - entries_[i].as_of;
    record.entry.detail = none;
    record.largest = largest_[i];
    if (entries_[i].detail != none) record.detail = details_[entries_[i].detail];
    if (listed_[i] == 0) continue;
    const PairResult& result = contacts.pairs[at];
    record.answer = result.answer;
    const auto points = contacts.of(result);
    record.contacts.assign(points.begin(), points.end());
  }
  return records;
}

void KeptContacts::take_in(const Scene& scene, ContactList& contacts, std::span<const KeptBody> bodies,
                           std::vector<KeptRecord> pairs) {
  if (bodies.empty() && pairs.empty()) return;
  if (!complete_) clear();
  resize(scene.indices());
  arrived_.assign(scene.indices(), 0);
  for (const auto& [body, rest] : bodies) {
    arrived_[body] = 1;
    const KeptRest known = rest.value_or(KeptRest{});
    anchor_places_[body] = known.anchor.translation;
    anchor_rotations_[body] = known.anchor.rotation;
    reach_[body] = known.reach;
    since_[body] = step_ - known.steps;
    body_shapes_[body] = known.has_shape ? scene.shape_of(body).identity() : 0;
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const KeptRecord& x, const KeptRecord& y) { return key_of(x.pair) < key_of(y.pair); });
  take_in_pairs(contacts, pairs);
  marked_.assign(keys_.size(), 0);
  restless_known_ = any_marked_ = false;
  columns_.clear();
  find_rows();
}

/// Merges the pairs into those of bodies that were there before.
void KeptContacts::take_in_pairs(ContactList& contacts, std::span<KeptRecord> pairs) {
  const auto keys = std::exchange(keys_, {});
  const auto entries = std::exchange(entries_, {});
  const auto listed = std::exchange(listed_, {});
  const auto largest = std::exchange(largest_, {});
  const ContactList before = std::exchange(contacts, {});
  const auto put = [&](Pair pair, const Entry& entry, bool is_listed, const Largest& its, const PairAnswer& answer,
                       std::span<const Contact> points) {
    keys_.push_back(key_of(pair));
    entries_.push_back(entry);
    listed_.push_back(is_listed ? 1 : 0);
    largest_.push_back(its);
    if (!is_listed) return;
    contacts.pairs.push_back({pair.a, pair.b, static_cast<std::uint32_t>(contacts.contacts.size()),
                              static_cast<std::uint32_t>(points.size()), answer});
    contacts.contacts.insert(contacts.contacts.end(), points.begin(), points.end());
  };
  auto next = pairs.begin();
  const auto take_until = [&](std::uint64_t key) {
    for (; next != pairs.end() && key_of(next->pair) < key; ++next) {
      Entry entry = next->entry;
      entry.seen = step_ - entry.seen;
      entry.as_of = step_ - entry.as_of;
      entry.detail = next->detail ? put_detail(std::move(*next->detail)) : none;
      put(next->pair, entry, entry.reported, next->largest, next->answer, next->contacts);
    }
  };
  std::uint32_t place = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::uint32_t at = std::exchange(place, place + listed[i]);
    const Pair pair = pair_of(keys[i]);
    take_until(keys[i]);
    const bool comes = next != pairs.end() && key_of(next->pair) == keys[i];
    if (!comes && arrived_[pair.a] == 0 && arrived_[pair.b] == 0) {
      const bool is_listed = listed[i] != 0;
      put(pair, entries[i], is_listed, largest[i], is_listed ? before.pairs[at].answer : PairAnswer{},
          is_listed ? before.of(before.pairs[at]) : std::span<const Contact>{});
    } else if (entries[i].detail != none) {
      free_details_.push_back(entries[i].detail);
    }
  }
  take_until(~std::uint64_t{0});
}

void KeptContacts::begin_anew() {
  clear();
  anchor_places_.clear();
  anchor_rotations_.clear();
  body_shapes_.clear();
  arrived_.clear();
}

}  // namespace tandem
