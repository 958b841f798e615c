// The regions of space that ranks own, by Zoltan's recursive bisection.
#include "regions.h"

#include <zoltan.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace tandem::mpi {
namespace {

constexpr double everywhere = std::numeric_limits<double>::infinity();

struct Points {
  std::span<const Vec3> points;
  std::span<const float> weights;
};

int count_points(void* data, int* error) {
  *error = ZOLTAN_OK;
  return static_cast<int>(static_cast<const Points*>(data)->points.size());
}

void list_points(void* data, int, int, ZOLTAN_ID_PTR ids, ZOLTAN_ID_PTR local, int, float* weights, int* error) {
  const Points& all = *static_cast<const Points*>(data);
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    ids[i] = local[i] = static_cast<ZOLTAN_ID_TYPE>(i);  // only the cuts matter
    weights[i] = all.weights[i];
  }
  *error = ZOLTAN_OK;
}

int dimensions(void*, int* error) {
  *error = ZOLTAN_OK;
  return 3;
}

void place_points(void* data, int, int, int count, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR local, int, double* places,
                  int* error) {
  const Points& all = *static_cast<const Points*>(data);
  for (int i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) places[3 * i + axis] = all.points[local[i]][axis];
  *error = ZOLTAN_OK;
}

Zoltan_Struct* new_cuts(MPI_Comm communicator) {
  float version = 0;
  Zoltan_Initialize(0, nullptr, &version);
  Zoltan_Struct* zoltan = Zoltan_Create(communicator);
  const std::pair<const char*, const char*> parameters[] = {
      {"DEBUG_LEVEL", "0"},    {"LB_METHOD", "RCB"},      {"NUM_GID_ENTRIES", "1"}, {"NUM_LID_ENTRIES", "1"},
      {"OBJ_WEIGHT_DIM", "1"}, {"RETURN_LISTS", "NONE"},  {"KEEP_CUTS", "1"},       {"AVERAGE_CUTS", "1"},
      {"REMAP", "0"},          {"RCB_OUTPUT_LEVEL", "0"}, {"CHECK_GEOM", "0"}};
  for (const auto& [name, value] : parameters) Zoltan_Set_Param(zoltan, name, value);
  return zoltan;
}

}  // namespace

Regions::Regions(const Communicator& communicator) : communicator_(communicator) { read_cut(); }

Regions::~Regions() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized != 0) return;
  if (cut_ != nullptr) Zoltan_Destroy(&cut_);
  if (before_ != nullptr) Zoltan_Destroy(&before_);
}

bool Regions::cut(std::span<const Vec3> points, std::span<const float> weights) {
  Zoltan_Struct* const fresh = new_cuts(communicator_.comm());
  Points all{points, weights};
  Zoltan_Set_Num_Obj_Fn(fresh, count_points, &all);
  Zoltan_Set_Obj_List_Fn(fresh, list_points, &all);
  Zoltan_Set_Num_Geom_Fn(fresh, dimensions, &all);
  Zoltan_Set_Geom_Multi_Fn(fresh, place_points, &all);
  int changes = 0, id_length = 0, local_length = 0, imports = 0, exports = 0;
  ZOLTAN_ID_PTR import_ids = nullptr, import_local = nullptr, export_ids = nullptr, export_local = nullptr;
  int *import_ranks = nullptr, *import_parts = nullptr, *export_ranks = nullptr, *export_parts = nullptr;
  const int status = Zoltan_LB_Partition(fresh, &changes, &id_length, &local_length, &imports, &import_ids,
                                         &import_local, &import_ranks, &import_parts, &exports, &export_ids,
                                         &export_local, &export_ranks, &export_parts);
  Zoltan_LB_Free_Part(&import_ids, &import_local, &import_ranks, &import_parts);
  Zoltan_LB_Free_Part(&export_ids, &export_local, &export_ranks, &export_parts);
  std::uint64_t failed[] = {status == ZOLTAN_OK || status == ZOLTAN_WARN ? 0u : 1u};
  communicator_.largest(std::span<std::uint64_t>(failed));
  if (failed[0] != 0) {
    Zoltan_Struct* gone = fresh;
    Zoltan_Destroy(&gone);
    return false;
  }
  if (before_ != nullptr) Zoltan_Destroy(&before_);
  before_ = std::exchange(cut_, fresh);
  read_cut();
  return true;
}

void Regions::take_back() {
  if (before_ == nullptr) return;
  std::swap(cut_, before_);
  Zoltan_Destroy(&before_);
  read_cut();
}

void Regions::read_cut() {
  ranks_.resize(static_cast<std::size_t>(communicator_.ranks()));
  if (cut_ == nullptr) {
    // No point lies in the regions of the others.
    own_.lo.fill(communicator_.rank() == 0 ? -everywhere : everywhere);
    own_.hi.fill(everywhere);
    is_box_ = true;
    return;
  }
  int axes = 0;
  auto &lo = own_.lo, &hi = own_.hi;
  Zoltan_RCB_Box(cut_, communicator_.rank(), &axes, &lo[0], &lo[1], &lo[2], &hi[0], &hi[1], &hi[2]);
  // If a cut of a group of ranks without points lies outside of the group's own region, Zoltan reports a box that
  // reaches into others'; its assignment of points and boxes does not. A box that touches a cut from below is reported
  // on both sides, though the cut itself belongs to the lower side.
  std::array<double, 3> first{}, last{};
  for (std::size_t i = 0; i < 3; ++i) {
    first[i] = std::nextafter(lo[i], everywhere);
    last[i] = std::nextafter(hi[i], -everywhere);
  }
  int count = 0;
  Zoltan_LB_Box_Assign(cut_, first[0], first[1], first[2], last[0], last[1], last[2], ranks_.data(), &count);
  is_box_ = count == 1 && ranks_[0] == communicator_.rank();
  // The outer sides are unbounded.
  for (std::size_t i = 0; i < 3; ++i) {
    if (lo[i] <= -std::numeric_limits<double>::max()) lo[i] = -everywhere;
    if (hi[i] >= std::numeric_limits<double>::max()) hi[i] = everywhere;
  }
}

Region Regions::own() const {
  if (is_box_) return own_;
  Region none;
  none.lo.fill(everywhere);
  none.hi.fill(-everywhere);
  return none;
}

int Regions::owner(const std::array<double, 3>& point) const {
  if (cut_ == nullptr) return 0;
  auto place = point;  // Zoltan's parameter is not const
  int owner = 0;
  Zoltan_LB_Point_Assign(cut_, place.data(), &owner);
  return owner;
}

std::span<const int> Regions::reached(const FloatBox& box) const {
  if (cut_ == nullptr) {
    ranks_[0] = 0;
    return std::span(ranks_).first(1);
  }
  int count = 0;
  Zoltan_LB_Box_Assign(cut_, box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2], ranks_.data(), &count);
  std::sort(ranks_.begin(), ranks_.begin() + count);
  return std::span(ranks_).first(static_cast<std::size_t>(count));
}

}  // namespace tandem::mpi
