// Compression of files whose names end in .gz.
#include "gzip.h"

#include <zlib.h>

#include <limits>
#include <stdexcept>

#include "formats/text_file.h"

namespace tandem {
namespace {

constexpr int gzip_format = 16 + MAX_WBITS;  // zlib's convention to request the gzip format

z_stream stream_over(std::string_view bytes) {
  if (bytes.size() > std::numeric_limits<uInt>::max()) throw std::runtime_error("gzip: more than 4 GiB");
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib only reads
  stream.avail_in = static_cast<uInt>(bytes.size());
  return stream;
}

// Fills `out` block by block until the work returns its end or an error; returns that.
template <class Work>
int drained(z_stream& stream, std::string& out, std::size_t most, Work&& work) {
  int word = Z_OK;
  while (word == Z_OK && out.size() <= most) {
    const std::size_t before = out.size();
    out.resize(before + (1u << 20));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = 1u << 20;
    word = work();
    out.resize(out.size() - stream.avail_out);
    if (word == Z_OK && out.size() == before) return Z_DATA_ERROR;  // the data is truncated
  }
  return word;
}

}  // namespace

std::string gzipped(std::string_view bytes) {
  z_stream stream = stream_over(bytes);
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_format, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string out;
  drained(stream, out, std::numeric_limits<std::size_t>::max(), [&] { return ::deflate(&stream, Z_FINISH); });
  deflateEnd(&stream);
  return out;
}

bool is_gzipped(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzipped(std::string_view bytes, std::size_t most) {
  z_stream stream = stream_over(bytes);
  if (inflateInit2(&stream, gzip_format) != Z_OK) throw std::bad_alloc();
  std::string out;
  const int word = drained(stream, out, most, [&] { return ::inflate(&stream, Z_NO_FLUSH); });
  inflateEnd(&stream);
  if (out.size() > most) throw InputError({}, "more inside the .gz file", "at most " + in_mebibytes(most));
  if (word != Z_STREAM_END) throw InputError({}, "a .gz file that is damaged or cut off");
  return out;
}

}  // namespace tandem
