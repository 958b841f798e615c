// What is kept of pairs and bodies from one step to the next.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
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
  std::size_t size() const { return count_; }
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
  Mat3 rotation;  ///< of the other, the mover, in the reference's frame
  Vec3 translation;
  double signed_distance = 0;
  double error_bound = 0;
  Vec3 point_a, point_b, normal;
  bool collide = false;
  Status status = Status::ok;
  KeptManifold contacts;  ///< none (Request::contacts): the bodies are at least signed_distance apart
};

/// What is known of a pair that was a candidate.
struct KeptEntry {
  static constexpr std::uint32_t none = 0xffffffffu;
  std::uint32_t seen = 0;       // step in which it was last asked for
  std::uint32_t as_of = 0;      // step for whose poses the answer is
  std::uint32_t detail = none;  // its KeptPair's place
  float bound = 0;              // metres, up to which the answer was moved along
  std::uint32_t touching = 0, gaps = 0;
  bool candidate : 1 = false;  // in the last step
  bool reported : 1 = false;
  bool steady : 1 = false;  // stands while both rest
  bool told : 1 = false;    // that they rested, in the answer if there is one
  bool collide : 1 = false;
  bool inexact : 1 = false;
};

/// Of a pair; of all in the whole.
struct KeptLargest {
  double depth = 0;
  double error_bound = 0;  // of a kept answer that is reported
};

/// What of a body's past decides the answers of its pairs.
struct KeptRest {
  Pose anchor;  ///< where its rest began
  double reach = 0;
  std::uint32_t steps = 0;  ///< since its rest began
  bool has_shape = false;   ///< still that of the last step
};

/// A body that has come since the last step, in another one's place perhaps.
struct KeptBody {
  std::uint32_t index = 0;
  std::optional<KeptRest> rest;  ///< where it comes from; none: it is new
};

/// All that is kept of a candidate of the last step. In `entry` as_of counts the steps that have passed since.
struct KeptRecord {
  Pair pair;
  KeptEntry entry;
  KeptLargest largest;
  std::optional<KeptPair> detail;
  PairAnswer answer;  ///< where it is reported, with its contacts
  std::vector<Contact> contacts;
};

}  // namespace tandem
