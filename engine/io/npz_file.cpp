#include "io/npz_file.h"

#include <zlib.h>

#include <bit>
#include <stdexcept>

#include "io/output_file.h"

namespace palpate {
namespace {

void append(std::string& out, std::uint64_t value, int bytes) {
  for (int b = 0; b < bytes; ++b) out += static_cast<char>(value >> (8 * b) & 0xff);
}

/// numpy/lib/format.py, version 1.0: magic, length of the header, a Python dictionary padded to 64 bytes.
std::string npyHead(const char* type, std::size_t rows, int columns) {
  std::string text = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (" +
                     std::to_string(rows) + ", " + std::to_string(columns) + "), }";
  while ((10 + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  append(head, text.size(), 2);
  return head + text;
}

/// What a file's two headers in a zip share (APPNOTE.TXT, 4.3.7 and 4.3.12): stored, on the first day that there is.
std::string zipFields(const std::string& name, const std::string& bytes) {
  const auto crc = crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  std::string fields;
  append(fields, 20, 2);         // version needed
  append(fields, 0, 2 + 2 + 2);  // flags, method, time
  append(fields, 0x21, 2);       // 1 January 1980
  append(fields, crc, 4);
  append(fields, bytes.size(), 4);
  append(fields, bytes.size(), 4);
  append(fields, name.size(), 2);
  append(fields, 0, 2);  // no extra field
  return fields;
}

}  // namespace

NpzArray npzVectors(const std::string& name, std::span<const Vec3> vectors) {
  NpzArray array{name, npyHead("<f8", vectors.size(), 3)};
  for (const Vec3& v : vectors)
    for (const double c : v) append(array.npy, std::bit_cast<std::uint64_t>(c), 8);
  return array;
}

NpzArray npzCells(const std::string& name, std::span<const std::array<int, 4>> cells) {
  NpzArray array{name, npyHead("<i4", cells.size(), 4)};
  for (const auto& cell : cells)
    for (const int node : cell) append(array.npy, static_cast<std::uint32_t>(node), 4);
  return array;
}

void writeNpz(const std::string& path, std::span<const NpzArray> arrays) {
  std::string files, directory;
  for (const NpzArray& array : arrays) {
    const std::string name = array.name + ".npy", fields = zipFields(name, array.npy);
    if (files.size() + array.npy.size() >= 0xffff0000)
      throw std::runtime_error("can't write " + path + ": 4 GB or more");
    append(directory, 0x02014b50, 4);
    append(directory, 20, 2);  // made by
    directory += fields;
    append(directory, 0, 2 + 2 + 2);  // no comment, disk, kind
    append(directory, 0, 4);          // attributes
    append(directory, files.size(), 4);
    directory += name;
    append(files, 0x04034b50, 4);
    files += fields + name + array.npy;
  }
  const std::size_t begin = files.size();
  files += directory;
  append(files, 0x06054b50, 4);
  append(files, 0, 2 + 2);  // disks
  append(files, arrays.size(), 2);
  append(files, arrays.size(), 2);
  append(files, directory.size(), 4);
  append(files, begin, 4);
  append(files, 0, 2);
  writeWholeFile(path, files);
}

}  // namespace palpate
