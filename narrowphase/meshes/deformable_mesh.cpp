// Meshes whose vertices move: buffers, refits, seams.
#include "tandem/narrowphase/deformable_mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "meshes/feature_pairs.h"
#include "meshes/traversal/self_intersections.h"
#include "shapes/mesh_builder.h"
#include "shapes/mesh_refit.h"
#include "shapes/run_parts.h"
#include "shapes/shape_insides.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

[[noreturn]] void refuse_vertices(const std::string& why) { throw std::invalid_argument("deformable mesh: " + why); }

// In this form NaN fails.
bool is_place(const Vec3& v) {
  const auto fits = [](double x) { return std::abs(x) <= tolerance::longest_length; };
  return fits(v.x()) && fits(v.y()) && fits(v.z());
}

[[noreturn]] void refuse_place(std::size_t v, const Vec3& place) {
  refuse_vertices("vertices[" + std::to_string(v) + "] is " + written(place) + "; it must be " + allowed_coordinate());
}

std::shared_ptr<MeshModel> model_of(Mesh mesh, const PartRunner& parts, std::vector<std::uint32_t>& first) {
  // Refuses what Shape refuses, too.
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!is_place(mesh.vertices[v])) refuse_place(v, mesh.vertices[v]);
  auto model = std::make_shared<MeshModel>(build_mesh(std::move(mesh), {.parts = parts}, &first));
  model->bends = true;
  return model;
}

}  // namespace

struct DeformableMesh::Impl {
  /// The vertices and hierarchy of one update. Written only while nobody else holds it.
  struct Buffer {
    std::shared_ptr<MeshModel> model;
    std::uint64_t structure = 0;  ///< version of the structure of its hierarchy
  };

  Impl(Mesh mesh, const PartRunner& parts)
      : current{model_of(std::move(mesh), parts, first), 0}, refit(*current.model) {
    used = vertices_in_use(*current.model);
    for (std::uint32_t v = 0; v < first.size(); ++v)
      if (first[v] != v) seams.push_back(v);
    shape.emplace(detail::ShapeInsides::shape(current.model));
  }

  Extent checked_extent(std::span<const Vec3> vertices, const PartRunner& parts) const;
  void require_seams(std::span<const Vec3> vertices, const MeshFrame& frame) const;
  Buffer take_free_buffer();
  void go_back(const Buffer& before, const MeshFrame& frame, const PartRunner& parts);

  std::vector<std::uint32_t> first;  ///< the representative of each vertex
  std::vector<std::uint32_t> seams;  ///< vertices represented by another one
  std::vector<std::uint8_t> used;
  Buffer current;
  std::vector<Buffer> others;  ///< of earlier updates
  std::uint64_t structure = 0;
  MeshRefit refit;
  std::optional<Shape> shape;
};

Extent DeformableMesh::Impl::checked_extent(std::span<const Vec3> vertices, const PartRunner& parts) const {
  const std::size_t count = chunks(vertices.size(), elements_per_chunk);
  std::vector<Extent> extents(count);
  std::vector<std::uint8_t> faulty(count, 0);
  run_chunks(parts, vertices.size(), elements_per_chunk, [&](std::size_t k, std::size_t begin, std::size_t end) {
    Extent own;  // a copy, kept in registers
    bool fault = false;
    for (std::size_t v = begin; v < end; ++v) {
      fault |= !is_place(vertices[v]);
      if (used[v] != 0) own.add(vertices[v]);
    }
    extents[k] = own, faulty[k] = fault ? 1 : 0;
  });
  if (const auto part = std::find(faulty.begin(), faulty.end(), 1); part != faulty.end())
    for (auto v = static_cast<std::size_t>(part - faulty.begin()) * elements_per_chunk;; ++v)
      if (!is_place(vertices[v])) refuse_place(v, vertices[v]);
  Extent all;
  for (const Extent& extent : extents) all.add(extent);
  return all;
}

// Requires that vertices that coincided still do, or nearly so.
void DeformableMesh::Impl::require_seams(std::span<const Vec3> vertices, const MeshFrame& frame) const {
  // Vertices that coincide through a third one may be twice as far apart.
  const double apart = current.model->solid ? 0 : 2 * seam_tolerance(frame);
  for (const std::uint32_t v : seams)
    if ((vertices[v] - vertices[first[v]]).lpNorm<Eigen::Infinity>() > apart)
      refuse_vertices("vertices[" + std::to_string(v) + "] is " + written(vertices[v]) + " and vertices[" +
                      std::to_string(first[v]) + "] is " + written(vertices[first[v]]) +
                      "; they were one when the mesh was built and must stay so");
}

// The current buffer if no Shape holds it; else an earlier one; else a copy. All but the vertices and boxes is then as
// in the previous one, which is returned if it is another one.
DeformableMesh::Impl::Buffer DeformableMesh::Impl::take_free_buffer() {
  const auto is_free = [](const Buffer& buffer) {
    if (buffer.model.use_count() > 1) return false;
    std::atomic_thread_fence(std::memory_order_acquire);  // the thread that released it has finished reading
    return true;
  };
  if (current.model.use_count() <= 2) shape.reset();  // held by the shape here and the buffer itself
  if (is_free(current)) return {};
  Buffer before = current, next;
  const auto free = std::find_if(others.begin(), others.end(), is_free);
  if (free != others.end()) {
    next = std::move(*free);
    others.erase(free);
  }
  if (next.model == nullptr || next.structure != current.structure) {
    next.model = std::make_shared<MeshModel>(*current.model);
    next.structure = current.structure;
  }
  others.push_back(std::move(current));
  current = std::move(next);
  // One unused buffer is enough.
  std::size_t spare = 0;
  std::erase_if(others, [&](const Buffer& buffer) { return is_free(buffer) && spare++ > 0; });
  return before;
}

// After a refit for vertices that are refused: restores the previous buffer, which was not changed, or the boxes of the
// vertices that are still there.
void DeformableMesh::Impl::go_back(const Buffer& before, const MeshFrame& frame, const PartRunner& parts) {
  if (before.model != nullptr) {
    std::swap(current, *std::find_if(others.begin(), others.end(),
                                     [&](const Buffer& buffer) { return buffer.model == before.model; }));
  } else {
    current.model->frame() = frame;
    refit.refit(*current.model, current.model->vertices, parts);
  }
  if (!shape) shape.emplace(detail::ShapeInsides::shape(current.model));
}

DeformableMesh::DeformableMesh(Mesh mesh, const PartRunner& parts)
    : impl_(std::make_unique<Impl>(std::move(mesh), parts)) {}
DeformableMesh::~DeformableMesh() = default;
DeformableMesh::DeformableMesh(DeformableMesh&&) noexcept = default;
DeformableMesh& DeformableMesh::operator=(DeformableMesh&&) noexcept = default;

DeformReport DeformableMesh::update(std::span<const Vec3> vertices, const PartRunner& parts) {
  Impl& impl = *impl_;
  const std::size_t wanted = impl.current.model->vertices.size();
  if (vertices.size() != wanted)
    refuse_vertices("vertices holds " + std::to_string(vertices.size()) + "; it must hold " + std::to_string(wanted) +
                    ", as many as the mesh has");
  const MeshFrame frame(impl.checked_extent(vertices, parts));
  // Squares of smaller ones underflow.
  if (frame.half.maxCoeff() > 0 && 2 * frame.half.norm() < tolerance::shortest_length)
    refuse_vertices("the extent of the vertices is " + written(2 * frame.half) + "; it must be 0 or at least " +
                    written(tolerance::shortest_length));
  impl.require_seams(vertices, frame);

  const Impl::Buffer before = impl.take_free_buffer();
  MeshModel& mesh = *impl.current.model;
  mesh.forget_extremes();
  const MeshFrame frame_before = mesh.frame();
  bool copies = false;
  try {
    mesh.frame() = frame;
    impl.refit.refit(mesh, vertices, parts);
    if (mesh.closed && !impl.refit.surely_outward())
      if (const auto volume = inside_out(mesh, vertices, parts))
        refuse_vertices("the mesh is closed, but its volume is " + written(*volume) +
                        "; it must not be negative: it was turned inside out");
    copies = true;
    run_chunks(parts, vertices.size(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::copy(vertices.data() + begin, vertices.data() + end, mesh.vertices.data() + begin);
    });
    const MeshRefit::Report report = impl.refit.rebuild_worn(mesh, parts);
    if (report.rebuilt != 0) impl.current.structure = ++impl.structure;
    impl.shape.emplace(detail::ShapeInsides::shape(impl.current.model));
    return {report.rebuilt, report.worn};
  } catch (...) {  // refused, or `parts` or an allocation failed: restores on the calling thread alone
    const bool in_place = before.model == nullptr;
    if (copies && in_place) std::copy(vertices.begin(), vertices.end(), mesh.vertices.begin());
    impl.go_back(before, copies && in_place ? frame : frame_before, {});
    throw;
  }
}

Shape DeformableMesh::shape() const { return *impl_->shape; }
std::span<const Vec3> DeformableMesh::vertices() const { return impl_->current.model->vertices; }
std::span<const std::array<std::uint32_t, 3>> DeformableMesh::triangles() const {
  return impl_->current.model->triangles;
}

std::vector<std::array<std::uint32_t, 2>> DeformableMesh::self_intersections(const PartRunner& parts) const {
  return tandem::self_intersections(*impl_->current.model, impl_->first, parts);
}

NearFeatures DeformableMesh::near_features(double margin, const PartRunner& parts) const {
  require_feature_margin(margin);
  return tandem::near_features(*impl_->current.model, impl_->first, margin, parts);
}

SearchEnd DeformableMesh::visit_self_intersections(
    const std::function<bool(const std::array<std::uint32_t, 2>&)>& visitor, const SearchOptions& options) const {
  return tandem::visit_self_intersections(*impl_->current.model, impl_->first, visitor, options);
}

SearchEnd DeformableMesh::visit_near_features(double margin, const NearFeatureVisitor& visitor,
                                              const SearchOptions& options) const {
  require_feature_margin(margin);
  return tandem::visit_near_features(*impl_->current.model, impl_->first, margin, visitor, options);
}

std::size_t DeformableMesh::memory() const {
  const Impl& impl = *impl_;
  std::size_t bytes = sizeof(Impl) + impl.refit.memory() + impl.current.model->memory().total() + impl.used.capacity() +
                      (impl.first.capacity() + impl.seams.capacity()) * sizeof(std::uint32_t);
  for (const Impl::Buffer& buffer : impl.others) bytes += buffer.model->memory().total();
  return bytes;
}

}  // namespace tandem
