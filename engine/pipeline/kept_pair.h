// The data of bodies and pairs that are kept from one step to the next.
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

/// A pair's contacts; the first few are stored within the pair's own data, where they are read next.
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

/// The computed answer of a pair, in the frame of one of the two bodies, the reference, and the relative pose for which
/// it was computed.
struct KeptPair {
  Mat3 rotation;  ///< pose of the other body, the mover, in the reference's frame
  Vec3 translation;
  PairAnswer answer;
  KeptManifold contacts;  ///< empty (Request::contacts): the bodies are at least signed_distance apart
};

/// The state of a pair that was a candidate.
struct KeptEntry {
  static constexpr std::uint32_t none = 0xffffffffu;
  std::uint32_t seen = 0;       // step in which it was last reported as a candidate
  std::uint32_t as_of = 0;      // step whose poses the answer is for
  std::uint32_t detail = none;  // index of its KeptPair
  float bound = 0;              // metres: bound on the motion since the answer was computed
  std::uint32_t touching = 0, gaps = 0;
  bool candidate : 1 = false;  // in the last step
  bool reported : 1 = false;
  bool steady : 1 = false;   // remains valid while both rest
  bool resting : 1 = false;  // the answer, if any, is already marked as resting
  bool collide : 1 = false;
  bool inexact : 1 = false;
};

/// The largest values of one pair, or of all pairs.
struct KeptLargest {
  double depth = 0;
  double error_bound = 0;  // of a kept answer that is reported
};

/// The state of a body on which the answers of its pairs depend.
struct KeptRest {
  Pose anchor;  ///< the pose at which its rest began
  double reach = 0;
  std::uint32_t steps = 0;  ///< since its rest began
  bool has_shape = false;   ///< still that of the last step
};

/// A body that was added since the last step, perhaps at the index of a removed one.
struct KeptBody {
  std::uint32_t index = 0;
  std::optional<KeptRest> rest;  ///< its state in the pipeline from which it comes; none: it is new
};

/// All kept data of a candidate of the last step. In `entry`, as_of counts the steps since then.
struct KeptRecord {
  Pair pair;
  KeptEntry entry;
  KeptLargest largest;
  std::optional<KeptPair> detail;
  PairAnswer answer;  ///< if it is reported, with its contacts
  std::vector<Contact> contacts;
};

}  // namespace tandem
