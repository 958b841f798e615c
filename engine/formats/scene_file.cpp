// Reads and writes scene files.
#include "tandem/formats/scene_file.h"

#include <nlohmann/json.hpp>

#include "formats/output_file.h"
#include "formats/scene_json.h"
#include "formats/text_file.h"
#include "tandem/formats/input_error.h"

namespace tandem {

Scene read_scene_file(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  try {
    const std::filesystem::path folder = path.parent_path();
    ShapeReader shapes({folder.empty() ? std::filesystem::path(".") : folder});
    const Json json = parse_json(text);
    return read_scene(JsonRef(json), shapes);
  } catch (const InputError& error) {
    throw error.within(path.string());
  }
}

void write_scene_file(const std::filesystem::path& path, const Scene& scene) {
  OutputFile file(path.string(), path);
  JsonWriter text;
  write_scene(text, scene);
  file.append(text.text());
  file.append("\n");
  file.commit();
}

}  // namespace tandem
