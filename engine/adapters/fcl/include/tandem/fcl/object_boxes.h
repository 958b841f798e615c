#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace tandem::fcl {

/// A box as FCL has it, float or double, without loss. FCL's tests are done on whatever numbers are in it: NaN overlaps
/// everything, and a box with lo > hi overlaps what both its bounds allow.
struct ExactBox {
  std::array<double, 3> lo;
  std::array<double, 3> hi;
};

/// Is given pairs of objects one after the other.
class ObjectPairVisitor {
 public:
  virtual ~ObjectPairVisitor() = default;
  /// Takes two objects; false ends the visit.
  virtual bool visit(void* a, void* b) = 0;
};
class NearPairVisitor {
 public:
  virtual ~NearPairVisitor() = default;
  /// Takes two objects; lowers `limit`, the distance from which on none is wanted; false ends the visit.
  virtual bool visit(void* a, void* b, double& limit) = 0;
};

/// Is given registered objects with the boxes that they have here.
class BoxedObjectVisitor {
 public:
  virtual ~BoxedObjectVisitor() = default;
  /// Takes an object; lowers `limit`, the distance from which on none is wanted, where distances are asked for; false
  /// ends the visit.
  virtual bool visit(void* object, const ExactBox& box, double& limit) = 0;
};

/// What collision_manager.h keeps of the objects registered: a pointer and a box each, in the order of registration but
/// for places that were given back. What tandem makes of the boxes, all pairs and a hierarchy, is brought up to date by
/// the first query that needs it, under a lock: const members may run from any number of threads at once.
class ObjectBoxes {
 public:
  ObjectBoxes();
  ~ObjectBoxes();
  ObjectBoxes(ObjectBoxes&&) noexcept;
  ObjectBoxes& operator=(ObjectBoxes&&) noexcept;

  /// Registrations: an object registered twice counts twice.
  std::size_t size() const;
  void reserve(std::size_t more);
  void add(void* object, const ExactBox& box);
  /// Takes back the last registration of an object; nothing happens to one that has none.
  void remove(const void* object);
  void clear();

  /// A place each registration, null where one was taken back.
  std::span<void* const> objects() const;
  /// All registrations, to be given the boxes that their objects have now: `changed` is to be set where a box is
  /// another than before, then take_changes to be called.
  struct Places {
    std::span<void* const> objects;  // null where one was taken back
    std::span<ExactBox> boxes;
    std::span<std::uint8_t> changed;
  };
  Places places();
  void take_changes();
  /// The box that an object has now, for all registrations of an object; nothing happens to one that has none.
  void set(const void* object, const ExactBox& box);

  /// Pairs whose boxes overlap: of a registered object and `asked`, of two registered ones, of one of these and one of
  /// `other`, in this order.
  void visit_overlapping(void* asked, const ExactBox& box, ObjectPairVisitor& visitor) const;
  void visit_overlapping(ObjectPairVisitor& visitor) const;
  void visit_overlapping(const ObjectBoxes& other, ObjectPairVisitor& visitor) const;
  /// Pairs whose boxes are nearer than `limit`, likewise; of an object's partners, nearer ones about first.
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
