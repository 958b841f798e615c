// The answers of one batch of pairs, kept or computed.
#pragma once
#include "pipeline/kept_contacts.h"

namespace tandem {

/// One batch's end, on one thread. After the pairs that `stand` comes one that does not: it is moved along, where that
/// can be, or computed and kept, and noted.
class KeptContacts::Batch {
 public:
  /// Answers are appended to the two.
  Batch(KeptContacts& all, std::vector<PairResult>& results, std::vector<Contact>& contacts)
      : all_(all), results_(results), contacts_(contacts) {}
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
  /// Hands over what is new.
  ~Batch();

  /// How many of these pairs, from the first on, have answers that stand; they are appended where all are asked for.
  std::size_t stand(std::span<const Pair> pairs);
  /// True if the answer of the pair that does not stand is moved along: then `result.answer` is set and the contacts
  /// are appended.
  /// `collide`, if not empty, is asked where the verdict is in doubt: whether they touch.
  void fetch_ahead() const;
  bool move_along(Pair pair, PairResult& result, const std::function<bool()>& collide = {});
  /// Keeps what was computed, so that it can be moved along.
  void keep(const PairResult& result, std::span<const Contact> contacts);
  void note(const PairResult& result, std::span<const Contact> contacts, bool reported);
  /// Whether the pair that does not stand touched in the last step.
  bool touched() const { return was_candidate_ && entry_->collide; }

 private:
  struct Relative {
    Mat3 rotation;
    Vec3 translation;
    bool a_is_reference;
  };
  Relative relative(Pair pair) const;
  void seek(Pair pair);
  void append(std::uint32_t begin, std::uint32_t end);

  KeptContacts& all_;
  std::vector<PairResult>& results_;
  std::vector<Contact>& contacts_;
  std::size_t next_ = 0;        // where the next pair's entry is expected
  Entry* entry_ = nullptr;      // of the pair asked for, where it has one
  bool was_candidate_ = false;  // in the step before
  bool moved_ = false;
  double gap_ = 0, moved_by_ = 0;  // of a pair that was moved along
  Relative at_;
  std::uint32_t detail_ = none;  // of the pair asked for, where it is new
  std::vector<Fresh> fresh_;
  std::vector<KeptPair> fresh_details_;
  std::vector<std::array<std::uint32_t, 2>> adopted_;
  Sums sums_;
};

}  // namespace tandem
