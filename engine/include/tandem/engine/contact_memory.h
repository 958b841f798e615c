// Begin and end of contacts, and user data kept with pairs and contact points.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// Two bodies by their ids, a.index() < b.index(). Ids are unique even where slots of removed bodies are reused.
struct BodyPair {
  BodyId a, b;
  friend bool operator==(const BodyPair&, const BodyPair&) = default;
};

/// The pair's bodies by the scene that the list belongs to, in its state of that time.
inline BodyPair body_pair(const Scene& scene, const PairResult& pair) { return {scene.id(pair.a), scene.id(pair.b)}; }

/// Compares two lists of pairs sorted by indices: ended(i) for those only in the first, began(j) for those only in the
/// second, stayed(i, j) for those in both. A slot with another body is another pair.
template <class Ended, class Began, class Stayed>
void compare_pairs(std::span<const BodyPair> before, std::span<const BodyPair> now, Ended&& ended, Began&& began,
                   Stayed&& stayed) {
  const auto key = [](const BodyPair& p) { return std::pair(p.a.index(), p.b.index()); };
  std::size_t i = 0, j = 0;
  while (i < before.size() || j < now.size()) {
    if (j == now.size() || (i < before.size() && key(before[i]) < key(now[j]))) {
      ended(i++);
    } else if (i == before.size() || key(now[j]) < key(before[i])) {
      began(j++);
    } else {
      if (before[i] == now[j]) {
        stayed(i, j);
      } else {
        ended(i);
        began(j);
      }
      ++i, ++j;
    }
  }
}

/// The pairs that began to touch, still touch, and ceased to touch from one call to the next: a begin and an end for
/// each contact, even if a body was removed or changed meanwhile. Sorted by indices; the same for any number of
/// threads.
class ContactEvents {
 public:
  /// Call after a step, with its contacts, before the scene changes. Pairs within a margin do not count as touching.
  /// O(contacts). Not after a step that its deadline ended (StepIssue::incomplete): its unfinished pairs would be
  /// reported as ended.
  void update(const Scene& scene, const ContactList& contacts) {
    // Where this throws, the list is of another scene and the events are as before.
    before_.clear();
    for (const PairResult& pair : contacts.pairs)
      if (pair.answer.collide) before_.push_back(body_pair(scene, pair));
    std::swap(touching_, before_);
    began_.clear();
    stayed_.clear();
    ended_.clear();
    compare_pairs(
        before_, touching_, [&](std::size_t i) { ended_.push_back(before_[i]); },
        [&](std::size_t j) { began_.push_back(touching_[j]); },
        [&](std::size_t, std::size_t j) { stayed_.push_back(touching_[j]); });
  }
  /// Ends all contacts, as if a step had found none.
  void end_all() {
    ended_ = std::exchange(touching_, {});
    began_.clear();
    stayed_.clear();
  }

  std::span<const BodyPair> began() const { return began_; }
  std::span<const BodyPair> stayed() const { return stayed_; }
  std::span<const BodyPair> ended() const { return ended_; }
  std::span<const BodyPair> touching() const { return touching_; }  ///< pairs that began and those that stayed

 private:
  std::vector<BodyPair> touching_, before_, began_, stayed_, ended_;
};

/// A value for each pair of a step's list, including those within the margin, kept from step to step: a force, a
/// material, a count. Values of pairs that are no longer in the list are dropped.
template <class Value>
class PairMap {
 public:
  /// As ContactEvents::update; new pairs get Value{}. Note that Value{} of an Eigen vector is not initialised to zero;
  /// put it into a struct with `Vec3 v = Vec3::Zero()`. Calls `dropped(pair, value)`, in order, for dropped ones.
  /// O(contacts).
  template <class Dropped>
  void update(const Scene& scene, const ContactList& contacts, Dropped&& dropped) {
    pairs_before_.clear();
    for (const PairResult& pair : contacts.pairs) pairs_before_.push_back(body_pair(scene, pair));
    std::swap(pairs_, pairs_before_);
    std::swap(values_, values_before_);
    values_.clear();
    values_.resize(pairs_.size());
    compare_pairs(
        pairs_before_, pairs_,
        [&](std::size_t i) { dropped(std::as_const(pairs_before_[i]), std::move(values_before_[i])); },
        [](std::size_t) {}, [&](std::size_t i, std::size_t j) { values_[j] = std::move(values_before_[i]); });
  }
  void update(const Scene& scene, const ContactList& contacts) {
    update(scene, contacts, [](const BodyPair&, Value&&) {});
  }

  /// The value of contacts.pairs[i] of the last update.
  Value& operator[](std::size_t i) { return values_[i]; }
  const Value& operator[](std::size_t i) const { return values_[i]; }
  std::size_t size() const { return values_.size(); }
  std::span<const BodyPair> pairs() const { return pairs_; }
  /// Null for a pair that was not in the last update. O(log pairs).
  Value* find(const BodyPair& pair) {
    const auto place = std::lower_bound(pairs_.begin(), pairs_.end(), pair, [](const BodyPair& x, const BodyPair& y) {
      return std::pair(x.a.index(), x.b.index()) < std::pair(y.a.index(), y.b.index());
    });
    return place != pairs_.end() && *place == pair ? &values_[static_cast<std::size_t>(place - pairs_.begin())]
                                                   : nullptr;
  }

 private:
  std::vector<BodyPair> pairs_, pairs_before_;
  std::vector<Value> values_, values_before_;
};

/// A value for each contact point of a step's list, passed to the corresponding point of the next step: among the
/// points of the same pair at most `reach` away, in the frame of the first body, one with the same feature first, then
/// the nearest; each is used once. For a spring at each contact, for example.
template <class Value>
class ContactMap {
 public:
  /// `reach`: metres, > 0. Throws std::invalid_argument for others.
  explicit ContactMap(double reach) : reach_(reach) {
    if (!(reach > 0)) throw std::invalid_argument("ContactMap: reach is not > 0, allowed: metres, > 0");
  }

  /// As ContactEvents::update; points without a predecessor get Value{}, like new pairs of PairMap. O(contacts) times
  /// the points of a pair.
  void update(const Scene& scene, const ContactList& contacts) {
    pairs_before_.clear();
    for (const PairResult& pair : contacts.pairs) pairs_before_.push_back(body_pair(scene, pair));
    std::swap(pairs_, pairs_before_);
    std::swap(first_, first_before_);
    std::swap(points_, points_before_);
    std::swap(values_, values_before_);
    first_.clear();
    points_.clear();
    values_.clear();
    values_.resize(contacts.contacts.size());
    points_.resize(contacts.contacts.size());
    for (const PairResult& pair : contacts.pairs) {
      first_.push_back(pair.first_contact);
      const Pose& pose = scene.poses()[pair.a];
      for (std::size_t k = pair.first_contact; k < pair.first_contact + pair.contact_count; ++k) {
        const Contact& contact = contacts.contacts[k];
        points_[k] = {pose.rotation.transpose() * (contact.point - pose.translation), contact.feature, false};
      }
    }
    first_.push_back(static_cast<std::uint32_t>(points_.size()));
    compare_pairs(
        pairs_before_, pairs_, [](std::size_t) {}, [](std::size_t) {},
        [&](std::size_t i, std::size_t j) { carry(i, j); });
  }

  /// The value of contacts.contacts[i] of the last update.
  Value& operator[](std::size_t i) { return values_[i]; }
  const Value& operator[](std::size_t i) const { return values_[i]; }
  std::size_t size() const { return values_.size(); }

 private:
  struct Point {
    Vec3 place;  // in the first body's frame
    std::uint32_t feature = 0;
    bool taken = false;
  };

  void carry(std::size_t before, std::size_t now) {
    const auto points = std::span(points_).subspan(first_[now], first_[now + 1] - first_[now]);
    const auto old =
        std::span(points_before_).subspan(first_before_[before], first_before_[before + 1] - first_before_[before]);
    for (const bool same_feature : {true, false})
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (points[k].taken) continue;
        std::size_t best = old.size();
        double least = reach_;
        for (std::size_t i = 0; i < old.size(); ++i) {
          if (old[i].taken || (same_feature && old[i].feature != points[k].feature)) continue;
          if (const double d = (old[i].place - points[k].place).norm(); d <= least) {
            if (best != old.size() && d == least) continue;
            least = d, best = i;
          }
        }
        if (best == old.size()) continue;
        old[best].taken = points[k].taken = true;
        values_[first_[now] + k] = std::move(values_before_[first_before_[before] + best]);
      }
    for (Point& point : points) point.taken = false;
  }

  double reach_;
  std::vector<BodyPair> pairs_, pairs_before_;
  std::vector<std::uint32_t> first_{0}, first_before_{0};
  std::vector<Point> points_, points_before_;
  std::vector<Value> values_, values_before_;
};

}  // namespace tandem
