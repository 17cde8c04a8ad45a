#include "io/stl_parser.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "base/printable_text.h"
#include "io/token_reader.h"

namespace palpate {

namespace {

// Binary layout, little-endian: 80 bytes of header, uint32 face count, then per
// face 12 float32 (normal, three corners) and a uint16 attribute.
constexpr std::size_t header_size = 84, face_size = 50;
static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies in memory");

std::uint32_t statedFaceCount(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  return count;
}

bool looksBinary(const std::string& bytes) {
  if (bytes.size() >= header_size && bytes.size() == header_size + face_size * statedFaceCount(bytes)) return true;
  const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || lowerCase(std::string_view(bytes).substr(begin, 5)) != "solid") return true;
  return bytes.find('\0') != std::string::npos;
}

SurfaceFile parseBinary(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  const bool tolerant = reading == SurfaceReading::Tolerant;
  const SourceLocation place{file, 0, 0};
  if (bytes.size() < header_size) {
    throw InputError(place,
                     "neither an ASCII STL (it does not begin with \"solid\") nor a binary one (" +
                         std::to_string(bytes.size()) + " bytes, a header alone has 84)",
                     "export it again as STL or OBJ");
  }
  std::uint32_t count = statedFaceCount(bytes);
  const std::uint64_t expected = header_size + std::uint64_t{face_size} * count;
  SurfaceFile result;
  result.source.file = file;
  if (bytes.size() != expected && tolerant) {
    // The faces that are there, whole ones.
    const auto there = static_cast<std::uint32_t>((bytes.size() - header_size) / face_size);
    result.unreadable_faces = count > there && count < 2 * there ? static_cast<int>(count - there) : 1;
    count = there;
  } else if (bytes.size() != expected) {
    throw InputError(place,
                     "this binary STL announces " + std::to_string(count) + " faces, which take " +
                         std::to_string(expected) + " bytes, but has " + std::to_string(bytes.size()),
                     bytes.size() < expected ? "it was cut short or is no STL: export it again"
                                             : "it has trailing bytes or is no STL: export it again");
  }
  if (count == 0) throw InputError(place, "no faces in this file", "export the organ as a triangle mesh");
  for (std::uint32_t t = 0; t < count; ++t) {
    float corner[9];
    std::memcpy(corner, bytes.data() + header_size + std::size_t{face_size} * t + 12, sizeof corner);
    const int first = static_cast<int>(result.surface.vertices.size());
    for (int k = 0; k < 3; ++k) {
      const Vec3 x(corner[3 * k], corner[3 * k + 1], corner[3 * k + 2]);
      if (!x.allFinite() && !tolerant) {
        throw InputError(place,
                         "corner " + std::to_string(k + 1) + " of face " + std::to_string(t + 1) + " of " +
                             std::to_string(count) + " is not finite",
                         "repair or export the file again");
      }
      result.surface.vertices.push_back(x);
    }
    result.surface.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

/// Adds the faces to `result`, up to where it throws.
void parseAscii(const std::string& text, const std::string& file, SurfaceFile& result) {
  result.source.file = file;
  TokenReader reader(text, file);
  const auto expect = [&](std::string_view word, const char* wanted) {
    if (lowerCase(word) == wanted) return;
    throw InputError(reader.place(),
                     word.empty() ? "the file ends where \"" + std::string(wanted) + "\" should stand"
                                  : inQuotes(word) + " where \"" + std::string(wanted) + "\" should stand",
                     "the file was cut short or damaged: export it again");
  };
  const auto numbers = [&](Vec3& x, const std::string& what) {
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = reader.next();
      x[k] = parseNumber(word, reader.place(), what);
    }
  };

  for (std::string_view word = reader.next(); !word.empty(); word = reader.next()) {
    expect(word, "solid");
    reader.nextLine();  // the rest is a name
    for (;;) {
      word = reader.next();
      if (lowerCase(word) == "endsolid") break;
      expect(word, "facet");
      const int line = reader.place().line;
      expect(reader.next(), "normal");
      // The stated normal is redundant and often wrong or NaN: three words to pass over.
      for (int k = 0; k < 3; ++k) reader.next();
      expect(reader.next(), "outer");
      expect(reader.next(), "loop");
      const int first = static_cast<int>(result.surface.vertices.size());
      for (int k = 0; k < 3; ++k) {
        expect(reader.next(), "vertex");
        result.source.vertex_line.push_back(reader.place().line);
        Vec3 x;
        numbers(x, "a coordinate");
        result.surface.vertices.push_back(x);
      }
      expect(reader.next(), "endloop");
      expect(reader.next(), "endfacet");
      result.surface.triangles.push_back({first, first + 1, first + 2});
      result.source.triangle_line.push_back(line);
    }
    reader.nextLine();
  }
}

}  // namespace

SurfaceFile parseStl(const std::string& bytes, const std::string& file, SurfaceReading reading) {
  if (looksBinary(bytes)) return parseBinary(bytes, file, reading);
  SurfaceFile result;
  try {
    parseAscii(bytes, file, result);
  } catch (const InputError&) {
    if (reading == SurfaceReading::Strict || result.surface.triangles.empty()) throw;
    result.unreadable_faces = 1;
    result.surface.vertices.resize(3 * result.surface.triangles.size());  // without those of the face cut off
    result.source.vertex_line.resize(result.surface.vertices.size());
  }
  if (result.surface.triangles.empty())
    throw InputError({file, 0, 0}, "no faces in this file", "export the organ as a triangle mesh");
  return result;
}

}  // namespace palpate
