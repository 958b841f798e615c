// The answers of one batch of pairs: kept, extrapolated or recomputed.
#pragma once
#include "pipeline/kept_contacts.h"

namespace tandem {

/// The processing of one batch by one thread. `append_valid` accepts pairs whose answers remain valid; the pair after
/// them is extrapolated where possible (`extrapolate`), else recomputed (`store`), and recorded (`record`).
class KeptContacts::Batch {
 public:
  /// Answers are appended to `results` and `contacts`.
  Batch(KeptContacts& all, std::vector<PairResult>& results, std::vector<Contact>& contacts)
      : all_(all), results_(results), contacts_(contacts) {}
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
  /// Reports the batch's new data.
  ~Batch();

  /// The number of pairs at the front whose answers remain valid; they are appended if all pairs are processed.
  std::size_t append_valid(std::span<const Pair> pairs);
  /// Prefetches the data of a pair that comes soon.
  void fetch_ahead() const;
  /// Extrapolates the answer of the pair after those whose answers remain valid; if true, `result.answer` is set and
  /// the contacts are appended. `collide`, if not empty, computes whether the bodies touch; it is called where the
  /// bound leaves the verdict in doubt.
  bool extrapolate(Pair pair, PairResult& result, const std::function<bool()>& collide = {});
  /// Stores a computed answer for extrapolation in later steps.
  void store(const PairResult& result, std::span<const Contact> contacts);
  void record(const PairResult& result, std::span<const Contact> contacts, bool reported);
  /// Whether the current pair touched in the last step.
  bool touched() const { return was_candidate_ && entry_->collide; }

 private:
  struct Relative {
    Mat3 rotation;
    Vec3 translation;
    bool a_is_reference;
  };
  Relative relative(Pair pair) const;
  void find_entry(Pair pair);
  void append(std::uint32_t begin, std::uint32_t end);

  KeptContacts& all_;
  std::vector<PairResult>& results_;
  std::vector<Contact>& contacts_;
  std::size_t next_ = 0;        // expected place of the next pair's entry
  Entry* entry_ = nullptr;      // of the current pair, if it has one
  bool was_candidate_ = false;  // in the last step
  bool moved_ = false;
  double gap_ = 0, moved_by_ = 0;  // of an extrapolated pair
  Relative at_;
  std::uint32_t detail_ = none;  // of the current pair, if it is new
  std::vector<NewPair> new_pairs_;
  std::vector<KeptPair> new_details_;
  std::vector<std::array<std::uint32_t, 2>> adopted_;
  Sums sums_;
};

}  // namespace tandem
