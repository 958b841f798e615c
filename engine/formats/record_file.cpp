// Writes and reads recordings, the binary files of `tandem run --record` (docs/record-format.md).
#include "formats/record_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "formats/scene_json.h"
#include "scene/scene_contacts.h"

namespace tandem {
namespace {

// Numbers are stored as they are in memory.
static_assert(std::endian::native == std::endian::little, "records are little-endian");

constexpr std::string_view format = "tandem-record";
constexpr std::uint32_t version = 1;
constexpr std::uint32_t step_mark = 0x50455453;  // "STEP"

template <typename T>
void put(std::string& out, const T& value) {
  static_assert(std::is_arithmetic_v<T>);
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

/// Reads numbers stored one after the other.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  T next() {
    T value;
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    return value;
  }

 private:
  std::string_view bytes_;
};

bool moves(const Scene& scene, std::uint32_t index) { return scene.alive(index) && scene.is_static()[index] == 0; }

}  // namespace

std::string record::header(const Scene& scene) {
  JsonWriter text;
  write_scene(text, scene);
  // Strings escape their line feeds, so every line feed is between elements, and without them the header is one line.
  std::string one_line = text.text();
  std::erase(one_line, '\n');
  JsonWriter header;
  header.begin_object().member("format", format).member("version", version);
  header.key("scene").raw(one_line).end_object();
  return header.text() + '\n';
}

void record::append_step_head(std::string& out, std::uint64_t step, std::uint64_t contact_hash, std::uint32_t moving,
                              std::uint32_t contacts) {
  put(out, step_mark);
  put(out, step);
  put(out, contact_hash);
  put(out, moving);
  put(out, contacts);
}

void record::append_pose(std::string& out, std::uint32_t index, const Pose& pose) {
  put(out, index);
  for (Eigen::Index k = 0; k < 3; ++k) put(out, pose.translation[k]);
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 3; ++column) put(out, pose.rotation(row, column));
}

void record::append_contact(std::string& out, std::uint32_t a, std::uint32_t b, const Contact& contact) {
  put(out, a);
  put(out, b);
  for (Eigen::Index k = 0; k < 3; ++k) put(out, static_cast<float>(contact.point[k]));
  for (Eigen::Index k = 0; k < 3; ++k) put(out, static_cast<float>(contact.normal[k]));
  put(out, static_cast<float>(contact.depth));
}

RecordWriter::RecordWriter(OutputFile& file, const Scene& scene) : file_(file) {
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (scene.alive(i)) bodies_.push_back(scene.id(i));
  number_of_.assign(bodies_.empty() ? 0 : bodies_.back().index() + 1, 0);
  for (std::uint32_t k = 0; k < bodies_.size(); ++k) number_of_[bodies_[k].index()] = k;
  file_.append(record::header(scene));
}

void RecordWriter::require_bodies(const Scene& scene) const {
  const bool same = scene.bodies() == bodies_.size() && std::ranges::all_of(bodies_, [&](BodyId body) {
                      const std::uint32_t i = body.index();
                      return i < scene.indices() && scene.alive(i) && scene.id(i) == body;
                    });
  if (!same)
    throw std::invalid_argument(
        "record: the scene has other bodies than when the record began, allowed: the same ones in each step");
}

void RecordWriter::step(std::uint64_t step, std::uint64_t contact_hash, const Scene& scene,
                        const ContactList& contacts) {
  require_bodies(scene);
  require_contacts_of(scene, contacts, "record");
  if (number_of_.size() != bodies_.size()) {  // the hash is that of the bodies' numbers
    ContactList numbered = contacts;
    for (PairResult& pair : numbered.pairs) pair.a = number_of_[pair.a], pair.b = number_of_[pair.b];
    contact_hash = hash(numbered);
  }
  block_.clear();
  std::uint32_t moving = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) moving += moves(scene, i);
  record::append_step_head(block_, step, contact_hash, moving, static_cast<std::uint32_t>(contacts.contacts.size()));
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (moves(scene, i)) record::append_pose(block_, number_of_[i], scene.poses()[i]);
  for (const PairResult& pair : contacts.pairs)
    for (const Contact& contact : contacts.of(pair))
      record::append_contact(block_, number_of_[pair.a], number_of_[pair.b], contact);
  file_.append(block_);
}

RecordReader::RecordReader(const std::filesystem::path& path) : file_(path, InputFile::Kind::regular) {
  if (!file_.size()) throw InputError(file_.name(), "a file of size 0", "a recording");
  std::string line;
  if (file_.line(line, limits::document_bytes) == InputFile::Line::too_long)
    throw InputError(file_.name() + ": line 1", "a longer line", "at most " + in_mebibytes(limits::document_bytes));
  try {
    const Json json = parse_json(line);
    const JsonRef header(json);
    header.require_keys({"format", "version", "scene"});
    const JsonRef found_format = header.at("format"), found_version = header.at("version");
    if (found_format.text() != format) found_format.refuse(format);
    if (found_version.whole(0xffffffffu) != version) found_version.refuse(std::to_string(version));
    ShapeReader shapes;
    scene_ = read_scene(header.at("scene"), shapes);
  } catch (const InputError& error) {
    throw error.within(file_.name());
  }
}

std::string_view RecordReader::take(std::size_t count, std::size_t size, std::string_view what) {
  const std::uint64_t at = file_.position(), needed = std::uint64_t{count} * size;
  const std::uint64_t left = *file_.size() - std::min(*file_.size(), at);
  // Checked before memory is allocated for a number that a damaged file may hold.
  if (needed <= left) {
    bytes_.resize(needed);
    if (file_.read(bytes_.data(), bytes_.size()) == bytes_.size()) return bytes_;
  }
  throw InputError(file_.name() + ": byte " + std::to_string(at + left), "end of file within a step",
                   std::to_string(needed) + " bytes of " + std::string(what) + " from byte " + std::to_string(at));
}

bool RecordReader::next(RecordedStep& step) {
  const std::uint64_t begin = file_.position();
  const auto refuse = [&](std::uint64_t at, std::string_view found, std::string_view allowed) {
    throw InputError(file_.name() + ": byte " + std::to_string(at), found, allowed);
  };
  if (file_.peek(1).empty()) return false;
  Numbers head(take(1, record::step_head_bytes, "the head of a step"));
  if (head.next<std::uint32_t>() != step_mark) refuse(begin, "no step", "the mark 'STEP'");
  step.step = head.next<std::uint64_t>();
  step.contact_hash = head.next<std::uint64_t>();
  const auto moving = head.next<std::uint32_t>(), contacts = head.next<std::uint32_t>();
  const std::size_t bodies = scene_.indices();
  const auto body = [&](Numbers& numbers, std::uint64_t at) {
    const auto index = numbers.next<std::uint32_t>();
    if (index >= bodies) refuse(at, "body " + std::to_string(index), "below " + std::to_string(bodies));
    return index;
  };
  if (moving > bodies) refuse(begin, std::to_string(moving) + " bodies that move", "at most " + std::to_string(bodies));

  std::uint64_t at = file_.position();
  Numbers poses(take(moving, record::pose_bytes, "poses"));
  step.poses.clear();
  for (std::uint32_t i = 0; i < moving; ++i, at += record::pose_bytes) {
    const std::uint32_t index = body(poses, at);
    if (i > 0 && index <= step.poses.back().first)
      refuse(at, "body " + std::to_string(index) + " after body " + std::to_string(step.poses.back().first),
             "each body once, by their numbers");
    Pose pose;
    for (double& x : pose.translation) x = poses.next<double>();
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) pose.rotation(row, column) = poses.next<double>();
    require_valid_pose(pose, file_.name() + ": byte " + std::to_string(at));
    step.poses.emplace_back(index, pose);
  }

  if (contacts > limits::step_contacts)
    refuse(begin, std::to_string(contacts) + " contacts", "at most " + std::to_string(limits::step_contacts));
  at = file_.position();
  Numbers found(take(contacts, record::contact_bytes, "contacts"));
  step.contacts.clear();
  for (std::uint32_t i = 0; i < contacts; ++i, at += record::contact_bytes) {
    RecordedContact contact;
    contact.a = body(found, at);
    contact.b = body(found, at);
    for (float& x : contact.point) x = found.next<float>();
    for (float& x : contact.normal) x = found.next<float>();
    contact.depth = found.next<float>();
    const auto finite = [](float x) { return std::isfinite(x); };
    if (!std::all_of(contact.point, contact.point + 3, finite) ||
        !std::all_of(contact.normal, contact.normal + 3, finite) || !finite(contact.depth))
      refuse(at, "a contact with a number that is not finite", "finite numbers");
    step.contacts.push_back(contact);
  }
  return true;
}

}  // namespace tandem
