// Reduction of a failing pair to a minimal one.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include "relations.h"

namespace tandem::relations {
namespace {

constexpr int most_checks = 2000;  // upper limit on the checks for one pair

/// Removes list[first, first + count), for decreasing counts, wherever `keep` accepts the rest.
template <class T, class Keep>
void thin_out(std::vector<T>& list, const Keep& keep) {
  for (std::size_t count = list.size() / 2; count > 0; count /= 2)
    for (std::size_t first = 0; first + count <= list.size() && list.size() > count;) {
      std::vector<T> kept = list;
      list.erase(list.begin() + static_cast<std::ptrdiff_t>(first),
                 list.begin() + static_cast<std::ptrdiff_t>(first + count));
      if (keep()) continue;
      list = kept;
      first += count;
    }
}

/// Moves one vertex to another: triangles at both vanish, and a closed surface stays closed.
void merge_vertices(Mesh& m, std::uint32_t from, std::uint32_t to) {
  for (auto& t : m.triangles) std::replace(t.begin(), t.end(), from, to);
  std::erase_if(m.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

/// Merges the ends of edges wherever `attempt` accepts the rest: single triangles cannot be removed from a solid.
template <class Attempt>
void merge_edges(Mesh& m, const Attempt& attempt) {
  for (std::size_t i = 0; i < m.triangles.size();) {
    const std::array<std::uint32_t, 3> corners = m.triangles[i];
    const std::size_t before = m.triangles.size();
    for (std::size_t k = 0; k < 3 && m.triangles.size() == before; ++k)
      attempt([&] { merge_vertices(m, corners[k], corners[(k + 1) % 3]); });
    if (m.triangles.size() == before) ++i;
  }
}

void drop_unused_vertices(Mesh& m) {
  std::vector<Vec3> used;
  std::vector<std::uint32_t> place(m.vertices.size(), ~0u);
  for (auto& t : m.triangles)
    for (auto& v : t) {
      if (place[v] == ~0u) place[v] = static_cast<std::uint32_t>(used.size()), used.push_back(m.vertices[v]);
      v = place[v];
    }
  m.vertices = used;
}

double with_digits(double x, int digits) {
  if (x == 0 || !std::isfinite(x)) return x;
  const double power = std::pow(10.0, digits - 1 - std::floor(std::log10(std::abs(x))));
  return std::isfinite(power) && power > 0 ? std::round(x * power) / power : x;
}

}  // namespace

PosedPair minimal(const Relation& relation, PosedPair pair) {
  int left = most_checks;
  const auto fails = [&] {
    if (left-- <= 0) return false;
    try {
      return !check(relation, pair).empty();
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  const auto attempt = [&](const std::function<void()>& change) {
    const PosedPair before = pair;
    change();
    if (!fails()) pair = before;
  };
  attempt([&] {
    pair.b.pose.translation -= pair.a.pose.translation;
    pair.a.pose.translation = Vec3::Zero();
  });
  attempt([&] { pair.b.pose.rotation = Mat3::Identity(); });
  attempt([&] { pair.a.pose.rotation = Mat3::Identity(); });
  for (PosedShape* s : {&pair.a, &pair.b}) {
    if (s->rounding > 0) attempt([&] { s->rounding = 0; });
    if (Mesh* m = std::get_if<Mesh>(&s->shape)) {
      if (m->solid) attempt([&] { m->solid = false; });
      if (m->solid)
        merge_edges(*m, attempt);
      else
        thin_out(m->triangles, fails);
      attempt([&] { drop_unused_vertices(*m); });
    }
    if (Convex* hull = std::get_if<Convex>(&s->shape)) thin_out(hull->vertices, fails);
  }
  for (const int digits : {1, 2, 3, 5, 8}) {
    const auto round = [&](Vec3& v) {
      if (v.unaryExpr([&](double x) { return with_digits(x, digits); }) != v)
        attempt([&] { v = Vec3(v.unaryExpr([&](double x) { return with_digits(x, digits); })); });
    };
    for (PosedShape* s : {&pair.a, &pair.b}) {
      round(s->pose.translation);
      if (with_digits(s->rounding, digits) != s->rounding)
        attempt([&] { s->rounding = with_digits(s->rounding, digits); });
      if (Mesh* m = std::get_if<Mesh>(&s->shape)) {
        if (m->vertices.size() <= 64)
          for (Vec3& v : m->vertices) round(v);
      } else if (Convex* hull = std::get_if<Convex>(&s->shape)) {
        for (Vec3& v : hull->vertices) round(v);
      } else if (Triangle* t = std::get_if<Triangle>(&s->shape)) {
        for (Vec3& v : t->vertices) round(v);
      } else if (Box* b = std::get_if<Box>(&s->shape)) {
        round(b->size);
      }
    }
  }
  return pair;
}

}  // namespace tandem::relations
