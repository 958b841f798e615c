// The boxes of FCL's objects, and the search for candidate pairs among them.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace tandem::fcl {

/// A box in FCL's float or double, without loss. FCL's tests are applied to whatever numbers it contains: NaN overlaps
/// everything, and a box with lo > hi overlaps what both its bounds permit.
struct ExactBox {
  std::array<double, 3> lo;
  std::array<double, 3> hi;
};

/// Receives pairs of objects one after the other.
class ObjectPairVisitor {
 public:
  virtual ~ObjectPairVisitor() = default;
  /// Takes two objects; false ends the visit.
  virtual bool visit(void* a, void* b) = 0;
};
class NearPairVisitor {
 public:
  virtual ~NearPairVisitor() = default;
  /// Takes two objects; lowers `limit`, the distance from which on pairs are not wanted; false ends the visit.
  virtual bool visit(void* a, void* b, double& limit) = 0;
};

/// Receives registered objects with their boxes.
class BoxedObjectVisitor {
 public:
  virtual ~BoxedObjectVisitor() = default;
  /// Takes an object; for distances lowers `limit`, the distance from which on objects are not wanted; false ends the
  /// visit.
  virtual bool visit(void* object, const ExactBox& box, double& limit) = 0;
};

/// The registered objects of a collision manager: a pointer and a box each, in the order of registration, with freed
/// places reused. The data made from the boxes, all pairs and a hierarchy, are updated by the first query that needs
/// them, under a lock: const members may run from any number of threads at once.
class ObjectBoxes {
 public:
  ObjectBoxes();
  ~ObjectBoxes();
  ObjectBoxes(ObjectBoxes&&) noexcept;
  ObjectBoxes& operator=(ObjectBoxes&&) noexcept;

  /// The number of registrations: an object registered twice counts twice.
  std::size_t size() const;
  void reserve(std::size_t more);
  void add(void* object, const ExactBox& box);
  /// Removes the last registration of an object; does nothing if it has none.
  void remove(const void* object);
  void clear();

  /// A place for each registration, null if it was removed.
  std::span<void* const> objects() const;
  /// All registrations, to be given their objects' present boxes: set `changed` where a box differs from before, then
  /// call take_changes.
  struct Places {
    std::span<void* const> objects;  // null if removed
    std::span<ExactBox> boxes;
    std::span<std::uint8_t> changed;
  };
  Places places();
  void take_changes();
  /// Sets the present box of an object, for all its registrations; does nothing if it has none.
  void set(const void* object, const ExactBox& box);

  /// Pairs whose boxes overlap: of a registered object and `asked`, of two registered ones, of one of these and one of
  /// `other`, in this order.
  void visit_overlapping(void* asked, const ExactBox& box, ObjectPairVisitor& visitor) const;
  void visit_overlapping(ObjectPairVisitor& visitor) const;
  void visit_overlapping(const ObjectBoxes& other, ObjectPairVisitor& visitor) const;
  /// Pairs whose boxes are nearer than `limit`, likewise; an object's partners roughly by distance.
  void visit_near(void* asked, const ExactBox& box, double limit, NearPairVisitor& visitor) const;
  void visit_near(double limit, NearPairVisitor& visitor) const;
  void visit_near(const ObjectBoxes& other, double limit, NearPairVisitor& visitor) const;
  /// Objects whose boxes overlap `box`, or are nearer to it than `limit`.
  void visit_overlapping(const ExactBox& box, BoxedObjectVisitor& visitor) const;
  void visit_near(const ExactBox& box, double limit, BoxedObjectVisitor& visitor) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::fcl
