#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/broadphase/pair.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// A pair's contacts; the first few lie with the pair's own data, where they are read next.
class KeptManifold {
 public:
  void clear() {
    count_ = 0;
    more_.clear();
  }
  void add(const Contact& contact) {
    if (count_ < few)
      first_[count_] = contact;
    else
      more_.push_back(contact);
    ++count_;
  }
  bool empty() const { return count_ == 0; }
  template <class Visit>
  void each(Visit&& visit) const {
    for (std::size_t i = 0; i < std::min(count_, few); ++i) visit(first_[i]);
    for (const Contact& contact : more_) visit(contact);
  }

 private:
  static constexpr std::size_t few = 4;
  std::size_t count_ = 0;
  std::array<Contact, few> first_;
  std::vector<Contact> more_;
};

/// What was computed for a pair, and for which poses: in the frame of one of the two, the reference.
struct KeptPair {
  std::uint64_t key = 0;   ///< a in the high half, b in the low one
  std::uint64_t seen = 0;  ///< step in which the pair was last a candidate
  Mat3 rotation;           ///< of the other, the mover, in the reference's frame
  Vec3 translation;
  double signed_distance = 0;
  double error_bound = 0;
  Vec3 point_a, point_b, normal;
  bool collide = false;
  Status status = Status::ok;
  KeptManifold contacts;  ///< none (Request::contacts): the bodies are at least signed_distance apart
};

/// Answers of the last step that may stand for this one's. A kept answer is the one that was computed for poses of
/// which no point of one body has moved by more than a bound, seen from the other: it is moved with the reference, and
/// says the bound. Which body is the reference, and whether an answer is kept, depends on the poses alone.
///
/// For convex bodies the signed distance changes by no more than any point moves (the largest separation over all
/// directions does, and each of them does), so the bound holds for distance and depth, and an answer is kept only
/// where it leaves the verdict beyond doubt. A mesh's contacts are those of the poses that they were computed for.
///
/// In a step any number of threads ask for different pairs at once; nothing is locked but where a batch brings pairs
/// that were no candidates in the step before.
class KeptContacts {
 public:
  /// `request` contacts or distance; `tolerance` relative to the smaller body's size, > 0; gaps up to `margin` (metres)
  /// are contacts.
  KeptContacts(Request request, double tolerance, double margin)
      : distances_(request == Request::distance), tolerance_(tolerance), margin_(margin) {}

  void begin_step(const Scene& scene);
  /// After a step that was not cut short; without it the next one keeps nothing.
  void end_step();

  struct Counts {
    std::uint64_t kept_pairs = 0;  ///< with contacts or without
    std::uint64_t computed_pairs = 0;
    double error_bound = 0;  ///< metres, the largest of a kept answer
  };
  /// Of the last step.
  Counts counts() const;
  std::size_t entries() const { return pairs_.size(); }

  /// One batch's end, on one thread.
  class Batch {
   public:
    explicit Batch(KeptContacts& all) : all_(all) {}
    Batch(const Batch&) = delete;
    Batch& operator=(const Batch&) = delete;
    /// Hands over what is new.
    ~Batch();

    /// Fetches what `find` will read for the pairs that follow; `rest` begins with the one at hand.
    void look_ahead(std::span<const Pair> rest) const;
    /// True if the pair's answer is kept: then `result.answer` is set and the contacts are appended.
    bool find(Pair pair, PairResult& result, std::vector<Contact>& contacts);
    /// Notes the answer to the pair that was not found just before.
    void keep(const PairResult& result, std::span<const Contact> contacts);

   private:
    struct Relative {
      Mat3 rotation;
      Vec3 translation;
      bool a_is_reference;
    };
    Relative relative(Pair pair) const;

    KeptContacts& all_;
    KeptPair* last_ = nullptr;  // of the pair asked for, where it has an entry
    Relative at_;
    std::vector<KeptPair> fresh_;
    std::uint64_t kept_ = 0, computed_ = 0;
    double error_bound_ = 0;
  };

 private:
  /// A ball that holds a shape, in its frame.
  struct Ball {
    Vec3 centre = Vec3::Zero();
    double radius = 0;   // infinite for a half-space
    double allowed = 0;  // metres: the tolerance times the size
  };
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t index_plus_one = 0;
  };

  static std::uint64_t key_of(Pair pair) { return std::uint64_t{pair.a} << 32 | pair.b; }
  std::size_t slot_of(std::uint64_t key) const;
  KeptPair* lookup(std::uint64_t key);  ///< null: none
  void insert(KeptPair&& pair);
  void rebuild(std::size_t room);
  void clear();

  bool distances_;
  double tolerance_, margin_;
  const Scene* scene_ = nullptr;
  std::uint64_t step_ = 1;
  bool complete_ = true;

  std::vector<Shape> shapes_;  // of the last step's scene: as long as they are held, no other shape has their address
  std::vector<Ball> balls_;    // one a shape
  std::vector<const MassProperties*> shape_of_;  // one a body: names its shape
  std::vector<std::uint64_t> changed_;           // one a body: step in which it got another shape

  std::vector<KeptPair> pairs_;
  std::vector<Slot> slots_;  // a power of two, at most half full
  std::uint32_t shift_ = 64;

  std::mutex mutex_;
  std::vector<KeptPair> fresh_;
  std::atomic<std::uint64_t> kept_{0}, computed_{0};
  std::atomic<double> error_bound_{0};
};

}  // namespace tandem
