// Shared by the tests of ranks: answers of one rank, and scenes on several.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <map>
#include <random>

#include "catch.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/mpi/pipeline.h"

/// Common parts of the tests of ranks: answers on one rank, and scenes on several.
namespace world {

using tandem::mpi::GatheredContacts;
using tandem::mpi::GlobalId;

inline int rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}
inline int ranks() {
  int ranks = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

/// The contacts of one machine, where `ids` gives bodies' ids by their indices, ascending.
inline GatheredContacts gathered(const tandem::ContactList& list, const std::vector<GlobalId>& ids) {
  GatheredContacts out;
  for (const tandem::PairResult& pair : list.pairs)
    out.pairs.push_back({ids[pair.a], ids[pair.b], pair.first_contact, pair.contact_count, pair.answer});
  out.contacts = list.contacts;
  return out;
}

inline bool same_bits(const GatheredContacts& x, const GatheredContacts& y) {
  if (x.pairs.size() != y.pairs.size() || x.contacts.size() != y.contacts.size()) return false;
  for (std::size_t i = 0; i < x.pairs.size(); ++i) {
    const auto &p = x.pairs[i], &q = y.pairs[i];
    if (p.a != q.a || p.b != q.b || p.contact_count != q.contact_count || p.first_contact != q.first_contact)
      return false;
    const auto &r = p.answer, &s = q.answer;
    if (r.collide != s.collide || r.signed_distance != s.signed_distance || r.normal != s.normal ||
        r.point_a != s.point_a || r.point_b != s.point_b || r.status != s.status || r.error_bound != s.error_bound)
      return false;
  }
  for (std::size_t i = 0; i < x.contacts.size(); ++i) {
    const auto &c = x.contacts[i], &d = y.contacts[i];
    if (c.point != d.point || c.normal != d.normal || c.depth != d.depth || c.feature != d.feature) return false;
  }
  return true;
}

inline tandem::BodyOptions options_of(const tandem::Scene& scene, std::uint32_t i) {
  tandem::BodyOptions body;
  body.shape = scene.shape_id(scene.id(i));
  body.pose = scene.poses()[i];
  body.velocity = scene.velocities()[i];
  body.angular_velocity = scene.angular_velocities()[i];
  body.density = scene.densities()[i];
  body.is_static = scene.is_static()[i] != 0;
  body.is_sensor = scene.is_sensor()[i] != 0;
  body.continuous = scene.continuous()[i] != 0;
  body.group = scene.groups()[i];
  body.mask = scene.masks()[i];
  return body;
}

/// Every rank adds a share, in turn; ids are indices.
inline void add_all(tandem::mpi::Pipeline& pipeline, const tandem::Scene& scene) {
  for (std::uint32_t k = 0; k < scene.shapes().size(); ++k)
    pipeline.add_shape(scene.shapes()[k], std::string(scene.shape_name(k)));
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (static_cast<int>(i) % ranks() == rank()) pipeline.add_body(i, options_of(scene, i));
}

inline std::vector<GlobalId> all_indices(const tandem::Scene& scene) {
  std::vector<GlobalId> ids(scene.indices());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = i;
  return ids;
}

/// Options of the tests: a rank that waits for ever ends the job.
inline tandem::mpi::Options options(int threads, double margin) {
  tandem::mpi::Options out;
  out.rank.threads = threads;
  out.rank.executor = threads == 1 ? tandem::ExecutorKind::sequential : tandem::ExecutorKind::flowgraph;
  out.rank.sharing.short_step_ms = 0;
  out.rank.answer.margin = margin;
  out.rank.answer.contact_hash = true;
  out.patience = 60;
  return out;
}

}  // namespace world
