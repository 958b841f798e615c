// The canonical order of two shapes in a query.
#include "shapes/pair_order.h"

#include <algorithm>
#include <utility>

namespace tandem {

bool reversed(double parameters, const Pose& pose_a, const Pose& pose_b) {
  if (parameters != 0) return parameters > 0;
  // Along this direction, bodies side by side or stacked are far from a tie.
  const Vec3 d = pose_b.translation - pose_a.translation;
  const double along = reversal[0] * d[0] + reversal[1] * d[1] + reversal[2] * d[2];
  if (along != 0) return along < 0;
  for (int i = 0; i < 3; ++i)
    if (d[i] != 0) return d[i] < 0;
  for (int i = 0; i < 9; ++i) {
    const double turn = pose_b.rotation.data()[i] - pose_a.rotation.data()[i];
    if (turn != 0) return turn < 0;
  }
  return false;
}

bool boxes_reversed(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b) {
  double difference = 0;
  for (std::size_t k = 0; k < 3 && difference == 0; ++k) difference = half_a[k] - half_b[k];
  return reversed(difference, pose_a, pose_b);
}

bool comes_after(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b) {
  if (a.size != b.size) return a.size > b.size;
  if (a.param != b.param) return a.param > b.param;
  if (a.vertices.size() != b.vertices.size()) return a.vertices.size() > b.vertices.size();
  const auto compare = [](const double* p, const double* q, std::size_t n) {
    const auto [i, j] = std::mismatch(p, p + n, q);
    return i == p + n ? 0 : *i > *j ? 1 : -1;
  };
  int order = 0;
  if (a.vertices.data() != b.vertices.data())
    order = compare(a.vertices[0].data(), b.vertices[0].data(), 3 * a.vertices.size());
  if (order == 0) order = compare(pose_a.translation.data(), pose_b.translation.data(), 3);
  if (order == 0) order = compare(pose_a.rotation.data(), pose_b.rotation.data(), 9);
  return order > 0;
}

void swap_answer(PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first) {
  std::swap(answer.point_a, answer.point_b);
  answer.normal = -answer.normal;
  if (contacts == nullptr) return;
  for (std::size_t i = first; i < contacts->size(); ++i) (*contacts)[i].normal = -(*contacts)[i].normal;
}

}  // namespace tandem
