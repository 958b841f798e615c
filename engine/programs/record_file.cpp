#include "record_file.h"

#include <bit>
#include <cstring>

#include "scene_file.h"

namespace tandem {
namespace {

// Numbers are stored as they lie in memory.
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

bool moves(const Scene& scene, std::uint32_t index) { return scene.alive(index) && scene.is_static()[index] == 0; }

}  // namespace

RecordWriter::RecordWriter(OutputFile& file, const Scene& scene) : file_(file) {
  JsonWriter text;
  write_scene(text, scene);
  // Strings escape theirs, so every line feed is one between elements, and the header is one line without them.
  std::string one_line = text.text();
  std::erase(one_line, '\n');
  JsonWriter header;
  header.begin_object().member("format", format).member("version", version);
  header.key("scene").raw(one_line).end_object();
  file_.append(header.text());
  file_.append("\n");
}

void RecordWriter::step(std::uint64_t step, std::uint64_t contact_hash, const Scene& scene,
                        const ContactList& contacts) {
  block_.clear();
  std::uint32_t moving = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) moving += moves(scene, i);
  put(block_, step_mark);
  put(block_, step);
  put(block_, contact_hash);
  put(block_, moving);
  put(block_, static_cast<std::uint32_t>(contacts.contacts.size()));
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!moves(scene, i)) continue;
    const Pose& pose = scene.poses()[i];
    put(block_, i);
    for (Eigen::Index k = 0; k < 3; ++k) put(block_, pose.translation[k]);
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) put(block_, pose.rotation(row, column));
  }
  for (const PairResult& pair : contacts.pairs) {
    for (const Contact& contact : contacts.of(pair)) {
      put(block_, pair.a);
      put(block_, pair.b);
      for (Eigen::Index k = 0; k < 3; ++k) put(block_, static_cast<float>(contact.point[k]));
      for (Eigen::Index k = 0; k < 3; ++k) put(block_, static_cast<float>(contact.normal[k]));
      put(block_, static_cast<float>(contact.depth));
    }
  }
  file_.append(block_);
}

RecordReader::RecordReader(const std::filesystem::path& path) : file_(path.string()), data_(read_file(path)) {
  try {
    const std::size_t end = data_.find('\n');
    const Json json = parse_json(std::string_view(data_).substr(0, end));
    const JsonRef header(json);
    header.require_keys({"format", "version", "scene"});
    const JsonRef found_format = header.at("format"), found_version = header.at("version");
    if (found_format.text() != format) found_format.refuse(format);
    if (found_version.whole(0xffffffffu) != version) found_version.refuse(std::to_string(version));
    ShapeReader shapes;
    scene_ = read_scene(header.at("scene"), shapes);
    at_ = end == std::string::npos ? data_.size() : end + 1;
  } catch (const InputError& error) {
    throw InputError(file_ + ": " + error.what());
  }
}

template <typename T>
T RecordReader::take() {
  if (data_.size() - at_ < sizeof(T))
    throw InputError(file_ + ": byte " + std::to_string(data_.size()) + ": end of file within a step");
  T value;
  std::memcpy(&value, data_.data() + at_, sizeof(T));
  at_ += sizeof(T);
  return value;
}

bool RecordReader::next(RecordedStep& step) {
  if (at_ == data_.size()) return false;
  const std::size_t begin = at_;
  if (take<std::uint32_t>() != step_mark)
    throw InputError(file_ + ": byte " + std::to_string(begin) + ": no step, allowed: the mark 'STEP'");
  step.step = take<std::uint64_t>();
  step.contact_hash = take<std::uint64_t>();
  const auto moving = take<std::uint32_t>(), contacts = take<std::uint32_t>();
  // Nothing is reserved by a number that a damaged file may hold.
  step.poses.clear();
  step.contacts.clear();
  for (std::uint32_t i = 0; i < moving; ++i) {
    const std::size_t at = at_;
    const auto index = take<std::uint32_t>();
    Pose pose;
    for (double& x : pose.translation) x = take<double>();
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) pose.rotation(row, column) = take<double>();
    if (index >= scene_.indices())
      throw InputError(file_ + ": byte " + std::to_string(at) + ": body " + std::to_string(index) +
                       ", allowed: below " + std::to_string(scene_.indices()));
    try {
      require_valid(pose, file_ + ": byte " + std::to_string(at));
    } catch (const std::invalid_argument& error) {
      throw InputError(error.what());
    }
    step.poses.emplace_back(index, pose);
  }
  for (std::uint32_t i = 0; i < contacts; ++i) {
    RecordedContact contact;
    contact.a = take<std::uint32_t>();
    contact.b = take<std::uint32_t>();
    for (float& x : contact.point) x = take<float>();
    for (float& x : contact.normal) x = take<float>();
    contact.depth = take<float>();
    step.contacts.push_back(contact);
  }
  return true;
}

}  // namespace tandem
