// Draws the layers of the libraries as SVG.
#include <algorithm>
#include <sstream>

#include "source_tree.h"

namespace {

// Lengths in pixels.
constexpr int box_width = 430, arcs_width = 190, line_height = 15, gap = 10, title_height = 34;
constexpr std::size_t line_letters = 68;

std::vector<std::string> wrapped(const std::set<std::string>& words) {
  std::vector<std::string> lines{""};
  for (const std::string& w : words) {
    if (lines.back().size() + w.size() > line_letters) lines.emplace_back();
    lines.back() += w + "  ";
  }
  return lines;
}

int height_of(const Folder& folder) { return 30 + line_height * static_cast<int>(wrapped(folder.units).size()); }

/// Draws a library, the lowest layer at the bottom; returns its height.
int draw_library(const SourceTree& tree, const std::string& library, int x, int y, std::ostream& out) {
  std::vector<std::size_t> folders;
  for (std::size_t i = tree.folders.size(); i-- > 0;)
    if (tree.folders[i].library == library) folders.push_back(i);
  out << "<text class='library' x='" << x << "' y='" << y + 22 << "'>" << library << "</text>\n";
  int top = y + title_height;
  std::map<std::size_t, int> middle;
  for (const std::size_t i : folders) {
    const Folder& folder = tree.folders[i];
    const int height = height_of(folder);
    out << "<rect x='" << x << "' y='" << top << "' width='" << box_width << "' height='" << height << "'/>\n"
        << "<text class='folder' x='" << x + 10 << "' y='" << top + 19 << "'>"
        << (folder.path == "." ? "of the library itself" : folder.path) << "</text>\n"
        << "<text class='size' x='" << x + box_width - 10 << "' y='" << top + 19 << "'>" << folder.units.size()
        << " units, " << folder.lines << " lines</text>\n";
    int line_y = top + 36;
    for (const std::string& line : wrapped(folder.units)) {
      out << "<text class='units' x='" << x + 10 << "' y='" << line_y << "'>" << line << "</text>\n";
      line_y += line_height;
    }
    middle[i] = top + height / 2;
    top += height + gap;
  }
  for (const auto& [arrow, count] : tree.includes) {
    const auto [from, to] = arrow;
    if (!middle.contains(from) || !middle.contains(to)) continue;
    const int x0 = x + box_width, y0 = middle[from] + 5, y1 = middle[to] - 5;
    const int reach = x0 + std::min(arcs_width - 10, 14 + std::abs(y1 - y0) / 4);
    out << "<path class='" << (to > from ? "up" : "down") << "' stroke-width='" << 0.6 + 0.25 * std::min(count, 12)
        << "' d='M" << x0 << " " << y0 << " C" << reach << " " << y0 << " " << reach << " " << y1 << " " << x0 << " "
        << y1 << "' marker-end='url(#head)'/>\n";
  }
  return top - y;
}

}  // namespace

std::string draw_tree(const SourceTree& tree) {
  std::ostringstream body;
  constexpr int margin = 20, column = box_width + arcs_width;
  const int left = draw_library(tree, "narrowphase", margin, margin, body);
  int right = 0;
  for (const char* library : {"engine", "flowgraph", "broadphase"})
    right += draw_library(tree, library, margin + column, margin + right, body);
  std::ostringstream out;
  const int width = 2 * margin + 2 * column, height = 2 * margin + std::max(left, right);
  out << "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 " << width << " " << height << "' width='" << width
      << "' height='" << height << "'>\n"
      << "<!-- drawn from the includes by tests/layers -->\n"
      << "<style>text{font-family:sans-serif;fill:#223}.library{font-size:20px;font-weight:bold}"
         ".folder{font-size:14px;font-weight:bold}.size{font-size:11px;text-anchor:end;fill:#667}"
         ".units{font-size:11px}rect{fill:#eef3fa;stroke:#9ab;rx:4}"
         "path{fill:none;stroke-opacity:.55}.down{stroke:#357}.up{stroke:#d22}</style>\n"
      << "<defs><marker id='head' viewBox='0 0 8 8' refX='7' refY='4' markerWidth='8' markerHeight='8' "
         "markerUnits='userSpaceOnUse' orient='auto'><polygon points='0,0 8,4 0,8' fill='#357'/></marker></defs>\n"
      << "<rect x='0' y='0' width='100%' height='100%' style='fill:#fff;stroke:none'/>\n"
      << body.str() << "</svg>\n";
  return out.str();
}
