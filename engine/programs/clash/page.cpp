// Writes the HTML page of clashes.
#include "page.h"

#include <algorithm>
#include <cmath>

#include "formats/json_writer.h"
#include "journal.h"
#include "programs/clash/page_text.h"

namespace tandem::clash {
namespace {

constexpr std::size_t most_triangles = 60'000;  // drawn in all: what a browser rotates smoothly, some 3 MB of page
// Steps of a coordinate over the box of the assembly: finer than a screen.
constexpr double steps = 16383;

// The bounding cube of all meshes.
struct Cube {
  Vec3 lo;
  double size;
};

Cube cube_of(const std::vector<Part>& parts) {
  Vec3 lo = parts.front().bounds.lo, hi = parts.front().bounds.hi;
  for (const Part& part : parts) {
    lo = lo.cwiseMin(part.bounds.lo);
    hi = hi.cwiseMax(part.bounds.hi);
  }
  const double size = (hi - lo).maxCoeff();
  return {lo, size > 0 ? size : 1};
}

void write_part(JsonWriter& out, const Part& part, const Cube& cube, std::size_t all_triangles) {
  const auto vertices = part.shape.vertices();
  const auto triangles = part.shape.triangles();
  const auto share =
      std::max<std::size_t>(1, triangles.size() * most_triangles / std::max(all_triangles, most_triangles));
  out.begin_object().member("file", part.file).member("triangles", triangles.size()).member("open", part.open);
  out.key("drawn").begin_array();
  for (std::size_t i = 0; i < share; ++i)
    for (const std::uint32_t corner : triangles[i * triangles.size() / share])
      for (int k = 0; k < 3; ++k) out.value(std::lround((vertices[corner][k] - cube.lo[k]) / cube.size * steps));
  out.end_array().end_object();
}

}  // namespace

std::string page(const std::vector<Part>& parts, const std::vector<Clash>& clashes, double clearance) {
  std::size_t all = 0;
  for (const Part& part : parts) all += part.shape.triangles().size();
  JsonWriter data;
  const Cube cube = cube_of(parts);
  data.begin_object().member("clearance", clearance).member("lo", cube.lo).member("step", cube.size / steps);
  data.key("parts").begin_array();
  for (const Part& part : parts) write_part(data, part, cube, all);
  data.end_array().key("clashes").begin_array();
  for (const Clash& clash : clashes) {
    data.begin_object().member("a", clash.a).member("b", clash.b).member("intersects", clash.intersects);
    data.member("triangle_pairs", clash.triangle_pairs).member("distance", clash.distance).member("place", clash.place);
    data.member("zone_count", clash.zone_count).key("zones").begin_array();
    for (const Zone& zone : clash.zones) data.value(zone.place);
    data.end_array().end_object();
  }
  data.end_array().end_object();
  std::string json = data.text();  // a file's name must not end the script element
  for (std::size_t at = 0; (at = json.find("</", at)) != std::string::npos; at += 3) json.replace(at, 2, "<\\/");
  std::string out(page_text);
  const std::string_view mark = "/*DATA*/";
  return out.replace(out.find(mark), mark.size(), json);
}

}  // namespace tandem::clash
