// The journal of `tandem clash`, from which an interrupted run continues.
#include "journal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "formats/json_reader.h"
#include "formats/text_file.h"

namespace tandem::clash {
namespace {

// FNV-1a (Fowler, Noll, Vo) of a mesh's numbers.
std::uint64_t hash(const Shape& shape) {
  std::uint64_t out = 0xcbf29ce484222325u;
  const auto add = [&](std::uint64_t bits) { out = (out ^ bits) * 0x100000001b3u; };
  for (const Vec3& v : shape.vertices())
    for (int k = 0; k < 3; ++k) add(std::bit_cast<std::uint64_t>(v[k]));
  for (const auto& t : shape.triangles())
    for (const std::uint32_t corner : t) add(corner);
  return out;
}

std::string header(const std::vector<Part>& parts, double clearance) {
  JsonWriter out;
  out.begin_object().member("tandem_clash", 2).member("clearance", clearance).key("parts").begin_array();
  for (const Part& part : parts)
    out.begin_object().member("file", part.file).member("mesh", std::to_string(hash(part.shape))).end_object();
  out.end_array().end_object();
  return out.text();
}

void write_zones(JsonWriter& out, const Clash& clash) {
  out.member("zone_count", clash.zone_count).key("zones").begin_array();
  for (const Zone& zone : clash.zones) {
    out.begin_object().member("triangle_pairs", zone.triangle_pairs).member("place", zone.place);
    out.key("bounds").begin_array().value(zone.bounds.lo).value(zone.bounds.hi).end_array().end_object();
  }
  out.end_array();
}

std::size_t count(const JsonRef& json) {
  if (!json.value().is_number_unsigned()) json.refuse("a whole number >= 0");
  return json.value().get<std::size_t>();
}

void require_two(const JsonRef& json, std::string_view allowed) {
  json.require_array(allowed);
  if (json.size() != 2) json.refuse(allowed);
}

void read_zones(const JsonRef& entry, Clash& clash) {
  clash.zone_count = count(entry.at("zone_count"));
  const JsonRef zones = entry.at("zones");
  zones.require_array("an array of zones");
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const JsonRef zone = zones.at(i), bounds = zone.at("bounds");
    require_two(bounds, "two corners");
    clash.zones.push_back({count(zone.at("triangle_pairs")),
                           zone.at("place").vec3(),
                           {bounds.at(std::size_t{0}).vec3(), bounds.at(std::size_t{1}).vec3()}});
  }
}

std::string line(const Pair& pair, const Answer& answer) {
  const Clash& c = answer.clash;
  JsonWriter out;
  out.begin_object().key("pair").begin_array().value(pair.a).value(pair.b).end_array().member("near", answer.near);
  out.member("intersects", c.intersects).member("triangle_pairs", c.triangle_pairs).member("distance", c.distance);
  out.member("place", c.place).member("normal", c.normal).member("status", static_cast<int>(c.status));
  out.member("error_bound", c.error_bound);
  write_zones(out, c);
  out.end_object();
  return out.text() + '\n';
}

Answer read(const JsonRef& entry, std::size_t parts) {
  Answer out;
  const JsonRef pair = entry.at("pair");
  constexpr std::string_view two = "two parts, in their order";
  require_two(pair, two);
  const auto most = static_cast<std::uint32_t>(parts - 1);
  out.clash.a = pair.at(std::size_t{0}).whole(most);
  out.clash.b = pair.at(std::size_t{1}).whole(most);
  if (out.clash.a >= out.clash.b) pair.refuse(two);
  out.near = entry.at("near").flag();
  out.clash.intersects = entry.at("intersects").flag();
  out.clash.triangle_pairs = count(entry.at("triangle_pairs"));
  out.clash.distance = entry.at("distance").number();
  out.clash.place = entry.at("place").vec3();
  out.clash.normal = entry.at("normal").vec3();
  out.clash.status = static_cast<Status>(entry.at("status").whole(static_cast<std::uint32_t>(Status::unproven)));
  out.clash.error_bound = entry.at("error_bound").number_at_least(0);
  read_zones(entry, out.clash);
  return out;
}

int opened(const std::filesystem::path& path) {
  const auto refuse = [&](std::string_view found) {
    throw InputError("--resume " + path.string(), found, "a regular file, or the name of a new one");
  };
  struct ::stat about {};
  if (::stat(path.c_str(), &about) == 0 && !S_ISREG(about.st_mode)) refuse("a folder, pipe or device");
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) refuse(std::strerror(errno));
  return descriptor;
}

}  // namespace

void write(JsonWriter& out, const std::vector<Part>& parts, const Clash& clash) {
  out.begin_object().member("a", parts[clash.a].file).member("b", parts[clash.b].file);
  out.member("intersects", clash.intersects).member("triangle_pairs", clash.triangle_pairs);
  out.member("distance", clash.distance).member("place", clash.place).member("normal", clash.normal);
  out.member("status", clash.status == Status::ok ? "ok" : clash.status == Status::inexact ? "inexact" : "unproven");
  if (clash.status == Status::inexact) out.member("error_bound", clash.error_bound);
  write_zones(out, clash);
  out.end_object();
}

Journal::Journal(const std::filesystem::path& path, const std::vector<Part>& parts, double clearance)
    : descriptor_(opened(path)), out_(descriptor_, "--resume") {
  const std::string first = header(parts, clearance);
  InputFile in(path);
  std::string text;
  std::uint64_t kept = 0;
  InputFile::Line found = in.line(text);
  const auto whole = [&] { return in.position() == kept + text.size() + 1; };  // including the line end
  if (found != InputFile::Line::none && !(whole() ? text == first : first.starts_with(text)))
    throw InputError("--resume " + path.string(), "no answers for these parts, meshes and clearance",
                     "a file that this tool wrote for them, or a new one");
  for (std::size_t number = 2; found == InputFile::Line::read && whole(); ++number) {
    kept = in.position();
    found = in.line(text);
    if (found != InputFile::Line::read || !whole()) break;
    try {
      const Json json = parse_json(text);
      const Answer answer = read(JsonRef(json), parts.size());
      answers_[{answer.clash.a, answer.clash.b}] = answer;
    } catch (const InputError& error) {
      throw error.within("--resume " + path.string() + ": line " + std::to_string(number));
    }
  }
  if (::ftruncate(descriptor_, static_cast<off_t>(kept)) != 0 || ::lseek(descriptor_, 0, SEEK_END) < 0)
    throw OutputError("--resume: " + std::string(std::strerror(errno)));
  if (kept == 0) out_.append(first + '\n');
  out_.flush();
}

Journal::~Journal() { ::close(descriptor_); }

void Journal::add(const Pair& pair, const Answer& answer) {
  out_.append(line(pair, answer));
  out_.flush();
}

}  // namespace tandem::clash
