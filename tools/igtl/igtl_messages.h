#pragma once

#include <igtlImageMessage.h>
#include <igtlPolyDataMessage.h>
#include <igtlTransformMessage.h>
#include <palpate.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace palpate::igtl_bridge {

/// A skin as the library hands it out: (vertex_count, 3) m and (triangle_count, 3).
struct Skin {
  std::vector<float> x;
  std::vector<int> corners;
};

/// A pose of palpate.h, m and quaternion x, y, z, w, of a matrix of OpenIGTLink, mm. None where it is no rigid motion
/// or not finite: `problem` then says what it is.
std::optional<std::array<double, 7>> poseOf(const igtl::Matrix4x4& matrix, std::string& problem);

constexpr int header_bytes = 58;  // of every message; their fields: OpenIGTLink's protocol, "Header"

/// Of the most significant byte first.
std::uint64_t numberAt(const unsigned char* bytes, int count);

/// The matrix of a TRANSFORM's body as it came, with or without the extended header of protocol version 2. The library
/// (1.11) knows version 1, and takes a body's length for what the header says. False where it is no such body:
/// `problem` then says why.
/// @param header  (header_bytes)
bool transformOf(const unsigned char* header, std::vector<unsigned char>& body, igtl::Matrix4x4& matrix,
                 std::string& problem);

/// The way back.
void matrixOf(const double* pose, igtl::Matrix4x4& matrix);

/// The skin, in mm, with its triangles.
igtl::PolyDataMessage::Pointer surfaceMessage(const Skin& skin, const std::string& device);

/// What the skin encloses as voxels of one byte, 1 inside, at most `cells` along the longest side. Axes are those of
/// the scene, in mm.
igtl::ImageMessage::Pointer volumeMessage(const Skin& skin, int cells, const std::string& device);

}  // namespace palpate::igtl_bridge
