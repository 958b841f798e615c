#include "kept_contacts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace tandem {
namespace {

Vec3 into(const Pose& frame, const Vec3& world) { return frame.rotation.transpose() * (world - frame.translation); }

}  // namespace

void KeptContacts::clear() {
  pairs_.clear();
  slots_.clear();
  fresh_.clear();
  shift_ = 64;
}

void KeptContacts::begin_step(const Scene& scene) {
  if (!std::exchange(complete_, false)) clear();
  scene_ = &scene;
  ++step_;
  kept_.store(0, std::memory_order_relaxed);
  computed_.store(0, std::memory_order_relaxed);
  error_bound_.store(0, std::memory_order_relaxed);

  const auto indices = scene.shape_indices();
  const std::size_t known = std::min(shape_of_.size(), indices.size());
  shape_of_.resize(indices.size(), nullptr);
  changed_.resize(indices.size(), step_);
  const auto shapes = scene.shapes();
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const MassProperties* now = &shapes[indices[i]].mass();
    if (i < known && now == shape_of_[i]) continue;
    shape_of_[i] = now;
    changed_[i] = step_;
  }
  const auto same = [](const Shape& x, const Shape& y) { return &x.mass() == &y.mass(); };
  if (std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same)) return;
  shapes_.assign(shapes.begin(), shapes.end());
  balls_.clear();
  for (const Shape& shape : shapes_) {
    if (!shape.is_bounded()) {
      balls_.push_back({Vec3::Zero(), std::numeric_limits<double>::infinity(), 0});
      continue;
    }
    const Bounds box = shape.bounds({});
    balls_.push_back({(box.lo + box.hi) / 2, (box.hi - box.lo).norm() / 2, tolerance_ * shape.size()});
  }
}

void KeptContacts::end_step() {
  complete_ = true;
  for (KeptPair& pair : fresh_) insert(std::move(pair));
  fresh_.clear();
  // Pairs that are candidates no more: gone once they are as many as the others.
  const std::size_t live = kept_.load(std::memory_order_relaxed) + computed_.load(std::memory_order_relaxed);
  if (pairs_.size() <= 2 * live + 64) return;
  std::erase_if(pairs_, [&](const KeptPair& pair) { return pair.seen != step_; });
  pairs_.shrink_to_fit();
  rebuild(pairs_.size());
}

KeptContacts::Counts KeptContacts::counts() const {
  return {kept_.load(std::memory_order_relaxed), computed_.load(std::memory_order_relaxed),
          error_bound_.load(std::memory_order_relaxed)};
}

// ---- The table: open addressing, linear probing

std::size_t KeptContacts::slot_of(std::uint64_t key) const {
  return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> shift_);
}

KeptPair* KeptContacts::lookup(std::uint64_t key) {
  if (slots_.empty()) return nullptr;
  for (std::size_t i = slot_of(key);; i = (i + 1) & (slots_.size() - 1)) {
    if (slots_[i].index_plus_one == 0) return nullptr;
    if (slots_[i].key == key) return &pairs_[slots_[i].index_plus_one - 1];
  }
}

void KeptContacts::insert(KeptPair&& pair) {
  if (2 * (pairs_.size() + 1) > slots_.size()) rebuild(2 * pairs_.size() + 64);
  pairs_.push_back(std::move(pair));
  std::size_t i = slot_of(pairs_.back().key);
  while (slots_[i].index_plus_one != 0) i = (i + 1) & (slots_.size() - 1);
  slots_[i] = {pairs_.back().key, static_cast<std::uint32_t>(pairs_.size())};
}

void KeptContacts::rebuild(std::size_t room) {
  const std::size_t size = std::bit_ceil(2 * room + 2);
  slots_.assign(size, {});
  slots_.shrink_to_fit();
  shift_ = 64 - static_cast<std::uint32_t>(std::countr_zero(size));
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    std::size_t i = slot_of(pairs_[k].key);
    while (slots_[i].index_plus_one != 0) i = (i + 1) & (size - 1);
    slots_[i] = {pairs_[k].key, static_cast<std::uint32_t>(k + 1)};
  }
}

// ---- A batch

KeptContacts::Batch::~Batch() {
  all_.kept_.fetch_add(kept_, std::memory_order_relaxed);
  all_.computed_.fetch_add(computed_, std::memory_order_relaxed);
  double known = all_.error_bound_.load(std::memory_order_relaxed);
  while (known < error_bound_ &&
         !all_.error_bound_.compare_exchange_weak(known, error_bound_, std::memory_order_relaxed)) {
  }
  if (fresh_.empty()) return;
  const std::scoped_lock lock(all_.mutex_);
  std::move(fresh_.begin(), fresh_.end(), std::back_inserter(all_.fresh_));
}

KeptContacts::Batch::Relative KeptContacts::Batch::relative(Pair pair) const {
  const auto shape = all_.scene_->shape_indices();
  const auto poses = all_.scene_->poses();
  // The smaller body moves less at its rim.
  const bool a_is_reference = all_.balls_[shape[pair.a]].radius >= all_.balls_[shape[pair.b]].radius;
  const Pose& reference = poses[a_is_reference ? pair.a : pair.b];
  const Pose& mover = poses[a_is_reference ? pair.b : pair.a];
  return {reference.rotation.transpose() * mover.rotation, into(reference, mover.translation), a_is_reference};
}

void KeptContacts::Batch::look_ahead(std::span<const Pair> rest) const {
  constexpr std::size_t slot_ahead = 12, pair_ahead = 6;
  if (all_.slots_.empty()) return;
  if (rest.size() > slot_ahead) __builtin_prefetch(&all_.slots_[all_.slot_of(key_of(rest[slot_ahead]))]);
  if (rest.size() <= pair_ahead) return;
  const char* pair = reinterpret_cast<const char*>(all_.lookup(key_of(rest[pair_ahead])));
  if (pair == nullptr) return;
  for (std::size_t line = 0; line < sizeof(KeptPair); line += 64) __builtin_prefetch(pair + line, 1);
}

bool KeptContacts::Batch::find(Pair pair, PairResult& result, std::vector<Contact>& contacts) {
  at_ = relative(pair);
  last_ = all_.lookup(key_of(pair));
  if (last_ == nullptr) return false;
  KeptPair& kept = *last_;
  if (std::exchange(kept.seen, all_.step_) + 1 != all_.step_ || all_.changed_[pair.a] == all_.step_ ||
      all_.changed_[pair.b] == all_.step_)
    return false;
  const Ball& ball = all_.balls_[all_.scene_->shape_indices()[at_.a_is_reference ? pair.b : pair.a]];
  const Mat3 turned = at_.rotation - kept.rotation;
  const Vec3 moved = turned * ball.centre + (at_.translation - kept.translation);
  // The spectral norm of the difference of two rotations, 2 sin(angle / 2).
  const double angle = turned.norm() / std::sqrt(2.0);
  // Rounding, and rotations that are orthonormal to 1e-6 only.
  const double bound =
      (moved.norm() + angle * ball.radius) * (1 + 4e-6) + 4e-15 * (at_.translation.lpNorm<1>() + ball.radius);
  const double distance = std::abs(kept.signed_distance) - kept.error_bound;
  if (kept.contacts.empty() && !all_.distances_) {
    if (kept.collide || !(distance - bound > all_.margin_)) return false;
    ++kept_;
    return true;
  }
  // The shift along the normal is taken into account: what is left is of second order, but not known to be less than
  // both together.
  if (!(2 * bound <= ball.allowed && angle <= all_.tolerance_ && bound < distance)) return false;
  ++kept_;
  error_bound_ = std::max(error_bound_, 2 * bound);
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? pair.a : pair.b];
  // The mover's point that was at `point`, in the reference's frame, has moved by `turn * point + shift`.
  const Mat3 turn = turned * kept.rotation.transpose();
  const Vec3 shift = at_.translation - kept.translation - turn * kept.translation;
  const double sense = at_.a_is_reference ? 1 : -1;  // normals are from A to B
  const auto opened = [&](const Vec3& normal, const Vec3& point) { return sense * normal.dot(turn * point + shift); };
  PairAnswer& answer = result.answer;
  answer.collide = kept.collide;
  answer.signed_distance = kept.signed_distance + opened(kept.normal, at_.a_is_reference ? kept.point_b : kept.point_a);
  answer.status = kept.status;
  answer.error_bound = kept.error_bound + 2 * bound;
  answer.point_a = frame * kept.point_a;
  answer.point_b = frame * kept.point_b;
  answer.normal = frame.rotation * kept.normal;
  kept.contacts.each([&](const Contact& contact) {
    const double depth = std::max(contact.depth - opened(contact.normal, contact.point), -all_.margin_);
    contacts.push_back({frame * contact.point, frame.rotation * contact.normal, depth, contact.feature});
  });
  return true;
}

void KeptContacts::Batch::keep(const PairResult& result, std::span<const Contact> contacts) {
  ++computed_;
  KeptPair& kept = last_ != nullptr ? *last_ : fresh_.emplace_back();
  kept.key = key_of({result.a, result.b});
  kept.seen = all_.step_;
  kept.rotation = at_.rotation;
  kept.translation = at_.translation;
  const PairAnswer& answer = result.answer;
  kept.signed_distance = answer.signed_distance;
  kept.error_bound = answer.error_bound;
  kept.collide = answer.collide;
  kept.status = answer.status;
  kept.contacts.clear();
  if (contacts.empty() && !all_.distances_) return;
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? result.a : result.b];
  const auto turned = [&](const Vec3& world) -> Vec3 { return frame.rotation.transpose() * world; };
  kept.point_a = into(frame, answer.point_a);
  kept.point_b = into(frame, answer.point_b);
  kept.normal = turned(answer.normal);
  for (const Contact& contact : contacts)
    kept.contacts.add({into(frame, contact.point), turned(contact.normal), contact.depth, contact.feature});
}

}  // namespace tandem
